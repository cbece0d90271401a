//! From the best yields of a grid to the best yields there are, with their confidence.

use super::regression::{Gram, MaxwellSlipFit, Regression, solve_normal};
use crate::signal::Deflection;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::ops::Range;

const ITERATIONS: usize = 40;
/// Relative improvement below which a refinement has converged.
const CONVERGED: f64 = 1e-9;

/// Step of `ln D` below which a refused step means that the optimum is reached, not that it was too long.
const STILL: f64 = 1e-6;

/// Everything that the force is regressed on for given yields, at the samples `rows`: linear columns,
/// deflections, derivatives with respect to `D`, force.
struct Design {
    columns: Vec<Vec<f64>>,
}

impl Design {
    fn new(regression: &Regression, rows: &[usize], yields: &[f64]) -> Self {
        let of_rows = |values: &[f64]| regression.weights.rows(values, rows);
        let (deflections, slopes): (Vec<_>, Vec<_>) = yields
            .par_iter()
            .map(|&d| {
                let Deflection { z, slope } = regression.deflection(d);
                (of_rows(&z), of_rows(&slope))
            })
            .unzip();
        let linear = regression.columns.iter().map(|c| of_rows(&c.values));
        Self {
            columns: linear
                .chain(deflections)
                .chain(slopes)
                .chain([of_rows(&regression.force)])
                .collect(),
        }
    }

    /// Sums of products over a part of the samples.
    fn gram(&self, part: Range<usize>) -> Option<Gram> {
        let columns: Vec<&[f64]> = self.columns.iter().map(Vec::as_slice).collect();
        let parts: Vec<Gram> = part
            .collect::<Vec<usize>>()
            .par_chunks(4096)
            .map(|rows| Gram::of(&columns, rows))
            .collect();
        Gram::sum(&parts)
    }
}

/// The best fit with fixed yields.
struct Solved {
    fit: MaxwellSlipFit,
    gram: Gram,
}

/// `None` where a stiffness would not be positive.
fn solve(regression: &Regression, rows: &[usize], yields: Vec<f64>) -> Option<Solved> {
    let gram = Design::new(regression, rows, &yields).gram(0..rows.len())?;
    let (linear, n) = (regression.columns.len(), yields.len());
    let chosen: Vec<usize> = (0..linear + n).collect();
    let (matrix, right) = gram.normal(&chosen);
    let coefficients = solve_normal(&matrix, &right)?;
    let stiffness: Vec<f64> = coefficients.iter().skip(linear).copied().collect();
    if stiffness.iter().any(|&k| k <= 0.0) {
        return None;
    }
    let squared_error = gram.squared_error(&chosen, &coefficients);
    Some(Solved {
        fit: MaxwellSlipFit {
            yields,
            stiffness,
            linear: coefficients.iter().take(linear).copied().collect(),
            squared_error,
        },
        gram,
    })
}

/// The joint normal equations in (linear, k, ln D) at `fit`: curvature and gradient.
fn joint(fit: &MaxwellSlipFit, gram: &Gram) -> (DMatrix<f64>, DVector<f64>) {
    let MaxwellSlipFit {
        linear,
        stiffness,
        yields,
        ..
    } = fit;
    let (p, n) = (linear.len(), yields.len());
    let all: Vec<usize> = (0..p + 2 * n).collect();
    let (matrix, right) = gram.normal(&all);
    let scale = DVector::from_fn(p + 2 * n, |i, _| {
        i.checked_sub(p + n)
            .map_or(1.0, |i| stiffness[i] * yields[i])
    });
    let value = DVector::from_fn(p + 2 * n, |i, _| {
        if i < p {
            linear[i]
        } else if i < p + n {
            stiffness[i - p]
        } else {
            0.0
        }
    });
    let residual = right - &matrix * &value;
    (
        DMatrix::from_fn(p + 2 * n, p + 2 * n, |i, j| {
            matrix[(i, j)] * scale[i] * scale[j]
        }),
        residual.component_mul(&scale),
    )
}

