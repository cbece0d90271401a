//! The motion of a recording.

use super::ZeroPhase;
use crate::friction::Path;
use crate::recording::Recording;

/// Speeds below this share of the highest count as standstill, where `sgn v` is noise.
const STANDSTILL: f64 = 1e-3;

/// Velocity, acceleration and effort of a recording, filtered alike.
#[derive(Clone)]
pub struct Kinematics {
    /// The filter and its band.
    pub filter: ZeroPhase,
    /// Velocity (m/s or rad/s).
    pub velocity: Vec<f64>,
    /// Acceleration (m/s² or rad/s²).
    pub acceleration: Vec<f64>,
    /// `sgn v`, 0 at standstill, not filtered.
    pub direction: Vec<f64>,
    /// Share of the acceleration, beside what velocity and direction explain of it, that is not the encoder's noise.
    pub reliable: f64,
}

impl Kinematics {
    /// The recording's motion, as friction models run along it.
    pub fn path<'a>(&'a self, recording: &'a Recording) -> Path<'a> {
        Path {
            position: &recording.position,
            velocity: &self.velocity,
            pieces: &recording.pieces,
            sample_time: recording.sample_time_s(),
        }
    }

    /// Chooses the band and differentiates the position.
    pub fn of(recording: &Recording) -> Self {
        Self::below(recording, ZeroPhase::choose_cutoff(recording))
    }

    /// Differentiates the position within the band up to a cut-off (Hz).
    pub fn below(recording: &Recording, cutoff_hz: f64) -> Self {
        let filter = ZeroPhase::new(recording, cutoff_hz);
        let velocity = filter.derivative(&recording.position, 1);
        let acceleration = filter.derivative(&recording.position, 2);
        let still = STANDSTILL * velocity.iter().fold(0.0, |top: f64, v| top.max(v.abs()));
        let direction = velocity
            .iter()
            .map(|v| if v.abs() <= still { 0.0 } else { v.signum() })
            .collect();
        let mut found = Self {
            filter,
            velocity,
            acceleration,
            direction,
            reliable: 1.0,
        };
        found.reliable = found.beside_noise(recording);
        found
    }
}
