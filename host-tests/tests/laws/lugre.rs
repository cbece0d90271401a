//! Eqs. (2)–(3) integrated in time.

use preslide_host_tests::reference::Stribeck;
use preslide_host_tests::reference::ode::integrate;

/// The model and its memory, in SI.
pub struct LuGre {
    /// `σ0` (N/m).
    pub stiffness: f64,
    /// `σp` (N·s/m).
    pub damping: f64,
    /// `s(v)`.
    pub stribeck: Stribeck,
    /// `T_s` (s).
    pub sample_time: f64,
    /// `σ0·z` (N).
    pub elastic: f64,
}

impl LuGre {
    /// Moves by `displacement` (m) at a constant rate over one sample time and returns the force (N) at its
    /// end. The caller's `velocity` (m/s) chooses `s(v)` and drives the damping.
    pub fn advance(&mut self, displacement: f64, velocity: f64) -> f64 {
        let strength = self.stribeck.force(velocity);
        let bristle = |v: f64, elastic: f64| self.stiffness * (v - elastic / strength * v.abs());
        let rate = displacement / self.sample_time;
        self.elastic = integrate(
            |elastic| bristle(rate, elastic),
            self.elastic,
            self.sample_time,
            1e-14,
        );
        self.elastic + self.damping * bristle(velocity, self.elastic) / self.stiffness
    }
}
