//! Eq. (1) integrated as it is printed.

use preslide_host_tests::reference::ode::integrate;

/// The model and its memory, in SI.
pub struct Dahl {
    /// `σ0` (N/m).
    pub stiffness: f64,
    /// `F_c` (N).
    pub coulomb: f64,
    /// `n`.
    pub exponent: f64,
    /// Force (N).
    pub force: f64,
}

impl Dahl {
    /// Moves by `displacement` (m) and returns the force (N).
    pub fn advance(&mut self, displacement: f64) -> f64 {
        let direction = displacement.signum();
        let slope = |force: f64| {
            let gap = 1.0 - force / self.coulomb * direction;
            // For n < 1 the force arrives at F_c, where the equation has no unique solution; it stays.
            if gap.abs() < 1e-12 {
                return 0.0;
            }
            direction * self.stiffness * gap.abs().powf(self.exponent) * gap.signum()
        };
        if displacement != 0.0 {
            self.force = integrate(slope, self.force, displacement.abs(), 1e-13);
        }
        self.force
    }
}
