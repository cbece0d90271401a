//! All shapes and coefficients of a hypothesis together, by Gauss and Newton's method: one parameter at a time stops short in a
//! valley between two.

use super::effect::Scale;
use super::null_model::{Hypothesis, NullModel};
use super::term::Term;

/// Most steps.
const STEPS: usize = 8;
/// Times the change over which columns are straight that one step may go.
const REACH: f64 = 30.0;
/// Share of the loss that is worth another step.
const WORTH: f64 = 1e-5;
/// Share of a full step below which none is tried.
const SHORTEST: f64 = 0.02;

/// A shape parameter of a term and the slope of its force over it.
pub struct Slope {
    /// Number of the term.
    pub term: usize,
    /// Number of the shape parameter.
    pub parameter: usize,
    /// Derivative of the term's force at the rows.
    pub force: Vec<f64>,
}

/// Slopes of all terms behind the first `given` by their shape parameters, but for those chosen from a grid.
pub fn slopes(null: &NullModel, hypothesis: &Hypothesis, given: usize) -> Vec<Slope> {
    let mut list = Vec::new();
    for (index, term) in hypothesis.terms.iter().enumerate().skip(given) {
        let Some(effect) = term.effect() else {
            continue;
        };
        // A measured temperature needs no time constant: fewer shape parameters than keys.
        for (k, ((_, scale), value)) in effect.card().shape.iter().zip(&term.shape).enumerate() {
            let Some(step) = straight(null, *scale, *value) else {
                continue;
            };
            let moved = |by: f64| {
                let mut moved = Term::new(term.subject, &term.shape);
                moved.shape[k] += by;
                null.columns_once(&moved)
            };
            let (up, down) = (moved(step), moved(-step));
            let mut force = vec![0.0; null.rows.force.len()];
            let columns = up.iter().zip(&down).zip(hypothesis.coefficients(index));
            for ((up, down), c) in columns {
                for (f, (u, d)) in force.iter_mut().zip(up.iter().zip(down)) {
                    *f += c * (u - d) / (2.0 * step);
                }
            }
            list.push(Slope {
                term: index,
                parameter: k,
                force,
            });
        }
    }
    list
}

/// A change of a shape parameter over which its columns are straight.
fn straight(null: &NullModel, scale: Scale, value: f64) -> Option<f64> {
    let s = &null.rows.s;
    match scale {
        Scale::Chosen => None,
        Scale::Period => Some(0.01 * value * value / s.travel()),
        Scale::Frequency => Some(0.01 / s.duration()),
        Scale::Logarithmic => Some(0.01 * value),
        Scale::Travel => Some(1e-3 * s.travel()),
    }
}

/// The hypothesis with its shapes polished, where that predicts better.
pub fn polished(null: &NullModel, mut hypothesis: Hypothesis, given: usize) -> Hypothesis {
    let mut length = 1.0;
    for _ in 0..STEPS {
        let slopes = slopes(null, &hypothesis, given);
        let columns: Vec<Vec<f64>> = slopes.iter().map(|s| s.force.clone()).collect();
        if columns.is_empty() {
            break;
        }
        let Some(fit) = null.fit_beside(&hypothesis.terms, &columns) else {
            break;
        };
        let first = fit.coefficients.len() - columns.len();
        let mut terms = hypothesis.terms.clone();
        for (slope, step) in slopes.iter().zip(&fit.coefficients[first..]) {
            let term = &mut terms[slope.term];
            let Some(effect) = term.effect() else {
                continue;
            };
            let (k, scale) = (slope.parameter, effect.card().shape[slope.parameter].1);
            let value = term.shape[k];
            let Some(small) = straight(null, scale, value) else {
                continue;
            };
            let step = length * step.clamp(-REACH * small, REACH * small);
            term.shape[k] = match scale {
                Scale::Logarithmic => value * (step / value).exp(),
                _ => value + step,
            };
            term.shape[k] = effect.within(&null.scene(), &term.shape, k);
        }
        let Some(next) = null.fit(&terms) else {
            break;
        };
        let gained = 1.0 - next.normal.loss() / hypothesis.normal.loss();
        let admits = |h: &Hypothesis, i: usize| null.admits(&h.terms[i], h.coefficients(i));
        let sound = (given..terms.len()).all(|i| admits(&next, i) || !admits(&hypothesis, i));
        if gained > 0.0 && sound {
            hypothesis = next;
            length = (2.0 * length).min(1.0);
        } else {
            length *= 0.3;
        }
        if (gained > 0.0 && gained < WORTH) || length < SHORTEST {
            break;
        }
    }
    hypothesis
}
