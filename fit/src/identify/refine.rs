//! From the best yields of a grid to the best yields there are, with their confidence.

use super::regression::{Between, Gram, MaxwellSlipFit, Sums, Surface, solve_normal};
use nalgebra::{DMatrix, DVector};

const ITERATIONS: usize = 40;
/// Relative improvement below which a refinement has converged.
const CONVERGED: f64 = 1e-9;

/// Step of `ln D` below which a refused step means that the optimum is reached, not that it was too long.
const STILL: f64 = 1e-6;

/// The best fit with fixed yields.
struct Solved {
    fit: MaxwellSlipFit,
    gram: Gram,
}

/// `None` where a stiffness would not be positive.
fn solve(sums: &impl Sums, yields: Vec<f64>) -> Option<Solved> {
    let gram = sums.at(&yields)?;
    let (linear, n) = (sums.linear(), yields.len());
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
pub fn refine(sums: &impl Sums, start: Vec<f64>, range: (f64, f64)) -> Option<MaxwellSlipFit> {
    refine_until(sums, start, range, CONVERGED)
}

/// [`refine`] that ends at relative improvements below `converged`.
pub fn refine_until(
    sums: &impl Sums,
    start: Vec<f64>,
    (shortest, longest): (f64, f64),
    converged: f64,
) -> Option<MaxwellSlipFit> {
    let mut best = solve(sums, start)?;
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
            solve(sums, yields)
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

/// Squared error that `fit` leaves.
pub fn squared_error(sums: &impl Sums, fit: &MaxwellSlipFit) -> Option<f64> {
    let gram = sums.at(&fit.yields)?;
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
pub fn covariance(surface: &Surface, fit: &MaxwellSlipFit) -> Option<DMatrix<f64>> {
    let count = surface.folds.len() as f64;
    if surface.folds.len() < 2 {
        return None;
    }
    let of = |folds: &Gram| {
        let folds = folds.clone();
        Some(joint(fit, &Between { surface, folds }.at(&fit.yields)?))
    };
    let (bread, _) = of(&Gram::sum(&surface.folds)?)?;
    let mut meat = DMatrix::zeros(bread.nrows(), bread.nrows());
    for fold in &surface.folds {
        let (_, score) = of(fold)?;
        meat += &score * score.transpose();
    }
    let inverse = bread.cholesky()?.inverse();
    Some(&inverse * meat * &inverse * (count / (count - 1.0)))
}
