//! A table of speed and effort without time: Coulomb and viscous friction, a constant force, and a Stribeck curve where there is one.
//!
//! `F = F_c·sgn v + b·v + d·|v| + (F_s − F_c)·sgn v·exp(−(v/v_s)²) + F_0`, by least squares; `d` and the Stribeck curve are there where chance makes
//! the gain once in ten thousand tables. Intervals are those of the linearised fit, with Student's t.

mod present;
#[cfg(test)]
mod tests;

use crate::effects::Effect;
use crate::friction::FrictionModel;
use crate::model::Model;
use crate::recording::Speeds;
use crate::report::figures::significant;
use crate::statistics::{Estimate, nmse};
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// Probability of a gain by chance below which a term is there: many speeds `v_s` are tried.
const CHANCE: f64 = 1e-4;

/// Speeds `v_s` that are tried.
const TRIED: i32 = 80;

/// Fewest rows beyond the parameters.
const SPARE: usize = 3;

/// Largest error held out (%) of a table that this law describes.
const MOST_LEFT: f64 = 50.0;

/// What is fitted to a table.
#[derive(Clone, Debug)]
pub struct SpeedTable {
    speeds: Speeds,
    /// By their names; `fit` has the keys.
    parameters: Vec<(&'static str, Estimate)>,
    /// What is modelled at each row.
    fitted: Vec<f64>,
    nmse_train: f64,
    nmse_held_out: f64,
    notes: Vec<String>,
}

/// What a law has beside Coulomb and viscous friction and a constant force.
#[derive(Clone, Copy, Debug, Default)]
struct Law {
    by_direction: bool,
    /// `v_s` (m/s or rad/s).
    stribeck: Option<f64>,
    /// Motion of one sign: Coulomb friction and a constant force are one.
    one_way: bool,
}

impl Law {
    /// The columns at a speed, the Stribeck curve's last.
    fn columns(self, v: f64) -> Vec<f64> {
        let mut columns = vec![v.signum(), v];
        if !self.one_way {
            columns.push(1.0);
        }
        if self.by_direction {
            columns.push(v.abs());
        }
        columns.extend(
            self.stribeck
                .map(|v_s| v.signum() * (-(v / v_s).powi(2)).exp()),
        );
        columns
    }
}

/// A solved law.
struct Solved {
    law: Law,
    coefficients: DVector<f64>,
    squares: f64,
}

fn solve(speeds: &Speeds, law: Law) -> Option<Solved> {
    let rows: Vec<Vec<f64>> = speeds.velocity.iter().map(|v| law.columns(*v)).collect();
    let matrix = DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j]);
    let effort = DVector::from_column_slice(&speeds.effort);
    let coefficients = matrix.clone().svd(true, true).solve(&effort, 1e-12).ok()?;
    let squares = (matrix * &coefficients - effort).norm_squared();
    Some(Solved {
        law,
        coefficients,
        squares,
    })
}

/// Whether so many parameters more are there, of what the errors were and are with `spare` rows beyond all parameters.
fn is_there(before: f64, after: f64, more: f64, spare: f64) -> bool {
    let ratio = (before - after) / more / (after / spare);
    // Nothing left is no chance.
    let by_chance = FisherSnedecor::new(more, spare).map_or(1.0, |f| 1.0 - f.cdf(ratio));
    before > after && (by_chance < CHANCE || after == 0.0)
}

