//! What every trial has in common: the sample time, and how a compliant drive divides the mass.

use std::f64::consts::PI;

/// Sample time of the controller (s).
pub const TICK_S: f64 = 0.25e-3;
/// Share of the moving mass on the motor's side of a compliant drive.
pub const MOTOR_SHARE: f64 = 0.4;

/// Resonance of a compliant drive with a load held at neither side (Hz).
pub fn resonance_hz(mass: f64, stiffness: f64) -> f64 {
    (stiffness / (mass * MOTOR_SHARE * (1.0 - MOTOR_SHARE))).sqrt() / (2.0 * PI)
}
