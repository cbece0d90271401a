//! Which coordinate organises a mismatch, without asking what physics it is.

use super::score::{Gain, beyond};
use super::search::{Candidate, consistent};
use super::signals::{Signals, quantile};
use super::spectra;
use super::study::{State, Study};
use super::weak::Column;
use rayon::prelude::*;

/// Nats that a curve must bring in any case: it has several coefficients and many coordinates to choose from.
const LEAST: f64 = 10.0;
/// Times its threshold that a curve over a coordinate brings before it is called unknown physics.
pub const UNNAMED: f64 = 6.0;
/// Highest frequency of a clock that the friction level follows (Hz).
const FASTEST_HZ: f64 = 5.0;
/// Knots of the smooth curve over a coordinate.
const KNOTS: usize = 8;

/// A coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Position (m or rad).
    Position,
    /// Velocity (m/s or rad/s).
    Velocity,
    /// Speed (m/s or rad/s).
    Speed,
    /// Displacement since the last reversal (m or rad).
    SinceReversal,
    /// Acceleration (m/s² or rad/s²).
    Acceleration,
    /// Time (s).
    Time,
    /// Travelled path (m or rad).
    Path,
    /// Temperature (°C).
    Temperature,
    /// Load (N).
    Load,
    /// Time since the last reversal (s).
    TimeSinceReversal,
    /// Highest speed of the last seconds, forgotten slowly (m/s or rad/s).
    RecentSpeed,
    /// Time, periodic (s).
    TimePeriodic,
    /// Time, in bursts (s): see [`super::bursts`].
    Bursts,
    /// Acceleration along the motion: speeding up or slowing down (m/s² or rad/s²).
    SpeedingUp,
}

/// Time in which a high speed is forgotten (s).
const FORGOTTEN_S: f64 = 1.0;

impl Axis {
    /// Those over which a curve can be drawn.
    pub const ALL: [Axis; 13] = [
        Axis::Position,
        Axis::Velocity,
        Axis::Speed,
        Axis::SinceReversal,
        Axis::Acceleration,
        Axis::Time,
        Axis::Path,
        Axis::Temperature,
        Axis::Load,
        Axis::TimeSinceReversal,
        Axis::RecentSpeed,
        Axis::SpeedingUp,
        Axis::TimePeriodic,
    ];

