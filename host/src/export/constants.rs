//! The parameters of a model as named constants, alike in every language.

use super::Options;
use preslide_fit::effects::Effect;
use preslide_fit::effects::form::{self, Argument};
use preslide_fit::model::Model;

/// Most by which a measured temperature or load may change the friction level of an exported model (-).
const LEVEL_LIMIT: f64 = 0.5;

/// The bound of forces that grow with speed or position, in breakaway forces, where none is given: far above what the
/// terms give on a healthy axis, and below what a drive could take for a fault.
const BREAKAWAYS: f64 = 10.0;

/// The constants of the two bounds.
pub(super) const FORCE_BOUND: &str = "FORCE_LIMIT";
/// See [`FORCE_BOUND`].
pub(super) const LEVEL_BOUND: &str = "LEVEL_LIMIT";

/// A number with a name.
pub(super) struct Constant {
    pub(super) name: String,
    /// What it is, a sentence without its full stop.
    pub(super) said: String,
    pub(super) value: f64,
}

/// What stands beside the friction model in a controller: the viscous term, the constant force, the effects.
pub fn carried(model: &Model) -> Vec<Effect> {
    let mut effects = Vec::new();
    if model.viscous != 0.0 {
        effects.push(Effect::of(&form::VISCOUS, &[model.viscous]));
    }
    if model.constant_force != 0.0 {
        effects.push(Effect::of(&form::CONSTANT_FORCE, &[model.constant_force]));
    }
    effects.extend(model.effects.iter().cloned());
    effects
}

/// The same, each with a name of its own: the second of an id has a 2 behind it.
pub(super) fn numbered(effects: &[Effect]) -> impl Iterator<Item = (String, &Effect)> {
    effects.iter().enumerate().map(|(i, effect)| {
        let before = effects[..i].iter().filter(|e| e.id() == effect.id());
        match before.count() {
            0 => (effect.id().to_owned(), effect),
            n => (format!("{}_{}", effect.id(), n + 1), effect),
        }
    })
}

/// The inertia of the moving part, where the model has one.
pub(super) fn inertia(model: &Model) -> Option<Constant> {
    let key = model.key("mass_kg");
    (model.inertia > 0.0).then(|| Constant {
        name: key.to_uppercase(),
        said: format!("`{key}` of the moving part"),
        value: model.inertia,
    })
}

/// What a running controller can be sent of a model: names and values, in the order of exported source. Names are those of a linear axis.
///
/// The bounds of forces and levels are none of it: they stay as they were compiled in.
pub fn parameters(model: &Model) -> Vec<(String, f64)> {
    let kind = model.friction.kind();
    let scalars = model.friction.scalars().into_iter();
    let mut all: Vec<_> = scalars
        .map(|(key, value)| (format!("{kind}.{key}"), value))
        .collect();
    for block in model.friction.blocks() {
        all.push(("stiffness".to_owned(), block.stiffness));
        all.push(("weight".to_owned(), block.weight));
    }
    let effects = carried(model);
    for (id, effect) in numbered(&effects).filter(|(_, effect)| effect.form.controller.is_ok()) {
        let values = effect.values.iter();
        all.extend(values.map(|(key, value)| (format!("{id}.{key}"), *value)));
    }
    all
}

/// Which parameters those are, and in which order (FNV-1a over their names): what a controller and who sends it a model must agree on.
pub fn layout(parameters: &[(String, f64)]) -> u32 {
    let bytes = parameters
        .iter()
        .flat_map(|(name, _)| name.bytes().chain([0]));
    bytes.fold(0x811C_9DC5, |hash, byte| {
        (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193)
    })
}

/// The scalars of the friction model, in the order of [`preslide_fit::friction::FrictionModel::scalars`].
pub(super) fn of_friction(model: &Model) -> Vec<Constant> {
    let kind = model.friction.kind();
    let scalars = model.friction.scalars().into_iter();
    scalars
        .map(|(key, value)| {
            let key = model.key(key);
            Constant {
                name: format!("{kind}_{key}").to_uppercase(),
                said: format!("`{key}` of `{kind}`"),
                value,
            }
        })
        .collect()
}

/// The parameters of an effect but for the cosines of a map, in the order of its keys.
pub(super) fn of_effect(model: &Model, effect: &Effect, id: &str) -> Vec<Constant> {
    let single = effect.values.len() - effect.cosines().len();
    let values = effect.values[..single].iter();
    values
        .map(|(key, value)| {
            let key = model.key(key);
            Constant {
                name: named(&key, id),
                said: format!("`{key}` of `{}`", effect.id()),
                value: *value,
            }
        })
        .collect()
}

/// The name of a parameter, which begins with its effect's.
pub(super) fn named(key: &str, id: &str) -> String {
    let (key, id) = (key.to_uppercase(), id.to_uppercase());
    match key.starts_with(&id) {
        true => key,
        false => format!("{id}_{key}"),
    }
}

/// The bounds that `effects` need.
///
/// # Errors
/// One that is needed and can be taken from nowhere.
pub(super) fn bounds(
    model: &Model,
    effects: &[Effect],
    options: &Options,
) -> Result<Vec<Constant>, String> {
    let needed = |bound: Argument| {
        let constructors = effects.iter().flat_map(|e| &e.form.controller);
        constructors.flat_map(|c| c.more).any(|a| *a == bound)
    };
    let mut bounds = Vec::new();
    if needed(Argument::ForceLimit) {
        let breakaway = model.friction.breakaway();
        let limit = options.limit.or(breakaway.map(|f| BREAKAWAYS * f));
        let limit = limit.filter(|l| l.is_finite() && *l > 0.0).ok_or_else(|| {
            let why = match breakaway {
                Some(_) => "",
                None => "; this model has no breakaway force to take it from",
            };
            format!("--limit: give the bound of each force that grows with speed or position, above zero (N or N·m){why}")
        })?;
        bounds.push(Constant {
            name: FORCE_BOUND.to_owned(),
            said: "Bound of each force that grows with speed or position (N or N·m)".to_owned(),
            value: limit,
        });
    }
    if needed(Argument::LevelLimit) {
        bounds.push(Constant {
            name: LEVEL_BOUND.to_owned(),
            said: "Most by which temperature or load may change the friction level (-)".to_owned(),
            value: LEVEL_LIMIT,
        });
    }
    Ok(bounds)
}
