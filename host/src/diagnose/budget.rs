//! The mismatch budget: what each finding takes off the residual on stretches held out, so that the squares add up.

use super::null_model::{Hypothesis, NullModel};
use super::term::Term;

/// What a finding takes off.
#[derive(Clone, Copy, Debug)]
pub struct Item {
    /// Its number among the effects.
    pub effect: usize,
    /// NMSE (% of the effort's variance) that it takes off beside those before it, or, against a simulation, its share of what all take.
    pub nmse: f64,
}

/// A missing effect.
pub(super) struct Finding<'a> {
    /// Its number among the effects.
    pub(super) effect: usize,
    /// Its term; without one it changes the whole recording or its core.
    pub(super) term: Option<&'a Term>,
    /// Its force at the rows.
    pub(super) force: &'a [f64],
    /// NMSE (%) without and with it, by itself.
    pub(super) nmse: [f64; 2],
}

/// What the findings against a simulation take off, `left` at the rows with all of them, of `from − to` %: their Shapley values, `f·(y + r)` for
/// what is missing, `y`, which no fit stands in front of. One after the other, the first would take what two share.
pub(super) fn of_a_simulation(
    null: &NullModel,
    left: &[f64],
    findings: &[Finding],
    [from, to]: [f64; 2],
) -> Vec<Item> {
    let value = |force: &[f64]| {
        let own = force.iter().zip(&null.rows.target).zip(left);
        own.map(|((f, y), r)| f * (y + r)).sum::<f64>().max(0.0)
    };
    let values: Vec<f64> = findings.iter().map(|f| value(f.force)).collect();
    let all = values.iter().sum::<f64>().max(1e-300);
    let items = findings.iter().zip(values).map(|(finding, value)| Item {
        effect: finding.effect,
        nmse: (from - to).max(0.0) * value / all,
    });
    items.collect()
}

/// What the findings take off in their order, `from` % being left without them and `to` % with all: first what has no term, then the terms on
/// top of `kept`.
pub(super) fn budget(
    null: &NullModel,
    kept: &[Term],
    findings: &[Finding],
    [from, to]: [f64; 2],
) -> Vec<Item> {
    let mut left = from;
    let mut items = Vec::new();
    let mut take = |effect: usize, nmse: f64| {
        let nmse = nmse.clamp(0.0, (left - to).max(0.0));
        left -= nmse;
        items.push(Item { effect, nmse });
    };
    for finding in findings.iter().filter(|f| f.term.is_none()) {
        take(finding.effect, finding.nmse[0] - finding.nmse[1]);
    }
    let mut terms = kept.to_vec();
    let test = |h: Option<Hypothesis>| h.map(|h| h.nmse(&null.rows).test);
    let mut before = test(null.fit(&terms));
    let with_terms: Vec<(usize, &Term)> = findings
        .iter()
        .filter_map(|f| Some((f.effect, f.term?)))
        .collect();
    for (place, (effect, term)) in with_terms.iter().enumerate() {
        terms.push((*term).clone());
        let after = match place + 1 == with_terms.len() {
            true => Some(to),
            false => test(null.fit(&terms)),
        };
        take(*effect, before.zip(after).map_or(0.0, |(b, a)| b - a));
        before = after;
    }
    items
}
