//! What a perfect diagnosis could reach: the recorded force without noise, with and without an effect,
//! and how much of it a refitted baseline still explains.

use super::body::{MOTOR_SHARE, TICK_S};
use super::effect::{Effect, Id};
use super::law::Hysteresis;
use super::plant::{Tick, encoder_error};
use super::scenario::Scenario;
use crate::least_squares::least_squares;

/// What can be achieved on a trial, from the truth.
#[derive(Clone, Debug)]
pub struct Achievable {
    /// Force (N) at each sample, on the true path, with every effect and without noise or variability.
    pub with: Vec<f64>,
    /// The same without any effect.
    pub without: Vec<f64>,
    /// For each effect of the label, RMS over the recording of what it adds (N).
    pub effect_rms: Vec<f64>,
    /// NMSE (%) of the recorded force that noise and variability leave to the true model.
    pub floor_nmse: f64,
    /// NMSE (%) that mass and a 16-block Maxwell-slip model without any effect, refitted by least squares,
    /// leave.
    pub baseline_nmse: f64,
}

/// Number of stops of the refitted baseline, and their yields (m).
const STOPS: usize = 16;
const YIELDS: (f64, f64) = (0.4e-6, 400e-6);

impl Achievable {
    /// From a scenario, what happened, and the recorded force (N) at every `scenario.ticks_per_sample`.
    pub fn new(scenario: &Scenario, ticks: &[Tick], recorded: &[f64]) -> Self {
        let all: Vec<Id> = scenario.effects.iter().map(|e| e.id).collect();
        let with = deterministic(scenario, ticks, &[]);
        let without = deterministic(scenario, ticks, &all);
        let effect_rms = all
            .iter()
            .map(|id| {
                rms(with
                    .iter()
                    .zip(&deterministic(scenario, ticks, &[*id]))
                    .map(|(a, b)| a - b))
            })
            .collect();
        let mean = recorded.iter().sum::<f64>() / recorded.len() as f64;
        let force_rms = rms(recorded.iter().map(|f| f - mean));
        let nmse = |residual: f64| 100.0 * (residual / force_rms).powi(2);
        let floor_nmse = nmse(rms(recorded.iter().zip(&with).map(|(a, b)| a - b)));
        let baseline_nmse = nmse(refit(scenario, ticks, recorded));
        Achievable {
            with,
            without,
            effect_rms,
            floor_nmse,
            baseline_nmse,
        }
    }
}

/// Root mean square of a sequence.
pub fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0usize), |(sum, n), v| (sum + v * v, n + 1));
    (sum / n.max(1) as f64).sqrt()
}

/// Position, velocity and acceleration as the encoder shows them, without quantisation, through a filter
/// of 100 Hz: the second derivative of an error at kilohertz is nothing that anyone would compute.
fn as_measured(scenario: &Scenario, [x, v, a]: [f64; 3]) -> [f64; 3] {
    let corner = 100.0 * super::ENCODER_PERIOD_M;
    let passed = 1.0 / (1.0 + (v / corner).powi(4));
    let [e, de, dde] = encoder_error(scenario, x).map(|part| passed * part);
    [x + e, v * (1.0 + de), a * (1.0 + de) + dde * v * v]
}

/// Force (N) that would be recorded at each sample on the path that was travelled, without noise and
/// variability and without the `removed` effects.
pub fn deterministic(scenario: &Scenario, ticks: &[Tick], removed: &[Id]) -> Vec<f64> {
    let kept: Vec<Effect> = scenario
        .effects
        .iter()
        .filter(|e| !removed.contains(&e.id))
        .cloned()
        .collect();
    let keeps = |wanted: fn(&Id) -> bool| kept.iter().any(|e| wanted(&e.id));
    let two_masses = keeps(|id| id.needs_two_masses());
    let actuator = keeps(|id| matches!(id, Id::ActuatorDeadZone | Id::ActuatorSaturation));
    let through_encoder = removed.contains(&Id::EncoderError);
    let mut friction = if removed.contains(&Id::PreslidingShape) {
        scenario.friction_of_model(&kept)
    } else {
        scenario.friction(&kept)
    };
    let forces: Vec<f64> = ticks
        .iter()
        .enumerate()
        .map(|(i, tick)| {
            let mut side = if two_masses { tick.load } else { tick.motor };
            if through_encoder {
                side = as_measured(scenario, side);
            }
            let inertial = if two_masses {
                let share = MOTOR_SHARE;
                scenario.mass * (share * tick.motor[2] + (1.0 - share) * tick.load[2])
            } else {
                scenario.mass * side[2]
            };
            let lost = if actuator {
                tick.commanded - tick.acted
            } else {
                0.0
            };
            let dt = if i == 0 { 0.0 } else { TICK_S };
            inertial + lost + friction.step(dt, &tick.now(i as f64 * TICK_S, side), 1.0)
        })
        .collect();
    sample(scenario, &forces, &kept)
}

/// Takes every sample of a force at the ticks, as late as a channel delay among `effects` makes it.
pub fn sample(scenario: &Scenario, forces: &[f64], effects: &[Effect]) -> Vec<f64> {
    let delay = effects
        .iter()
        .find(|e| e.id == Id::ChannelDelay)
        .map_or(0.0, |e| e.values[0])
        / TICK_S;
    (0..forces.len())
        .step_by(scenario.ticks_per_sample)
        .map(|i| {
            let at = (i as f64 - delay).max(0.0);
            let (low, part) = (at.floor() as usize, at.fract());
            let high = (low + 1).min(forces.len() - 1);
            forces[low] + part * (forces[high] - forces[low])
        })
        .collect()
}

/// RMS (N) of what acceleration and stops, fitted to `recorded` by least squares, leave.
fn refit(scenario: &Scenario, ticks: &[Tick], recorded: &[f64]) -> f64 {
    let ratio = (YIELDS.1 / YIELDS.0).powf(1.0 / (STOPS - 1) as f64);
    let mut stops: Vec<Hysteresis> = (0..STOPS)
        .map(|i| {
            let yielding = YIELDS.0 * ratio.powi(i as i32);
            Hysteresis::of_blocks(&[(1.0 / yielding, 1.0)])
        })
        .collect();
    let mut before = 0.0;
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(recorded.len());
    for (i, tick) in ticks.iter().enumerate() {
        let [x, v, a] = as_measured(scenario, tick.motor);
        let moved = stops
            .iter_mut()
            .map(|stop| stop.step(x - before, v, 1.0, 1.0));
        let row: Vec<f64> = std::iter::once(a).chain(moved).collect();
        before = x;
        if i % scenario.ticks_per_sample == 0 {
            rows.push(row);
        }
    }
    let all: Vec<usize> = (0..rows.len()).collect();
    let weights = least_squares(&rows, recorded, &all);
    let weights = weights.expect("a ridge keeps the stops apart");
    rms(rows
        .iter()
        .zip(recorded)
        .map(|(row, force)| force - row.iter().zip(&weights).map(|(a, b)| a * b).sum::<f64>()))
}
