//! A friction model beside an observer of what it leaves out.

use super::{Condition, Observer, ObserverSettings, ObserverState};
use crate::param::{ParamError, Units, positive, to_scalar};
use crate::{Friction, Motion, Scalar};

/// The friction model `F`, and what an [`Observer`] sees beside it.
///
/// Its force is `F̂ + d̂`: the model's friction and the disturbance that was observed, |d̂| at most
/// [`ObserverSettings::limit`]; [`super::FeedForward::limit`] bounds their sum. The observer's velocity takes the place of the one measured over a
/// window ([`Friction::velocity`]), which then is not computed, and has no lag.
///
/// It goes outermost: `Observed<Learning<With<F, E>, L>>`. The learner then compares what is spent with the model alone.
///
/// **Wind-up.** The observer is told the force that acted ([`Friction::acted`]): behind the limiter, and with what a fade adds. A cut
/// command therefore does not wind it up. Disabling the axis forgets the disturbance and keeps the velocity.
///
/// **Stability.** The disturbance closes a loop. Gains come with their margins (`preslide tune`), for a mass, a delay and a
/// resonance of the drive; nothing here checks them.
///
/// ```
/// use preslide::control::{Observed, ObserverSettings};
/// use preslide::{Block, Friction, Motion, QuasiStaticGms, Units};
///
/// let blocks = [Block { stiffness: 1e5, weight: 1.0 }];
/// let gms = QuasiStaticGms::<1>::try_new(&blocks, 0.9, Units::SI)?;
/// // `preslide tune` proposes the gains; the integral gain of the loop is 0 beside it.
/// let observed = Observed::try_new(gms, &ObserverSettings::PAPER_AXIS, 50e-6, Units::SI)?;
/// let mut state = observed.at_rest();
/// // Nothing was observed yet: the force is the model's.
/// assert!((observed.step(&mut state, Motion::quasi_static(1e-6)) - 0.1).abs() < 1e-6);
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Observed<F: Friction> {
    friction: F,
    observer: Observer<F::Scalar>,
    limit: F::Scalar,
}

/// What an [`Observed`] remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ObservedState<M, S> {
    friction: M,
    observer: ObserverState<S>,
    /// The model's force of this tick.
    modelled: S,
}

impl<M, S> ObservedState<M, S> {
    /// The friction model's memory.
    pub fn friction(&mut self) -> &mut M {
        &mut self.friction
    }

    /// What is observed.
    pub fn observer(&self) -> &ObserverState<S> {
        &self.observer
    }
}

impl<F: Friction> Observed<F> {
    /// `friction` must have been built in the same `units`; `sample_time` is `T` (s).
    ///
    /// # Errors
    /// [`ParamError`] where a setting is out of range or does not fit the number type.
    pub fn try_new(
        friction: F,
        settings: &ObserverSettings,
        sample_time: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        let limit = positive("limit of the disturbance", settings.limit)? / units.force;
        if let Some(own) = friction.limit() {
            let sum = own.to_f64() + limit;
            crate::param::fits::<F::Scalar>("limit of friction and disturbance", sum)?;
        }
        Ok(Self {
            observer: Observer::try_new(settings, sample_time, units)?,
            limit: to_scalar("limit of the disturbance", limit)?,
            friction,
        })
    }
}

impl<F: Friction> Friction for Observed<F> {
    type Scalar = F::Scalar;
    type State = ObservedState<F::State, F::Scalar>;
    const OBSERVES: bool = true;

    fn at_rest(&self) -> Self::State {
        ObservedState {
            friction: self.friction.at_rest(),
            observer: ObserverState::new(),
            modelled: F::Scalar::ZERO,
        }
    }

    fn release(&self, state: &mut Self::State) {
        self.friction.release(&mut state.friction);
        state.observer.release();
        state.modelled = F::Scalar::ZERO;
    }

    fn take_over(&self, old: &Self, state: &Self::State) -> Self::State {
        ObservedState {
            friction: self.friction.take_over(&old.friction, &state.friction),
            observer: state.observer.clone(),
            modelled: state.modelled,
        }
    }

    #[inline]
    fn set_position(&self, state: &mut Self::State, position: F::Scalar) {
        self.friction.set_position(&mut state.friction, position);
    }

    #[inline]
    fn velocity(
        &self,
        state: &mut Self::State,
        displacement: F::Scalar,
        _window: impl FnOnce() -> F::Scalar,
    ) -> F::Scalar {
        self.observer.observe(&mut state.observer, displacement);
        state.observer.velocity()
    }

    #[inline]
    fn step(&self, state: &mut Self::State, motion: Motion<F::Scalar>) -> F::Scalar {
        state.modelled = self.friction.step(&mut state.friction, motion);
        let disturbance = state.observer.disturbance().limited(self.limit);
        state.modelled.add_input(disturbance)
    }

    #[inline]
    fn acted(
        &self,
        state: &mut Self::State,
        velocity_error: F::Scalar,
        force: impl FnOnce() -> F::Scalar,
    ) {
        let beside = force().sub_input(state.modelled);
        (self.observer).act(&mut state.observer, beside, velocity_error);
    }

    #[inline]
    fn hand_observed(&self, state: &Self::State, left: &mut Self::State) {
        left.observer.clone_from(&state.observer);
    }

    #[inline]
    fn spent(&self, state: &mut Self::State, force: impl FnOnce() -> Option<F::Scalar>) {
        self.friction.spent(&mut state.friction, force);
    }

    fn condition(&self, state: &Self::State) -> Condition<F::Scalar> {
        self.friction.condition(&state.friction)
    }

    fn limit(&self) -> Option<F::Scalar> {
        (self.friction.limit()).map(|own| own.add_input(self.limit))
    }
}
