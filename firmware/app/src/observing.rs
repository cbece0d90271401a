//! A friction model with an observer beside it comes from where the one that it wraps comes from.

use crate::{Model, Table};
use preslide::control::{Observed, ObserverSettings};
use preslide::{ParamError, Units};

/// The model `M` with an observer of these settings; outermost, so `Observing<Learner<M, L>>`. Set the integral gain to 0 beside it:
/// the disturbance takes its place.
#[derive(Clone)]
pub struct Observing<M>(M, ObserverSettings);

impl<M> Observing<M> {
    /// Observes what `model` leaves out.
    pub const fn new(model: M, settings: ObserverSettings) -> Self {
        Self(model, settings)
    }
}

impl<M: Model> Model for Observing<M> {
    type Friction = Observed<M::Friction>;
    const UNITS: Units = M::UNITS;

    fn build(&self, sample_time: f64) -> Result<Self::Friction, ParamError> {
        let friction = self.0.build(sample_time)?;
        Observed::try_new(friction, &self.1, sample_time, Self::UNITS)
    }

    fn table(&mut self) -> Table<'_> {
        self.0.table()
    }
}
