//! How fast a change of parameters acts.

use crate::Scalar;
use crate::param::{ParamError, positive, to_scalar};

/// How many ticks a fade may take: its reciprocal must be resolved in 16 fractional bits.
const LONGEST: f64 = 10_000.0;

/// How fast parameters change over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fade<S> {
    pub(super) part: S,
    pub(super) ticks: u32,
}

impl<S: Scalar> Fade<S> {
    /// `time` (s) is how long the old parameters still act; `sample_time` is `T_s` (s).
    ///
    /// # Errors
    /// [`ParamError`] where a time is not positive or the fade takes more than 10 000 ticks.
    pub fn try_new(time: f64, sample_time: f64) -> Result<Self, ParamError> {
        positive("sample time", sample_time)?;
        let ticks = libm::ceil(positive("fade time", time)? / sample_time);
        let ticks = crate::param::at_most("fade time in ticks", ticks, LONGEST)?;
        let part: S = to_scalar("fade per tick", 1.0 / ticks)?;
        Ok(Self {
            part,
            // As many as the rounded part needs to take the weight to 0.
            ticks: libm::round(1.0 / part.to_f64()) as u32,
        })
    }
}
