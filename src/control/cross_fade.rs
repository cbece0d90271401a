//! A change of parameters without a bump in the command: the old controller and the new one cross-fade.

use super::coefficients::Law;
use super::{Fade, NotchState};
use crate::{Friction, Scalar};

/// The old parameters, which the new ones cross-fade from.
///
/// `F = F_new + w·(F_old − F_new) + w·rest`, `w` from 1 to 0 by equal parts. Both controllers run, on the same errors and with
/// one integral; `rest` is what a swap in the middle of a fade left of the one before.
#[derive(Clone, Debug)]
pub(super) struct CrossFade<F: Friction> {
    pub(super) old: Law<F>,
    /// The old model's memory; `None` where the model and its use stay.
    pub(super) friction: Option<F::State>,
    pub(super) notch: NotchState<F::Scalar>,
    weight: F::Scalar,
    part: F::Scalar,
    left: u32,
    rest: F::Scalar,
    /// What it added in the last tick.
    added: F::Scalar,
}

impl<F: Friction> CrossFade<F> {
    /// `added` is what a fade that still ran added last.
    pub(super) fn start(
        old: Law<F>,
        friction: Option<F::State>,
        notch: NotchState<F::Scalar>,
        fade: &Fade<F::Scalar>,
        added: F::Scalar,
    ) -> Self {
        Self {
            old,
            friction,
            notch,
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
