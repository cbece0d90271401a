//! A change of parameters without a bump in the command.

use crate::Scalar;
use crate::param::{ParamError, positive, to_scalar};

/// How many ticks a fade may take: its reciprocal must be resolved in 16 fractional bits.
const LONGEST: f64 = 10_000.0;

/// Fades out the difference between the old parameters' command and the new ones'.
///
/// At the swap the difference is stored; it is added to every command and shrinks by an equal part each tick, so
/// the command is continuous and the new parameters rule alone after the fade. The limiter comes after it.
#[derive(Clone, Debug)]
pub struct Fade<S> {
    part: S,
    ticks: u32,
}

/// The difference that is still being faded out.
#[derive(Clone, Debug, PartialEq)]
pub struct FadeState<S> {
    force: S,
    decrement: S,
    left: u32,
}

impl<S: Scalar> FadeState<S> {
    /// Nothing to fade.
    pub fn new() -> Self {
        Self {
            force: S::ZERO,
            decrement: S::ZERO,
            left: 0,
        }
    }

    /// A difference is still being faded out.
    #[inline]
    pub fn is_running(&self) -> bool {
        self.left > 0
    }
}

impl<S: Scalar> Default for FadeState<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar> Fade<S> {
    /// `time` (s) is how long a difference takes to vanish; `sample_time` is `T_s` (s).
    ///
    /// # Errors
    /// [`ParamError`] where a time is not positive or the fade takes more than 10 000 ticks.
    pub fn try_new(time: f64, sample_time: f64) -> Result<Self, ParamError> {
        positive("sample time", sample_time)?;
        let ticks = libm::ceil(positive("fade time", time)? / sample_time);
        let ticks = crate::param::at_most("fade time in ticks", ticks, LONGEST)?;
        Ok(Self {
            part: to_scalar("fade per tick", 1.0 / ticks)?,
            ticks: ticks as u32,
        })
    }

    /// Starts to fade out `difference`, the old command's force less the new one's.
    #[inline]
    pub fn start(&self, state: &mut FadeState<S>, difference: S) {
        *state = FadeState {
            force: difference,
            decrement: self.part.mul_input(difference),
            left: self.ticks,
        };
    }

    /// The force to add in this tick.
    #[inline]
    pub fn step(&self, state: &mut FadeState<S>) -> S {
        if state.left == 0 {
            return S::ZERO;
        }
        let force = state.force;
        state.left -= 1;
        state.force = force.sub_input(state.decrement);
        force
    }
}
