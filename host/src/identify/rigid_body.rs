//! Inertia, viscous friction, Coulomb friction and offset by linear least squares.

use super::regression::{Gram, Regressor, solve_normal};
use super::weights::Weights;
use crate::recording::Recording;
use crate::signal::Kinematics;
use crate::statistics::Estimate;
use nalgebra::{DMatrix, DVector};

/// `effort = inertia·a + viscous·v + coulomb·sgn v + offset`.
#[derive(Clone, Debug)]
pub struct RigidBody {
    /// Coefficients by name: `mass` and `viscous` where they are fitted, `coulomb`, `offset`.
    pub parameters: Vec<(&'static str, Estimate)>,
    /// Coefficient times column, summed: the fitted effort at every sample.
    pub fitted: Vec<f64>,
}

impl RigidBody {
    /// The value of a coefficient, 0 where it was not fitted.
    pub fn value(&self, name: &str) -> f64 {
        self.parameters
            .iter()
            .find(|p| p.0 == name)
            .map_or(0.0, |p| p.1.value)
    }
}

/// What a rigid body fit contains beside Coulomb friction and offset.
#[derive(Clone, Copy, Debug)]
pub struct Terms {
    /// Inertia.
    pub mass: bool,
    /// Viscous friction.
    pub viscous: bool,
}

/// Fits the rigid body over the folds' samples. Both sides of the equation go through the same zero-phase filter
/// where the effort contains inertia, so that the filter biases nothing.
///
/// # Errors
/// Which of the four the motion does not show.
pub fn fit(
    recording: &Recording,
    kinematics: &Kinematics,
    effort: &[f64],
    folds: &[Vec<usize>],
    weights: &Weights,
    terms: Terms,
) -> Result<RigidBody, String> {
    let inertial = recording.role.contains_inertia();
    let mut columns = Vec::new();
    if terms.mass {
        columns.push(Regressor {
            name: "mass",
            values: kinematics.acceleration.clone(),
        });
    }
    if terms.viscous {
        columns.push(Regressor {
            name: "viscous",
            values: kinematics.velocity.clone(),
        });
    }
    columns.push(Regressor {
        name: "coulomb",
        values: if inertial {
            kinematics.filter.smooth(&kinematics.direction)
        } else {
            kinematics.direction.clone()
        },
    });
    columns.push(Regressor {
        name: "offset",
        values: vec![1.0; recording.len()],
    });

    let p = columns.len();
    let every: Vec<&[f64]> = columns
        .iter()
        .map(|c| c.values.as_slice())
        .chain([effort])
        .collect();
    let grams: Vec<Gram> = folds
        .iter()
        .map(|rows| gram(&every, rows, weights))
        .collect();
    let total = Gram::sum(&grams).ok_or("there are no samples to fit")?;
    let chosen: Vec<usize> = (0..p).collect();
    let (matrix, right) = total.normal(&chosen);
    let coefficients = solve_normal(&matrix, &right).ok_or_else(|| {
        format!(
            "{}: the motion does not tell inertia, viscous friction, Coulomb friction and offset apart; record both directions at several speeds",
            recording.name
        )
    })?;
    let errors = clustered_errors(&matrix, &coefficients, &grams, &chosen);
    let fitted = (0..recording.len())
        .map(|i| (0..p).map(|j| coefficients[j] * every[j][i]).sum())
        .collect();
    let parameters = columns
        .iter()
        .enumerate()
        .map(|(j, column)| {
            let error = errors.as_ref().map(|e| e[j]);
            (
                column.name,
                Estimate::new(coefficients[j], error, folds.len()),
            )
        })
        .collect();
    Ok(RigidBody { parameters, fitted })
}

fn gram(columns: &[&[f64]], rows: &[usize], weights: &Weights) -> Gram {
    if !weights.differ() {
        return Gram::of(columns, rows);
    }
    let weighted: Vec<Vec<f64>> = columns.iter().map(|c| weights.rows(c, rows)).collect();
    let weighted: Vec<&[f64]> = weighted.iter().map(Vec::as_slice).collect();
    Gram::of(&weighted, &(0..rows.len()).collect::<Vec<_>>())
}

/// Standard errors clustered by fold, as in [`super::refine::covariance`].
fn clustered_errors(
    matrix: &DMatrix<f64>,
    coefficients: &DVector<f64>,
    folds: &[Gram],
    chosen: &[usize],
) -> Option<DVector<f64>> {
    let count = folds.len() as f64;
    if folds.len() < 2 {
        return None;
    }
    let mut meat = DMatrix::zeros(chosen.len(), chosen.len());
    for fold in folds {
        let (own, right) = fold.normal(chosen);
        let score = right - own * coefficients;
        meat += &score * score.transpose();
    }
    let inverse = matrix.clone().cholesky()?.inverse();
    let covariance = &inverse * meat * &inverse * (count / (count - 1.0));
    Some(covariance.diagonal().map(|v| v.max(0.0).sqrt()))
}
