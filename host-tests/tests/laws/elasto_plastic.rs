//! Dupont's single-state law integrated in time, with `α` as printed.

use preslide_host_tests::reference::Stribeck;
use preslide_host_tests::reference::ode::integrate;
use std::f64::consts::PI;

/// The model and its memory, in SI.
pub struct ElastoPlastic {
    /// `σ0` (N/m).
    pub stiffness: f64,
    /// `σ1` (N·s/m).
    pub damping: f64,
    /// `z_ba` (m).
    pub elastic: f64,
    /// `s(v)`.
    pub stribeck: Stribeck,
    /// `T_s` (s).
    pub sample_time: f64,
    /// `z` (m).
    pub deflection: f64,
}

impl ElastoPlastic {
    fn rate(&self, z: f64, v: f64, steady: f64) -> f64 {
        let width = steady - self.elastic;
        let middle = 0.5 * (steady + self.elastic);
        let alpha = if z * v <= 0.0 || z.abs() <= self.elastic {
            0.0
        } else if z.abs() < steady {
            0.5 * (PI * (z.abs() - middle) / width).sin() + 0.5
        } else {
            1.0
        };
        v * (1.0 - alpha * z.abs() / steady)
    }

    /// Moves by `displacement` (m) at a constant rate over one sample time and returns the force (N) at its end. The
    /// caller's `velocity` (m/s) chooses `s(v)` and drives the damping.
    pub fn advance(&mut self, displacement: f64, velocity: f64) -> f64 {
        let steady = self.stribeck.force(velocity) / self.stiffness;
        let rate = displacement / self.sample_time;
        self.deflection = integrate(
            |z| self.rate(z, rate, steady),
            self.deflection,
            self.sample_time,
            1e-19,
        );
        self.stiffness * self.deflection
            + self.damping * self.rate(self.deflection, velocity, steady)
    }
}