    /// Its name in JSON and tables.
    pub fn name(self) -> &'static str {
        match self {
            Axis::Position => "position",
            Axis::Velocity => "velocity",
            Axis::Speed => "speed",
            Axis::SinceReversal => "displacement since reversal",
            Axis::Acceleration => "acceleration",
            Axis::Time => "time",
            Axis::Path => "path",
            Axis::Temperature => "temperature",
            Axis::Load => "load",
            Axis::TimeSinceReversal => "time since reversal",
            Axis::RecentSpeed => "highest speed of the last seconds",
            Axis::TimePeriodic => "time, periodic",
            Axis::Bursts => "time, in bursts",
            Axis::SpeedingUp => "acceleration along the motion",
        }
    }

    /// Its unit on a linear or rotary axis.
    pub fn unit(self, position: &str) -> String {
        match self {
            Axis::Position | Axis::SinceReversal | Axis::Path => position.to_owned(),
            Axis::Velocity | Axis::Speed | Axis::RecentSpeed => format!("{position}/s"),
            Axis::Acceleration | Axis::SpeedingUp => format!("{position}/s²"),
            Axis::Time | Axis::TimeSinceReversal | Axis::TimePeriodic | Axis::Bursts => {
                "s".to_owned()
            }
            Axis::Temperature => "°C".to_owned(),
            Axis::Load => "N".to_owned(),
        }
    }

    /// Its value at every sample, where the recording has it.
    pub fn values(self, s: &Signals) -> Option<Vec<f64>> {
        match self {
            Axis::Position => Some(s.x.clone()),
            Axis::Velocity => Some(s.v.clone()),
            Axis::Speed => Some(s.v.iter().map(|v| v.abs()).collect()),
            Axis::SinceReversal => Some(s.since_reversal.clone()),
            Axis::Acceleration => Some(s.a.clone()),
            Axis::Time | Axis::TimePeriodic | Axis::Bursts => Some(s.t.clone()),
            Axis::Path => Some(s.path.clone()),
            Axis::Temperature => s.temperature.clone(),
            Axis::Load => s.load.clone(),
            Axis::TimeSinceReversal => Some(s.time_since_reversal()),
            Axis::RecentSpeed => {
                let kept = (-s.dt / FORGOTTEN_S).exp();
                let mut recent = 0.0f64;
                let speeds = s.v.iter().map(|v| {
                    recent = v.abs().max(recent * kept);
                    recent
                });
                Some(speeds.collect())
            }
            Axis::SpeedingUp => Some(s.a.iter().zip(&s.direction).map(|(a, d)| a * d).collect()),
        }
    }

    /// Whether an effect over one of the two coordinates looks alike over the other.
    fn is_akin(self, other: Axis) -> bool {
        let family = |axis| match axis {
            Axis::Velocity | Axis::Speed => 0,
            Axis::Acceleration | Axis::SpeedingUp => 1,
            Axis::Time | Axis::Path | Axis::Temperature => 2,
            _ => 3,
        };
        self == other || family(self) < 3 && family(self) == family(other)
    }

    /// The coordinate in which an effect of the catalogue acts.
    pub fn of(id: &str) -> Axis {
        match id {
            "viscous" | "quadratic_drag" | "constant_force" | "coulomb_asymmetry" => Axis::Velocity,
            "stribeck" | "frictional_lag" => Axis::Speed,
            "position_spring"
            | "position_force"
            | "position_friction"
            | "local_friction_spot"
            | "periodic_force"
            | "periodic_friction"
            | "encoder_error" => Axis::Position,
            "drive_compliance" | "channel_delay" => Axis::Acceleration,
            "presliding_shape" | "backlash" | "creep" => Axis::SinceReversal,
            "run_in" => Axis::Path,
            "load_dependent_friction" => Axis::Load,
            _ => Axis::Time,
        }
    }
}

/// A smooth curve over one coordinate that predicts the mismatch in folds held out.
#[derive(Clone, Debug)]
pub struct Signature {
    /// The coordinate.
    pub axis: Axis,
    /// Flips with direction.
    pub odd: bool,
    /// Nats by fold, and for noise alone.
    pub gain: Gain,
    /// Nats that noise alone does not reach.
    pub threshold: f64,
}

impl Signature {
    /// Nats above what noise gives.
    pub fn excess(&self) -> f64 {
        self.gain.total() - self.threshold
    }

    /// Beyond twice the threshold and in most folds.
    pub fn certain(&self) -> bool {
        self.gain.total() > 2.0 * self.threshold && consistent(&self.gain.by_fold)
    }
}

/// Every coordinate's curve on top of a hypothesis, best first.
pub fn signatures(study: &Study, state: &State) -> Vec<Signature> {
    let mut tried: Vec<(Axis, bool)> = Vec::new();
    for axis in Axis::ALL {
        tried.push((axis, false));
        if axis != Axis::Velocity {
            tried.push((axis, true));
        }
    }
    let mut found: Vec<Signature> = tried
        .into_par_iter()
        .filter_map(|(axis, odd)| {
            let rows = rows(study, state, axis, odd)?;
            let gain = study.gain_of(state, &rows)?;
            // A clock is looked for among so many frequencies, which the draws did not do.
            let tries = if axis == Axis::TimePeriodic {
                (FASTEST_HZ * study.s.duration()).max(1.0).ln()
            } else {
                0.0
            };
            let threshold = beyond(&gain.null).max(LEAST) + tries;
            Some(Signature {
                axis,
                odd,
                gain,
                threshold,
            })
        })
        .collect();
    found.sort_by(|a, b| b.excess().total_cmp(&a.excess()));
    found
}

/// Share of an effect's nats that it keeps beside a free curve over another coordinate, if its name is right.
const BESIDE: f64 = 0.5;

