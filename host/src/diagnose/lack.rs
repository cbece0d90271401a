//! What a recording lacks.

use super::effect::{self, Effect};
use super::signals::Signals;

/// What the recording lacks, and what it therefore cannot show.
pub struct Lack {
    /// What is missing.
    pub missing: String,
    /// The effects that it hides.
    pub hides: Vec<&'static dyn Effect>,
}

impl Lack {
    /// In a sentence.
    pub fn words(&self) -> String {
        let hidden: Vec<&str> = self.hides.iter().map(|e| e.name()).collect();
        format!("Cannot show {}: {}.", hidden.join(", "), self.missing)
    }
}

/// What the recording lacks, and the effects that each lack hides, but for what it shows nevertheless.
pub(super) fn lacks(s: &Signals, is_stated: impl Fn(&str) -> bool) -> Vec<Lack> {
    let mut lacks: Vec<Lack> = Vec::new();
    for effect in effect::ALL.into_iter().filter(|e| !is_stated(e.id())) {
        let Some(missing) = effect.lacks(s).or_else(|| effect.blurred(s)) else {
            continue;
        };
        match lacks.iter_mut().find(|l| l.missing == missing) {
            Some(lack) => lack.hides.push(effect),
            None => lacks.push(Lack {
                missing: missing.to_owned(),
                hides: vec![effect],
            }),
        }
    }
    lacks
}
