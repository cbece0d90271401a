//! Every effect as columns at the sample rate, linear in their coefficients once the shape is given.

use super::signals::{Signals, bounds, quantile};
use super::study::Study;
use super::weak::Column;
use crate::identify::stop::Deflection;
use std::f64::consts::{PI, TAU};

/// The model that effects act through.
#[derive(Default)]
pub struct Baseline {
    /// Inertia (kg or kg·m²).
    pub mass: f64,
    /// Stiffness (N/m) and yield displacement (m) of the blocks.
    pub blocks: Vec<(f64, f64)>,
    /// Friction without effects (N or N·m).
    pub friction: Vec<f64>,
    /// Its usual size in sliding (N or N·m).
    pub level: f64,
    /// Its part in blocks that slip.
    pub slipping: Vec<f64>,
    /// Stiffness of the blocks that stick (N/m or N·m/rad).
    pub stiffness: Vec<f64>,
    /// Whole modelled effort, plain effects included.
    pub fitted: Vec<f64>,
}

/// How a shape parameter is refined.
#[derive(Clone, Copy, PartialEq)]
pub enum Scale {
    /// By its logarithm.
    Logarithmic,
    /// By itself, in shares of the travel.
    Travel,
    /// As a period in position: by phase over the travel.
    Period,
    /// As a frequency in time: by phase over the recording.
    Frequency,
    /// Chosen from the grid only.
    Chosen,
}

/// The shape parameters of an effect: key, in the units of a linear axis, and scale.
pub fn parameters(id: &str) -> &'static [(&'static str, Scale)] {
    use Scale::*;
    match id {
        "stribeck" => &[
            ("velocity_m_s", Logarithmic),
            ("exponent", Logarithmic),
            ("slipping_only", Chosen),
        ],
        "frictional_lag" => &[
            ("velocity_m_s", Logarithmic),
            ("exponent", Logarithmic),
            ("time_constant_s", Logarithmic),
        ],
        "position_force" | "position_friction" => &[("terms", Chosen)],
        "local_friction_spot" => &[("position_m", Travel), ("width_m", Logarithmic)],
        "periodic_force" | "periodic_friction" | "encoder_error" => &[("period_m", Period)],
        "external_vibration" => &[("frequency_Hz", Frequency)],
        "thermal_drift" => &[("time_constant_s", Chosen)],
        "run_in" => &[("path_m", Logarithmic)],
        "dwell_aging" => &[
            ("time_constant_s", Logarithmic),
            ("erasing_path_m", Logarithmic),
        ],
        "creep" => &[("share_of_breakaway", Chosen)],
        "drive_compliance" => &[("motor_share", Chosen)],
        "backlash" => &[("gap_m", Logarithmic)],
        "actuator_saturation" => &[("limit_N", Logarithmic)],
        _ => &[],
    }
}

/// Key of the coefficient of an effect that has one, or of the amplitude of a wave.
pub fn amplitude_key(id: &str, s: &Signals) -> &'static str {
    match id {
        "constant_force" | "periodic_force" | "external_vibration" => "force_N",
        "coulomb_asymmetry" => "asymmetry",
        "viscous" => "viscous_N_s_per_m",
        "quadratic_drag" => "drag_N_s2_per_m2",
        "position_spring" => "stiffness_N_per_m",
        "encoder_error" => "error_m",
        "channel_delay" => "delay_s",
        "backlash" => "share",
        "drive_compliance" => "compliance_m_per_N",
        "thermal_drift" if s.temperature.is_some() => "level_per_K",
        "load_dependent_friction" => "level_per_N",
        "dwell_aging" => "level_per_decade",
        "creep" => "rate_m_s",
        "actuator_dead_zone" => "width_N",
        "actuator_saturation" => "share",
        _ => "level",
    }
}

