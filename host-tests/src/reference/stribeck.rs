//! `s(v) = F_c + (F_s − F_c)·exp(−(|v|/v_s)^δ)` with the true exponential.

/// The parameters, in SI.
#[derive(Clone, Copy, Debug)]
pub struct Stribeck {
    /// `F_s` (N).
    pub breakaway: f64,
    /// `F_c` (N).
    pub coulomb: f64,
    /// `v_s` (m/s).
    pub velocity: f64,
    /// `δ`.
    pub exponent: f64,
}

impl Stribeck {
    /// `s(v)` (N).
    pub fn force(&self, velocity: f64) -> f64 {
        let decay = (velocity.abs() / self.velocity).powf(self.exponent);
        self.coulomb + (self.breakaway - self.coulomb) * (-decay).exp()
    }
}
