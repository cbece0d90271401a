//! Coulomb friction and plain physics by linear least squares.

use super::plain::Plain;
use super::regression::{Gram, Regressor, solve_normal};
use super::weights::Weights;
use crate::recording::Recording;
use crate::signal::Kinematics;
use crate::statistics::Estimate;
use nalgebra::{DMatrix, DVector};

/// `effort = inertia·a + viscous·v + coulomb·sgn v + offset`, and what else of [`Plain`] physics there is.
#[derive(Clone, Debug)]
pub struct RigidBody {
    /// What is fitted beside Coulomb friction.
    pub plain: Plain,
    /// Coefficients of its columns.
    pub linear: Vec<f64>,
    /// What they say, and `coulomb`.
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

/// Fits the rigid body over the folds' samples. Both sides of the equation go through the same zero-phase filter
/// where the effort contains inertia, so that the filter biases nothing.
///
/// # Errors
/// That the motion does not separate them.
pub fn fit(
    recording: &Recording,
    kinematics: &Kinematics,
    effort: &[f64],
    folds: &[Vec<usize>],
    weights: &Weights,
    plain: Plain,
) -> Result<RigidBody, String> {
    let inertial = recording.role.contains_inertia();
    let folds = &moving(recording, kinematics, folds);
    let mut columns = plain.columns(recording, kinematics);
    let moves = |sign: f64| {
        folds
            .iter()
            .flatten()
            .any(|&i| kinematics.direction[i] == sign)
    };
    let both_ways = moves(1.0) && moves(-1.0);
    if both_ways {
        columns.push(Regressor {
            name: "coulomb",
            values: if inertial {
                kinematics.filter.smooth(&kinematics.direction)
            } else {
                kinematics.direction.clone()
            },
        });
    }
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
            "{}: the motion cannot separate inertia, viscous friction, Coulomb friction and offset; record both directions at several speeds",
            recording.name
        )
    })?;
    let covariance = clustered(&matrix, &coefficients, &grams, &chosen);
    let fitted = (0..recording.len())
        .map(|i| (0..p).map(|j| coefficients[j] * every[j][i]).sum())
        .collect();
    let linear: Vec<f64> = (coefficients.iter().copied())
        .take(p - usize::from(both_ways))
        .collect();
    let mut parameters = plain.parameters(recording, &linear, covariance.as_ref(), folds.len());
    if both_ways {
        let error = covariance.map(|c| c[(p - 1, p - 1)].max(0.0).sqrt());
        let coulomb = Estimate::new(coefficients[p - 1], error, folds.len());
        parameters.push(("coulomb", coulomb));
    } else {
        // What friction and a constant load share is reported as one.
        let offset = parameters.iter_mut().filter(|p| p.0 == "offset");
        offset.for_each(|p| p.0 = "coulomb_and_offset");
    }
    Ok(RigidBody {
        plain,
        linear,
        parameters,
        fitted,
    })
}

/// Periods of the filter's cut-off over which it blurs.
const BLUR: f64 = 2.0;

/// Of every fold the samples at which the law of sliding holds: not at rest, where friction is any force up to breakaway, and not where a piece
/// begins or ends in motion, where the filter knows only one side. All of them if little else would be left.
pub fn moving(
    recording: &Recording,
    kinematics: &Kinematics,
    folds: &[Vec<usize>],
) -> Vec<Vec<usize>> {
    if !recording.role.contains_inertia() {
        return folds.to_vec();
    }
    let blur = BLUR / (kinematics.filter.cutoff_hz() * recording.sample_time_s());
    let blur = blur.ceil() as usize;
    let mut told = vec![true; recording.len()];
    for piece in &recording.pieces {
        let direction = &kinematics.direction[piece.clone()];
        let mut start = 0;
        for run in direction.chunk_by(|a, b| (*a == 0.0) == (*b == 0.0)) {
            let (from, to) = (start, start + run.len());
            start = to;
            let rests = run[0] == 0.0;
            let mut leave_out = |from: usize, to: usize| {
                told[piece.start + from..piece.start + to.min(piece.len())].fill(false);
            };
            if rests && run.len() > blur {
                leave_out(from.saturating_sub(blur), to + blur);
            }
            if !rests && from == 0 {
                leave_out(0, blur);
            }
            if !rests && to == piece.len() {
                leave_out(piece.len().saturating_sub(blur), piece.len());
            }
        }
    }
    let kept: Vec<Vec<usize>> = folds
        .iter()
        .map(|fold| fold.iter().copied().filter(|i| told[*i]).collect())
        .filter(|fold: &Vec<usize>| !fold.is_empty())
        .collect();
    let samples = |folds: &[Vec<usize>]| folds.iter().map(Vec::len).sum::<usize>();
    match 2 * samples(&kept) > samples(folds) {
        true => kept,
        false => folds.to_vec(),
    }
}

/// Share of the acceleration's squares, where the axis moves, that direction, velocity and a constant leave; 0 if the columns cannot be separated.
pub fn inertia_told(recording: &Recording, kinematics: &Kinematics, folds: &[Vec<usize>]) -> f64 {
    let rows = moving(recording, kinematics, folds).concat();
    let direction = kinematics.filter.smooth(&kinematics.direction);
    let ones = vec![1.0; recording.len()];
    let columns = [
        &direction,
        &kinematics.velocity,
        &ones,
        &kinematics.acceleration,
    ];
    let gram = Gram::of(&columns.map(Vec::as_slice), &rows);
    let (matrix, right) = gram.normal(&[0, 1, 2]);
    let whole = gram.products[(3, 3)];
    let Some(fit) = solve_normal(&matrix, &right) else {
        return 0.0;
    };
    (whole - fit.dot(&right)) / whole
}

fn gram(columns: &[&[f64]], rows: &[usize], weights: &Weights) -> Gram {
    if !weights.differ() {
        return Gram::of(columns, rows);
    }
    let weighted: Vec<Vec<f64>> = columns.iter().map(|c| weights.rows(c, rows)).collect();
    let weighted: Vec<&[f64]> = weighted.iter().map(Vec::as_slice).collect();
    Gram::of(&weighted, &(0..rows.len()).collect::<Vec<_>>())
}

/// Covariance clustered by fold, as in [`super::refine::covariance`].
pub fn clustered(
    matrix: &DMatrix<f64>,
    coefficients: &DVector<f64>,
    folds: &[Gram],
    chosen: &[usize],
) -> Option<DMatrix<f64>> {
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
    Some(&inverse * meat * &inverse * (count / (count - 1.0)))
}
