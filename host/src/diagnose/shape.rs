//! The shapes of effects: periods, velocities, widths, exponents, which enter nonlinearly.

use super::columns::{Scale, lowest_limit, parameters};
use super::score::{Bound, Problem};
use super::search::{is_physical, physical};
use super::study::{State, Study, Term};

/// A shape parameter within what a recording can tell.
fn within(study: &Study, id: &str, key: &str, value: f64) -> f64 {
    match key {
        "exponent" => value.clamp(0.5, 3.0),
        // A shorter lag is none that the rows could tell.
        "time_constant_s" if id == "frictional_lag" => value.max(0.6 * study.weak.half_width_s),
        // The column is made of the measured effort: with a limit below most of it, the effort explains itself.
        "limit_N" => value.max(lowest_limit(study)),
        _ => value,
    }
}

/// Refines the shape of a term by likelihood, all coefficients free.
pub fn refine(study: &Study, without: &State, term: &Term) -> Term {
    let mut best = term.clone();
    let Some(mut value) = study.gain(without, &best).map(|g| g.total()) else {
        return best;
    };
    let keys = parameters(term.id);
    let (travel, duration) = (study.s.travel(), study.s.duration());
    let mut steps: Vec<f64> = keys
        .iter()
        .map(|(_, scale)| match scale {
            Scale::Chosen => 0.0,
            Scale::Period => 0.15 * term.shape[0] / travel,
            Scale::Frequency => 0.15 / (duration * term.shape[0]),
            Scale::Logarithmic => 0.3,
            Scale::Travel => travel / 80.0,
        })
        .collect();
    for _ in 0..7 {
        let mut moved = false;
        for j in 0..keys.len().min(best.shape.len()) {
            if steps[j] == 0.0 {
                continue;
            }
            for sign in [-1.0, 1.0] {
                let mut trial = best.clone();
                trial.shape[j] = match keys[j].1 {
                    Scale::Travel => trial.shape[j] + sign * steps[j],
                    _ => trial.shape[j] * (sign * steps[j]).exp(),
                };
                trial.shape[j] = within(study, term.id, keys[j].0, trial.shape[j]);
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

/// Refines every term that was found, after what they act through has changed.
pub fn sharpened(study: &Study, mut state: State, given: usize) -> Option<State> {
    for index in given..state.terms.len() {
        let mut terms = state.terms.clone();
        if parameters(terms[index].id).is_empty() {
            continue;
        }
        terms[index] = refine(study, &study.without(&state, index)?, &terms[index]);
        state = study.fit(&terms, Some(&state))?;
    }
    Some(state)
}

/// Derivative of a term's force at the rows by each of its shape parameters, its coefficients fixed; `None` for those that are
/// chosen from a grid.
pub fn slopes(study: &Study, state: &State, index: usize) -> Vec<Option<Vec<f64>>> {
    let term = &state.terms[index];
    let c = &state.fit.coefficients[state.places[index].clone()];
    // A measured temperature needs no time constant: fewer shape parameters than keys.
    let keys = parameters(term.id).iter().zip(&term.shape).enumerate();
    keys.map(|(k, ((_, scale), value))| {
        let step = small(study, *scale, *value)?;
        let moved = |by: f64| {
            let mut term = term.clone();
            term.shape[k] += by;
            study.term_rows(&term)
        };
        let (up, down) = (moved(step), moved(-step));
        let mut slope = vec![0.0; study.force.len()];
        for ((up, down), c) in up.iter().zip(down.iter()).zip(c) {
            for (s, (u, d)) in slope.iter_mut().zip(up.iter().zip(down)) {
                *s += c * (u - d) / (2.0 * step);
            }
        }
        Some(slope)
    })
    .collect()
}

/// A change of a shape parameter over which its columns are straight.
fn small(study: &Study, scale: Scale, value: f64) -> Option<f64> {
    match scale {
        Scale::Chosen => None,
        Scale::Period => Some(0.01 * value * value / study.s.travel()),
        Scale::Frequency => Some(0.01 / study.s.duration()),
        Scale::Logarithmic => Some(0.01 * value),
        Scale::Travel => Some(1e-3 * study.s.travel()),
    }
}

/// Most steps of [`polished`].
const POLISHES: usize = 8;
/// Times the change over which columns are straight that one step may go.
const REACH: f64 = 30.0;
/// Nats that are worth another step.
const WORTH: f64 = 0.1;
/// Share of the plain held-out error by which a step may raise it.
const WORSE: f64 = 0.01;
/// Share of Gauss and Newton's step below which none is tried.
const SHORTEST: f64 = 0.02;

/// All shapes of terms that are not given, and all coefficients, by Gauss and Newton's method: [`refine`] goes along one
/// parameter at a time and stops short in a valley between two.
pub fn polished(study: &Study, mut state: State, given: usize) -> Option<State> {
    let free: Vec<usize> = (given..state.terms.len()).collect();
    let mut length = 1.0;
    for _ in 0..POLISHES {
        let mut rows = state.rows.clone();
        let mut bounds = state.bounds.clone();
        let mut places = Vec::new();
        for &index in &free {
            for (k, slope) in slopes(study, &state, index).into_iter().enumerate() {
                if let Some(slope) = slope {
                    places.push((index, k, rows.len()));
                    rows.push(slope);
                    bounds.push(Bound::Free);
                }
            }
        }
        if places.is_empty() {
            break;
        }
        let fit = Problem::new(&state.noise, &rows, bounds, &study.force, 1).fit()?;
        let mut terms = state.terms.clone();
        for &(index, k, column) in &places {
            let term = &mut terms[index];
            let (key, scale) = parameters(term.id)[k];
            let value = term.shape[k];
            let most = REACH * small(study, scale, value)?;
            let step = length * fit.coefficients[column].clamp(-most, most);
            let moved = match scale {
                Scale::Logarithmic => value * (step / value).exp(),
                _ => value + step,
            };
            term.shape[k] = within(study, term.id, key, moved);
        }
        let next = study.fit_with(&terms, state.noise.clone())?;
        let gained = next.fit.total() - state.fit.total();
        // A column that grows like another gains nats by what the noise model lets pass, and predicts worse.
        let (share, _) = study.improvement(&state, &next);
        let sound = free.iter().all(|&i| is_physical(&next, i)) && share > -WORSE;
        if gained > 0.0 && sound {
            state = next;
            length = (2.0 * length).min(1.0);
        } else {
            length *= 0.3;
        }
        if gained.abs() < WORTH || length < SHORTEST {
            break;
        }
    }
    Some(state)
}
