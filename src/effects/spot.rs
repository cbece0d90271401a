//! A narrow place of higher friction.

use super::curve::{Curve, DECAYED};
use super::{Bounds, Effect, Situation, level};
use crate::Scalar;
use crate::param::{ParamError, Units, positive, to_scalar};

/// `local_friction_spot`: a dent, dirt or a dry place, `m = 1 + a·exp(−((x − x_s)/w)²)`.
///
/// Tabulated; 0 from `|x − x_s| = 3.03·w` on.
#[derive(Clone, Debug, PartialEq)]
pub struct LocalFrictionSpot<S = f32> {
    curve: Curve<S>,
    position: S,
    level: S,
}

impl<S: Scalar> LocalFrictionSpot<S> {
    /// `rise` is `a` (-), `position` is `x_s` and `width` is `w` (m or rad).
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, `width` not positive, or one does not fit `S` in `units`.
    pub fn try_new(rise: f64, position: f64, width: f64, units: Units) -> Result<Self, ParamError> {
        units.check()?;
        positive("width of the friction spot", width)?;
        Ok(Self {
            level: level("level of the friction spot", rise)?,
            curve: Curve::falling(
                "level of the friction spot",
                rise,
                width * libm::sqrt(DECAYED),
                units.length,
                |u| libm::exp(-(u / width) * (u / width)),
            )?,
            position: to_scalar("position of the friction spot", position / units.length)?,
        })
    }
}

impl<S: Scalar> Effect<S> for LocalFrictionSpot<S> {
    type State = ();
    const LEVEL: bool = true;
    const PLACED: bool = true;

    fn at_rest(&self) {}

    #[inline]
    fn level(&self, _state: &mut (), at: &Situation<S>) -> S {
        self.curve.at(at.position.sub_input(self.position))
    }

    fn bounds(&self) -> Bounds<S> {
        Bounds::of_level(self.level.magnitude())
    }
}
