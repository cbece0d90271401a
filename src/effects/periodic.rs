//! What repeats along the travel: cogging, torque ripple, screw and ball-passage ripple.

use super::wave::Wave;
use super::{Bounds, Effect, Situation, level};
use crate::Scalar;
use crate::param::{ParamError, Units, to_scalar};

/// `periodic_force`: cogging or torque ripple, `A·cos(2πx/p + φ)`. A harmonic is another effect.
#[derive(Clone, Debug, PartialEq)]
pub struct PeriodicForce<S = f32> {
    wave: Wave<S>,
    force: S,
}

impl<S: Scalar> PeriodicForce<S> {
    /// `force` is `A` (N or N·m), `period` is `p` (m or rad), `phase` is `φ` (rad).
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, `period` not positive, or one does not fit `S` in `units`.
    pub fn try_new(force: f64, period: f64, phase: f64, units: Units) -> Result<Self, ParamError> {
        units.check()?;
        Ok(Self {
            wave: Wave::try_new(period, phase, units.length)?,
            force: to_scalar("periodic force", force / units.force)?,
        })
    }
}

impl<S: Scalar> Effect<S> for PeriodicForce<S> {
    type State = ();
    const FORCE: bool = true;
    const PLACED: bool = true;

    fn at_rest(&self) {}

    #[inline]
    fn force(&self, _state: &mut (), at: &Situation<S>) -> S {
        self.force.mul_input(self.wave.at(at.position))
    }

    fn bounds(&self) -> Bounds<S> {
        Bounds::of_force(self.force.magnitude())
    }
}

/// `periodic_friction`: screw or ball-passage ripple, `m = 1 + a·cos(2πx/p + φ)`.
#[derive(Clone, Debug, PartialEq)]
pub struct PeriodicFriction<S = f32> {
    wave: Wave<S>,
    level: S,
}

impl<S: Scalar> PeriodicFriction<S> {
    /// `ripple` is `a` (-), `period` is `p` (m or rad), `phase` is `φ` (rad).
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, `period` not positive, or one does not fit `S` in `units`.
    pub fn try_new(ripple: f64, period: f64, phase: f64, units: Units) -> Result<Self, ParamError> {
        units.check()?;
        Ok(Self {
            wave: Wave::try_new(period, phase, units.length)?,
            level: level("level of the periodic friction", ripple)?,
        })
    }
}

impl<S: Scalar> Effect<S> for PeriodicFriction<S> {
    type State = ();
    const LEVEL: bool = true;
    const PLACED: bool = true;

    fn at_rest(&self) {}

    #[inline]
    fn level(&self, _state: &mut (), at: &Situation<S>) -> S {
        self.level.mul_input(self.wave.at(at.position))
    }

    fn bounds(&self) -> Bounds<S> {
        Bounds::of_level(self.level.magnitude())
    }
}
