//! A sum of very many very small steps.

use crate::Scalar;

/// Steps of the coarse part in one unit.
const COARSE: i32 = 1024;

/// Sums steps that single precision would lose: a whole number of 1/1024, and what is below that. Stays at
/// [`Odometer::END`] from there on.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Odometer<S = f32> {
    coarse: i32,
    fine: S,
}

impl<S: Scalar> Odometer<S> {
    /// Where it stops.
    pub const END: i32 = 16;

    /// At 0.
    pub(super) const ZERO: Self = Self {
        coarse: 0,
        fine: S::ZERO,
    };

    /// Adds `step ≥ 0` and returns the sum; a step that is negative or NaN counts as 0, more than 1 as 1.
    #[inline]
    pub(super) fn add(&mut self, step: S) -> S {
        let grain = S::from_q16(65_536 / COARSE);
        if self.coarse < Self::END * COARSE && step > S::ZERO {
            self.fine = self.fine.add_input(step.limited(S::ONE));
            if !(self.fine < grain) {
                let grains = self
                    .fine
                    .mul_input(S::from_int(COARSE))
                    .whole_below(2 * COARSE as usize)
                    .map_or(2 * COARSE, |grains| grains as i32);
                self.fine = self.fine - S::from_int(grains).mul_input(grain);
                self.coarse += grains;
            }
        }
        S::from_int(self.coarse)
            .mul_input(grain)
            .add_input(self.fine)
    }
}
