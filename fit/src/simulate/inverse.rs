//! From force to motion: friction models inverted, one force after the other, without inertia.

use crate::friction::{FrictionModel, Visitor};
use preslide::{Block, Friction, Motion, ParamError, Sliding};

/// A model at rest under a force, waiting for the next one.
pub trait Inverse {
    /// Moves until the friction force is `force` (N or N·m); the displacement (m or rad).
    ///
    /// # Errors
    /// [`SlidesAway`] where no displacement gives that force; the state is then as before.
    fn advance(&mut self, force: f64) -> Result<f64, SlidesAway>;
}

/// The body breaks away: friction cannot balance the force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlidesAway {
    /// The highest friction force (N or N·m) of the model.
    pub limit: f64,
}

/// The inverse of `model`, from a body that was never moved, for forces `sample_time` \[s\] apart.
///
/// # Errors
/// [`ParamError`] where the library refuses a parameter.
pub fn inverse(model: &FrictionModel, sample_time: f64) -> Result<Box<dyn Inverse>, ParamError> {
    if let FrictionModel::Coulomb { coulomb } = *model {
        return Ok(Box::new(Rigid { limit: coulomb }));
    }
    if let FrictionModel::Gms {
        breakaway,
        ref blocks,
        ..
    } = *model
    {
        let block = |b: &Block| SlipBlock {
            stiffness: b.stiffness,
            limit: b.yield_displacement(breakaway),
            deflection: 0.0,
        };
        let blocks = blocks.iter().map(block).collect();
        return Ok(Box::new(MaxwellSlip { blocks }));
    }
    let scale = model.clone().law().length;
    let timed = matches!(model, FrictionModel::Hsieh(_)).then_some(sample_time);
    // The others take the time for their lag alone, which is none at rest.
    let time = timed.unwrap_or(sample_time.min(1.0));
    // At rest the level is the breakaway force, and nothing is damped.
    let still = model.along(Sliding::none);
    let still = still.as_ref().unwrap_or(model);
    still.visit(time, Search { scale, timed })
}

/// Has any model searched.
struct Search {
    scale: f64,
    timed: Option<f64>,
}

impl Visitor for Search {
    type Outcome = Box<dyn Inverse>;

    fn visit<M: Friction<Scalar = f64, State: Send> + Send + 'static>(
        self,
        model: M,
    ) -> Self::Outcome {
        Box::new(Searched {
            state: model.at_rest(),
            model,
            scale: self.scale,
            sample_time: self.timed,
        })
    }
}

/// Coulomb: no motion below the limit.
struct Rigid {
    limit: f64,
}

impl Inverse for Rigid {
    fn advance(&mut self, force: f64) -> Result<f64, SlidesAway> {
        if force.abs() <= self.limit {
            Ok(0.0)
        } else {
            Err(SlidesAway { limit: self.limit })
        }
    }
}

#[derive(Clone, Copy)]
struct SlipBlock {
    stiffness: f64,
    /// Yield displacement `D_i`.
    limit: f64,
    /// `z_i`.
    deflection: f64,
}

/// The quasi-static GMS law. Between yields the force is linear in the displacement, so the walk from one yield to
/// the next ends at the exact displacement.
struct MaxwellSlip {
    blocks: Vec<SlipBlock>,
}

/// Relative excess over `ΣW` that is rounding, not force.
const ROUNDING: f64 = 1e-12;

impl Inverse for MaxwellSlip {
    fn advance(&mut self, force: f64) -> Result<f64, SlidesAway> {
        let limit: f64 = self.blocks.iter().map(|b| b.stiffness * b.limit).sum();
        if force.abs() > limit * (1.0 + ROUNDING) {
            return Err(SlidesAway { limit });
        }
        let now = |blocks: &[SlipBlock]| -> f64 {
            blocks.iter().map(|b| b.stiffness * b.deflection).sum()
        };
        let sign = if force >= now(&self.blocks) {
            1.0
        } else {
            -1.0
        };
        let mut moved = 0.0;
        // Every round ends at the force or makes a block yield for good; twice over, for yields apart by rounding.
        for _ in 0..=2 * self.blocks.len() {
            let missing = sign * (force - now(&self.blocks));
            let sticking = self.blocks.iter().filter(|b| sign * b.deflection < b.limit);
            let (stiffness, to_yield) = sticking.fold((0.0, f64::INFINITY), |(k, to), b| {
                (k + b.stiffness, to.min(b.limit - sign * b.deflection))
            });
            if stiffness == 0.0 || missing <= 0.0 {
                break;
            }
            let step = missing / stiffness;
            let yields = step >= to_yield;
            let step = step.min(to_yield);
            for block in &mut self.blocks {
                let free = sign * block.deflection + step;
                // The one that yields here does so exactly, whatever the subtraction above rounded.
                let at_limit = free >= block.limit * (1.0 - f64::EPSILON);
                block.deflection = sign * if at_limit { block.limit } else { free };
            }
            moved += step;
            if !yields {
                break;
            }
        }
        Ok(sign * moved)
    }
}

