//! The last word before the PWM.

use crate::param::{Bound, ParamError, positive};

/// Clamps the *total* command: feedback, feed-forward and back-EMF together, after rounding. Nothing may be
/// added behind it.
#[derive(Clone, Copy, Debug)]
pub struct Limiter {
    largest: i32,
}

/// On which side the limiter cut; the integrator holds in that direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Saturation {
    /// The command passed.
    None,
    /// It was above the limit.
    Above,
    /// It was below the negative limit.
    Below,
}

impl Limiter {
    /// `duty` is the largest |duty| (-), 0…1, of `steps` codes.
    ///
    /// # Errors
    /// [`ParamError`] where `duty` is not in (0, 1] or the limit is less than one code.
    pub fn try_new(duty: f64, steps: f64) -> Result<Self, ParamError> {
        let refuse = |bound| ParamError::new("duty limit", duty, bound);
        if positive("duty limit", duty)? > 1.0 {
            return Err(refuse(Bound::AtMost(1.0)));
        }
        // Rounded down, so that the limit is never exceeded by a part of a code.
        let largest = (duty * steps) as i32;
        if largest < 1 {
            return Err(refuse(Bound::AtLeast(1.0 / steps)));
        }
        Ok(Self { largest })
    }

    /// The command within ± [`Limiter::largest`], and which side was cut.
    #[inline]
    #[must_use]
    pub fn apply(&self, code: i32) -> (i32, Saturation) {
        if code > self.largest {
            (self.largest, Saturation::Above)
        } else if code < -self.largest {
            (-self.largest, Saturation::Below)
        } else {
            (code, Saturation::None)
        }
    }

    /// The largest |code| that passes.
    pub fn largest(&self) -> i32 {
        self.largest
    }
}
