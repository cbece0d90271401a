//! A learning model is built from the same source as the model it wraps.

use crate::{Model, Table};
use core::marker::PhantomData;
use preslide::control::learning::Learn;
use preslide::control::{Learning, LearningSettings};
use preslide::{Friction, ParamError, Units};

/// The model `M` with what `L` learns of it, by [`LearningSettings::PAPER_AXIS`]. A new model, and new gains, begin to learn anew.
pub struct Learner<M, L>(M, PhantomData<L>);

impl<M, L> Learner<M, L> {
    /// Learns of `model`.
    pub const fn new(model: M) -> Self {
        Self(model, PhantomData)
    }
}

impl<M: Clone, L> Clone for Learner<M, L> {
    fn clone(&self) -> Self {
        Self::new(self.0.clone())
    }
}

impl<M, L> Model for Learner<M, L>
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

    fn table(&mut self) -> Table<'_> {
        self.0.table()
    }
}