/// Fits the table.
///
/// # Errors
/// Why it shows nothing, and what would.
pub fn fit(mut speeds: Speeds, may_turn: bool) -> Result<SpeedTable, String> {
    let mut notes = Vec::new();
    let name = speeds.name.clone();
    let fail = |why: &str| Err(format!("{name}: {why}"));
    let standing = speeds.velocity.iter().filter(|v| **v == 0.0).count();
    if standing > 0 {
        notes.push(format!(
            "{standing} rows at zero speed are left out: friction at rest can be anything up to its level"
        ));
        let moving: Vec<bool> = speeds.velocity.iter().map(|v| *v != 0.0).collect();
        let keep = |values: &mut Vec<f64>| {
            let mut flags = moving.iter();
            values.retain(|_| *flags.next().unwrap_or(&true));
        };
        keep(&mut speeds.velocity);
        keep(&mut speeds.effort);
    }
    let mut different: Vec<f64> = speeds.velocity.iter().map(|v| v.abs()).collect();
    different.sort_by(f64::total_cmp);
    different.dedup();
    let [.., top] = different[..] else {
        return fail(
            "no row has a speed; a table of speed and effort has one for each speed that was held",
        );
    };
    if different.len() < 3 || speeds.velocity.len() < 3 + SPARE {
        return Err(format!(
            "{name}: {} rows of {} speeds: Coulomb and viscous friction need three speeds or more, in {} rows or more",
            speeds.velocity.len(),
            different.len(),
            3 + SPARE
        ));
    }
    if speeds.effort.iter().all(|f| *f == speeds.effort[0]) {
        return fail("the effort is the same in all rows; map the column that holds it");
    }
    let forward = speeds.velocity.iter().filter(|v| **v > 0.0).count();
    let one_way = forward == 0 || forward == speeds.velocity.len();
    let law = Law {
        one_way,
        ..Law::default()
    };
    let failed =
        || format!("{name}: these rows have no fit; look for repeated values or another unit");
    let mut best = solve(&speeds, law).ok_or_else(failed)?;
    if best.coefficients[0] < 0.0 && best.coefficients[1] < 0.0 && may_turn {
        speeds.effort.iter_mut().for_each(|f| *f = -*f);
        notes.push(
            "the effort opposes the motion in all of the table, so it was multiplied by -1; --sign -1 says so and silences this, --sign 1 forbids it"
                .to_owned(),
        );
        best = solve(&speeds, law).ok_or_else(failed)?;
    }
    let rows = speeds.velocity.len();
    let slanted = Law {
        by_direction: true,
        ..law
    };
    let spare = |parameters: usize| rows.saturating_sub(parameters) as f64;
    if !one_way && spare(4) >= SPARE as f64 {
        let with = solve(&speeds, slanted).ok_or_else(failed)?;
        if is_there(best.squares, with.squares, 1.0, spare(4)) {
            best = with;
        }
    }
    let parameters = best.coefficients.len() + 2;
    if spare(parameters) >= SPARE as f64 && different.len() > 4 {
        let (low, high) = (different[1], 0.5 * top);
        let tried = (0..TRIED).filter(|_| high > low).filter_map(|i| {
            let v_s = low * (high / low).powf(f64::from(i) / f64::from(TRIED - 1));
            let law = Law {
                stribeck: Some(v_s),
                ..best.law
            };
            solve(&speeds, law).filter(|s| s.coefficients[s.coefficients.len() - 1] > 0.0)
        });
        let with = tried.min_by(|a, b| a.squares.total_cmp(&b.squares));
        let with = with.filter(|w| is_there(best.squares, w.squares, 2.0, spare(parameters)));
        best = with.unwrap_or(best);
    }
    let found = SpeedTable::of(speeds, &best, notes).ok_or_else(failed)?;
    if found.nmse_held_out.is_nan() || found.nmse_held_out > MOST_LEFT {
        return fail(&format!(
            "Coulomb and viscous friction leave {:.0} % of the effort's variance: this is not a table of friction over speed; check its columns and units",
            found.nmse_held_out
        ));
    }
    Ok(found)
}

