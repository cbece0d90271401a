//! From the best yields of a grid to the best yields there are, with their confidence.

use super::regression::{Gram, Regression, solve_normal};
use super::stop::Deflection;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// A fitted Maxwell-slip model with its linear companions.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Yield displacements `D_i` [m or rad], ascending.
    pub yields: Vec<f64>,
    /// Stiffnesses `k_i` [N/m or N·m/rad].
    pub stiffness: Vec<f64>,
    /// Coefficients of the regression's linear columns, in their order.
    pub linear: Vec<f64>,
    /// Squared error over the fitted samples.
    pub squared_error: f64,
}

const ITERATIONS: usize = 40;
/// Relative improvement below which a refinement has converged.
const CONVERGED: f64 = 1e-9;

/// Everything that the force is regressed on for given yields, sample by sample.
struct Design<'a> {
    regression: &'a Regression<'a>,
    deflections: Vec<Deflection>,
}

impl<'a> Design<'a> {
    fn new(regression: &'a Regression<'a>, yields: &[f64]) -> Self {
        Self {
            regression,
            deflections: yields
                .par_iter()
                .map(|&d| regression.deflection(d))
                .collect(),
        }
    }

    /// Sums of products over `rows`: linear columns, deflections, derivatives with respect to `D`, force.
    fn gram(&self, rows: &[usize]) -> Option<Gram> {
        let columns: Vec<&[f64]> = self
            .regression
            .columns
            .iter()
            .map(|c| c.values.as_slice())
            .chain(self.deflections.iter().map(|d| d.z.as_slice()))
            .chain(self.deflections.iter().map(|d| d.slope.as_slice()))
            .chain([self.regression.force.as_slice()])
            .collect();
        let parts: Vec<Gram> = rows
            .par_chunks(4096)
            .map(|rows| Gram::of(&columns, rows))
            .collect();
        Gram::sum(&parts)
    }
}

/// The best fit with fixed yields.
struct Solved {
    fit: Fit,
    gram: Gram,
}

/// `None` where a stiffness would not be positive.
fn solve(regression: &Regression, rows: &[usize], yields: Vec<f64>) -> Option<Solved> {
    let gram = Design::new(regression, &yields).gram(rows)?;
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
        fit: Fit {
            yields,
            stiffness,
            linear: coefficients.iter().take(linear).copied().collect(),
            squared_error,
        },
        gram,
    })
}

/// The joint normal equations in (linear, k, ln D) at `fit`: curvature and gradient.
fn joint(fit: &Fit, gram: &Gram) -> (DMatrix<f64>, DVector<f64>) {
    let Fit {
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

/// Moves the yields, within `[shortest, longest]`, to the nearest least squares optimum.
///
/// Variable projection: stiffnesses and linear coefficients are solved exactly for any yields, and the yields
/// move by damped Gauss–Newton steps on `ln D`. A step that makes a stiffness negative is refused.
pub fn refine(
    regression: &Regression,
    rows: &[usize],
    start: Vec<f64>,
    (shortest, longest): (f64, f64),
) -> Option<Fit> {
    let mut best = solve(regression, rows, start)?;
    let (p, n) = (best.fit.linear.len(), best.fit.yields.len());
    let mut damping = 1e-3;
    for _ in 0..ITERATIONS {
        let (mut matrix, right) = joint(&best.fit, &best.gram);
        for i in p + n..p + 2 * n {
            matrix[(i, i)] *= 1.0 + damping;
        }
        let before = best.fit.squared_error;
        let trial = solve_normal(&matrix, &right).and_then(|step| {
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
                if gain < CONVERGED * before {
                    break;
                }
            }
            _ => {
                damping *= 10.0;
                if damping > 1e6 {
                    break;
                }
            }
        }
    }
    Some(best.fit)
}

/// Standard errors of (linear, k, ln D) that hold although neighbouring errors are alike.
///
/// Sandwich estimate clustered by fold, with the small-sample factor `G/(G − 1)`: the scatter of the folds'
/// scores takes the place of a noise variance. `None` with fewer than two folds or a singular matrix.
pub fn standard_errors(regression: &Regression, fit: &Fit) -> Option<DVector<f64>> {
    let folds = regression.folds.len();
    if folds < 2 {
        return None;
    }
    let design = Design::new(regression, &fit.yields);
    let (bread, _) = joint(fit, &design.gram(&regression.folds.concat())?);
    let mut meat = DMatrix::zeros(bread.nrows(), bread.nrows());
    for fold in &regression.folds {
        let (_, score) = joint(fit, &design.gram(fold)?);
        meat += &score * score.transpose();
    }
    let inverse = bread.cholesky()?.inverse();
    let covariance = &inverse * meat * &inverse * (folds as f64 / (folds as f64 - 1.0));
    Some(covariance.diagonal().map(|v| v.max(0.0).sqrt()))
}
