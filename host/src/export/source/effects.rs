//! The effects in the source: their parameters and bounds as constants, and the calls that build them.

use super::{Options, Source, Term, literal};
use crate::effects::Effect;
use crate::effects::form::{self, Argument, Constructor};
use crate::model::Model;
use std::fmt::Write as _;

/// Most by which a measured temperature or load may change the friction level of an exported model (-).
const LEVEL_LIMIT: f64 = 0.5;

/// The bound of forces that grow with speed or position, in breakaway forces, where none is given: far above what the
/// terms give on a healthy axis, and below what a drive could take for a fault.
const BREAKAWAYS: f64 = 10.0;

/// The constants of the two bounds.
const FORCE_BOUND: &str = "FORCE_LIMIT";
const LEVEL_BOUND: &str = "LEVEL_LIMIT";

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

impl Source<'_> {
    pub(super) fn effects(&mut self, options: &Options) -> Result<(), String> {
        let effects = carried(self.model);
        self.bounds(&effects, options)?;
        for (i, effect) in effects.iter().enumerate() {
            let before = effects[..i]
                .iter()
                .filter(|e| e.id() == effect.id())
                .count();
            let id = if before == 0 {
                effect.id().to_owned()
            } else {
                format!("{}_{}", effect.id(), before + 1)
            };
            self.effect(effect, &id)?;
        }
        Ok(())
    }

    /// The constants of the bounds that `effects` need.
    fn bounds(&mut self, effects: &[Effect], options: &Options) -> Result<(), String> {
        let needed = |bound: Argument| {
            let constructors = effects.iter().flat_map(|e| &e.form.controller);
            constructors.flat_map(|c| c.more).any(|a| *a == bound)
        };
        if needed(Argument::ForceLimit) {
            let breakaway = self.model.friction.breakaway();
            let limit = options.limit.or(breakaway.map(|f| BREAKAWAYS * f));
            let limit = limit.filter(|l| l.is_finite() && *l > 0.0).ok_or(
                "--limit: give the bound of each force that grows with speed or position, above zero (N or N·m); this model has no breakaway force to take it from",
            )?;
            self.constant(
                FORCE_BOUND,
                "Bound of each force that grows with speed or position (N or N·m)",
                limit,
            );
        }
        if needed(Argument::LevelLimit) {
            self.constant(
                LEVEL_BOUND,
                "Most by which temperature or load may change the friction level (-)",
                LEVEL_LIMIT,
            );
        }
        Ok(())
    }

    fn effect(&mut self, effect: &Effect, id: &str) -> Result<(), String> {
        let controller = effect.form.controller.as_ref();
        let Constructor { kind, more } =
            controller.map_err(|reason| format!("effect {}: {reason}", effect.id()))?;
        let mut build = self.parameters(effect, id);
        build.extend(more.iter().map(|argument| source(*argument).to_owned()));
        let of_terms = match effect.cosines().len() {
            0 => "S".to_owned(),
            n => format!("{n}, S"),
        };
        self.terms.push(Term {
            kind: format!("::preslide::effects::{kind}<{of_terms}>"),
            build: format!(
                "::preslide::effects::{kind}::try_new({})?",
                build.join(", ")
            ),
        });
        Ok(())
    }

    /// Writes the constants of an effect's parameters, the cosines of a map as one; their names.
    fn parameters(&mut self, effect: &Effect, id: &str) -> Vec<String> {
        let named = |key: &str| {
            let (key, id) = (key.to_uppercase(), id.to_uppercase());
            match key.starts_with(&id) {
                true => key,
                false => format!("{id}_{key}"),
            }
        };
        let cosines: Vec<String> = effect.cosines().into_iter().map(literal).collect();
        let single = effect.values.len() - cosines.len();
        let mut names = Vec::new();
        for (key, value) in &effect.values[..single] {
            let own = self.model.key(key);
            let name = named(&own);
            let said = format!("`{own}` of `{}`", effect.id());
            self.constant(&name, &said, *value);
            names.push(name);
        }
        if !cosines.is_empty() {
            let name = named("COSINES");
            let _ = writeln!(
                self.constants,
                "/// The cosines of `{}`.\npub const {name}: [f64; {}] = [{}];",
                effect.id(),
                cosines.len(),
                cosines.join(", ")
            );
            names.push(name);
        }
        names
    }
}

/// An argument that is no parameter, as the exported function has it.
fn source(argument: Argument) -> &'static str {
    match argument {
        Argument::ForceLimit => FORCE_BOUND,
        Argument::LevelLimit => LEVEL_BOUND,
        Argument::SampleTime => "sample_time",
        Argument::Units => "units",
        Argument::Number(number) => number,
    }
}
