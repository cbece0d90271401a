//! The mismatch budget: what each finding takes off the residual on stretches held out, so that the squares add up.

use super::null_model::NullModel;
use super::term::Term;

/// What a finding takes off.
#[derive(Clone, Copy, Debug)]
pub struct Item {
    /// Its number among the effects.
    pub effect: usize,
    /// NMSE (% of the effort's variance); the sum is what all take, or less.
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
/// what is missing, `y`, which no fit precedes. One after the other, the first would take what two share.
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

/// What the findings take off, `from` % being left without them and `to` % with all: first what has no term, then the terms, each by the mean of what
/// it takes off first, on top of what the diagnosis begins with, and last, beside all others: one after the other, the first would take what two share.
pub(super) fn budget(
    null: &NullModel,
    begun: &[Term],
    findings: &[Finding],
    [from, to]: [f64; 2],
) -> Vec<Item> {
    let mut left = from;
    let mut items = Vec::new();
    for finding in findings.iter().filter(|f| f.term.is_none()) {
        let nmse = (finding.nmse[0] - finding.nmse[1]).clamp(0.0, (left - to).max(0.0));
        left -= nmse;
        items.push(Item {
            effect: finding.effect,
            nmse,
        });
    }
    let terms: Vec<(usize, &Term)> = findings
        .iter()
        .filter_map(|f| Some((f.effect, f.term?)))
        .collect();
    let test = |which: &dyn Fn(usize) -> bool| {
        let names: Vec<&Term> = (terms.iter())
            .filter(|(effect, _)| which(*effect))
            .map(|(_, term)| *term)
            .collect();
        match names.len() {
            0 => Some(left),
            n if n == terms.len() => Some(to),
            _ => {
                let all: Vec<Term> = begun.iter().chain(names).cloned().collect();
                Some(null.fit(&all)?.nmse(&null.rows).test)
            }
        }
    };
    let value = |effect: usize| {
        let first = left - test(&|e| e == effect)?;
        let last = test(&|e| e != effect)? - to;
        Some(0.5 * (first.max(0.0) + last.max(0.0)))
    };
    let values: Vec<f64> = terms
        .iter()
        .map(|(e, _)| value(*e).unwrap_or(0.0))
        .collect();
    let sum = values.iter().sum::<f64>().max(1e-300);
    let held = ((left - to).max(0.0) / sum).min(1.0);
    items.extend(terms.iter().zip(values).map(|((effect, _), value)| Item {
        effect: *effect,
        nmse: held * value,
    }));
    items
}
