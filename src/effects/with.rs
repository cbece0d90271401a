//! A friction model with effects is a friction model.

use super::{Effect, Situation};
use crate::param::{Bound, ParamError};
use crate::{Friction, Motion, Scalar};

/// The friction model `F` with the effects `E`, an [`Effect`] or a tuple of up to eight (tuples nest).
///
/// `F = max(0, 1 + Σ level_i)·F_model + Σ force_i`; the displacement that the model sees has the change of `Σ shift_i`
/// added. Levels are summed and not multiplied, so that several small ones stay what each was fitted as.
///
/// **Cost.** That of the effects in the tuple, their number known at compile time; with `()` two stores (the position, and that it is known)
/// beside the friction model's own instructions, on a Cortex-M4F.
///
/// **Bound.** `|F| ≤ (1 + Σ bound of level_i)·limit of the model + Σ bound of force_i` ([`Friction::limit`]), for any
/// motion, position, temperature and load, NaN included.
///
/// **Stability.** What [`VelocitySource`](crate::control::VelocitySource) says holds with that bound. Driven by the measured motion, a
/// level adds `level·Σk_i` to the stiffness that the feedback has to exceed, a spring its own.
#[derive(Clone, Debug, PartialEq)]
pub struct With<F, E> {
    friction: F,
    effects: E,
}

/// What a [`With`] remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WithState<M, E, S = f32> {
    /// Temperature (°C), for [`ThermalDrift`](super::ThermalDrift): to be told as it is measured.
    pub temperature: Option<S>,
    /// Load in force units, for [`LoadDependentFriction`](super::LoadDependentFriction): to be told as it is measured.
    pub load: Option<S>,
    position: S,
    /// The position has been told.
    located: bool,
    /// The shift of the last tick, none before the first.
    shift: Option<S>,
    friction: M,
    effects: E,
}

impl<F: Friction, E: Effect<F::Scalar>> With<F, E> {
    /// `effects` must have been built in the units of `friction`.
    ///
    /// # Errors
    /// [`ParamError`] where the bound of the composed force does not fit the number type.
    pub fn try_new(friction: F, effects: E) -> Result<Self, ParamError> {
        let composed = Self { friction, effects };
        let greatest = F::Scalar::greatest();
        match composed.limit().map(Scalar::to_f64) {
            // Sums of bounds saturate where they do not fit.
            Some(limit) if !(limit < greatest) => Err(ParamError::new(
                "bound of the composed force",
                limit,
                Bound::Representable(greatest),
            )),
            _ => Ok(composed),
        }
    }

    /// The friction model without its effects.
    pub fn friction(&self) -> &F {
        &self.friction
    }

    /// The effects.
    pub fn effects(&self) -> &E {
        &self.effects
    }
}

impl<F: Friction, E: Effect<F::Scalar>> Friction for With<F, E> {
    type Scalar = F::Scalar;
    type State = WithState<F::State, E::State, F::Scalar>;

    fn at_rest(&self) -> Self::State {
        WithState {
            temperature: None,
            load: None,
            position: F::Scalar::ZERO,
            located: false,
            shift: None,
            friction: self.friction.at_rest(),
            effects: self.effects.at_rest(),
        }
    }

    fn take_over(&self, old: &Self, state: &Self::State) -> Self::State {
        WithState {
            friction: self.friction.take_over(&old.friction, &state.friction),
            effects: if self.effects == old.effects {
                state.effects.clone()
            } else {
                self.effects.at_rest()
            },
            ..state.clone()
        }
    }

    #[inline]
    fn set_position(&self, state: &mut Self::State, position: F::Scalar) {
        state.position = position;
        state.located = true;
        self.friction.set_position(&mut state.friction, position);
    }

    #[inline(always)]
    fn step(&self, state: &mut Self::State, mut motion: Motion<F::Scalar>) -> F::Scalar {
        let mut position = state.position;
        // What shifts, shifts by place.
        if E::SHIFT && state.located {
            let shift = self.effects.shift(position);
            if let Some(last) = state.shift {
                motion.displacement = motion.displacement.add_input(shift.sub_input(last));
            }
            state.shift = Some(shift);
            position = position.add_input(shift);
        }
        let friction = self.friction.step(&mut state.friction, motion);
        let at = Situation {
            position,
            located: state.located,
            velocity: motion.velocity,
            friction,
            temperature: state.temperature,
            load: state.load,
        };
        let mut force = friction;
        let acts = state.located || !E::PLACED;
        if E::LEVEL && acts {
            let level = F::Scalar::ONE.add_input(self.effects.level(&mut state.effects, &at));
            force = if level > F::Scalar::ZERO {
                force.mul_input(level)
            } else {
                F::Scalar::ZERO
            };
        }
        if E::FORCE && acts {
            force = force.add_input(self.effects.force(&mut state.effects, &at));
        }
        force
    }

    fn limit(&self) -> Option<F::Scalar> {
        let bounds = self.effects.bounds();
        let level = F::Scalar::ONE.add_input(bounds.level);
        Some(
            self.friction
                .limit()?
                .mul_input(level)
                .add_input(bounds.force),
        )
    }
}
