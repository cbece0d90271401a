//! An effect in C.

use super::{SAMPLE_TIME, filled};
use crate::export::constants::{Constant, named, of_effect};
use preslide_fit::effects::Effect;
use preslide_fit::effects::form::CTerm;
use preslide_fit::model::Model;

/// An effect with the names of its constants filled in.
pub(super) struct Term {
    pub(super) id: String,
    pub(super) constants: Vec<Constant>,
    /// The cosines of a map: the array's name, and what they are.
    pub(super) map: Option<(String, Vec<f64>)>,
    pub(super) c: CTerm,
    pub(super) value: String,
    /// What it remembers at rest, and after a tick.
    pub(super) memory: Option<[String; 2]>,
}

impl Term {
    pub(super) fn of(model: &Model, effect: &Effect, id: String) -> Result<Self, String> {
        let controller = effect.form.controller.as_ref();
        let refused = |reason| format!("effect {}: {reason}", effect.id());
        let c = controller.map_err(refused)?.c;
        let constants = of_effect(model, effect, &id);
        let cosines = effect.cosines();
        let map = (!cosines.is_empty()).then(|| (named("COSINES", &id), cosines));
        let list = map
            .as_ref()
            .map(|(name, own)| format!("{name}, {}", own.len()));
        let own = effect.values.iter().zip(&constants);
        let keys: Vec<(&str, &str)> = own
            .map(|((key, _), constant)| (key.as_str(), constant.name.as_str()))
            .chain(list.as_deref().map(|list| ("cosines", list)))
            .collect();
        let written = |text: &str| filled(text, &keys).replace('@', &format!("s->{id}"));
        Ok(Self {
            value: written(c.value),
            memory: c.memory.map(|m| [m.at_rest, m.next].map(written)),
            constants,
            map,
            c,
            id,
        })
    }

    /// What of it is computed in a tick.
    fn code(&self) -> impl Iterator<Item = &str> {
        let next = self.memory.iter().map(|[_, next]| next.as_str());
        next.chain([self.value.as_str()])
    }

    /// Whether it takes the time between ticks.
    pub(super) fn is_timed(&self) -> bool {
        self.code().any(|code| code.contains(SAMPLE_TIME))
    }

    /// Whether it takes a variable.
    pub(super) fn takes(&self, variable: &str) -> bool {
        let is_part = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '>');
        self.code()
            .any(|code| code.split(|c| !is_part(c)).any(|word| word == variable))
    }
}