/// Shapes to try, from what the recording covers; periods are found by [`super::spectra`].
pub fn shapes(id: &str, study: &Study) -> Vec<Vec<f64>> {
    let s = &study.s;
    let (slow, fast) = s.speeds();
    let several = fast > 1.5 * slow;
    let (from, to) = bounds(&s.x);
    let travel = to - from;
    let duration = s.duration();
    let path = s.path.last().copied().unwrap_or(0.0);
    let speeds = |count| spread((slow / 2.0).max(fast / 1000.0), fast / 1.5, count);
    let product = |a: &[f64], b: &[f64]| -> Vec<Vec<f64>> {
        a.iter()
            .flat_map(|&a| b.iter().map(move |&b| vec![a, b]))
            .collect()
    };
    match id {
        "stribeck" if several => speeds(8)
            .into_iter()
            .flat_map(|v| [(1.0, 0.0), (2.0, 0.0), (1.0, 1.0)].map(|(e, only)| vec![v, e, only]))
            .collect(),
        "frictional_lag" if several => product(
            &speeds(5),
            &spread(s.dt.max(5e-3), (duration / 50.0).clamp(0.02, 0.2), 4),
        )
        .into_iter()
        .map(|shape| vec![shape[0], 1.0, shape[1]])
        .collect(),
        "position_force" | "position_friction" => {
            [2.0, 3.0, 5.0, 8.0].iter().map(|&j| vec![j]).collect()
        }
        "local_friction_spot" => {
            let mut shapes = Vec::new();
            for width in spread(travel / 120.0, travel / 10.0, 4) {
                let places = (travel / width).ceil() as usize;
                shapes.extend(
                    (0..=places).map(|i| vec![from + travel * i as f64 / places as f64, width]),
                );
            }
            shapes
        }
        "thermal_drift" if s.temperature.is_none() => spread(duration / 10.0, duration * 2.0, 4)
            .into_iter()
            .map(|t| vec![t])
            .collect(),
        "thermal_drift" => vec![vec![]],
        "run_in" => spread(path / 20.0, path * 2.0, 5)
            .into_iter()
            .map(|l| vec![l])
            .collect(),
        "dwell_aging" => {
            let (least, most) = bounds(&s.dwell);
            if most <= 0.05 || most < 1.5 * least {
                return Vec::new();
            }
            let erased = quantile(&s.last_stroke, 0.5);
            product(&[0.1, 0.5], &spread(erased / 300.0, erased, 5))
        }
        // Its centre in the middle of the travel, or free.
        "position_spring" => vec![Vec::new(), vec![1.0]],
        "creep" => vec![vec![0.15]],
        "drive_compliance" => vec![vec![MOTOR_SHARE]],
        "backlash" => {
            let shortest = shortest_yield(study);
            spread(shortest, (200.0 * shortest).min(travel / 20.0), 9)
                .into_iter()
                .map(|gap| vec![gap])
                .collect()
        }
        "actuator_saturation" => {
            let size: Vec<f64> = study.effort.iter().map(|f| f.abs()).collect();
            let top = quantile(&size, 0.9999);
            spread(lowest_limit(study), 0.95 * top, 16)
                .into_iter()
                .map(|l| vec![l])
                .collect()
        }
        "stribeck" | "frictional_lag" | "presliding_shape" => Vec::new(),
        "periodic_force" | "periodic_friction" | "encoder_error" | "external_vibration" => {
            Vec::new()
        }
        "load_dependent_friction" if s.load.is_none() => Vec::new(),
        _ => vec![Vec::new()],
    }
}

/// The lowest limit of the actuator that is tried (N or N·m).
pub fn lowest_limit(study: &Study) -> f64 {
    let size: Vec<f64> = study.effort.iter().map(|f| f.abs()).collect();
    quantile(&size, RARE)
}

/// The shortest yield of the reference friction that carries a hundredth of it (m or rad).
fn shortest_yield(study: &Study) -> f64 {
    let b = &study.reference;
    b.blocks
        .iter()
        .filter(|(k, d)| k * d > 0.01 * b.level)
        .map(|b| b.1)
        .fold(f64::INFINITY, f64::min)
        .min(1.0)
}

/// Share of the samples that stay below an actuator's limit at least: a limit that most of the effort exceeds would explain the
/// measured effort by itself.
pub const RARE: f64 = 0.95;

/// `count` values from `low` to `high`, evenly on a logarithmic scale.
pub fn spread(low: f64, high: f64, count: usize) -> Vec<f64> {
    let usable = low > 0.0 && high > low;
    (0..count)
        .filter(|_| usable)
        .map(|i| low * (high / low).powf(i as f64 / (count - 1).max(1) as f64))
        .collect()
}

