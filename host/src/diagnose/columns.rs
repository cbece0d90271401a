//! Every effect as columns at the sample rate, linear in their coefficients once the shape is given.

use super::catalogue::moving_speeds;
use super::signals::{Signals, bounds, quantile};
use super::weak::{curvature, slope};
use crate::identify::stop::Deflection;
use std::f64::consts::{PI, TAU};

/// The present model, as far as effects act through it.
pub struct Baseline {
    /// Inertia [kg or kg·m²].
    pub mass: f64,
    /// Stiffness [N/m] and yield displacement [m] of the blocks.
    pub blocks: Vec<(f64, f64)>,
    /// Friction without effects [N or N·m].
    pub friction: Vec<f64>,
    /// Its part in blocks that slip.
    pub slipping: Vec<f64>,
    /// Its part in blocks of short yield.
    pub short: Vec<f64>,
    /// Whole modelled effort, effects included.
    pub fitted: Vec<f64>,
    /// Half-width of the kernel [s], the shortest time that can be told.
    pub shortest_s: f64,
}

impl Baseline {
    /// Friction of the blocks along another position.
    fn friction_along(&self, x: &[f64], s: &Signals) -> Vec<f64> {
        let mut force = vec![0.0; x.len()];
        for &(k, d) in &self.blocks {
            let z = Deflection::along(x, &s.pieces, d).z;
            force.iter_mut().zip(&z).for_each(|(f, z)| *f += k * z);
        }
        force
    }
}

/// A shape parameter: its key, whether it is refined on a logarithmic scale, and its bounds.
pub struct Parameter {
    /// Key, in the units of a linear axis.
    pub key: &'static str,
    /// Refined by its logarithm, or by itself; `None`: chosen from the grid only.
    pub logarithmic: Option<bool>,
}

const fn log(key: &'static str) -> Parameter {
    Parameter {
        key,
        logarithmic: Some(true),
    }
}
const fn plain(key: &'static str) -> Parameter {
    Parameter {
        key,
        logarithmic: Some(false),
    }
}
const fn chosen(key: &'static str) -> Parameter {
    Parameter {
        key,
        logarithmic: None,
    }
}

/// The shape parameters of an effect.
pub fn parameters(id: &str) -> Vec<Parameter> {
    match id {
        "stribeck" => vec![
            log("velocity_m_s"),
            log("exponent"),
            chosen("slipping_only"),
        ],
        "frictional_lag" => vec![log("velocity_m_s"), log("time_s")],
        "position_force" | "position_friction" => vec![chosen("terms")],
        "local_friction_spot" => vec![plain("centre_m"), log("width_m")],
        "periodic_force" | "periodic_friction" | "encoder_error" => vec![log("period_m")],
        "external_vibration" => vec![log("frequency_Hz")],
        "thermal_drift" => vec![chosen("time_s")],
        "run_in" => vec![log("path_m")],
        "dwell_aging" => vec![log("time_s"), log("path_m")],
        "backlash" => vec![log("gap_m")],
        _ => Vec::new(),
    }
}

/// Shapes to try, from what the recording covers; periods are found by [`super::spectra`].
pub fn shapes(id: &str, s: &Signals) -> Vec<Vec<f64>> {
    let (slow, fast) = moving_speeds(s);
    let (from, to) = bounds(&s.x);
    let travel = to - from;
    let duration = s.t.last().copied().unwrap_or(0.0);
    let path = s.path.last().copied().unwrap_or(0.0);
    let product = |a: &[f64], b: &[f64]| -> Vec<Vec<f64>> {
        a.iter()
            .flat_map(|&a| b.iter().map(move |&b| vec![a, b]))
            .collect()
    };
    match id {
        "stribeck" if fast > 1.5 * slow => spread((slow / 2.0).max(fast / 300.0), fast / 1.5, 8)
            .into_iter()
            .flat_map(|v| [1.0, 2.0].map(|e| [v, e]))
            .flat_map(|[v, e]| [0.0, 1.0].map(|only| vec![v, e, only]))
            .collect(),
        "frictional_lag" if fast > 1.5 * slow => product(
            &spread((slow / 2.0).max(fast / 300.0), fast / 1.5, 5),
            &spread(s.dt.max(3e-3), (duration / 50.0).clamp(0.02, 0.3), 5),
        ),
        "position_force" | "position_friction" => {
            [2.0, 3.0, 5.0, 8.0].iter().map(|&j| vec![j]).collect()
        }
        "local_friction_spot" => product(
            &(0..25)
                .map(|i| from + travel * (f64::from(i) + 0.5) / 25.0)
                .collect::<Vec<_>>(),
            &[travel / 60.0, travel / 25.0, travel / 10.0],
        ),
        "thermal_drift" if s.temperature.is_none() => spread(duration / 10.0, duration * 2.0, 4)
            .into_iter()
            .map(|t| vec![t])
            .collect(),
        "run_in" => spread(path / 20.0, path * 2.0, 5)
            .into_iter()
            .map(|l| vec![l])
            .collect(),
        "dwell_aging" => {
            let (least, most) = bounds(&s.dwell);
            if most <= 0.05 || most < 1.5 * least {
                return Vec::new();
            }
            product(&[0.1, 1.0], &spread(travel / 300.0, travel / 5.0, 5))
        }
        "backlash" => {
            let step = quantile(&s.last_stroke, 0.5);
            spread(step / 300.0, step / 8.0, 6)
                .into_iter()
                .map(|b| vec![b])
                .collect()
        }
        "stribeck" | "frictional_lag" => Vec::new(),
        "periodic_force" | "periodic_friction" | "encoder_error" | "external_vibration" => {
            Vec::new()
        }
        "presliding_shape" => Vec::new(),
        "load_dependent_friction" if s.load.is_none() => Vec::new(),
        _ => vec![Vec::new()],
    }
}

