//! The feedback: a PID controller in parallel form.

use super::Saturation;
use crate::Scalar;
use crate::param::{ParamError, Units, not_negative, positive, to_gain, to_scalar};

/// Gains of the feedback (SI).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PidGains {
    /// `K_p` (N/m or N·m/rad).
    pub proportional: f64,
    /// `K_i` (N/(m·s) or N·m/(rad·s)); 0 for none.
    pub integral: f64,
    /// `K_d` (N·s/m or N·m·s/rad); 0 for none.
    pub derivative: f64,
    /// Bound on the integral's force (N or N·m).
    pub integral_limit: f64,
    /// Position error (m or rad) below which the integral holds. Friction with stick and an integrator hunt
    /// around the target; an error within the encoder's resolution is none that it could remove.
    pub deadband: f64,
}

/// `u = K_p·e + I + K_d·(v_ref − v)`, `I ← I + K_i·T_s·e` while `|e|` exceeds the deadband.
///
/// The integral is kept as a force, so a change of `K_i` does not bump the command. It is bounded, and it holds
/// in the direction in which the limiter cut the previous command (conditional integration).
#[derive(Clone, Debug, PartialEq)]
pub struct Pid<S> {
    proportional: S,
    integral_per_tick: S,
    derivative: S,
    integral_limit: S,
    deadband: S,
}

/// What a [`Pid`] remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PidState<S> {
    integral: S,
}

impl<S: Scalar> PidState<S> {
    /// No force in the integral.
    pub fn new() -> Self {
        Self { integral: S::ZERO }
    }
}

impl<S: Scalar> Default for PidState<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar> Pid<S> {
    /// Computes the coefficients for the sample time `T_s` (s).
    ///
    /// # Errors
    /// [`ParamError`] where a gain is negative, not finite, or does not fit `S` in `units`.
    pub fn try_new(gains: &PidGains, sample_time: f64, units: Units) -> Result<Self, ParamError> {
        units.check()?;
        positive("sample time", sample_time)?;
        let per_length = units.length / units.force;
        Ok(Self {
            proportional: to_gain(
                "proportional gain",
                positive("proportional gain", gains.proportional)? * per_length,
            )?,
            integral_per_tick: to_gain(
                "integral gain per tick",
                not_negative("integral gain", gains.integral)? * sample_time * per_length,
            )?,
            derivative: to_gain(
                "derivative gain",
                not_negative("derivative gain", gains.derivative)? * units.velocity / units.force,
            )?,
            integral_limit: to_scalar(
                "integral limit",
                not_negative("integral limit", gains.integral_limit)? / units.force,
            )?,
            deadband: to_scalar(
                "integral deadband",
                not_negative("integral deadband", gains.deadband)? / units.length,
            )?,
        })
    }

    /// The force for a position error and a velocity error; `cut` is what the limiter did last.
    #[inline]
    pub fn step(&self, state: &mut PidState<S>, error: S, velocity_error: S, cut: Saturation) -> S {
        // Before the branch: beyond it fixed point multiplies by the error in two words.
        let immediate = self.immediate(error, velocity_error);
        let deeper = match cut {
            Saturation::None => false,
            Saturation::Above => error > S::ZERO,
            Saturation::Below => error < S::ZERO,
        };
        if !deeper && error.magnitude() > self.deadband {
            let added = self.integral_per_tick.mul_input(error);
            state.integral = state.integral.add_input(added).limited(self.integral_limit);
        }
        immediate.add_input(state.integral)
    }

    /// Holds the integral to the limit; the force that is taken from it.
    pub(super) fn shorten(&self, state: &mut PidState<S>) -> S {
        let before = state.integral;
        state.integral = before.limited(self.integral_limit);
        before.sub_input(state.integral)
    }

    /// The force without its memory, `K_p·e + K_d·(v_ref − v)`.
    #[inline]
    pub(super) fn immediate(&self, error: S, velocity_error: S) -> S {
        let force = self.proportional.mul_input(error);
        force.add_input(self.derivative.mul_input(velocity_error))
    }
}
