//! The axis as the margins see it: a mass on its contacts, behind the drive's first mode.

use nalgebra::SMatrix;
use std::f64::consts::TAU;

/// The axis about a place where it rests or slides (SI).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Machine {
    /// Moving mass, the rotor's with it (kg or kg·m²).
    pub mass: f64,
    /// What motor and sliding brake (N·s/m).
    pub braking: f64,
    /// Stiffness of the contacts that stick (N/m); 0 where it slides.
    pub contact: f64,
    /// The drive's first mode (Hz), between rotor and load with both free.
    pub mode_hz: f64,
    /// Its damping ratio (-).
    pub mode_damping: f64,
    /// Ticks from the command to the force, beside the hold.
    pub delay: u32,
}

/// Position and velocity of the mass, and of what the encoder sees behind the mode.
pub const STATES: usize = 4;

impl Machine {
    /// State and its reaction to a held force over `t` seconds: `(A, B)`.
    ///
    /// ```text
    /// m·x″ + b·x′ + k·x = F        y″ + 2ζω·y′ + ω²·y = ω²·x
    /// ```
    /// which for two masses and no other damping is exact: the load's answer has no zeros but the damper's.
    pub fn held(&self, t: f64) -> (SMatrix<f64, 4, 4>, SMatrix<f64, 4, 1>) {
        let mode = TAU * self.mode_hz;
        let mut a = SMatrix::<f64, 5, 5>::zeros();
        a[(0, 1)] = 1.0;
        a[(1, 0)] = -self.contact / self.mass;
        a[(1, 1)] = -self.braking / self.mass;
        a[(1, 4)] = 1.0 / self.mass;
        a[(2, 3)] = 1.0;
        a[(3, 0)] = mode * mode;
        a[(3, 2)] = -mode * mode;
        a[(3, 3)] = -2.0 * self.mode_damping * mode;
        let flow = (a * t).exp();
        (
            flow.fixed_view::<4, 4>(0, 0).into_owned(),
            flow.fixed_view::<4, 1>(0, 4).into_owned(),
        )
    }
}
