//! Seeded noise.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha12Rng;

/// Draws that a seed repeats.
pub struct Dice(ChaCha12Rng);

impl Dice {
    /// Of a seed.
    pub fn new(seed: u64) -> Self {
        Self(ChaCha12Rng::seed_from_u64(seed ^ 0x6d61_6368_696e_6573))
    }

    /// Nearly normal: twelve uniform ones (limits at six deviations).
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.0.random_range(0.0..1.0)).sum::<f64>() - 6.0
    }
}
