//! The recording that `preslide demo` makes for itself: the simulated stage under a plain position controller.

use crate::progress::Progress;
use crate::stage::trajectory::Trajectory;
use crate::stage::{Stage, StageConfig};
use std::f64::consts::TAU;

/// Strokes of one repeat (m), peak to peak. The largest exceeds twice the longest yield displacement of the
/// paper's axis (39 µm), so that every block slips; the smaller ones show the memory.
const STROKES_M: [f64; 4] = [150e-6, 60e-6, 20e-6, 8e-6];
/// Speed of the strokes (m/s): below the Stribeck velocity, and hundreds of samples within a stroke.
const SPEED_M_S: f64 = 40e-6;
/// Repeats: one fold of the cross-validation each.
const REPEATS: usize = 6;
/// Control ticks averaged into one sample: 500 Hz at the stage's 20 kHz.
const TICKS_PER_SAMPLE: usize = 40;
/// Bandwidth of the position controller (Hz), a ninth of the drive's resonance.
const BANDWIDTH_HZ: f64 = 40.0;

/// What an engineer would have on disk after an afternoon at the machine.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    /// Time (s).
    pub t_s: Vec<f64>,
    /// Measured position (m), from the encoder count.
    pub x_m: Vec<f64>,
    /// Motor force at the stage (N), from the measured current.
    pub force_n: Vec<f64>,
    /// Number of the repeat.
    pub repeat: Vec<u32>,
}

impl Samples {
    /// The recording as CSV in the project's format.
    pub fn to_csv(&self) -> String {
        let mut text = String::from("t_s,x_m,force_N,repeat\n");
        for i in 0..self.t_s.len() {
            text += &format!(
                "{:.6},{:.10},{:.6},{}\n",
                self.t_s[i], self.x_m[i], self.force_n[i], self.repeat[i]
            );
        }
        text
    }
}

/// Moves the simulated stage through nested triangles and records it.
///
/// # Errors
/// Where the stage refuses its configuration.
pub fn record(seed: u64, progress: &Progress) -> anyhow::Result<Samples> {
    let config = StageConfig {
        seed,
        ..StageConfig::default()
    };
    let mut corners = vec![(0.0, 0.0)];
    let mut repeats = Vec::new();
    for _ in 0..REPEATS {
        for stroke in STROKES_M {
            for end in [0.5 * stroke, -0.5 * stroke] {
                let (t, x) = corners[corners.len() - 1];
                corners.push((t + (end - x).abs() / SPEED_M_S, end));
            }
        }
        repeats.push(corners[corners.len() - 1].0);
    }
    let trajectory = Trajectory::try_polyline(&corners, 0.0)?;

    let mut stage = Stage::try_new(config.clone())?;
    let mass = config.mass_kg + stage.reflected_rotor_kg();
    let omega = TAU * BANDWIDTH_HZ;
    let (stiffness, damping, reset) = (mass * omega * omega, 1.4 * mass * omega, omega / 4.0);
    let tick = 1.0 / config.control_rate_hz;
    // The derivative of 25 nm counts at 20 kHz needs a low-pass, here at five times the bandwidth.
    let smoothing = 1.0 - (-5.0 * omega * tick).exp();
    let force_per_volt = stage.force_constant_n_per_a() / config.motor.resistance_ohm;

    let mut samples = Samples::default();
    let (mut error_before, mut slope, mut sum) = (0.0, 0.0, 0.0);
    let (mut position, mut current) = (0.0, 0.0);
    let mut reading = stage.reading();
    let ticks = (trajectory.duration_s() / tick) as usize;
    for k in 0..ticks {
        let time = k as f64 * tick;
        let measured = f64::from(reading.count) * config.encoder.count_m;
        let error = trajectory.at(time).position_m - measured;
        slope += smoothing * ((error - error_before) / tick - slope);
        error_before = error;
        sum += stiffness * reset * tick * error;
        let force = stiffness * error + damping * slope + sum;
        reading = stage.tick(force / force_per_volt / reading.supply_v);

        position += measured;
        current += reading.current_a;
        if (k + 1) % TICKS_PER_SAMPLE == 0 {
            let n = TICKS_PER_SAMPLE as f64;
            samples.t_s.push(time - 0.5 * (n - 1.0) * tick);
            samples.x_m.push(position / n);
            samples
                .force_n
                .push(current / n * stage.force_constant_n_per_a());
            samples
                .repeat
                .push(repeats.partition_point(|&end| end <= time) as u32);
            (position, current) = (0.0, 0.0);
        }
        if (k + 1) % (ticks / 100) == 0 {
            progress.inc(1);
        }
    }
    Ok(samples)
}
