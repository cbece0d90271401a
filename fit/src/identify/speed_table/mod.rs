//! A table of speed and effort without time: Coulomb and viscous friction, a constant force, and a Stribeck curve where there is one.
//!
//! `F = F_c·sgn v + b·v + d·|v| + (F_s − F_c)·sgn v·exp(−|v/v_s|^δ) + F_0`, by least squares; `d` and the Stribeck curve are there where chance makes
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

/// Exponents `δ` that a model may have.
const EXPONENTS: [f64; 2] = [1.0, 4.0];

/// Speeds `v_s` and exponents that are tried, and about the best of those, ever closer.
const TRIED: [[usize; 2]; 4] = [[25, 7], [9, 9], [9, 9], [9, 9]];

/// Bisections of an interval's end: to a thousandth of the range.
const HALVINGS: u32 = 10;

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

/// `exp(−|v/v_s|^δ)`.
#[derive(Clone, Copy, Debug)]
struct Curve {
    /// `v_s` (m/s or rad/s).
    velocity: f64,
    /// `δ`.
    exponent: f64,
}

impl Curve {
    /// Its value at a speed, and its slopes over `v_s` and `δ`.
    fn at(self, v: f64) -> [f64; 3] {
        let ratio = v.abs() / self.velocity;
        let u = ratio.powf(self.exponent);
        let value = (-u).exp();
        // No row has a speed of zero, whose logarithm is infinite.
        let [by_velocity, by_exponent] = [self.exponent * u / self.velocity, -u * ratio.ln()];
        [value, value * by_velocity, value * by_exponent]
    }
}

/// What a law has beside Coulomb and viscous friction and a constant force.
#[derive(Clone, Copy, Debug, Default)]
struct Law {
    by_direction: bool,
    stribeck: Option<Curve>,
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
        columns.extend(self.stribeck.map(|curve| v.signum() * curve.at(v)[0]));
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

/// The law with the Stribeck curve that leaves least, whose speed and exponent are within those.
fn with_curve(
    speeds: &Speeds,
    law: Law,
    velocities: [f64; 2],
    exponents: [f64; 2],
) -> Option<Solved> {
    let within = [velocities.map(f64::ln), exponents];
    if within.iter().any(|[low, high]| low > high) {
        return None;
    }
    let mut ranges = within;
    let mut best: Option<Solved> = None;
    for counts in TRIED {
        // One of what is given.
        let counts = [0, 1].map(|k| {
            if within[k][0] < within[k][1] {
                counts[k]
            } else {
                1
            }
        });
        let step = |k: usize| (ranges[k][1] - ranges[k][0]) / (counts[k] - 1).max(1) as f64;
        let steps = [step(0), step(1)];
        let tried = (0..counts[0] * counts[1]).filter_map(|i| {
            let at = [i % counts[0], i / counts[0]];
            let [velocity, exponent] = [0, 1].map(|k| ranges[k][0] + at[k] as f64 * steps[k]);
            let curve = Curve {
                velocity: velocity.exp(),
                exponent,
            };
            let law = Law {
                stribeck: Some(curve),
                ..law
            };
            solve(speeds, law).filter(|s| s.coefficients[s.coefficients.len() - 1] > 0.0)
        });
        best = tried
            .chain(best)
            .min_by(|a, b| a.squares.total_cmp(&b.squares));
        let curve = best.as_ref()?.law.stribeck?;
        let about = [curve.velocity.ln(), curve.exponent];
        let near =
            |k: usize, side: f64| (about[k] + side * steps[k]).clamp(within[k][0], within[k][1]);
        ranges = [0, 1].map(|k| [near(k, -1.0), near(k, 1.0)]);
    }
    best
}

/// How far the exponent may go either way before the rest, fitted with it, leaves more than chance makes once in twenty: what it leaves is no
/// parabola, and an interval from its curvature held a true exponent nine times in ten.
fn exponents_that_do(speeds: &Speeds, solved: &Solved, velocities: [f64; 2]) -> Option<[f64; 2]> {
    let own = solved.law.stribeck?.exponent;
    let freedom = (speeds.velocity.len() - solved.coefficients.len() - 2) as f64;
    let allowed = FisherSnedecor::new(1.0, freedom).ok()?.inverse_cdf(0.95);
    let most = solved.squares * (1.0 + allowed / freedom);
    let does = |exponent: f64| {
        with_curve(speeds, solved.law, velocities, [exponent; 2]).is_some_and(|s| s.squares <= most)
    };
    Some(EXPONENTS.map(|end| {
        if does(end) {
            return end;
        }
        let (mut inside, mut outside) = (own, end);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + outside);
            *(if does(middle) {
                &mut inside
            } else {
                &mut outside
            }) = middle;
        }
        outside
    }))
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
    let velocities = [different[1], 0.5 * top];
    let parameters = best.coefficients.len() + 3;
    if spare(parameters) >= SPARE as f64 && different.len() > 4 {
        let with = with_curve(&speeds, best.law, velocities, EXPONENTS);
        let with = with.filter(|w| is_there(best.squares, w.squares, 3.0, spare(parameters)));
        best = with.unwrap_or(best);
    }
    let exponents = exponents_that_do(&speeds, &best, velocities);
    let found = SpeedTable::of(speeds, &best, exponents, notes).ok_or_else(failed)?;
    if found.nmse_held_out.is_nan() || found.nmse_held_out > MOST_LEFT {
        return fail(&format!(
            "Coulomb and viscous friction leave {:.0} % of the effort's variance: this is not a table of friction over speed; check its columns and units",
            found.nmse_held_out
        ));
    }
    Ok(found)
}

impl SpeedTable {
    fn of(
        speeds: Speeds,
        solved: &Solved,
        exponents: Option<[f64; 2]>,
        notes: Vec<String>,
    ) -> Option<Self> {
        let Solved {
            law, coefficients, ..
        } = solved;
        let last = coefficients[coefficients.len() - 1];
        // With the slopes over the curve's two, which makes the intervals those of all parameters together.
        let slopes = |v: f64| {
            let mut row = law.columns(v);
            if let Some(curve) = law.stribeck {
                let [_, slopes @ ..] = curve.at(v);
                row.extend(slopes.map(|slope| last * v.signum() * slope));
            }
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
        if let Some(Curve { velocity, exponent }) = law.stribeck {
            let at = coefficients.len() - 1;
            parameters.push(("static", estimate(c(0) + last, &[(0, 1.0), (at, 1.0)])));
            parameters.push(("stribeck_velocity", estimate(velocity, &[(at + 1, 1.0)])));
            let exponent = Estimate {
                value: exponent,
                ci95: exponents,
            };
            parameters.push(("stribeck_exponent", exponent));
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
        if let Some(level) = self.get("static") {
            let [velocity, exponent] =
                ["velocity", "exponent"].map(|of| get(&format!("stribeck_{of}")));
            let values = [
                ("level", level / coulomb - 1.0),
                ("velocity_m_s", velocity),
                ("exponent", exponent),
            ];
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
