//! Normal numbers.

use rand::{Rng, RngExt as _};
use std::f64::consts::TAU;

/// A standard normal number, by Box and Muller of two uniform ones; `1 − u` is never zero.
///
/// `rand_distr` draws by another method: every seed's recording would change, and with it the figures that were printed of it.
pub fn normal(random: &mut impl Rng) -> f64 {
    let (u, v): (f64, f64) = (random.random(), random.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * v).cos()
}
