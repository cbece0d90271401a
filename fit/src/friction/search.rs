//! Where a fit looks for a law: what a recording can show bounds its parameters, and several laws share their shapes.

use preslide::{Block, Sliding};

/// What a recording can show, which bounds the search.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// Displacement of a typical sample (m or rad).
    pub shortest: f64,
    /// Half of the longest stroke (m or rad).
    pub longest: f64,
    /// Highest speed (m/s or rad/s).
    pub speed: f64,
    /// Time between samples (s).
    pub sample_time: f64,
    /// Time from the first sample to the last (s).
    pub duration: f64,
}

impl Span {
    /// A pre-sliding length `times` as long as LuGre's: below a sample's displacement it cannot be seen, beyond a few strokes it is a spring.
    pub(super) fn length(&self, name: &'static str, times: f64) -> Bounded {
        bounded(
            name,
            times * (self.shortest / 3.0),
            times * (self.longest * 3.0),
        )
    }

    pub(super) fn stribeck_velocity(&self) -> Bounded {
        bounded("stribeck velocity", 1e-3 * self.speed, 3.0 * self.speed)
    }
}

/// A positive parameter that the optimiser moves, as its logarithm, between two bounds.
#[derive(Clone, Copy, Debug)]
pub struct Bounded {
    /// What it is, for messages.
    pub name: &'static str,
    /// Least value.
    pub from: f64,
    /// Greatest value.
    pub to: f64,
}

pub(super) fn bounded(name: &'static str, from: f64, to: f64) -> Bounded {
    Bounded { name, from, to }
}

/// Breakaway at more than three times the sliding force is no dry or lubricated contact.
pub(super) fn weakening() -> Bounded {
    bounded("coulomb over breakaway", 1.0 / 3.0, 1.0)
}

/// The exponent of LuGre's Stribeck curve; one recording seldom separates it from the Stribeck velocity.
const STRIBECK_EXPONENT: f64 = 2.0;

/// A Stribeck curve without lag.
pub(super) fn stribeck(breakaway: f64, weakening: f64, stribeck_velocity: f64) -> Sliding {
    Sliding {
        coulomb: breakaway * weakening.min(1.0),
        stribeck_velocity,
        stribeck_exponent: STRIBECK_EXPONENT,
        attraction: f64::INFINITY,
    }
}

/// Blocks of Leuven's transition curve.
const TRANSITION_BLOCKS: usize = 8;

/// Maxwell-slip blocks whose virgin curve meets `F_s·(1 − exp(−(z/length)^stretch))` where it has risen by equal steps
/// of the force, and `F_s` after the last. The curve is concave, so every stiffness is positive.
pub(super) fn transition_blocks(length: f64, stretch: f64, breakaway: f64) -> Vec<Block> {
    let steps = TRANSITION_BLOCKS as f64;
    let place = |share: f64| length * (-(1.0 - share).ln()).powf(1.0 / stretch);
    // The last chord ends half a step before the top, where the curve would never arrive.
    let mut corners: Vec<(f64, f64)> = (0..TRANSITION_BLOCKS)
        .map(|i| i as f64 / steps)
        .chain([1.0 - 0.5 / steps])
        .map(|share| (place(share), share * breakaway))
        .collect();
    let reached = 1.0 - 0.5 / steps;
    for corner in &mut corners {
        corner.1 /= reached;
    }
    let slopes: Vec<f64> = corners
        .windows(2)
        .map(|pair| (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0))
        .chain([0.0])
        .collect();
    corners[1..]
        .iter()
        .zip(slopes.windows(2))
        .map(|(corner, slopes)| {
            let stiffness = slopes[0] - slopes[1];
            Block {
                stiffness,
                weight: stiffness * corner.0 / breakaway,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Concave, all of the force, and as many as said.
    #[test]
    fn the_transition_curve_becomes_blocks() {
        for stretch in [0.3, 0.6, 1.0] {
            let blocks = transition_blocks(1e-6, stretch, 0.9);
            assert_eq!(blocks.len(), TRANSITION_BLOCKS);
            assert!(blocks.iter().all(|b| b.stiffness > 0.0 && b.weight > 0.0));
            let sum: f64 = blocks.iter().map(|b| b.weight).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        }
    }
}
