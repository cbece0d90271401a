//! The converter of the current.

use super::{Sampling, SenseConfig};
use crate::normal::normal;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Keeps the converter's noise apart from what else a seed makes.
const STREAM: u64 = 0x5e45e;

#[derive(Debug, Clone)]
pub(super) struct Sense {
    config: SenseConfig,
    period_s: f64,
    random: ChaCha8Rng,
    /// Samples taken in this tick, the sum of their codes, and when the next is due \[s\].
    taken: u32,
    sum: f64,
    next_s: f64,
    /// \[A\].
    read: f64,
}

impl Sense {
    pub(super) fn new(config: SenseConfig, period_s: f64, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(STREAM);
        let mut sense = Self {
            config,
            period_s,
            random,
            taken: 0,
            sum: 0.0,
            next_s: 0.0,
            read: 0.0,
        };
        // A stage that has not moved yet is read as well.
        for _ in 0..sense.samples() {
            sense.sample(0.0);
        }
        sense.finish();
        sense
    }

    fn samples(&self) -> u32 {
        match self.config.sampling {
            Sampling::Oversampled(samples) => samples,
            Sampling::Synchronous(_) | Sampling::Unsynchronised => 1,
        }
    }

    /// The time of the next sample \[s\], if it is due by `to_s`.
    pub(super) fn due(&self, to_s: f64) -> Option<f64> {
        // A hair for rounding: the last sample is due at the very end of the period.
        (self.taken < self.samples() && self.next_s <= to_s * (1.0 + 1e-9))
            .then(|| self.next_s.min(to_s))
    }

    /// Converts.
    pub(super) fn sample(&mut self, current_a: f64) {
        let config = &self.config;
        let normal = normal(&mut self.random);
        let steps = f64::from(1_u32 << (config.bits - 1));
        let code = (current_a + config.offset_a + config.noise_a * normal) / config.range_a * steps;
        self.sum += code.round().clamp(-steps, steps - 1.0) * config.range_a / steps;
        self.taken += 1;
        self.next_s = self.place(self.taken + 1);
    }

    /// When the sample with this number, from 1, is due in a tick \[s\].
    fn place(&self, number: u32) -> f64 {
        self.period_s * f64::from(number) / f64::from(self.samples())
    }

    /// The tick is over.
    pub(super) fn finish(&mut self) {
        self.read = self.sum / f64::from(self.taken.max(1));
        (self.taken, self.sum) = (0, 0.0);
        self.next_s = match self.config.sampling {
            Sampling::Unsynchronised => self.period_s * self.random.random::<f64>(),
            // The pulse is in the middle of a tick.
            Sampling::Synchronous(phase) => self.period_s * (0.5 + phase),
            Sampling::Oversampled(_) => self.place(1),
        };
    }

    /// The mean of the last tick's samples \[A\].
    pub(super) fn read_a(&self) -> f64 {
        self.read
    }
}
