//! Which effects act: forward, swap and backward, with thresholds from the recording's own noise.

use super::catalogue::TESTED;
use super::columns::{moving_range, parameters, shapes};
use super::score::Gain;
use super::signature::{Signature, signatures};
use super::spectra;
use super::study::{State, Study, Term};
use crate::progress::Progress;
use rayon::prelude::*;

/// Most effects named in one recording.
const MOST: usize = 6;
/// Standard deviations of the best noise draw's nats above their mean.
const DEVIATIONS: f64 = 4.0;
/// Nats that a name must bring in any case: odds of 150 to 1 on the folds held out.
const LEAST: f64 = 5.0;

/// Least share of the held-out squared error that an effect must take off where it acts, to be looked at…
const SLIGHT: f64 = 0.04;
/// … and to be stated with confidence. No parallel blocks follow a real hysteresis exactly; a regular part of their error can
/// always be written as a little of some effect.
pub const MATERIAL: f64 = 0.1;

/// The best shape of an effect, what it would add, and what noise alone adds.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The effect.
    pub term: Term,
    /// What it adds.
    pub gain: Gain,
    /// Nats that noise alone does not reach.
    pub threshold: f64,
}

impl Candidate {
    /// Nats above what noise would give.
    pub fn excess(&self) -> f64 {
        self.gain.total() - self.threshold
    }

    /// Gains in most folds: a mean above twice its standard error, or nine folds in ten.
    pub fn consistent(&self) -> bool {
        consistent(&self.gain.by_fold)
    }
}

