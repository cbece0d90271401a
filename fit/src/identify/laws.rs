//! Other laws of friction beside the blocks, and what plain physics would be beside them.
//!
//! A number of blocks is a model's form and no law of nature. Where friction nears its level along a tail, forgets inner loops (Dahl), or follows
//! the speed alone (`tanh`), blocks leave an error that every stroke repeats: no scatter of the folds shows it, and inertia, viscous friction and the
//! level are bent by it to beyond their intervals. A mixture of all these laws, none with a negative share, is free where blocks are not.
//! Nor does a log say at which moment between two samples its effort acts: the mixture has that free, too.

use super::evidence::{Evidence, Shown};
use super::fit::{shown as name_shown, unit};
use super::regression::{Gram, Regressor, Surface};
use super::rigid_body::clustered;
use super::{Candidate, Identification};
use crate::recording::Recording;
use crate::report::figures::{left, quantity};
use crate::signal::{Kinematics, LATE, RELAXED, SMOOTH, bristle};
use crate::statistics::{Estimate, quantile_between_ranks, spread};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Relaxation lengths of bristles, from two of the shortest yields on: over four decades neighbours differ by a factor of four, between which two mix.
const LENGTHS: usize = 8;
/// Share of the error of the recommended blocks below which the mixture's is worth a word.
const WORTH_TELLING: f64 = 0.5;
/// Error (%) of the blocks below which it is not: what is left is nothing that anybody looks for.
const HARDLY_ANY: f64 = 0.05;

/// Name of a column that is the force of a law …
const LAW: &str = "law";
/// … and of the one that is the effort's change within a sample.
const SHIFT: &str = "shift";

/// A law that is linear in its level, which is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Law {
    /// `dz/dx = (1 − sgn(v)·z)ⁿ/d` (Dahl 1968) with n = 1 or 2 and the length `d` (m or rad).
    Bristles { squared: bool, length: f64 },
    /// `tanh(v/v₀)` with the speed `v₀` (m/s or rad/s).
    Smooth(f64),
}

impl Law {
    /// Those that the rows `train` of a recording can show, beside blocks that yield from `shortest` (m or rad) on.
    pub(super) fn all(
        recording: &Recording,
        kinematics: &Kinematics,
        train: &[usize],
        shortest: f64,
    ) -> Vec<Self> {
        let (low, high) = recording.ends();
        let lengths = spread(2.0 * shortest, LATE * (high - low) / RELAXED, LENGTHS);
        let bristles = lengths
            .into_iter()
            .flat_map(|length| [false, true].map(|squared| Self::Bristles { squared, length }));
        let speeds: Vec<f64> = train
            .iter()
            .map(|i| kinematics.velocity[*i].abs())
            .collect();
        let top = quantile_between_ranks(&speeds, 0.95);
        bristles
            .chain(SMOOTH.map(|share| Self::Smooth(share * top)))
            .collect()
    }

    /// Its force at every sample.
    fn force(self, recording: &Recording, kinematics: &Kinematics) -> Vec<f64> {
        match self {
            Self::Smooth(speed) => {
                let velocity = kinematics.velocity.iter();
                velocity.map(|v| (v / speed).tanh()).collect()
            }
            Self::Bristles { squared, length } => {
                let z = bristle(&recording.position, &recording.pieces, length, squared);
                z.into_iter().map(|z| z / length).collect()
            }
        }
    }
}

/// Columns of `laws` for the mixture, filtered as the effort is where it contains inertia; then also what the effort would be a sample later, less
/// what it is.
pub(super) fn columns(
    laws: &[Law],
    recording: &Recording,
    kinematics: &Kinematics,
    effort: &[f64],
) -> Vec<Regressor> {
    let filter = &kinematics.filter;
    let inertial = recording.role.contains_inertia();
    let of_law = laws.par_iter().map(|law| {
        let raw = law.force(recording, kinematics);
        Regressor {
            name: LAW,
            values: if inertial { filter.smooth(&raw) } else { raw },
        }
    });
    let mut columns: Vec<Regressor> = of_law.collect();
    if inertial {
        let by = recording.sample_time_s();
        let slope = filter.derivative(effort, 1);
        columns.push(Regressor {
            name: SHIFT,
            values: slope.iter().map(|slope| by * slope).collect(),
        });
    }
    columns
}

