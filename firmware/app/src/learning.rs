//! A friction model that learns is built and set like the one that it wraps.

use crate::Model;
use core::marker::PhantomData;
use preslide::control::learning::Learn;
use preslide::control::{Learning, LearningSettings};
use preslide::{Friction, ParamError, Units};
use preslide_link::{ModelSettings, Refusal};

/// The model `M` whose friction learns `L` from what the drive spends, with [`LearningSettings::PAPER_AXIS`]. A new model, and new
/// gains, begin to learn anew.
pub struct Learned<M, L>(M, PhantomData<L>);

impl<M, L> Learned<M, L> {
    /// Lets `model` learn.
    pub const fn new(model: M) -> Self {
        Self(model, PhantomData)
    }
}

impl<M: Clone, L> Clone for Learned<M, L> {
    fn clone(&self) -> Self {
        Self::new(self.0.clone())
    }
}

impl<M, L> Model for Learned<M, L>
where
    M: Model,
    L: Learn<<M::Friction as Friction>::Scalar> + 'static,
{
    type Friction = Learning<M::Friction, L>;
    const UNITS: Units = M::UNITS;

    fn build(&self, sample_time: f64) -> Result<Self::Friction, ParamError> {
        let friction = self.0.build(sample_time)?;
        Learning::try_new(friction, &LearningSettings::PAPER_AXIS, Self::UNITS)
    }

    fn set(&self, settings: &ModelSettings) -> Result<Self, Refusal> {
        Ok(Self::new(self.0.set(settings)?))
    }
}
