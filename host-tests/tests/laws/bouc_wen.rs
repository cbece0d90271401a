//! Bouc-Wen with the survey's own parameters `β` and `γ`, integrated as printed.

use preslide_host_tests::reference::ode::integrate;

/// The model and its memory, in SI.
pub struct BoucWen {
    /// `σ0` (N/m).
    pub stiffness: f64,
    /// `β` (m⁻ⁿ).
    pub beta: f64,
    /// `γ` (m⁻ⁿ).
    pub gamma: f64,
    /// `n`.
    pub exponent: f64,
    /// `z` (m).
    pub deflection: f64,
}

impl BoucWen {
    /// `β` and `γ` from the force (N) that is neared and from `σ = β/(β + γ)`.
    pub fn new(stiffness: f64, coulomb: f64, exponent: f64, shape: f64) -> Self {
        let sum = (stiffness / coulomb).powf(exponent);
        Self {
            stiffness,
            beta: shape * sum,
            gamma: (1.0 - shape) * sum,
            exponent,
            deflection: 0.0,
        }
    }

    /// Moves by `displacement` (m) and returns the force (N).
    pub fn advance(&mut self, displacement: f64) -> f64 {
        let v = displacement.signum();
        let n = self.exponent;
        let slope = |z: f64| {
            v - self.beta * v.abs() * z.abs().powf(n - 1.0) * z - self.gamma * v * z.abs().powf(n)
        };
        if displacement != 0.0 {
            self.deflection = integrate(slope, self.deflection, displacement.abs(), 1e-19);
        }
        self.stiffness * self.deflection
    }
}
