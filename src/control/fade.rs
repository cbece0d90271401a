//! A change of parameters without a bump in the command: the old controller and the new one cross-fade.

use super::Coefficients;
use crate::param::{ParamError, positive, to_scalar};
use crate::{Friction, Scalar};

/// How many ticks a fade may take: its reciprocal must be resolved in 16 fractional bits.
const LONGEST: f64 = 10_000.0;

/// How fast parameters change over.
#[derive(Clone, Debug, PartialEq)]
pub struct Fade<S> {
    part: S,
    ticks: u32,
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

/// The parameters that are being left.
///
/// `F = F_new + w·(F_old − F_new) + w·rest`, `w` from 1 to 0 by equal parts. Both controllers run, on the same errors and with
/// one integral; `rest` is what a swap in the middle of a fade left of the one before.
#[derive(Clone, Debug)]
pub(super) struct Leaving<F: Friction> {
    pub(super) old: Coefficients<F>,
    /// The old model's memory; `None` where the model and its use stay.
    pub(super) friction: Option<F::State>,
    weight: F::Scalar,
    part: F::Scalar,
    left: u32,
    rest: F::Scalar,
    /// What it added in the last tick.
    added: F::Scalar,
}

impl<F: Friction> Leaving<F> {
    /// `added` is what a fade that still ran added last.
    pub(super) fn start(
        old: Coefficients<F>,
        friction: Option<F::State>,
        fade: &Fade<F::Scalar>,
        added: F::Scalar,
    ) -> Self {
        Self {
            old,
            friction,
            weight: F::Scalar::ONE,
            part: fade.part,
            left: fade.ticks,
            rest: added,
            added,
        }
    }

    pub(super) fn added(&self) -> F::Scalar {
        self.added
    }

    /// The model changes, so that what is spent tells nothing of it.
    #[inline]
    pub(super) fn changes_model(&self) -> bool {
        self.friction.is_some()
    }

    /// The force to add in this tick, for the old parameters' force less the new ones'.
    #[inline]
    pub(super) fn step(&mut self, difference: F::Scalar) -> F::Scalar {
        self.added = self.weight.mul_input(difference.add_input(self.rest));
        self.weight = self.weight.sub_input(self.part);
        self.left = self.left.saturating_sub(1);
        self.added
    }

    #[inline]
    pub(super) fn is_over(&self) -> bool {
        self.left == 0
    }
}
