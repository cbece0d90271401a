//! The hypothesis without names that nobody should believe: a simpler one takes the place of what it makes needless, and beside two
//! terms that cancel each other, neither has its own size.

use super::confidence::confidence;
use super::effect;
use super::named::{Name, Named};
use super::naming::{TermReport, reports};
use super::search::Found;
use preslide_fit::effects::form;

/// Confidence below which a name does not stand in the way of others, and a delay, which is always looked for, is not worth a word.
pub(super) const INCREDIBLE: f64 = 0.1;

/// What everything found is worth, and what was said of what went: simpler names take the places of those that they make needless, and
/// incredible ones go, one after the other; so they do in `found`.
pub fn sieved(
    found: &mut Found,
    given: usize,
    periods: &[f64],
) -> Option<(Vec<TermReport>, Vec<TermReport>)> {
    let mut gone = Vec::new();
    loop {
        let mut left = reports(found, given, periods);
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
        found.hypothesis = found.null.fit(&terms)?;
        gone.push(out);
    }
}

/// Puts the best of the better names in its place; whether there was one. Each is simpler than the last, so that this ends. Friction is found
/// anew beside it: what it took the place of may have held a part of it, and a level refers to the whole.
fn exchange(found: &mut Found, reports: &[TermReport]) -> Option<bool> {
    let better = reports
        .iter()
        .filter_map(|s| Some((s.index, s.better.as_ref()?)));
    let Some((index, (better, _))) = better.max_by(|a, b| a.1.1.total_cmp(&b.1.1)) else {
        return Some(false);
    };
    let mut terms = found.hypothesis.terms.clone();
    terms[index] = better.clone();
    found.null = found.null.referred_to(&terms)?;
    found.hypothesis = found.null.fit(&terms)?;
    Some(true)
}

/// A delay stays: every recording may have one.
fn is_incredible(report: &TermReport) -> bool {
    let effect = report.term.effect();
    effect.is_some_and(|e| e.id() != effect::ALWAYS_FREE.id()) && confidence(report) < INCREDIBLE
}

/// Doubts lines in position at the period of a larger encoder error, or at its half, third or quarter, as near as the `travel` (m or rad) separates
/// periods: friction and inertia answer to the error with its harmonics. Set with seven such lines of three blind judges in sight.
pub fn doubt_harmonics(effects: &mut [Named], travel: f64) {
    const MOST: f64 = 4.0;
    /// Periods within the travel by which two lines differ at least that are two (Rayleigh).
    const APART: f64 = 1.0;
    let period = |e: &Named| e.term.as_ref().and_then(|t| t.shape.first().copied());
    let is_error = |e: &Named| e.id() == form::ENCODER_ERROR.id;
    let errors = effects.iter().filter(|e| e.confident && is_error(e));
    let errors: Vec<(f64, f64)> = errors
        .filter_map(|e| Some((period(e)?, e.evidence.share)))
        .collect();
    let in_position = |e: &Named| match e.name {
        Name::Entry(effect) => effect.line().is_some_and(|l| l != effect::Line::Time),
        _ => false,
    };
    let is_harmonic = |line: &Named| {
        let of = |&(error, share): &(f64, f64)| {
            period(line).is_some_and(|own| {
                let order = (error / own).round().clamp(1.0, MOST);
                let apart = (travel / own - order * travel / error).abs();
                apart < APART && line.evidence.share < share
            })
        };
        in_position(line) && !is_error(line) && errors.iter().any(of)
    };
    let harmonics = effects.iter_mut().filter(|e| is_harmonic(e));
    harmonics.for_each(Named::doubt);
}
