//! The hypothesis without the names that nobody should believe: a simpler one takes the place of what it makes needless, and beside two
//! terms that cancel each other, neither has its own size.

use super::confidence::confidence;
use super::effect;
use super::naming::{Standing, standings};
use super::search::Found;

/// Confidence below which a name does not stand in the way of others.
const INCREDIBLE: f64 = 0.1;

/// What everything found is worth, and what was said of what went: simpler names take the places of those that they make needless, and
/// incredible ones go, one after the other; so they do in `found`.
pub fn sieved(
    found: &mut Found,
    given: usize,
    periods: &[f64],
) -> Option<(Vec<Standing>, Vec<Standing>)> {
    let mut gone = Vec::new();
    loop {
        let mut left = standings(found, given, periods);
        if exchange(found, &left)? {
            continue;
        }
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

/// Puts the best of the better names in its place; whether there was one. Each is simpler than the last, so that this ends. Friction is found
/// anew beside it: what it took the place of may have held a part of it, and a level refers to the whole.
fn exchange(found: &mut Found, standings: &[Standing]) -> Option<bool> {
    let better = standings
        .iter()
        .filter_map(|s| Some((s.index, s.better.as_ref()?)));
    let Some((index, (better, _))) = better.max_by(|a, b| a.1.1.total_cmp(&b.1.1)) else {
        return Some(false);
    };
    let mut terms = found.hypothesis.terms.clone();
    terms[index] = better.clone();
    found.ground = found.ground.referred_to(&terms)?;
    found.hypothesis = found.ground.fit(&terms)?;
    Some(true)
}

/// A delay stays: every recording may have one.
fn is_incredible(standing: &Standing) -> bool {
    let effect = standing.term.effect();
    effect.is_some_and(|e| e.id() != effect::ALWAYS_FREE.id()) && confidence(standing) < INCREDIBLE
}