/// Any model of the library, by root finding on the displacement of a step.
struct Searched<M: Friction<Scalar = f64>> {
    model: M,
    state: M::State,
    /// A length over which the force changes (m or rad).
    scale: f64,
    /// The time of a step \[s\] where time matters: the velocity is then the displacement over it.
    sample_time: Option<f64>,
}

/// Doublings of the bracket from a millionth of the scale: to 1e30 of it, where no force changes any more.
const DOUBLINGS: usize = 120;
/// Halvings and secants after that; bisection alone takes 53 to rounding.
const NARROWINGS: usize = 200;

impl<M: Friction<Scalar = f64>> Searched<M> {
    fn motion(&self, displacement: f64) -> Motion<f64> {
        Motion {
            displacement,
            velocity: self.sample_time.map_or(0.0, |time| displacement / time),
        }
    }

    /// Force after a step of `displacement`, less `force`; rises with the displacement.
    fn excess(&self, displacement: f64, force: f64) -> f64 {
        let mut state = self.state.clone();
        self.model.step(&mut state, self.motion(displacement)) - force
    }

    /// A displacement beyond the root, and the excess there.
    fn beyond(&self, sign: f64, force: f64) -> Option<(f64, f64)> {
        (0..DOUBLINGS)
            .map(|i| sign * self.scale * 1e-6 * 2_f64.powi(i as i32))
            .map(|x| (x, self.excess(x, force)))
            .find(|(_, excess)| sign * excess >= 0.0)
    }
}

impl<M: Friction<Scalar = f64>> Inverse for Searched<M> {
    fn advance(&mut self, force: f64) -> Result<f64, SlidesAway> {
        // These models near their limit without reaching it.
        if let Some(limit) = self.model.limit().filter(|limit| force.abs() >= *limit) {
            return Err(SlidesAway { limit });
        }
        let at_rest = (0.0, self.excess(0.0, force));
        let mut root = 0.0;
        if at_rest.1 != 0.0 {
            let far = self
                .beyond(-at_rest.1.signum(), force)
                .ok_or(SlidesAway { limit: force.abs() })?;
            root = narrow(at_rest, far, &|x| self.excess(x, force));
        }
        let motion = self.motion(root);
        self.model.step(&mut self.state, motion);
        Ok(root)
    }
}

/// The root between `near` and `far` (each a point and its value, of opposite signs): regula falsi after Illinois,
/// with bisection whenever that does not halve the bracket.
fn narrow(mut near: (f64, f64), mut far: (f64, f64), value: &dyn Fn(f64) -> f64) -> f64 {
    let (mut near_weight, mut far_weight) = (1.0, 1.0);
    let mut bisect = false;
    for _ in 0..NARROWINGS {
        let width = (far.0 - near.0).abs();
        if far.1 == 0.0 || width <= 2.0 * f64::EPSILON * far.0.abs().max(near.0.abs()) {
            break;
        }
        let (a, b) = (near.1 * near_weight, far.1 * far_weight);
        let secant = near.0 - a * (far.0 - near.0) / (b - a);
        let middle = 0.5 * (near.0 + far.0);
        let inside = (secant - near.0) * (secant - far.0) < 0.0;
        let x = if bisect || !inside { middle } else { secant };
        let at = value(x);
        if (at > 0.0) == (far.1 > 0.0) || at == 0.0 {
            far = (x, at);
            (near_weight, far_weight) = (near_weight * 0.5, 1.0);
        } else {
            near = (x, at);
            (near_weight, far_weight) = (1.0, far_weight * 0.5);
        }
        bisect = (far.0 - near.0).abs() > 0.5 * width;
    }
    if near.1.abs() < far.1.abs() {
        near.0
    } else {
        far.0
    }
}