/// The columns of an effect of a given shape; empty where the recording has none.
pub fn columns(id: &str, shape: &[f64], study: &Study) -> Vec<Column> {
    let (s, b) = (&study.s, &study.reference);
    let at = |i: usize| shape.get(i).copied().unwrap_or(1.0);
    let of = |f: &dyn Fn(usize) -> f64| -> Vec<f64> { (0..s.x.len()).map(f).collect() };
    let friction = |level: &dyn Fn(usize) -> f64| of(&|i| b.friction[i] * level(i));
    let wave = |period: f64, of_x: &dyn Fn(usize) -> f64| {
        let phase = move |x: f64| TAU * x / period;
        vec![of(&|i| phase(of_x(i)).cos()), of(&|i| phase(of_x(i)).sin())]
    };
    let (from, to) = bounds(&s.x);
    let travel = to - from;
    // Cosines of multiples of one angle, by their recurrence.
    let cosines = |weight: &dyn Fn(usize) -> f64| -> Vec<Vec<f64>> {
        let base = of(&|i| (PI * (s.x[i] - from) / (to - from)).cos());
        let (mut before, mut now) = (vec![1.0; base.len()], base.clone());
        let mut columns = Vec::new();
        for _ in 0..at(0) as usize {
            columns.push(now.iter().enumerate().map(|(i, c)| c * weight(i)).collect());
            let next = (0..base.len())
                .map(|i| 2.0 * base[i] * now[i] - before[i])
                .collect();
            before = std::mem::replace(&mut now, next);
        }
        columns
    };
    let level = b.level;
    let plain: Vec<Vec<f64>> = match id {
        "constant_force" => vec![vec![1.0; s.x.len()]],
        "coulomb_asymmetry" => vec![friction(&|i| (b.friction[i] / (0.1 * level)).tanh())],
        "viscous" => {
            return vec![Column {
                sloped: s.x.clone(),
                ..Column::default()
            }];
        }
        "quadratic_drag" => vec![of(&|i| s.v[i] * s.v[i].abs())],
        "stribeck" => {
            let curve = |i: usize| (-(s.v[i].abs() / at(0)).powf(at(1))).exp();
            if at(2) > 0.5 {
                vec![of(&|i| b.slipping[i] * curve(i))]
            } else {
                vec![friction(&curve)]
            }
        }
        "frictional_lag" => {
            let share = (-s.dt / at(2)).exp();
            let mut lagging = vec![0.0; s.x.len()];
            for piece in &s.pieces {
                let mut state: Option<f64> = None;
                for i in piece.clone() {
                    let now = (-(s.v[i].abs() / at(0)).powf(at(1))).exp();
                    let next = state.map_or(now, |last| now + (last - now) * share);
                    lagging[i] = next;
                    state = Some(next);
                }
            }
            vec![friction(&|i| lagging[i])]
        }
        "position_spring" => vec![of(&|i| s.x[i] - 0.5 * (from + to))]
            .into_iter()
            .chain(shape.first().map(|_| vec![ASIDE * travel; s.x.len()]))
            .collect(),
        "position_force" => cosines(&|_| 1.0)
            .into_iter()
            .chain(shape.get(1).map(|_| vec![1.0; s.x.len()]))
            .collect(),
        "position_friction" => cosines(&|i| b.friction[i]),
        "local_friction_spot" => {
            vec![friction(&|i| (-((s.x[i] - at(0)) / at(1)).powi(2)).exp())]
        }
        "periodic_force" => wave(at(0), &|i| s.x[i]),
        "periodic_friction" => wave(at(0), &|i| s.x[i])
            .iter()
            .map(|w| friction(&|i| w[i]))
            .collect(),
        "encoder_error" => {
            return wave(at(0), &|i| s.x[i])
                .into_iter()
                .map(|e| displaced(e, b.mass, study))
                .collect();
        }
        "external_vibration" => wave(1.0 / at(0), &|i| s.t[i]),
        "channel_delay" => {
            return vec![Column {
                sloped: of(&|i| -b.fitted[i]),
                ..Column::default()
            }];
        }
        // Behind a spring the load is displaced by the transmitted effort.
        "drive_compliance" => {
            let transmitted = of(&|i| b.fitted[i] - at(0) * b.mass * s.a[i]);
            return vec![displaced(transmitted, (1.0 - at(0)) * b.mass, study)];
        }
        // The gap is crossed where the transmitted effort changes sign.
        "backlash" => {
            let side = of(&|i| {
                let transmitted = b.fitted[i] - MOTOR_SHARE * b.mass * s.a[i];
                0.5 * at(0) * (transmitted / (0.05 * level)).tanh()
            });
            // A gap is not small beside the yields: the blocks follow the load's path itself.
            let load = of(&|i| s.x[i] - side[i]);
            let mut column: Vec<f64> = b.friction.iter().map(|f| -f).collect();
            for &(k, d) in &b.blocks {
                let z = Deflection::along(&load, &s.pieces, d).z;
                column.iter_mut().zip(&z).for_each(|(c, z)| *c += k * z);
            }
            let mass = (1.0 - MOTOR_SHARE) * b.mass;
            return vec![Column {
                value: column,
                sloped: Vec::new(),
                curved: side.iter().map(|e| -mass * e).collect(),
            }];
        }
        "actuator_dead_zone" => vec![of(&|i| 0.5 * (b.fitted[i] / (0.03 * level)).tanh())],
        "actuator_saturation" => vec![of(&|i| {
            let f = study.effort[i];
            f.signum() * (f.abs() - at(0)).max(0.0)
        })],
        "thermal_drift" => match &s.temperature {
            Some(t) => {
                let mean = mean(t);
                vec![friction(&|i| t[i] - mean)]
            }
            None => vec![friction(&|i| (-s.t[i] / at(0)).exp())],
        },
        "run_in" => vec![friction(&|i| (-s.path[i] / at(0)).exp())],
        // Age of the contact: grows with time, is erased along a path (Dieterich 1979).
        "dwell_aging" => {
            let (mut age, mut path) = (0.0, 0.0);
            let aged = s.path.iter().map(|&now| {
                age = (age + s.dt) / (1.0 + (now - path) / at(1));
                path = now;
                (1.0f64 + age / at(0)).log10()
            });
            let level: Vec<f64> = aged.collect();
            vec![friction(&|i| level[i])]
        }
        // Blocks that stick give way at a rate that grows with the stress (Eyring's sinh).
        "creep" => {
            let mut crept = vec![0.0; s.x.len()];
            for i in 1..s.x.len() {
                let stress = (b.friction[i - 1] / (at(0) * level)).clamp(-8.0, 8.0);
                crept[i] = crept[i - 1] + s.dt * stress.sinh();
            }
            return vec![displaced(crept, 0.0, study)];
        }
        "load_dependent_friction" => match &s.load {
            Some(load) => {
                let mean = mean(load);
                vec![friction(&|i| load[i] - mean)]
            }
            None => Vec::new(),
        },
        _ => Vec::new(),
    };
    plain.into_iter().map(Column::of).collect()
}