/// Moves the yields, within `(shortest, longest)`, to the nearest least squares optimum.
///
/// Variable projection: stiffnesses and linear coefficients are solved exactly for any yields, and the yields
/// move by damped Gauss–Newton steps on `ln D`. A step that makes a stiffness negative is refused.
pub fn refine(
    regression: &Regression,
    rows: &[usize],
    start: Vec<f64>,
    range: (f64, f64),
) -> Option<MaxwellSlipFit> {
    refine_until(regression, rows, start, range, CONVERGED)
}

/// [`refine`] that ends at relative improvements below `converged`.
pub fn refine_until(
    regression: &Regression,
    rows: &[usize],
    start: Vec<f64>,
    (shortest, longest): (f64, f64),
    converged: f64,
) -> Option<MaxwellSlipFit> {
    let mut best = solve(regression, rows, start)?;
    let (p, n) = (best.fit.linear.len(), best.fit.yields.len());
    let mut damping = 1e-3;
    for _ in 0..ITERATIONS {
        let (mut matrix, right) = joint(&best.fit, &best.gram);
        for i in p + n..p + 2 * n {
            matrix[(i, i)] *= 1.0 + damping;
        }
        let before = best.fit.squared_error;
        let mut reach = f64::INFINITY;
        let trial = solve_normal(&matrix, &right).and_then(|step| {
            reach = step
                .iter()
                .skip(p + n)
                .fold(0.0, |r: f64, s| r.max(s.abs()));
            let mut yields: Vec<f64> = best
                .fit
                .yields
                .iter()
                .zip(step.iter().skip(p + n))
                .map(|(d, step)| (d * step.clamp(-0.5, 0.5).exp()).clamp(shortest, longest))
                .collect();
            yields.sort_by(f64::total_cmp);
            solve(regression, rows, yields)
        });
        match trial {
            Some(trial) if trial.fit.squared_error < before => {
                let gain = before - trial.fit.squared_error;
                best = trial;
                damping = (damping / 10.0_f64).max(1e-9);
                if gain < converged * before {
                    break;
                }
            }
            _ => {
                damping *= 10.0;
                if damping > 1e6 || reach < STILL {
                    break;
                }
            }
        }
    }
    Some(best.fit)
}

/// Squared error that `fit` leaves on `rows`.
pub fn squared_error(regression: &Regression, fit: &MaxwellSlipFit, rows: &[usize]) -> Option<f64> {
    let gram = Design::new(regression, rows, &fit.yields).gram(0..rows.len())?;
    let coefficients = DVector::from_iterator(
        fit.linear.len() + fit.stiffness.len(),
        fit.linear.iter().chain(&fit.stiffness).copied(),
    );
    let chosen: Vec<usize> = (0..coefficients.len()).collect();
    Some(gram.squared_error(&chosen, &coefficients))
}

/// Covariance of (linear, k, ln D) that holds although neighbouring errors are alike.
///
/// Sandwich estimate clustered by fold, with the small-sample factor `G/(G − 1)`: the scatter of the folds'
/// scores takes the place of a noise variance. `None` with fewer than two folds or a singular matrix.
pub fn covariance(regression: &Regression, fit: &MaxwellSlipFit) -> Option<DMatrix<f64>> {
    let folds = regression.folds.len();
    if folds < 2 {
        return None;
    }
    let rows = regression.folds.concat();
    let design = Design::new(regression, &rows, &fit.yields);
    let (bread, _) = joint(fit, &design.gram(0..rows.len())?);
    let mut meat = DMatrix::zeros(bread.nrows(), bread.nrows());
    let mut end = 0;
    for fold in &regression.folds {
        let start = end;
        end += fold.len();
        let (_, score) = joint(fit, &design.gram(start..end)?);
        meat += &score * score.transpose();
    }
    let inverse = bread.cholesky()?.inverse();
    Some(&inverse * meat * &inverse * (folds as f64 / (folds as f64 - 1.0)))
}
