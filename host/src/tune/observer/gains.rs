//! The stationary Kalman filter of a mass under a disturbance that walks at random.

use nalgebra::{SMatrix, SVector};

/// What the filter believes of axis and encoder (SI).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Belief {
    /// Sample time (s).
    pub sample_time: f64,
    /// Moving mass (kg or kg·m²).
    pub mass: f64,
    /// What the motor brakes (N·s/m).
    pub braking: f64,
    /// Variance of a reading (m²).
    pub reading: f64,
    /// By how much the disturbance's variance grows in a second (N²/s).
    pub walk: f64,
}

/// What of the innovation goes to position (-), velocity (1/s) and disturbance (N/m, positive).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// `l₁`.
    pub position: f64,
    /// `l₂`.
    pub velocity: f64,
    /// `l₃`.
    pub disturbance: f64,
}

/// Ticks after which a filter that has not settled will not: at 20 kHz, 50 s.
const LONGEST: usize = 1_000_000;

/// Relative change of the gains in a tick that counts as none.
const SETTLED: f64 = 1e-12;

impl Belief {
    /// Position, velocity and disturbance after a tick, as `preslide::control::Observer` predicts them.
    pub fn transition(&self) -> SMatrix<f64, 3, 3> {
        let (t, per_force) = (self.sample_time, self.sample_time / self.mass);
        let braked = self.braking * per_force;
        SMatrix::from([
            [1.0, 0.0, 0.0],
            [t * (1.0 - braked / 2.0), 1.0 - braked, 0.0],
            [-t * per_force / 2.0, -per_force, 1.0],
        ])
    }

    /// The gains to which the Riccati recursion `P ← Φ·(P − K·C·P)·Φᵀ + Q`, `K = P·Cᵀ/(C·P·Cᵀ + R)` settles; `None` where it does
    /// not.
    pub fn gains(&self) -> Option<Gains> {
        let transition = self.transition();
        let mut covariance = SMatrix::<f64, 3, 3>::zeros();
        let mut last = SVector::<f64, 3>::zeros();
        for _ in 0..LONGEST {
            covariance[(2, 2)] += self.walk * self.sample_time;
            let gain = covariance.column(0) / (covariance[(0, 0)] + self.reading);
            let same = |(new, old): (&f64, &f64)| (new - old).abs() <= SETTLED * new.abs();
            if gain[0] > 0.0 && gain.iter().zip(&last).all(same) {
                return Some(Gains {
                    position: gain[0],
                    velocity: gain[1],
                    disturbance: -gain[2],
                });
            }
            let known = covariance - gain * covariance.row(0);
            covariance = transition * known * transition.transpose();
            last = gain;
        }
        None
    }
}
