//! Where a fit looks for a law: parameters that enter nonlinearly, where these may lie, and what is left linear.

use super::{Family, FrictionModel};
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

/// A recording of which nothing but its form matters.
const ANY: Span = Span {
    shortest: 1.0,
    longest: 1.0,
    speed: 1.0,
    sample_time: 1.0,
    duration: 1.0,
};

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
        bounded("v_s", 1e-3 * self.speed, 3.0 * self.speed)
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
    bounded("F_c/F_s", 1.0 / 3.0, 1.0)
}

/// How a law is searched for.
pub(super) struct Search {
    /// Bounds of the nonlinear parameters.
    pub(super) bounds: fn(&Span) -> Vec<Bounded>,
    /// See [`Family::model`].
    pub(super) model: fn(&[f64], f64, f64) -> Option<FrictionModel>,
}

impl Family {
    /// The nonlinear parameters. Every one is a length, a velocity, a rate or a ratio: the level of the force is
    /// linear and is solved for, see [`Family::model`].
    pub fn parameters(self, span: &Span) -> Vec<Bounded> {
        (self.search().bounds)(span)
    }

    /// The model with the parameters `nonlinear`, whose force is
    /// `amplitude·(force of model(nonlinear, 1, 0)) + damping·(force of model(nonlinear, 1, 1) − force of model(nonlinear, 1, 0))`.
    ///
    /// `amplitude` (N or N·m) is `F_c` (Dahl, Bouc-Wen), `k_2s/β` (Hsieh), else `F_s`; `damping` (N·s/m or N·m·s/rad) is
    /// `σp` (LuGre), `σ1` (elasto-plastic, Leuven), `C_v` (Hsieh). `None` where `nonlinear` has the wrong length.
    pub fn model(self, nonlinear: &[f64], amplitude: f64, damping: f64) -> Option<FrictionModel> {
        (self.search().model)(nonlinear, amplitude, damping)
    }

    /// One of its models.
    fn example(self) -> Option<FrictionModel> {
        let least = self.parameters(&ANY).into_iter().map(|b| b.from);
        self.model(&least.collect::<Vec<_>>(), 1.0, 0.0)
    }

    /// Its name in messages and tables.
    pub fn name(self) -> String {
        self.example()
            .map_or_else(String::new, |model| model.name())
    }

    /// Whether the model has a viscous term of its own: LuGre's `σp·dz/dt` and its relatives', Hsieh's `C_v·dx_s/dt`.
    pub fn is_damped(self) -> bool {
        let model = self.example();
        model.is_some_and(|mut model| model.damping().is_some())
    }

    /// Number of friction parameters that are fitted, without offset and rigid body.
    pub fn parameter_count(self) -> usize {
        self.parameters(&ANY).len() + 1 + usize::from(self.is_damped())
    }
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
