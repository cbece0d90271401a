//! The hypothesis without the names that nobody should believe: beside two terms that cancel each other, neither has its own size.

use super::confidence::confidence;
use super::effect;
use super::naming::{Standing, standings};
use super::search::Found;

/// Confidence below which a name does not stand in the way of others.
const INCREDIBLE: f64 = 0.1;

/// What everything found is worth once incredible names are gone, one after the other, and what was said of those; `found` loses them.
pub fn sieved(
    found: &mut Found,
    given: usize,
    periods: &[f64],
) -> Option<(Vec<Standing>, Vec<Standing>)> {
    let mut gone = Vec::new();
    loop {
        let mut left = standings(found, given, periods);
        let least = (0..left.len())
            .filter(|&i| is_incredible(&left[i]))
            .min_by(|&a, &b| confidence(&left[a]).total_cmp(&confidence(&left[b])));
        let Some(least) = least else {
            return Some((left, gone));
        };
        let out = left.remove(least);
        let mut terms = found.hypothesis.terms.clone();
        terms.remove(out.index);
        found.hypothesis = found.ground.fit(&terms)?;
        gone.push(out);
    }
}

/// A delay stays: every recording may have one.
fn is_incredible(standing: &Standing) -> bool {
    let effect = standing.term.effect();
    effect.is_some_and(|e| e.id() != effect::ALWAYS_FREE.id()) && confidence(standing) < INCREDIBLE
}
