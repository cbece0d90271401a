//! A force that is periodic in the position, as a motor's cogging and a screw's error are: no model of `identify` has it, and what it leaves is alike in
//! neighbouring samples, so that an offset or a friction that differs by direction predicts it by chance.

use super::evidence::{Evidence, FALLING, LAW, WAVE};
use super::plain::{Place, Plain};
use super::regression::{Regression, Regressor};
use crate::recording::{MotionKind, Recording};
use crate::signal::{Kinematics, ONE_SLOPE_RAD, spectra};
use crate::statistics::LeastSquares;

/// Share of the residual's squares that a sine must hold: less bends nothing by more than the folds scatter.
const HOLDS: f64 = 0.1;
/// Fewest and most periods in the travel. Fewer are a spring or a weight.
const PERIODS: [f64; 2] = [2.0, 200.0];
/// Most sines: a period and two of its harmonics.
const MOST: usize = 3;

impl Evidence<'_> {
    /// What all laws and all plain physics together leave of the force at every sample.
    fn residual(&self, regression: &Regression, plain: Plain, longest: f64) -> Option<Vec<f64>> {
        let laws = self.named(LAW).chain(self.named(FALLING));
        let friction: Vec<usize> = laws.chain(self.blocks(longest)).collect();
        let linear = plain.among(self.columns);
        let (chosen, coefficients) = self.fit(&self.surface.folds, &linear, &friction)?;
        let mut left = regression.force.clone();
        for (column, by) in chosen.iter().zip(&coefficients) {
            let take = |left: &mut [f64], values: &[f64]| {
                let both = left.iter_mut().zip(values);
                both.for_each(|(l, v)| *l -= by * v);
            };
            match column.checked_sub(self.columns.len()) {
                None => take(&mut left, &self.columns[*column].values),
                Some(block) => take(
                    &mut left,
                    &regression.deflection(self.surface.grid[block]).z,
                ),
            }
        }
        Some(left)
    }

    /// Columns of the sines in the position that stand out of the residual; none where none does.
    pub(super) fn waves(
        &self,
        regression: &Regression,
        (recording, kinematics): (&Recording, &Kinematics),
        base: Plain,
        longest: f64,
    ) -> Vec<Regressor> {
        let (low, high) = recording.ends();
        let turns = recording.kind == MotionKind::Rotary && high - low >= ONE_SLOPE_RAD;
        let every = Plain {
            by_direction: true,
            place: if turns { Place::Gravity } else { Place::Spring },
            ..base
        };
        let Some(residual) = self.residual(regression, every, longest) else {
            return Vec::new();
        };
        let rows = regression.folds.concat();
        let of = |values: &[f64]| rows.iter().map(|i| values[*i]).collect::<Vec<f64>>();
        let (at, mut left) = (of(&recording.position), of(&residual));
        let speed: Vec<f64> = of(&kinematics.velocity).iter().map(|v| v.abs()).collect();
        let mut found = Vec::new();
        for _ in 0..MOST {
            let Some(order) = strongest(&at, &mut left, &speed, high - low) else {
                break;
            };
            found.extend([f64::cos, f64::sin].map(|wave| {
                let force = recording.position.iter().map(|x| wave(order * x));
                let force: Vec<f64> = force.collect();
                Regressor {
                    name: WAVE,
                    values: (regression.filter)(&force),
                }
            }));
        }
        found
    }
}

/// The angular wave number (rad per unit of `at`) of the sine that holds most of what is `left`, which is taken off it; `None` where that is little.
fn strongest(at: &[f64], left: &mut [f64], speed: &[f64], travel: f64) -> Option<f64> {
    // By the path, not by the time: a rest is one place.
    let along: Vec<f64> = left.iter().zip(speed).map(|(l, v)| l * v).collect();
    let [from, to] = PERIODS.map(|periods| periods / travel);
    let order = std::f64::consts::TAU * spectra::strongest(at, &along, from, to)?;
    let of = |wave: fn(f64) -> f64| at.iter().map(|x| wave(order * x)).collect::<Vec<f64>>();
    let columns = [vec![1.0; at.len()], of(f64::cos), of(f64::sin)];
    let columns = columns.each_ref().map(Vec::as_slice);
    let fit = LeastSquares::of(&columns)?.coefficients(left);
    let squares = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>();
    let before = squares(left);
    for (i, l) in left.iter_mut().enumerate() {
        *l -= (0..3).map(|j| fit[j] * columns[j][i]).sum::<f64>();
    }
    (squares(left) < (1.0 - HOLDS) * before).then_some(order)
}
