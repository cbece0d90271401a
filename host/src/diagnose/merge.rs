//! One place of the friction level for two: a ripple is found as two spots where it has few periods within the travel, and a map as a ripple and a
//! spot. Maps of a force take all that is slow, a spring and what is not there: nothing is merged into them.

use super::candidate::{Candidate, candidates, refined};
use super::effect::Class;
use super::null_model::{Hypothesis, NullModel};
use super::term::Term;

/// Share of what two terms explain that one must explain in their place.
const AS_MUCH: f64 = 0.9;

/// The hypothesis with one term in place of two that vary the friction level over the position, where it has fewer parameters and explains
/// nearly as much; and the two.
pub(super) fn merged(
    null: &NullModel,
    hypothesis: &Hypothesis,
    given: usize,
    periods: &[f64],
) -> Option<(Hypothesis, [Term; 2])> {
    // Two lines at two periods are harmonics, and each stands out by itself.
    let is_line = |i: usize| {
        hypothesis.terms[i]
            .effect()
            .is_some_and(|e| e.line().is_some())
    };
    let places: Vec<usize> = (given..hypothesis.terms.len())
        .filter(|i| is_place_of_the_level(null, &hypothesis.terms[*i]))
        .collect();
    let pairs = places
        .iter()
        .enumerate()
        .flat_map(|(k, a)| places[k + 1..].iter().map(|b| [*a, *b]))
        .filter(|[a, b]| !(is_line(*a) && is_line(*b)));
    let one_for = |pair: [usize; 2]| one_for(null, hypothesis, pair, periods);
    let best = pairs
        .filter_map(|pair| Some((one_for(pair)?, pair)))
        .max_by(|(a, _), (b, _)| b.normal.loss().total_cmp(&a.normal.loss()));
    best.map(|(one, pair)| (one, pair.map(|i| hypothesis.terms[i].clone())))
}

/// The best hypothesis with one term in place of two.
fn one_for(
    null: &NullModel,
    hypothesis: &Hypothesis,
    pair: [usize; 2],
    periods: &[f64],
) -> Option<Hypothesis> {
    let others = hypothesis.terms.iter().enumerate();
    let others = others.filter(|(i, _)| !pair.contains(i));
    let terms: Vec<Term> = others.map(|(_, t)| t.clone()).collect();
    let without = null.fit(&terms)?;
    let of_two: usize = pair
        .iter()
        .map(|i| hypothesis.terms[*i].shape.len() + hypothesis.coefficients(*i).len())
        .sum();
    let (list, _) = candidates(null, &without, periods);
    let least = AS_MUCH * (without.normal.loss() - hypothesis.normal.loss());
    let is_simpler = |o: &&Candidate| {
        let parameters = o.term.shape.len() + o.trial.coefficients.len();
        parameters < of_two && is_place_of_the_level(null, &o.term)
    };
    let with = |o: &Candidate| {
        let sharp = refined(null, &without, &o.term);
        null.fit(&[terms.as_slice(), &[sharp]].concat())
    };
    let fitted = list.iter().filter(is_simpler).filter_map(with);
    fitted
        .filter(|h| without.normal.loss() - h.normal.loss() >= least)
        .min_by(|a, b| a.normal.loss().total_cmp(&b.normal.loss()))
}

fn is_place_of_the_level(null: &NullModel, term: &Term) -> bool {
    let is_place = term.effect().is_some_and(|e| e.class() == Class::Place);
    is_place && term.is_level(&null.scene())
}