/// Whether a curve that is free over a coordinate other than the effect's own explains more than the effect does in the same
/// place, goes on explaining where `state` has the effect, and leaves it little: then the name is wrong. Over its own coordinate it is right, and
/// something else acts there as well.
pub fn outdone(study: &Study, state: &State, own: &Candidate, curves: &[Signature]) -> bool {
    let nats = own.gain.total();
    // Every curve that is alike in both directions holds a constant.
    let constant = matches!(own.term.id, "constant_force" | "coulomb_asymmetry");
    let foreign = |c: &&Signature| {
        let akin = Axis::of(own.term.id).is_akin(c.axis);
        !akin && (c.odd || !constant) && c.certain()
    };
    curves.iter().filter(foreign).any(|c| {
        let beside = || {
            let rows = rows(study, state, c.axis, c.odd)?;
            Some(study.gain_of(state, &rows)?.total())
        };
        // What the effect brings beside the curve, by the chain rule of log-likelihoods.
        let left = |beside: f64| nats + beside - c.gain.total();
        c.gain.total() > nats
            && beside()
                .is_some_and(|gain| gain > UNNAMED * c.threshold && left(gain) < BESIDE * nats)
    })
}

/// Whether free curves over speed, in place of the form of a `larger` effect of speed, take most of what a smaller one brings.
pub fn remainder(study: &Study, without: &State, own: &Candidate, larger: &str) -> bool {
    // A force in proportion to velocity has no form that could be wrong.
    if Axis::of(larger) != Axis::Speed && larger != "quadratic_drag"
        || matches!(own.term.id, "viscous" | "constant_force")
    {
        return false;
    }
    let curves = [(Axis::Speed, true), (Axis::Velocity, false)]
        .into_iter()
        .filter_map(|(axis, odd)| curve(study, axis, odd))
        .flatten();
    let mut columns: Vec<Vec<f64>> = curves.collect();
    let alone = study.gain_of(without, &columns);
    columns.extend(study.term_rows(&own.term).iter().cloned());
    let both = study.gain_of(without, &columns);
    alone
        .zip(both)
        .is_some_and(|(alone, both)| both.total() - alone.total() < 0.5 * own.gain.total())
}

/// Share of its nats that an effect may gain by changing its size over a coordinate.
const FORM: f64 = 0.15;

/// The coordinate over which the size of term `index` changes most, if it gains much by that.
pub fn malformed(study: &Study, state: &State, index: usize, nats: f64) -> Option<Axis> {
    let id = state.terms[index].id;
    // These are only as right as the core and the share of inertia that they act through.
    if matches!(id, "drive_compliance" | "backlash" | "creep") {
        return None;
    }
    let force = study.force_of(state, index);
    let changing = |axis: Axis| -> Option<f64> {
        let values = study.weak.at_centres(&axis.values(&study.s)?);
        let columns: Vec<Vec<f64>> = hats(&values)?
            .iter()
            .map(|hat| hat.iter().zip(&force).map(|(h, f)| h * f).collect())
            .collect();
        let own = study.gain_of(state, &columns)?.total();
        // What any curve over that coordinate gains is the core's error there, not the effect's.
        let any = [false, true]
            .into_iter()
            .filter_map(|odd| study.gain_of(state, &curve(study, axis, odd)?))
            .map(|g| g.total())
            .fold(0.0, f64::max);
        (own > 2.0 * any).then_some(own)
    };
    let own = Axis::of(id);
    let found = [Axis::Speed, Axis::Time, Axis::SinceReversal]
        .into_par_iter()
        .filter(|axis| !axis.is_akin(own))
        .filter_map(|axis| Some((axis, changing(axis)?)))
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    (found.1 > 10.0 && found.1 > FORM * nats).then_some(found.0)
}

fn rows(study: &Study, state: &State, axis: Axis, odd: bool) -> Option<Vec<Vec<f64>>> {
    match axis {
        Axis::TimePeriodic => clockwork(study, state, odd),
        _ => curve(study, axis, odd),
    }
}

