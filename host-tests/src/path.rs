//! Random motion with reversals on every scale, in encoder counts.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Length of a count of the paper's encoder (m).
pub const COUNT: f64 = 25e-9;

/// Sample time of a 20 kHz control task (s).
pub const SAMPLE_TIME: f64 = 50e-6;

/// Counts travelled in each of `ticks` ticks: legs of log-uniform length (1…`longest` counts) and speed
/// (1…`fastest` counts per tick) that alternate in direction, with a rest of some ticks after every fourth.
pub fn random_reversals(seed: u64, ticks: usize, longest: f64, fastest: f64) -> Vec<i32> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut path = Vec::with_capacity(ticks + 64);
    let mut direction = 1;
    while path.len() < ticks {
        let length = longest.powf(rng.random_range(0.0..1.0)).round() as i32;
        let speed = (fastest.powf(rng.random_range(0.0..1.0)).round() as i32).max(1);
        let mut left = length;
        while left > 0 {
            let step = speed.min(left);
            path.push(direction * step);
            left -= step;
        }
        if rng.random_range(0..4) == 0 {
            path.extend(std::iter::repeat_n(0, rng.random_range(1..10)));
        }
        direction = -direction;
    }
    path.truncate(ticks);
    path
}
