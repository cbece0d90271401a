//! The parameters of a model as named constants, alike in every language.

use super::Options;
use super::bound::bounds;
use super::terms::{carried, numbered};
use preslide_fit::effects::Effect;
use preslide_fit::effects::form::Argument;
use preslide_fit::model::Model;

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

/// A key of a linear axis as a name in exported source: in the words of the model's axis and, where its forces are none, in their unit.
/// A load is a force on any axis.
pub(super) fn name_of(model: &Model, key: &str) -> String {
    let key = model.key(key);
    let Some(unit) = model
        .effort_unit
        .filter(|_| !key.ends_with("load_N") && !key.ends_with("_per_N"))
    else {
        return key;
    };
    let length = model.motion.unit();
    let in_unit = |(ending, instead): &(&str, String)| {
        let stem = key.strip_suffix(ending)?;
        Some(format!("{stem}{instead}"))
    };
    let inertias = [("mass_kg", "mass"), ("inertia_kg_m2", "inertia")]
        .map(|(ending, name)| (ending, format!("{name}_{unit}_s2_per_{length}")));
    if let Some(name) = inertias.iter().find_map(in_unit) {
        return name;
    }
    let parts = key.split('_').map(|part| match part {
        "N" | "Nm" => unit.to_owned(),
        "N2" | "Nm2" => format!("{unit}2"),
        part => part.to_owned(),
    });
    parts.collect::<Vec<_>>().join("_")
}

/// What stands beside a model file's key, whose N is none.
fn in_unit(model: &Model) -> String {
    let unit = model
        .effort_unit
        .map(|unit| format!(", whose N is {unit} (effort_unit)"));
    unit.unwrap_or_default()
}

/// The unit of the model's forces, as comments have it.
pub(super) fn effort_of(model: &Model) -> &'static str {
    match model.effort().unit() {
        "Nm" => "N m",
        unit => unit,
    }
}

/// The inertia of the moving part, where the model has one.
pub(super) fn inertia(model: &Model) -> Option<Constant> {
    let key = model.key("mass_kg");
    (model.inertia > 0.0).then(|| Constant {
        name: name_of(model, "mass_kg").to_uppercase(),
        said: match model.effort_unit {
            Some(unit) => format!(
                "`{key}` of the moving part, in {unit} s^2/{} (effort_unit)",
                model.motion.unit()
            ),
            None => format!("`{key}` of the moving part"),
        },
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
            let (key, name) = (model.key(key), name_of(model, key));
            Constant {
                name: format!("{kind}_{name}").to_uppercase(),
                said: format!("`{key}` of `{kind}`{}", in_unit(model)),
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
            let (key, name) = (model.key(key), name_of(model, key));
            Constant {
                name: named(&name, id),
                said: format!("`{key}` of `{}`{}", effect.id(), in_unit(model)),
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

/// The bounds that the model needs, as constants.
///
/// # Errors
/// As of [`bounds`].
pub(super) fn of_bounds(model: &Model, options: &Options) -> Result<Vec<Constant>, String> {
    let bounds = bounds(model, options)?.into_iter();
    let constant = bounds.map(|bound| {
        let (name, said) = match bound.of {
            Argument::ForceLimit => (
                FORCE_BOUND,
                "Bound of each force that grows with speed or position",
            ),
            _ => (
                LEVEL_BOUND,
                "Most by which temperature or load may change the friction level",
            ),
        };
        let unit = match (bound.of, model.effort_unit) {
            (Argument::ForceLimit, None) => "N or N·m",
            (Argument::ForceLimit, Some(unit)) => unit,
            _ => "-",
        };
        Constant {
            name: name.to_owned(),
            said: format!("{said} ({unit})"),
            value: bound.value,
        }
    });
    Ok(constant.collect())
}