/// Share of the travel by which a spring's centre may lie aside of the middle: beyond it the constant is a matter of its own.
pub const ASIDE: f64 = 0.4;

/// Share of the inertia on the motor's side of a compliant drive or a gap, which one recording does not tell.
pub const MOTOR_SHARE: f64 = 0.5;

/// Between which values a parameter lies that is assumed because a recording does not tell it: `motor_share`, `share_of_breakaway`.
pub fn assumed(id: &str) -> Option<[f64; 2]> {
    match id {
        "drive_compliance" => Some([0.3, 0.7]),
        "creep" => Some([0.12, 0.2]),
        _ => None,
    }
}

/// Mean of some values.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// How the effort changes when the measured position is the load's position plus `error`: `−m·ë − Σ k_i·w_i`, where `w_i`
/// follows the error while block `i` sticks and is cleared when it slips.
fn displaced(error: Vec<f64>, mass: f64, study: &Study) -> Column {
    let s = &study.s;
    let mut column = vec![0.0; error.len()];
    for &(k, d) in &study.reference.blocks {
        let (mut z, mut w) = (0.0f64, 0.0);
        for piece in &s.pieces {
            for i in piece.start + 1..piece.end {
                let free = z + s.x[i] - s.x[i - 1];
                z = free.clamp(-d, d);
                w = if free.abs() >= d {
                    0.0
                } else {
                    w + error[i] - error[i - 1]
                };
                column[i] -= k * w;
            }
        }
    }
    Column {
        value: column,
        sloped: Vec::new(),
        curved: error.iter().map(|e| -mass * e).collect(),
    }
}