/// `count` values from `low` to `high`, evenly on a logarithmic scale.
pub fn spread(low: f64, high: f64, count: usize) -> Vec<f64> {
    let usable = low > 0.0 && high > low;
    (0..count)
        .filter(|_| usable)
        .map(|i| low * (high / low).powf(i as f64 / (count - 1).max(1) as f64))
        .collect()
}

/// The columns of an effect of a given shape; empty where the recording has none.
pub fn columns(id: &str, shape: &[f64], s: &Signals, b: &Baseline) -> Vec<Vec<f64>> {
    let at = |i: usize| shape.get(i).copied().unwrap_or(1.0);
    let of = |f: &dyn Fn(usize) -> f64| -> Vec<f64> { (0..s.x.len()).map(f).collect() };
    let friction = |level: &dyn Fn(usize) -> f64| of(&|i| b.friction[i] * level(i));
    let wave = |period: f64, origin: f64, of_x: &dyn Fn(usize) -> f64| {
        let phase = move |x: f64| TAU * (x - origin) / period;
        vec![of(&|i| phase(of_x(i)).cos()), of(&|i| phase(of_x(i)).sin())]
    };
    let weighted = |waves: Vec<Vec<f64>>| -> Vec<Vec<f64>> {
        waves.iter().map(|w| friction(&|i| w[i])).collect()
    };
    let (from, to) = bounds(&s.x);
    let place = |i: usize| (s.x[i] - from) / (to - from);
    match id {
        "constant_force" => vec![vec![1.0; s.x.len()]],
        "coulomb_asymmetry" => vec![friction(&|i| s.direction[i])],
        "viscous" => vec![slope(&s.x, &s.pieces, s.dt)],
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
            let share = (-s.dt / at(1)).exp();
            let mut lagging = vec![0.0; s.x.len()];
            for piece in &s.pieces {
                let mut state: Option<f64> = None;
                for i in piece.clone() {
                    let now = (-s.v[i].abs() / at(0)).exp();
                    let next = state.map_or(now, |last| now + (last - now) * share);
                    lagging[i] = next;
                    state = Some(next);
                }
            }
            vec![friction(&|i| lagging[i])]
        }
        "position_spring" => vec![of(&|i| s.x[i] - 0.5 * (from + to))],
        "position_force" => (1..=at(0) as usize)
            .map(|j| of(&|i| (j as f64 * PI * place(i)).cos()))
            .collect(),
        "position_friction" => (1..=at(0) as usize)
            .map(|j| friction(&|i| (j as f64 * PI * place(i)).cos()))
            .collect(),
        "local_friction_spot" => {
            vec![friction(&|i| (-((s.x[i] - at(0)) / at(1)).powi(2)).exp())]
        }
        "periodic_force" => wave(at(0), 0.0, &|i| s.x[i]),
        "periodic_friction" => weighted(wave(at(0), 0.0, &|i| s.x[i])),
        "encoder_error" => wave(at(0), 0.0, &|i| s.x[i])
            .iter()
            .map(|e| encoder_column(e, s, b))
            .collect(),
        "external_vibration" => wave(1.0 / at(0), 0.0, &|i| s.t[i]),
        "channel_delay" => vec![
            slope(&b.fitted, &s.pieces, s.dt)
                .iter()
                .map(|v| -v)
                .collect(),
        ],
        "drive_compliance" => vec![curvature(&b.fitted, &s.pieces, s.dt)],
        "thermal_drift" => match &s.temperature {
            Some(t) => {
                let mean = t.iter().sum::<f64>() / t.len() as f64;
                vec![friction(&|i| t[i] - mean)]
            }
            None => vec![friction(&|i| (-s.t[i] / at(0)).exp())],
        },
        "run_in" => vec![friction(&|i| (-s.path[i] / at(0)).exp())],
        "dwell_aging" => vec![friction(&|i| {
            (1.0 + s.dwell[i] / at(0)).ln() * (-s.since_rest[i] / at(1)).exp()
        })],
        "load_dependent_friction" => match &s.load {
            Some(load) => {
                let mean = load.iter().sum::<f64>() / load.len() as f64;
                vec![friction(&|i| load[i] - mean)]
            }
            None => Vec::new(),
        },
        "backlash" => {
            let gap = 0.5 * at(0);
            let mut carried = vec![0.0; s.x.len()];
            let mut load = s.x.first().copied().unwrap_or(0.0);
            for (c, &x) in carried.iter_mut().zip(&s.x) {
                load = load.clamp(x - gap, x + gap);
                *c = load;
            }
            let through = b.friction_along(&carried, s);
            vec![of(&|i| through[i] - b.friction[i])]
        }
        _ => Vec::new(),
    }
}

/// How the effort changes when the measured position is true position plus `error`: `−m·ë − Σ k_i·w_i`, where `w_i` follows
/// the error while block `i` sticks and is cleared when it slips.
fn encoder_column(error: &[f64], s: &Signals, b: &Baseline) -> Vec<f64> {
    let mut column: Vec<f64> = curvature(error, &s.pieces, s.dt)
        .iter()
        .map(|e| -b.mass * e)
        .collect();
    for &(k, d) in &b.blocks {
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
    column
}

/// Travel [m or rad], and a speed that a fifth of the moving samples stays below.
pub fn moving_range(s: &Signals) -> (f64, f64) {
    let (from, to) = bounds(&s.x);
    let top = s.v.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let moving: Vec<f64> =
        s.v.iter()
            .map(|v| v.abs())
            .filter(|v| *v > 0.01 * top)
            .collect();
    (to - from, quantile(&moving, 0.2).max(1e-300))
}
