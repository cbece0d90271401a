//! Motions: random ones with reversals on every scale, in encoder counts, and one with friction as a recording.

use preslide::{Motion, Units};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::fmt::Write as _;

/// Length of a count of the paper's encoder (m).
pub const COUNT: f64 = 25e-9;

/// Units of controllers in whole numbers: counts and millinewtons.
pub const COUNTS: Units = Units {
    length: COUNT,
    force: 1e-3,
    velocity: 1e-3,
};

/// What a model gets in a tick.
pub fn motion<S>(displacement: S, velocity: S) -> Motion<S> {
    Motion {
        displacement,
        velocity,
    }
}

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

/// A recording (CSV) whose friction is `dF/dt` of a published equation, integrated by Heun's method, which shares nothing with the library's closed
/// forms; the motion is two sines, so that strokes differ. The force has 300 N·s/m of viscous friction and -0.05 N besides, and uniform noise of ±5 mN.
///
/// `law(v, z)` is `dz/dt`, `force(v, z)` the friction.
pub fn recorded(law: impl Fn(f64, f64) -> f64, force: impl Fn(f64, f64) -> f64) -> String {
    /// Integration steps a sample.
    const FINE: usize = 40;
    const NOISE: f64 = 5e-3;
    let (sample_time, samples) = (2e-3, 10_000);
    let place = |t: f64| 60e-6 * (2.0 * t).sin() + 25e-6 * (5.3 * t).sin();
    let speed = |t: f64| 120e-6 * (2.0 * t).cos() + 25e-6 * 5.3 * (5.3 * t).cos();
    let mut text = String::from("t_s,x_m,friction_N\n");
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut z = 0.0;
    for i in 0..samples {
        let t = i as f64 * sample_time;
        let noise = random.random_range(-NOISE..NOISE);
        let friction = force(speed(t), z) + 300.0 * speed(t) - 0.05 + noise;
        writeln!(text, "{t},{},{friction}", place(t)).expect("a string takes all");
        let h = sample_time / FINE as f64;
        for j in 0..FINE {
            let t = t + j as f64 * h;
            let slope = law(speed(t), z);
            let ahead = law(speed(t + h), z + h * slope);
            z += 0.5 * h * (slope + ahead);
        }
    }
    text
}