/// What a mixture of all laws makes of the plain physics.
#[derive(Clone, Debug)]
pub(super) struct Mixture {
    /// NMSE (%) on stretches that were held out in turn.
    nmse_cross: f64,
    /// Plain physics and the level, as of a candidate.
    parameters: Vec<(&'static str, Estimate)>,
    /// Speed (m/s or rad/s) over which friction reverses, where most of it follows the speed alone.
    speed: Option<f64>,
}

impl Mixture {
    /// Fits `laws`, which the evidence has columns of, and blocks beside the plain physics that is `shown`. Errors are clustered by the folds of
    /// `surface`, which has the evidence's columns.
    pub(super) fn of(
        evidence: &Evidence,
        surface: &Surface,
        laws: &[Law],
        recording: &Recording,
        shown: Shown,
    ) -> Option<Self> {
        let columns = evidence.columns;
        let named = |name| columns.iter().position(|c| c.name == name);
        let first = named(LAW)?;
        let law = |column: usize| laws.get(column.checked_sub(first)?);
        let plain = shown.plain.among(columns);
        let linear: Vec<usize> = plain.iter().copied().chain(named(SHIFT)).collect();
        let mut friction: Vec<usize> = (first..first + laws.len()).collect();
        friction.extend(evidence.blocks(shown.longest));
        let (chosen, coefficients) = evidence.fit(&surface.folds, &linear, &friction)?;
        // What the laws are worth by themselves.
        let held_out = evidence.held_out(&plain, &friction)?;
        let total = Gram::sum(&surface.folds)?;
        let matrix = total.normal(&chosen).0;
        let covariance = clustered(&matrix, &coefficients, &surface.folds, &chosen);

        let level = |column: &usize| match column.checked_sub(columns.len()) {
            Some(block) => surface.grid[block],
            None => f64::from(law(*column).is_some()),
        };
        let levels = DVector::from_iterator(chosen.len(), chosen.iter().map(level));
        let error = |c: &DMatrix<f64>| (c * &levels).dot(&levels).max(0.0).sqrt();
        let coulomb = levels.dot(&coefficients);
        let folds = surface.folds.len();
        let (own, covariance) = (&coefficients.as_slice()[..plain.len()], covariance.as_ref());
        let mut parameters = (shown.plain).parameters(recording, own, covariance, folds);
        let estimate = Estimate::new(coulomb, covariance.map(error), folds);
        parameters.push(("coulomb", estimate));

        let shares = chosen.iter().zip(&coefficients);
        let smooth = shares.filter_map(|(column, share)| match law(*column)? {
            Law::Smooth(speed) => Some((*share, speed.ln())),
            Law::Bristles { .. } => None,
        });
        let (share, speed) = smooth.fold((0.0, 0.0), |(sum, speed), (share, of)| {
            (sum + share, speed + share * of)
        });
        Some(Self {
            nmse_cross: 100.0 * held_out.iter().sum::<f64>() / total.force_variation(),
            parameters,
            speed: (share > 0.5 * coulomb).then(|| (speed / share).exp()),
        })
    }
}

impl Candidate {
    /// Intervals that reach to what others make of each parameter, too; the names of those that did not.
    fn reach_to(&mut self, others: &[(&'static str, Estimate)]) -> Vec<&'static str> {
        let mut wider = Vec::new();
        for (name, own) in &mut self.rigid_body {
            let other = others.iter().find(|p| p.0 == *name);
            let other = other.and_then(|p| p.1.ci95);
            if let (Some(own), Some(other)) = (&mut own.ci95, other) {
                let both = [own[0].min(other[0]), own[1].max(other[1])];
                if both != *own {
                    *own = both;
                    wider.push(*name);
                }
            }
        }
        wider
    }
}

impl Identification {
    /// Lets every interval reach to what a mixture of laws makes of the parameter, and says so where it predicts much better than what is recommended.
    pub(super) fn reach_to_other_laws(&mut self, recording: &Recording) {
        let Some(mixture) = self.mixture.take() else {
            return;
        };
        let candidates = self.candidates.iter_mut();
        candidates.for_each(|c| {
            c.reach_to(&mixture.parameters);
        });
        let own = self.best().nmse_test;
        if own > HARDLY_ANY && mixture.nmse_cross < WORTH_TELLING * own {
            self.search_notes.push(mixture.words(recording, own));
        }
    }

    /// Lets the intervals of a law that the user asked for reach to what the model `before` makes of the parameters, where that leaves much less: the
    /// folds scatter about a law's own values, and do not show how far it bends them.
    pub(super) fn reach_to_a_better(&mut self, before: usize, recording: &Recording) {
        let better = self.candidates[before].clone();
        let Some(own) = self.candidates.get_mut(self.recommended) else {
            return;
        };
        if better.nmse_test >= WORTH_TELLING * own.nmse_test {
            return;
        }
        let reach = own.reach_to(&better.rigid_body);
        let names: Vec<String> = reach
            .iter()
            .map(|name| name_shown(recording, name))
            .collect();
        let [law, other] = [&*own, &better].map(|c| c.model.friction.name());
        let [here, there] = [own.nmse_test, better.nmse_test].map(left);
        let reach = match names.as_slice() {
            [] => String::new(),
            names => format!(": {} reach to its values", names.join(", ")),
        };
        self.search_notes.push(format!(
            "the intervals are those of {law} alone, which leaves {here} of the variance where {other} leaves {there}: what the law lacks bends its parameters, and true values may lie outside{reach}"
        ));
    }
}

impl Mixture {
    /// In words, what laws other than blocks, which leave an error `own` (%), make of this recording.
    fn words(&self, recording: &Recording, own: f64) -> String {
        let [own, here] = [own, self.nmse_cross].map(left);
        let Some(speed) = self.speed else {
            return format!(
                "friction approaches its level along a tail, or forgets inner loops, as Dahl's does: with such bristles added the blocks leave {here} of the variance on held-out data, without them {own}. Intervals include each parameter's value with bristles; `preslide compare` fits Dahl's law and its relatives"
            );
        };
        let figures = self
            .parameters
            .iter()
            .filter(|p| ["mass", "viscous", "coulomb"].contains(&p.0));
        let figures: Vec<String> = figures
            .map(|(name, e)| {
                let size = quantity(e.value, &unit(recording, name));
                format!("{} {size}", name_shown(recording, name))
            })
            .collect();
        format!(
            "friction here follows the speed and reverses smoothly over about {}, as tanh(v/v0) does: with such a law {here} of the variance is left on held-out data, with blocks {own}, and the parameters are {}. No model file has this law; the intervals include these figures",
            quantity(speed, &format!("{}/s", recording.position_unit())),
            figures.join(", ")
        )
    }
}
