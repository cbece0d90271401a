//! The weight of an unbalanced arm.

use super::wave::Wave;
use super::{Bounds, Effect, Situation};
use crate::Scalar;
use crate::param::{ParamError, Units, to_scalar};
use core::f64::consts::{FRAC_PI_2, TAU};

/// `gravity`: the torque that holds an unbalanced rotary axis, `A·sin(q − q0)` with `A = m·g·r`.
///
/// Computed as [`PeriodicForce`](super::PeriodicForce) of one turn, at its cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Gravity<S = f32> {
    wave: Wave<S>,
    torque: S,
}

impl<S: Scalar> Gravity<S> {
    /// `torque` is `A` (N·m), `angle` is `q0` (rad), where the arm hangs straight down (`A > 0`) and rests by itself.
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite or does not fit `S` in `units`.
    pub fn try_new(torque: f64, angle: f64, units: Units) -> Result<Self, ParamError> {
        units.check()?;
        Ok(Self {
            wave: Wave::try_new(TAU, -angle - FRAC_PI_2, units.length)?,
            torque: to_scalar("torque of gravity", torque / units.force)?,
        })
    }
}

impl<S: Scalar> Effect<S> for Gravity<S> {
    type State = ();
    const FORCE: bool = true;
    const PLACED: bool = true;

    fn at_rest(&self) {}

    #[inline]
    fn force(&self, _state: &mut (), at: &Situation<S>) -> S {
        self.torque.mul_input(self.wave.at(at.position))
    }

    fn bounds(&self) -> Bounds<S> {
        Bounds::of_force(self.torque.magnitude())
    }
}