/// The curve's columns at the rows: a force, or a change of the friction level.
fn curve(study: &Study, axis: Axis, odd: bool) -> Option<Vec<Vec<f64>>> {
    let s = &study.s;
    let columns = hats(&axis.values(s)?)?;
    // After a reversal the friction is still small; what acts there is not in proportion to it.
    let load = match axis {
        Axis::SinceReversal | Axis::TimeSinceReversal => &s.direction,
        _ => &study.reference.friction,
    };
    Some(
        columns
            .into_par_iter()
            .map(|mut column| {
                if odd {
                    column.iter_mut().zip(load).for_each(|(c, d)| *c *= d);
                }
                study.weak.rows(&Column::of(column))
            })
            .collect(),
    )
}

/// A change of the friction level that follows a clock: of the lines in time of the mismatch along the friction the one that
/// brings most, with its third harmonic; slower than noise wanders, faster than drift.
fn clockwork(study: &Study, state: &State, odd: bool) -> Option<Vec<Vec<f64>>> {
    if !odd {
        return None;
    }
    let t = study.weak.at_centres(&study.s.t);
    let friction = study.weak.at_centres(&study.reference.friction);
    let (_, weights) = study.weighed_residual(state);
    let duration = t.last()? - t.first()?;
    let waves = |line: f64| -> Vec<Vec<f64>> {
        let wave = |order: f64, phase: f64| {
            let angle = move |t: f64| std::f64::consts::TAU * (order * line * t + phase);
            let level = t.iter().zip(&friction).map(|(t, f)| f * angle(*t).cos());
            level.collect()
        };
        vec![
            wave(1.0, 0.0),
            wave(1.0, 0.25),
            wave(3.0, 0.0),
            wave(3.0, 0.25),
        ]
    };
    spectra::lines(&t, &weights, 4.0 / duration, FASTEST_HZ)
        .into_iter()
        .map(waves)
        .filter_map(|columns| Some((study.gain_of(state, &columns)?.total(), columns)))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|best| best.1)
}

/// Hat functions over quantiles of a coordinate, without the last one (all together are a constant).
fn hats(values: &[f64]) -> Option<Vec<Vec<f64>>> {
    let mut knots: Vec<f64> = (0..KNOTS)
        .map(|k| quantile(values, k as f64 / (KNOTS - 1) as f64))
        .collect();
    let span = knots.last()? - knots.first()?;
    knots.dedup_by(|a, b| *a - *b < 0.02 * span);
    if span <= 0.0 || knots.len() < 4 {
        return None;
    }
    let last = knots.len() - 1;
    Some(
        (0..last)
            .map(|k| {
                values
                    .iter()
                    .map(|v| {
                        let v = v.clamp(knots[0], knots[last]);
                        if k > 0 && v <= knots[k] {
                            ((v - knots[k - 1]) / (knots[k] - knots[k - 1])).max(0.0)
                        } else if v <= knots[k] {
                            1.0
                        } else {
                            ((knots[k + 1] - v) / (knots[k + 1] - knots[k])).max(0.0)
                        }
                    })
                    .collect()
            })
            .collect(),
    )
}

/// The narrowest of 20 equal stretches of a coordinate, joined, that hold 80 % of `weights`: from, to, and the share held.
pub fn concentration(values: &[f64], weights: &[f64]) -> Option<(f64, f64, f64)> {
    const BINS: usize = 20;
    let (low, high) = super::signals::bounds(values);
    let total: f64 = weights.iter().sum();
    if total <= 0.0 || high <= low {
        return None;
    }
    let mut bins = [0.0; BINS];
    for (v, w) in values.iter().zip(weights) {
        let bin = ((v - low) / (high - low) * BINS as f64) as usize;
        bins[bin.min(BINS - 1)] += w / total;
    }
    for width in 1..=BINS {
        let best = (0..=BINS - width)
            .map(|start| (start, bins[start..start + width].iter().sum::<f64>()))
            .max_by(|a, b| a.1.total_cmp(&b.1))?;
        if best.1 >= 0.8 || width == BINS {
            let edge = |i: usize| low + (high - low) * i as f64 / BINS as f64;
            return Some((edge(best.0), edge(best.0 + width), best.1));
        }
    }
    None
}
