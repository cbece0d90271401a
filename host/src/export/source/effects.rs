//! The effects in the source: their parameters and bounds as constants, and the calls that build them.

use super::{Options, Source, Term, literal};
use crate::export::constants::{FORCE_BOUND, LEVEL_BOUND, named, of_bounds, of_effect};
use crate::export::terms::{carried, numbered};
use preslide_fit::effects::Effect;
use preslide_fit::effects::form::{Argument, Constructor};
use std::fmt::Write as _;

impl Source<'_> {
    pub(super) fn effects(&mut self, options: &Options) -> Result<(), String> {
        let effects = carried(self.model);
        for bound in of_bounds(self.model, options)? {
            self.constant(&bound);
        }
        for (id, effect) in numbered(&effects) {
            self.effect(effect, &id)?;
        }
        Ok(())
    }

    fn effect(&mut self, effect: &Effect, id: &str) -> Result<(), String> {
        let controller = effect.form.controller.as_ref();
        let Constructor { kind, more, .. } =
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

    /// Writes the constants of an effect's parameters, the cosines of a map as one; the arguments that they are.
    fn parameters(&mut self, effect: &Effect, id: &str) -> Vec<String> {
        let constants = of_effect(self.model, effect, id);
        constants.iter().for_each(|c| self.constant(c));
        let mut names: Vec<String> = constants
            .into_iter()
            .map(|c| self.parameter(c.name.clone(), &c.name))
            .collect();
        let cosines: Vec<String> = effect.cosines().into_iter().map(literal).collect();
        if !cosines.is_empty() {
            let name = named("COSINES", id);
            let _ = writeln!(
                self.constants,
                "/// The cosines of `{}`.\npub const {name}: [f64; {}] = [{}];",
                effect.id(),
                cosines.len(),
                cosines.join(", ")
            );
            let each = (0..cosines.len())
                .map(|i| self.parameter(format!("{name}[{i}]"), &format!("{name}_{i}")));
            names.push(format!("[{}]", each.collect::<Vec<_>>().join(", ")));
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
