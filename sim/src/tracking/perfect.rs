//! The stage's own friction, fed forward: what is left then is not friction's.

use crate::stage::friction::FrictionTruth;
use crate::stage::{StageConfig, StageError};
use preslide::{Friction, Motion, Scalar, Units};
use std::marker::PhantomData;

/// A copy of a stage's friction, driven by the reference instead of the mass.
#[derive(Clone, Debug)]
pub struct Perfect<S> {
    truth: FrictionTruth,
    viscous_n_s_per_m: f64,
    units: Units,
    scalar: PhantomData<S>,
}

impl<S> Perfect<S> {
    /// Of a stage built from `config`.
    ///
    /// # Errors
    /// [`StageError`] naming the first key of the friction that is out of range.
    pub fn try_new(config: &StageConfig, units: Units) -> Result<Self, StageError> {
        Ok(Self {
            truth: FrictionTruth::try_new(&config.friction, config.seed)?,
            viscous_n_s_per_m: config.friction.viscous_n_s_per_m,
            units,
            scalar: PhantomData,
        })
    }
}

impl<S> PartialEq for Perfect<S> {
    /// Nobody swaps it.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl<S: Scalar> Friction for Perfect<S> {
    type Scalar = S;
    type State = FrictionTruth;

    fn at_rest(&self) -> FrictionTruth {
        self.truth.clone()
    }

    fn step(&self, state: &mut FrictionTruth, motion: Motion<S>) -> S {
        let v = motion.velocity.to_f64() * self.units.velocity;
        state.advance(motion.displacement.to_f64() * self.units.length);
        let force = state.force_n(v) + self.viscous_n_s_per_m * v;
        S::from_f32((force / self.units.force) as f32)
    }

    fn limit(&self) -> Option<S> {
        None
    }
}
