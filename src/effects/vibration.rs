//! A vibration from outside, fixed in time.

use super::wave::{cosine, precise};
use super::{Bounds, Effect, Situation};
use crate::Scalar;
use crate::param::{ParamError, Units, at_most, fits, positive, to_scalar};
use core::f64::consts::TAU;

/// `external_vibration`: `A·sin(2πft + φ)`, with `t` from the tick after [`Effect::at_rest`].
///
/// A controller can use it only where something tells it the phase; the frequency of a pump nearby wanders.
#[derive(Clone, Debug, PartialEq)]
pub struct ExternalVibration<S = f32> {
    force: S,
    per_tick: S,
    start: S,
}

impl<S: Scalar> ExternalVibration<S> {
    /// `force` is `A` (N or N·m), `frequency` is `f` (Hz), at most half the sample rate, `phase` is `φ` (rad),
    /// `sample_time` is `T_s` (s). The first tick is `t = 0`.
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, out of its range, or does not fit `S` in `units`.
    pub fn try_new(
        force: f64,
        frequency: f64,
        phase: f64,
        sample_time: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        units.check()?;
        positive("frequency", frequency)?;
        positive("sample time", sample_time)?;
        at_most("frequency", frequency, 0.5 / sample_time)?;
        fits::<S>("coefficients of the cosine", 82.0)?;
        let per_tick = frequency * sample_time;
        // sin is cos a quarter turn later.
        let start = phase / TAU - 0.25 - per_tick;
        Ok(Self {
            force: to_scalar("amplitude of the vibration", force / units.force)?,
            per_tick: precise("turns per tick", per_tick, 1e-5)?,
            start: to_scalar("phase", start - libm::round(start))?,
        })
    }
}

impl<S: Scalar> Effect<S> for ExternalVibration<S> {
    /// The phase of the last tick, in turns, −½…½.
    type State = S;
    const FORCE: bool = true;

    fn at_rest(&self) -> S {
        self.start
    }

    #[inline]
    fn force(&self, state: &mut S, _at: &Situation<S>) -> S {
        let mut turns = *state + self.per_tick;
        if turns > S::ONE.half() {
            turns = turns - S::ONE;
        }
        *state = turns;
        self.force.mul_input(cosine(turns))
    }

    fn bounds(&self) -> Bounds<S> {
        Bounds::of_force(self.force.magnitude())
    }
}