impl SpeedTable {
    fn of(speeds: Speeds, solved: &Solved, notes: Vec<String>) -> Option<Self> {
        let Solved {
            law, coefficients, ..
        } = solved;
        let last = coefficients[coefficients.len() - 1];
        // With the slope over v_s, which makes the intervals those of all parameters together.
        let slopes = |v: f64| {
            let mut row = law.columns(v);
            row.extend(law.stribeck.map(|v_s| {
                let u = (v / v_s).powi(2);
                last * v.signum() * 2.0 * u / v_s * (-u).exp()
            }));
            row
        };
        let rows: Vec<Vec<f64>> = speeds.velocity.iter().map(|v| slopes(*v)).collect();
        let (n, p) = (rows.len(), rows[0].len());
        let jacobian = DMatrix::from_fn(n, p, |i, j| rows[i][j]);
        let inverse = (jacobian.transpose() * &jacobian).try_inverse()?;
        let variance = solved.squares / (n - p) as f64;
        let covariance = &inverse * variance;
        let estimate = |value: f64, of: &[(usize, f64)]| {
            let mut slope = DVector::zeros(p);
            of.iter().for_each(|(i, share)| slope[*i] = *share);
            let error = (&covariance * &slope).dot(&slope).max(0.0).sqrt();
            // One degree of freedom less than folds.
            Estimate::new(value, Some(error), n - p + 1)
        };
        let c = |i: usize| coefficients[i];
        let mut parameters = Vec::new();
        let level = if law.one_way {
            "coulomb_and_offset"
        } else {
            "coulomb"
        };
        parameters.push((level, estimate(c(0), &[(0, 1.0)])));
        if law.by_direction {
            parameters.push((
                "viscous_forward",
                estimate(c(1) + c(3), &[(1, 1.0), (3, 1.0)]),
            ));
            parameters.push((
                "viscous_backward",
                estimate(c(1) - c(3), &[(1, 1.0), (3, -1.0)]),
            ));
        } else {
            parameters.push(("viscous", estimate(c(1), &[(1, 1.0)])));
        }
        if !law.one_way {
            parameters.push(("offset", estimate(c(2), &[(2, 1.0)])));
        }
        if let Some(v_s) = law.stribeck {
            let at = coefficients.len() - 1;
            parameters.push(("static", estimate(c(0) + last, &[(0, 1.0), (at, 1.0)])));
            parameters.push(("stribeck_velocity", estimate(v_s, &[(at + 1, 1.0)])));
        }
        let columns = speeds.velocity.iter().map(|v| law.columns(*v));
        let fitted: Vec<f64> = columns
            .map(|row| {
                row.iter()
                    .zip(coefficients.iter())
                    .map(|(x, c)| x * c)
                    .sum()
            })
            .collect();
        // Each row left out in turn, by its leverage.
        let leverage = |i: usize| {
            let row = jacobian.row(i);
            (row * &inverse * row.transpose())[0].min(1.0 - 1e-9)
        };
        let held_out = (0..n).map(|i| {
            let error = speeds.effort[i] - fitted[i];
            speeds.effort[i] - error / (1.0 - leverage(i))
        });
        let held_out: Vec<f64> = held_out.collect();
        let all: Vec<usize> = (0..n).collect();
        Some(Self {
            parameters,
            nmse_train: nmse(&speeds.effort, &fitted, &all),
            nmse_held_out: nmse(&speeds.effort, &held_out, &all),
            fitted,
            speeds,
            notes,
        })
    }

    fn get(&self, name: &str) -> Option<f64> {
        let mut of = self.parameters.iter().filter(|p| p.0 == name);
        of.next().map(|p| p.1.value)
    }

    /// The model: without an inertia.
    ///
    /// # Errors
    /// What of the parameters no model can have.
    pub fn model(&self) -> Result<Model, String> {
        let get = |name: &str| self.get(name).unwrap_or(0.0);
        let (forward, backward) = match self.get("viscous") {
            Some(viscous) => (viscous, viscous),
            None => (get("viscous_forward"), get("viscous_backward")),
        };
        let coulomb = get("coulomb") + get("coulomb_and_offset");
        if coulomb <= 0.0 || forward + backward < 0.0 {
            return Err(format!(
                "{}: Coulomb friction of {} with viscous friction of {} is impossible; check the sign of the effort",
                self.speeds.name,
                significant(coulomb),
                significant(0.5 * (forward + backward))
            ));
        }
        let mut effects = Vec::new();
        if forward != backward {
            let half = 0.5 * (forward - backward);
            let values = [("half_difference_N_s_per_m", half)];
            effects.push(Effect::new("viscous_asymmetry", &values)?);
        }
        if let (Some(level), Some(v_s)) = (self.get("static"), self.get("stribeck_velocity")) {
            let level = level / coulomb - 1.0;
            let values = [("level", level), ("velocity_m_s", v_s), ("exponent", 2.0)];
            effects.push(Effect::new("stribeck", &values)?);
        }
        Ok(Model {
            motion: self.speeds.kind,
            effort_unit: self.speeds.role.other_unit(),
            inertia: 0.0,
            viscous: 0.5 * (forward + backward),
            friction: FrictionModel::Coulomb { coulomb },
            constant_force: get("offset"),
            effects,
            mechanics: Vec::new(),
        })
    }
}
