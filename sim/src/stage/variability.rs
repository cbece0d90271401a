//! The part of friction that does not repeat.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A number in −1..1 that wanders smoothly with slipped path.
///
/// Knots are uniform in −1..1 at equal distances of path, joined by `a + (b − a)·t²(3 − 2t)`, so the bound is exact.
/// It is a function of path, not of steps: halving the integration step does not change what is drawn.
#[derive(Debug, Clone)]
pub(super) struct Wander {
    rng: ChaCha8Rng,
    from: f64,
    to: f64,
    /// Path since `from`, in knot distances [–].
    phase: f64,
    knots_per_m: f64,
}

/// The next number of a stream, uniform in −1..1.
fn uniform(rng: &mut ChaCha8Rng) -> f64 {
    // 53 random bits make every f64 of the grid equally likely.
    (rng.next_u64() >> 11) as f64 * (2.0 / (1u64 << 53) as f64) - 1.0
}

impl Wander {
    /// Process number `stream` of `seed`, with `correlation_m` of path between knots.
    pub(super) fn new(seed: u64, stream: u64, correlation_m: f64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(stream);
        let (from, to) = (uniform(&mut rng), uniform(&mut rng));
        Self {
            rng,
            from,
            to,
            phase: 0.0,
            knots_per_m: 1.0 / correlation_m,
        }
    }

    /// Moves on by `path_m` ≥ 0 of slipped path.
    pub(super) fn advance(&mut self, path_m: f64) {
        self.phase += path_m * self.knots_per_m;
        if self.phase < 1.0 {
            return;
        }
        // Only the last two knots matter, however many a wild step jumps over.
        let draws = if self.phase < 2.0 { 1 } else { 2 };
        for _ in 0..draws {
            self.from = self.to;
            self.to = uniform(&mut self.rng);
        }
        self.phase = self.phase.fract();
    }

    /// The value here.
    pub(super) fn value(&self) -> f64 {
        let t = self.phase;
        self.from + (self.to - self.from) * t * t * (3.0 - 2.0 * t)
    }
}

/// The constant of one repeat, in −1..1.
pub(super) fn repeat_constant(seed: u64, stream: u64) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    uniform(&mut rng)
}
