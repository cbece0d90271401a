//! Friction that falls with speed, at once or late.

use super::curve::{Curve, DECAYED};
use super::{Bounds, Effect, Situation, level};
use crate::Scalar;
use crate::param::{ParamError, Units, at_least, at_most, fits, positive, to_positive};

/// `stribeck`: `m = 1 + a·exp(−(|v|/v_s)^δ)`.
///
/// Acts on the whole friction force. A [`Gms`](crate::Gms) with [`Sliding`](crate::Sliding) has the Stribeck curve in the
/// limit of its blocks instead; use one of the two.
#[derive(Clone, Debug, PartialEq)]
pub struct Stribeck<S = f32> {
    curve: Curve<S>,
    level: S,
}

impl<S: Scalar> Stribeck<S> {
    /// `rise` is `a` (-), `velocity` is `v_s` (m/s or rad/s), `exponent` is `δ` (-), 1…4.
    ///
    /// # Errors
    /// [`ParamError`] where a value is out of its range or does not fit `S` in `units`.
    pub fn try_new(
        rise: f64,
        velocity: f64,
        exponent: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        units.check()?;
        positive("Stribeck velocity", velocity)?;
        at_least("Stribeck exponent", exponent, 1.0)?;
        at_most("Stribeck exponent", exponent, 4.0)?;
        Ok(Self {
            level: level("Stribeck level", rise)?,
            curve: Curve::falling(
                "Stribeck level",
                rise,
                velocity * libm::pow(DECAYED, 1.0 / exponent),
                units.velocity,
                |v| libm::exp(-libm::pow(v / velocity, exponent)),
            )?,
        })
    }
}

impl<S: Scalar> Effect<S> for Stribeck<S> {
    type State = ();
    const LEVEL: bool = true;

    fn at_rest(&self) {}

    #[inline]
    fn level(&self, _state: &mut (), at: &Situation<S>) -> S {
        self.curve.at(at.velocity)
    }

    fn bounds(&self) -> Bounds<S> {
        Bounds::of_level(self.level.magnitude())
    }
}

/// `frictional_lag`: the Stribeck level follows the velocity with a time constant,
/// `dm/dt = (1 + a·exp(−(|v|/v_s)^δ) − m)/τ`, exact for a velocity that is constant over the tick.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionalLag<S = f32> {
    stribeck: Stribeck<S>,
    share: S,
}

impl<S: Scalar> FrictionalLag<S> {
    /// As [`Stribeck::try_new`], with the time constant `τ` (s) at the sample time `T_s` (s).
    ///
    /// # Errors
    /// [`ParamError`] where a value is out of its range or does not fit `S` in `units`.
    pub fn try_new(
        rise: f64,
        velocity: f64,
        exponent: f64,
        time_constant: f64,
        sample_time: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        positive("time constant of the frictional lag", time_constant)?;
        positive("sample time", sample_time)?;
        fits::<S>("twice the level of the frictional lag", 2.0 * rise)?;
        Ok(Self {
            stribeck: Stribeck::try_new(rise, velocity, exponent, units)?,
            share: to_positive("lag per tick", -libm::expm1(-sample_time / time_constant))?,
        })
    }
}

impl<S: Scalar> Effect<S> for FrictionalLag<S> {
    /// The level; at rest that of standstill.
    type State = S;
    const LEVEL: bool = true;

    fn at_rest(&self) -> S {
        self.stribeck.level
    }

    #[inline]
    fn level(&self, state: &mut S, at: &Situation<S>) -> S {
        let now = self.stribeck.level(&mut (), at);
        *state = *state + self.share * (now - *state);
        *state
    }

    fn bounds(&self) -> Bounds<S> {
        self.stribeck.bounds()
    }
}