/// Whether a gain is spread over the folds.
pub fn consistent(by_fold: &[f64]) -> bool {
    let n = by_fold.len() as f64;
    let mean = by_fold.iter().sum::<f64>() / n;
    let variance = by_fold.iter().map(|g| (g - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let positive = by_fold.iter().filter(|g| **g > 0.0).count() as f64;
    mean > 2.0 * (variance / n).sqrt() || positive >= 0.9 * n
}

/// Whether coefficients have the sign that the physics has.
fn physical(id: &str, coefficients: &[f64]) -> bool {
    match (id, coefficients) {
        (
            "viscous" | "quadratic_drag" | "stribeck" | "frictional_lag" | "dwell_aging"
            | "drive_compliance" | "position_spring",
            [c],
        ) => *c > 0.0,
        // The friction carried through the gap, less some of the blocks having found the gap themselves.
        ("backlash", [c]) => (0.3..3.0).contains(c),
        _ => true,
    }
}

/// The share of the held-out squared error that term `index` of `with` takes off, where 80 % of its force is.
pub fn material(study: &Study, without: &State, with: &State, index: usize) -> f64 {
    let force = study.force_of(with, index);
    let mut order: Vec<usize> = (0..force.len()).collect();
    order.sort_by(|&a, &b| force[b].abs().total_cmp(&force[a].abs()));
    let total: f64 = force.iter().map(|f| f * f).sum();
    let mut held = 0.0;
    let (before, after) = (
        study.held_out_residual(without),
        study.held_out_residual(with),
    );
    let (mut was, mut is) = (0.0, 0.0);
    for i in order {
        if held > 0.8 * total {
            break;
        }
        held += force[i].powi(2);
        was += before[i].powi(2);
        is += after[i].powi(2);
    }
    1.0 - is / was.max(1e-300)
}

/// The best candidate of every effect, best first.
pub fn scan(study: &Study, state: &State, periods: &[f64]) -> Vec<Candidate> {
    let mut tried: Vec<(Term, f64)> = Vec::new();
    let term = |id, shape| Term {
        id,
        shape,
        given: false,
    };
    for entry in &TESTED {
        let present = state.terms.iter().any(|t| t.id == entry.id);
        let repeatable = matches!(
            entry.id,
            "periodic_force" | "periodic_friction" | "external_vibration" | "local_friction_spot"
        );
        if !present || repeatable {
            tried.extend(
                shapes(entry.id, &study.s)
                    .into_iter()
                    .map(|s| (term(entry.id, s), 0.0)),
            );
        }
    }
    for (id, shape, tries) in lines(study, state, periods) {
        tried.push((term(id, shape), tries));
    }
    let gains: Vec<(Term, f64, Gain)> = tried
        .into_par_iter()
        .filter_map(|(term, tries)| {
            let gain = study.gain(state, &term)?;
            physical(term.id, &gain.coefficients).then_some((term, tries, gain))
        })
        .collect();
    let mut best: Vec<Candidate> = Vec::new();
    for entry in &TESTED {
        let own: Vec<_> = gains.iter().filter(|g| g.0.id == entry.id).collect();
        let Some(top) = own
            .iter()
            .max_by(|a, b| a.2.total().total_cmp(&b.2.total()))
        else {
            continue;
        };
        let draws = top.2.null.len();
        let maxima: Vec<f64> = (0..draws)
            .map(|d| {
                own.iter()
                    .map(|g| g.2.null[d])
                    .fold(f64::NEG_INFINITY, f64::max)
            })
            .collect();
        let mean = maxima.iter().sum::<f64>() / draws as f64;
        let spread =
            (maxima.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (draws - 1) as f64).sqrt();
        best.push(Candidate {
            term: top.0.clone(),
            gain: top.2.clone(),
            // Lines are looked for among `tries` frequencies, which the draws did not do.
            threshold: (mean + DEVIATIONS * spread).max(LEAST) + top.1.max(1.0).ln(),
        });
    }
    best.sort_by(|a, b| b.excess().total_cmp(&a.excess()));
    best
}

/// Lines of the mismatch in position and in time, and the periods of the mechanics.
fn lines(study: &Study, state: &State, periods: &[f64]) -> Vec<(&'static str, Vec<f64>, f64)> {
    let s = &study.s;
    let weights = state
        .noise
        .inverse(&study.residual(state, &state.fit.coefficients));
    let x = study.weak.at_centres(&s.x);
    let t = study.weak.at_centres(&s.t);
    let friction = study.weak.at_centres(&state.baseline.friction);
    let (travel, slow) = moving_range(s);
    let row_s = study.weak.half_width_s;
    let finest = 0.5 / (row_s * slow);
    let lowest = 1.5 / travel;
    let by_friction: Vec<f64> = weights.iter().zip(&friction).map(|(w, f)| w * f).collect();
    let mut found = Vec::new();
    let tries = (finest / lowest).max(1.0);
    let duration = t.last().copied().unwrap_or(0.0) - t.first().copied().unwrap_or(0.0);
    let position = spectra::lines(&x, &weights, lowest, finest);
    let level = spectra::lines(&x, &by_friction, lowest, finest);
    for nu in &position {
        found.push(("periodic_force", vec![1.0 / nu], tries));
        found.push(("encoder_error", vec![1.0 / nu], tries));
    }
    for nu in &level {
        found.push(("periodic_friction", vec![1.0 / nu], tries));
    }
    for &p in periods.iter().filter(|p| **p < travel / 1.5) {
        for p in [p, p / 2.0] {
            for id in ["periodic_force", "periodic_friction", "encoder_error"] {
                found.push((id, vec![p], 1.0));
            }
        }
    }
    // Slower than ten periods is drift, or the motion itself.
    let highest = 0.45 / row_s;
    let in_time = 20.0 / duration;
    for f in spectra::lines(&t, &weights, in_time, highest) {
        found.push(("external_vibration", vec![f], (highest * duration).max(1.0)));
    }
    found
}

/// Refines the shape of term `index` by likelihood, all coefficients free.
pub fn refine(study: &Study, without: &State, term: &Term) -> Term {
    let mut best = term.clone();
    let Some(mut value) = study.gain(without, &best).map(|g| g.total()) else {
        return best;
    };
    let keys = parameters(term.id);
    let (travel, _) = moving_range(&study.s);
    let duration = study.s.t.last().copied().unwrap_or(1.0);
    let mut steps: Vec<f64> = keys
        .iter()
        .map(|p| match (p.key, p.logarithmic) {
            (_, None) => 0.0,
            ("period_m", _) => 0.15 * term.shape[0] / travel,
            ("frequency_Hz", _) => 0.15 / (duration * term.shape[0]),
            (_, Some(true)) => 0.25,
            (_, Some(false)) => travel / 80.0,
        })
        .collect();
    for _ in 0..8 {
        let mut moved = false;
        for j in 0..keys.len().min(best.shape.len()) {
            if steps[j] == 0.0 {
                continue;
            }
            for sign in [-1.0, 1.0] {
                let mut trial = best.clone();
                trial.shape[j] = match keys[j].logarithmic {
                    Some(true) => trial.shape[j] * (sign * steps[j]).exp(),
                    _ => trial.shape[j] + sign * steps[j],
                };
                if keys[j].key == "exponent" {
                    trial.shape[j] = trial.shape[j].clamp(0.5, 3.0);
                }
                if let Some(gain) = study
                    .gain(without, &trial)
                    .filter(|g| physical(trial.id, &g.coefficients))
                    .map(|g| g.total())
                    && gain > value + 1e-3
                {
                    (best, value, moved) = (trial, gain, true);
                    break;
                }
            }
        }
        if !moved {
            steps.iter_mut().for_each(|s| *s *= 0.4);
        }
    }
    best
}

/// What the search found.
pub struct Found {
    /// The hypothesis with everything that passed its threshold.
    pub state: State,
    /// The hypothesis without any of it.
    pub first: State,
    /// For each term that is not given: its evidence and its rivals', best first.
    pub evidence: Vec<Evidence>,
    /// What was left when the search ended, best first.
    pub rest: Vec<Candidate>,
}

/// Why one effect is named and not another.
pub struct Evidence {
    /// The effect, its nats given everything else.
    pub candidate: Candidate,
    /// Every other effect in its place, best first.
    pub rivals: Vec<Candidate>,
    /// Free curves over each coordinate in its place, best first.
    pub curves: Vec<Signature>,
    /// Share of the held-out squared error that it takes off where it acts.
    pub material: f64,
}

/// Searches from the given terms.
pub fn search(
    study: &Study,
    given: &[Term],
    periods: &[f64],
    progress: &Progress,
) -> Option<Found> {
    let first = study.fit(given, None)?;
    let mut state = study.fit(given, Some(&first))?;
    progress.inc(1);
    let mut rest = scan(study, &state, periods);
    // Found by the likelihood, but too small to be told from the law's own error.
    let mut slight: Vec<&str> = Vec::new();
    while state.terms.len() < given.len() + MOST {
        let next = rest
            .iter()
            .find(|c| c.excess() > 0.0 && !slight.contains(&c.term.id));
        let Some(top) = next else { break };
        let term = refine(study, &state, &top.term);
        let id = term.id;
        let terms: Vec<Term> = state.terms.iter().cloned().chain([term]).collect();
        let Some(next) = study.fit(&terms, Some(&state)) else {
            break;
        };
        if material(study, &state, &next, terms.len() - 1) < SLIGHT {
            slight.push(id);
            continue;
        }
        state = next;
        progress.inc(1);
        rest = scan(study, &state, periods);
    }
    // Swap and backward: each effect once more against all others in its place.
    let mut evidence = Vec::new();
    let mut index = given.len();
    let mut swaps = 0;
    let searched = state.terms.clone();
    while index < state.terms.len() {
        let term = state.terms[index].clone();
        let others: Vec<Term> = state
            .terms
            .iter()
            .enumerate()
            .filter(|(i, _)| *i != index)
            .map(|(_, t)| t.clone())
            .collect();
        let without = study.fit(&others, Some(&state))?;
        let mut rivals = scan(study, &without, periods);
        let own = rivals.iter().find(|c| c.term.id == term.id).cloned();
        let gain = study.gain(&without, &term);
        let (Some(own), Some(gain)) = (own, gain) else {
            state = without;
            continue;
        };
        let own = Candidate {
            term: term.clone(),
            gain,
            threshold: own.threshold,
        };
        if own.excess() <= 0.0 {
            state = without;
            continue;
        }
        rivals.retain(|c| c.term.id != term.id);
        let better = rivals
            .first()
            .filter(|c| c.excess() > own.excess() + 3.0)
            .cloned();
        if let Some(better) = better
            && swaps < 3
        {
            swaps += 1;
            let mut terms = others;
            terms.insert(index, refine(study, &without, &better.term));
            if let Some(next) = study.fit(&terms, Some(&without)) {
                state = next;
                evidence.clear();
                index = given.len();
                continue;
            }
        }
        let curves = signatures(study, &without);
        let material = material(study, &without, &state, index);
        if material < SLIGHT {
            state = without;
            continue;
        }
        evidence.push(Evidence {
            candidate: own,
            rivals,
            curves,
            material,
        });
        index += 1;
        progress.inc(1);
    }
    if searched.len() != state.terms.len() {
        rest = scan(study, &state, periods);
    }
    Some(Found {
        state,
        first,
        evidence,
        rest,
    })
}
