//! A notch in the feedback, for the drive's first mode.

use crate::Scalar;
use crate::param::{
    Bound, ParamError, at_most, nearest, not_negative, positive, reachable, to_gain, to_scalar,
};

/// A notch: which frequency the feedback is not to answer, and how little of it (SI).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Notch {
    /// Its centre (Hz), below half the control rate; 0 for no notch.
    pub frequency: f64,
    /// Bandwidth over frequency (-), above 0 and at most 1: between the two places where a notch of depth 1 leaves half the power.
    pub width: f64,
    /// Share that is taken out at the centre (-), 0…1: 0.9 leaves a tenth, −20 dB.
    pub depth: f64,
}

impl Notch {
    /// None; what is to be switched on by its frequency alone is wide enough for a mode that is known to a tenth.
    pub const NONE: Notch = Notch {
        frequency: 0.0,
        width: 0.5,
        depth: 0.9,
    };
}

impl Default for Notch {
    fn default() -> Self {
        Self::NONE
    }
}

/// `y = u − depth·p`, where `p` is `u` behind a band-pass of gain 1 at the centre.
///
/// The band-pass is the state-variable filter by the trapezoidal rule, its centre not warped:
///
/// ```text
/// q = s₁ + g·(k·u − s₂)     p = q − b·q     s₁ ← 2p − s₁     s₂ ← s₂ + 2g·p
/// g = tan(π·f·T)            k = width       b = g(g + k)/(1 + g(g + k))
/// ```
/// A mode lies far below the control rate. There a biquad in direct form has `1 − cos ω` in its coefficients and loses the frequency twice as fast as
/// this one, in which it is `g ≈ ω/2`: fixed point holds 20 Hz at 20 kHz. The states are scaled by `k`, so that none is larger at resonance
/// than the input; and whatever rounds, what is constant passes: only a part without a mean is taken off.
///
/// ```
/// use preslide::control::{Notch, NotchFilter, NotchState};
/// let notch = Notch { frequency: 370.0, ..Notch::NONE };
/// let filter = NotchFilter::<f32>::try_new(&notch, 50e-6)?.expect("a frequency above 0");
/// let mut state = NotchState::new();
/// let left = (0..20_000).map(|tick| {
///     let force = libm::sinf(core::f32::consts::TAU * 370.0 * 50e-6 * tick as f32);
///     force - filter.step(&mut state, force)
/// });
/// let largest = left.skip(19_000).fold(0.0, f32::max);
/// assert!((largest - 0.1).abs() < 1e-3);
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct NotchFilter<S> {
    /// g, b, k and the depth.
    rate: S,
    loss: S,
    width: S,
    depth: S,
}

/// What a [`NotchFilter`] remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NotchState<S> {
    band: S,
    low: S,
    taken: S,
}

impl<S: Scalar> NotchState<S> {
    /// After a rest without force.
    pub fn new() -> Self {
        Self {
            band: S::ZERO,
            low: S::ZERO,
            taken: S::ZERO,
        }
    }

    /// Its filter may be no more: then it takes nothing.
    pub(super) fn left(&mut self) {
        self.taken = S::ZERO;
    }

    /// What was to be taken off in the last tick.
    #[inline]
    pub fn taken(&self) -> S {
        self.taken
    }
}

impl<S: Scalar> Default for NotchState<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar> NotchFilter<S> {
    /// Computes the coefficients for the sample time `T` (s); `None` where the frequency is 0.
    ///
    /// # Errors
    /// [`ParamError`] where a value is out of range, the frequency not below half the control rate, or frequency or width more than a hundredth
    /// off as `S` holds them: a low frequency, a narrow notch.
    pub fn try_new(notch: &Notch, sample_time: f64) -> Result<Option<Self>, ParamError> {
        positive("sample time", sample_time)?;
        let width = at_most("width of the notch", notch.width, 1.0)?;
        positive("width of the notch", width)?;
        let depth = not_negative("depth of the notch", notch.depth)?;
        at_most("depth of the notch", depth, 1.0)?;
        let frequency = not_negative("frequency of the notch", notch.frequency)?;
        // Above it the feedback has no frequency to take out.
        reachable("frequency of the notch", frequency, 0.5 / sample_time, 1.0)?;
        if frequency == 0.0 {
            return Ok(None);
        }
        let rate: S = to_gain(
            "frequency of the notch as a rate",
            libm::tan(core::f64::consts::PI * frequency * sample_time),
        )?;
        let g = rate.to_f64();
        let share = g * (g + width);
        let loss: S = to_gain("loss of the notch in a tick", share / (1.0 + share))?;
        // What the two make of the width, which is their small difference.
        let b = loss.to_f64();
        let held = b / (1.0 - b) / g - g;
        let near = (held - width).abs() <= 0.01 * width;
        if !near {
            let bound = Bound::Rounded(held);
            return Err(ParamError::new("width of the notch", width, bound));
        }
        Ok(Some(Self {
            rate,
            loss,
            // The gain at the centre is the one over the other.
            width: nearest("width of the notch", held)?,
            depth: to_scalar("depth of the notch", depth)?,
        }))
    }

    /// What to take off a `force`.
    #[inline]
    pub fn step(&self, state: &mut NotchState<S>, force: S) -> S {
        let above = self.width.mul_input(force).sub_input(state.low);
        let before = state.band.add_input(self.rate.mul_input(above));
        let band = before.sub_input(self.loss.mul_input(before));
        // In this order nothing is doubled that may be near the range's end.
        state.band = band.sub_input(state.band).add_input(band);
        let gained = self.rate.mul_input(band);
        state.low = state.low.add_input(gained).add_input(gained);
        state.taken = self.depth.mul_input(band);
        state.taken
    }
}
