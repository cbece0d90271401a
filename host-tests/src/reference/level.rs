//! The friction level by weighted least squares over everything that was seen: no recursion, no reciprocal.

/// Minimises `Σ w_i·(s_i − θ·φ_i)²` with `w_i = q^(k−i)/M`, `q = 1 − 1/M`, and one observation of `θ = 1` before all others
/// with the weight `q^k`.
#[derive(Clone, Debug)]
pub struct Level {
    memory: f64,
    seen: Vec<(f64, f64)>,
}

impl Level {
    /// Nothing seen, with the memory `M` (blocks).
    pub fn new(memory: f64) -> Self {
        Self {
            memory,
            seen: Vec::new(),
        }
    }

    /// Adds the model's mean force `φ` and the spent one `s`, both over the limit.
    pub fn see(&mut self, model: f64, spent: f64) {
        self.seen.push((model, spent));
    }

    /// `θ`.
    pub fn estimate(&self) -> f64 {
        let old = 1.0 - 1.0 / self.memory;
        let k = self.seen.len() as i32;
        let first = old.powi(k);
        let (mut top, mut bottom) = (first, first);
        for (i, (model, spent)) in (1..).zip(&self.seen) {
            let weight = old.powi(k - i) / self.memory;
            top += weight * model * spent;
            bottom += weight * model * model;
        }
        top / bottom
    }
}
