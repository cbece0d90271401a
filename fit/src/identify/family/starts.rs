//! Where the optimiser starts.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// `count` points in the unit cube of `dimensions`: each axis is cut into `count` equal parts, and each part of
/// each axis holds exactly one point (McKay, Beckman and Conover 1979).
pub fn latin_hypercube(count: usize, dimensions: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut points = vec![Vec::with_capacity(dimensions); count];
    for _ in 0..dimensions {
        let mut parts: Vec<usize> = (0..count).collect();
        for last in (1..count).rev() {
            parts.swap(last, random.random_range(0..=last));
        }
        for (point, part) in points.iter_mut().zip(parts) {
            let within: f64 = random.random();
            point.push((part as f64 + within) / count as f64);
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_of_every_axis_holds_one_point() {
        let points = latin_hypercube(40, 5, 7);
        for axis in 0..5 {
            let mut parts: Vec<usize> = points.iter().map(|p| (p[axis] * 40.0) as usize).collect();
            parts.sort_unstable();
            assert_eq!(parts, (0..40).collect::<Vec<_>>());
        }
        assert_ne!(points, latin_hypercube(40, 5, 8), "the seed must matter");
    }
}
