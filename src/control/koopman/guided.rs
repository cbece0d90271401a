//! A friction model beside a force that an outer task orders.

use crate::control::Condition;
use crate::param::{Bound, ParamError, Units, fits, positive, to_gain, to_scalar};
use crate::{Friction, Motion, Scalar};

/// The friction model `F`, and a force that a slower task orders once a sample of so many ticks ([`GuidedState::order`]).
///
/// It goes outermost: `Guided<Observed<F>>`. The observer then knows the ordered force as one that acts.
///
/// **Deadline.** An order counts from the next sample on; until then its task has time. A sample that begins without one is counted
/// ([`GuidedState::missed`]), the last order fades, to a third in a sample, and the control loop goes on as it is without an outer task.
/// |order| is at most the limit, whatever the task computes. Disabling the axis forgets the orders, and misses none until the next one.
#[derive(Clone, Debug, PartialEq)]
pub struct Guided<F: Friction> {
    friction: F,
    ticks: u32,
    limit: F::Scalar,
    fade: F::Scalar,
}

/// What a [`Guided`] remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GuidedState<M, S> {
    friction: M,
    /// What acts; what the next sample begins with.
    force: S,
    ordered: Option<S>,
    /// Ticks of the sample.
    tick: u32,
    guided: bool,
    fades: bool,
    missed: u32,
    /// What was travelled since the beginning of the sample.
    travelled: S,
    reference: S,
}

impl<M, S: Scalar> GuidedState<M, S> {
    /// The friction model's memory.
    pub fn friction(&mut self) -> &mut M {
        &mut self.friction
    }

    /// A sample has just begun: its task is to be started.
    #[inline]
    pub fn is_due(&self) -> bool {
        self.tick == 0
    }

    /// What axis and reference travelled until now, since this was asked last; ask when it [`is_due`](Self::is_due).
    #[inline]
    pub fn travelled(&mut self) -> [S; 2] {
        let both = [self.travelled, self.reference];
        (self.travelled, self.reference) = (S::ZERO, S::ZERO);
        both
    }

    /// The force that the next sample begins with.
    #[inline]
    pub fn order(&mut self, force: S) {
        self.ordered = Some(force);
        self.guided = true;
    }

    /// An order has come since the axis was enabled: samples without one are counted.
    #[inline]
    pub fn is_guided(&self) -> bool {
        self.guided
    }

    /// The force that acts.
    #[inline]
    pub fn force(&self) -> S {
        self.force
    }

    /// Samples that began without an order, up to 2³² − 1.
    pub fn missed(&self) -> u32 {
        self.missed
    }
}

impl<F: Friction> Guided<F> {
    /// `friction` must have been built in the same `units`. Orders come every so many `ticks` and are at most `limit` (N or N·m).
    ///
    /// # Errors
    /// [`ParamError`] where a setting is out of range or does not fit the number type.
    pub fn try_new(friction: F, ticks: u32, limit: f64, units: Units) -> Result<Self, ParamError> {
        let limit = positive("limit of the outer force", limit)? / units.force;
        if let Some(own) = friction.limit() {
            fits::<F::Scalar>("limit of friction and outer force", own.to_f64() + limit)?;
        }
        if ticks < 2 {
            return Err(ParamError::new(
                "ticks of an outer sample",
                ticks.into(),
                Bound::AtLeast(2.0),
            ));
        }
        Ok(Self {
            friction,
            ticks,
            limit: to_scalar("limit of the outer force", limit)?,
            fade: to_gain("fade of the outer force", 1.0 - 1.0 / f64::from(ticks))?,
        })
    }

    /// A sample begins.
    fn begin(&self, state: &mut GuidedState<F::State, F::Scalar>) {
        state.tick = 0;
        match state.ordered.take() {
            Some(force) => {
                state.force = force.limited(self.limit);
                state.fades = false;
            }
            None if state.guided => {
                state.missed = state.missed.saturating_add(1);
                state.fades = true;
            }
            None => (),
        }
    }
}

impl<F: Friction> Friction for Guided<F> {
    type Scalar = F::Scalar;
    type State = GuidedState<F::State, F::Scalar>;
    const OBSERVES: bool = F::OBSERVES;

    fn at_rest(&self) -> Self::State {
        GuidedState {
            friction: self.friction.at_rest(),
            force: F::Scalar::ZERO,
            ordered: None,
            // The first tick begins a sample.
            tick: self.ticks - 1,
            guided: false,
            fades: false,
            missed: 0,
            travelled: F::Scalar::ZERO,
            reference: F::Scalar::ZERO,
        }
    }

    fn release(&self, state: &mut Self::State) {
        self.friction.release(&mut state.friction);
        let missed = state.missed;
        *state = GuidedState {
            friction: state.friction.clone(),
            missed,
            ..self.at_rest()
        };
    }

    fn take_over(&self, old: &Self, state: &Self::State) -> Self::State {
        GuidedState {
            friction: self.friction.take_over(&old.friction, &state.friction),
            tick: state.tick.min(self.ticks - 1),
            ..state.clone()
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
        window: impl FnOnce() -> F::Scalar,
    ) -> F::Scalar {
        state.travelled = state.travelled.add_input(displacement);
        (self.friction).velocity(&mut state.friction, displacement, window)
    }

    #[inline]
    fn step(&self, state: &mut Self::State, motion: Motion<F::Scalar>) -> F::Scalar {
        state.reference = state.reference.add_input(motion.displacement);
        state.tick += 1;
        if state.tick >= self.ticks {
            self.begin(state);
        }
        if state.fades {
            state.force = self.fade.mul_input(state.force);
        }
        let modelled = self.friction.step(&mut state.friction, motion);
        modelled.add_input(state.force)
    }

    #[inline]
    fn acted(
        &self,
        state: &mut Self::State,
        velocity_error: F::Scalar,
        force: impl FnOnce() -> F::Scalar,
    ) {
        (self.friction).acted(&mut state.friction, velocity_error, force);
    }

    #[inline]
    fn hand_observed(&self, state: &Self::State, left: &mut Self::State) {
        (self.friction).hand_observed(&state.friction, &mut left.friction);
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
