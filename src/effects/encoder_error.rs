//! The encoder's interpolation error.

use super::wave::Wave;
use super::{Bounds, Effect};
use crate::Scalar;
use crate::param::{Bound, ParamError, Units, to_scalar};
use core::f64::consts::TAU;

/// `encoder_error`: the encoder reads `x + e·cos(2πx/p + φ)` where the axis is at `x`.
///
/// The correction takes the error at the reading for that at the true position: it is wrong by at most
/// `2π·e²/p`, 6 nm of a 100 nm error at a period of 10 µm. It corrects position and displacement; the
/// velocity, of which it would be a share of `2π·e/p`, is left as measured.
#[derive(Clone, Debug, PartialEq)]
pub struct EncoderError<S = f32> {
    wave: Wave<S>,
    error: S,
}

impl<S: Scalar> EncoderError<S> {
    /// `error` is `e`, `period` is `p` (m or rad), `phase` is `φ` (rad). `2π·e/p` must be below 1: beyond that the
    /// reading would turn back while the axis moves on.
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, out of its range, or does not fit `S` in `units`.
    pub fn try_new(error: f64, period: f64, phase: f64, units: Units) -> Result<Self, ParamError> {
        units.check()?;
        let wave = Wave::try_new(period, phase, units.length)?;
        let limit = period / TAU;
        if !(error.abs() < limit) {
            return Err(ParamError::new(
                "encoder error",
                error,
                Bound::AtMost(limit),
            ));
        }
        Ok(Self {
            wave,
            error: to_scalar("encoder error", error / units.length)?,
        })
    }
}

impl<S: Scalar> Effect<S> for EncoderError<S> {
    type State = ();
    const SHIFT: bool = true;
    const PLACED: bool = true;

    fn at_rest(&self) {}

    #[inline]
    fn shift(&self, position: S) -> S {
        self.error.mul_input(self.wave.at(position)).opposite()
    }

    fn bounds(&self) -> Bounds<S> {
        Bounds {
            shift: self.error.magnitude(),
            ..Bounds::NONE
        }
    }
}
