//! Friction that settles: with the path since the machine was put together, with the time since it was switched on.

use super::curve::{Curve, DECAYED};
use super::odometer::Odometer;
use super::{Bounds, Effect, Situation, level};
use crate::Scalar;
use crate::param::{ParamError, Units, positive, to_positive};

/// `a·exp(−u)`, tabulated.
fn decay<S: Scalar>(name: &'static str, rise: f64) -> Result<Curve<S>, ParamError> {
    Curve::falling(name, rise, DECAYED, 1.0, |u| libm::exp(-u))
}

/// `run_in`: `m = 1 + a·exp(−s/λ)`, `s` the path travelled since [`Effect::at_rest`], `Σ|v|·T_s`.
#[derive(Clone, Debug, PartialEq)]
pub struct RunIn<S = f32> {
    curve: Curve<S>,
    level: S,
    /// Share of `λ` per tick and velocity.
    per_velocity: S,
}

impl<S: Scalar> RunIn<S> {
    /// `rise` is `a` (-), `path` is `λ` (m or rad), `sample_time` is `T_s` (s).
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, `path` or `sample_time` not positive, or one does not fit `S` in `units`.
    pub fn try_new(
        rise: f64,
        path: f64,
        sample_time: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        units.check()?;
        positive("path of the run-in", path)?;
        positive("sample time", sample_time)?;
        Ok(Self {
            curve: decay("level of the run-in", rise)?,
            level: level("level of the run-in", rise)?,
            per_velocity: to_positive(
                "run-in per tick and velocity",
                sample_time / path * units.velocity,
            )?,
        })
    }
}

impl<S: Scalar> Effect<S> for RunIn<S> {
    /// The path in units of `λ`.
    type State = Odometer<S>;
    const LEVEL: bool = true;

    fn at_rest(&self) -> Odometer<S> {
        Odometer::ZERO
    }

    #[inline]
    fn level(&self, state: &mut Odometer<S>, at: &Situation<S>) -> S {
        let step = self.per_velocity.mul_input(at.velocity.magnitude());
        self.curve.at(state.add(step))
    }

    fn bounds(&self) -> Bounds<S> {
        Bounds::of_level(self.level.magnitude())
    }
}

/// `thermal_drift` where no temperature is measured: `m = 1 + a·exp(−t/τ)`, `t` the time since [`Effect::at_rest`].
#[derive(Clone, Debug, PartialEq)]
pub struct WarmUp<S = f32> {
    curve: Curve<S>,
    level: S,
    /// Share of `τ` per tick.
    per_tick: S,
}

impl<S: Scalar> WarmUp<S> {
    /// `rise` is `a` (-), `time_constant` is `τ` (s), `sample_time` is `T_s` (s).
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, a time not positive, or one does not fit `S`.
    pub fn try_new(rise: f64, time_constant: f64, sample_time: f64) -> Result<Self, ParamError> {
        positive("time constant of the warm-up", time_constant)?;
        positive("sample time", sample_time)?;
        Ok(Self {
            curve: decay("level of the warm-up", rise)?,
            level: level("level of the warm-up", rise)?,
            per_tick: to_positive("warm-up per tick", sample_time / time_constant)?,
        })
    }
}

impl<S: Scalar> Effect<S> for WarmUp<S> {
    /// The time in units of `τ`.
    type State = Odometer<S>;
    const LEVEL: bool = true;

    fn at_rest(&self) -> Odometer<S> {
        Odometer::ZERO
    }

    #[inline]
    fn level(&self, state: &mut Odometer<S>, _at: &Situation<S>) -> S {
        self.curve.at(state.add(self.per_tick))
    }

    fn bounds(&self) -> Bounds<S> {
        Bounds::of_level(self.level.magnitude())
    }
}
