//! Least squares of a simulated motion: Levenberg and Marquardt's method on central differences, one core a parameter.
//!
//! Standstill comes and goes with the parameters, so the error is rough on a small scale: slopes are taken over steps that begin wide and
//! narrow where nothing is gained any more. Where a simulation sticks and the machine slips the error is large for a while; such stretches
//! weigh by their size, not its square (`2c²·(√(1 + (e/c)²) − 1)`, Charbonnier's loss).

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Steps of the slopes, in parameters' scales, widest first.
pub(super) const STEPS: [f64; 3] = [0.02, 0.007, 0.002];
/// Most steps of the descent at each width, and the share of the loss that one must gain to be followed by another.
const MOST: usize = 25;
const GAIN: f64 = 1e-3;
/// Damping at the start, after a step that gains, after one that does not, and where no step is left.
const DAMPING: [f64; 4] = [1e-2, 0.2, 4.0, 1e6];

/// Where a descent ended.
#[derive(Clone)]
pub(super) struct Valley {
    pub(super) at: Vec<f64>,
    /// See [`loss_of`].
    pub(super) loss: f64,
}

/// Descends from `at`, in parameters' scales, on the errors that `errors` makes of parameters; `None` is a place where nothing can be.
pub(super) fn descend(
    at: Vec<f64>,
    rough: f64,
    errors: &(impl Fn(&[f64]) -> Option<Vec<f64>> + Sync),
) -> Option<Valley> {
    let mut now = errors(&at)?;
    let mut at = at;
    let mut loss = loss_of(&now, rough);
    for step in STEPS {
        let mut damping = DAMPING[0];
        for _ in 0..MOST {
            let slopes = slopes(&at, step, &now, errors);
            let (gram, right) = normal(&slopes, &now, rough);
            let mut found = None;
            while found.is_none() && damping < DAMPING[3] {
                let next = damped(&gram, &right, damping).map(|z| moved(&at, &z));
                found = next.and_then(|next| {
                    let error = errors(&next)?;
                    let own = loss_of(&error, rough);
                    (own < loss).then_some((next, error, own))
                });
                damping *= DAMPING[if found.is_some() { 1 } else { 2 }];
            }
            let Some((next, error, own)) = found else {
                break;
            };
            let gained = 1.0 - (own / loss).powi(2);
            (at, now, loss) = (next, error, own);
            if gained < GAIN {
                break;
            }
        }
    }
    Some(Valley { at, loss })
}

/// Root of the mean of Charbonnier's loss: an RMS in which errors beyond `rough` count less.
pub(super) fn loss_of(errors: &[f64], rough: f64) -> f64 {
    let one = |e: &f64| 2.0 * rough * rough * ((1.0 + (e / rough).powi(2)).sqrt() - 1.0);
    (errors.iter().map(one).sum::<f64>() / errors.len() as f64).sqrt()
}

/// Gram matrix of the slopes and their product with the errors, each sample weighted as its loss asks.
pub(super) fn normal(
    slopes: &DMatrix<f64>,
    errors: &[f64],
    rough: f64,
) -> (DMatrix<f64>, DVector<f64>) {
    let weight = |e: &f64| (1.0 + (e / rough).powi(2)).powf(-0.25);
    let mut weighted = slopes.clone();
    for (mut row, e) in weighted.row_iter_mut().zip(errors) {
        row *= weight(e);
    }
    let right = errors.iter().map(|e| e * weight(e));
    let right = DVector::from_iterator(errors.len(), right);
    (weighted.tr_mul(&weighted), weighted.tr_mul(&right))
}

/// Change of every error with every parameter, in its scale.
pub(super) fn slopes(
    at: &[f64],
    step: f64,
    now: &[f64],
    errors: &(impl Fn(&[f64]) -> Option<Vec<f64>> + Sync),
) -> DMatrix<f64> {
    let of = |j: usize| {
        let beside = |by: f64| {
            let mut other = at.to_vec();
            other[j] += by;
            errors(&other)
        };
        // At the edge of what can be, one side tells.
        let (up, down) = (beside(step), beside(-step));
        let width = step * f64::from(u8::from(up.is_some()) + u8::from(down.is_some()));
        let (up, down) = (up.as_deref().unwrap_or(now), down.as_deref().unwrap_or(now));
        let slope = up.iter().zip(down).map(|(u, d)| (u - d) / width.max(step));
        DVector::from_iterator(now.len(), slope)
    };
    let columns: Vec<DVector<f64>> = (0..at.len()).into_par_iter().map(of).collect();
    DMatrix::from_columns(&columns)
}

/// The step of least squares, damped by a share of each parameter's own curvature.
fn damped(gram: &DMatrix<f64>, right: &DVector<f64>, damping: f64) -> Option<DVector<f64>> {
    let floor = 1e-9 * gram.diagonal().max();
    let mut damped = gram.clone();
    for j in 0..gram.nrows() {
        damped[(j, j)] += damping * gram[(j, j)] + floor;
    }
    damped.cholesky().map(|c| -c.solve(right))
}

fn moved(at: &[f64], by: &DVector<f64>) -> Vec<f64> {
    at.iter().zip(by.iter()).map(|(a, b)| a + b).collect()
}
