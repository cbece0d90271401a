//! What a recording lacks.

use super::effect;
use super::signals::Signals;

/// What the recording lacks, and what it therefore cannot show.
pub struct Lack {
    /// What is missing.
    pub missing: String,
    /// Ids of the effects that it hides.
    pub hides: Vec<&'static str>,
}

/// What the recording lacks, and the effects that each lack hides, but for what it shows nevertheless.
pub(super) fn lacks(s: &Signals, is_stated: impl Fn(&str) -> bool) -> Vec<Lack> {
    let mut lacks: Vec<Lack> = Vec::new();
    for effect in effect::ALL.into_iter().filter(|e| !is_stated(e.id())) {
        let Some(missing) = effect.lacks(s).or_else(|| effect.blurred(s)) else {
            continue;
        };
        match lacks.iter_mut().find(|l| l.missing == missing) {
            Some(lack) => lack.hides.push(effect.id()),
            None => lacks.push(Lack {
                missing: missing.to_owned(),
                hides: vec![effect.id()],
            }),
        }
    }
    lacks
}
