//! The packed slip-reserve form on one path.

use super::Whole;
use super::dsp;
use super::packed::{PackedSlipReserve, PackedState, cut};
use crate::{Block, Friction, Motion, ParamError, Units};

/// Quasi-static GMS that takes the same time whatever moves: [`PackedSlipReserve`] without a branch.
///
/// The reversal is arithmetic: with `r = 1` in the tick of a reversal and 0 otherwise,
///
/// `w_i ← max(w_i + r·(2·D_i − 2·w_i) − |dx|, 0)`, both blocks of a word in one multiplication, since no half of
/// `2·D − w` borrows from the other. Range, units and the bits of the force are those of `PackedSlipReserve`. On a core without
/// DSP instructions the bits are the same, but the compiler may branch.
#[derive(Clone, Debug, PartialEq)]
pub struct ConstantTimeSlipReserve<const PAIRS: usize> {
    packed: PackedSlipReserve<PAIRS>,
}

impl<const PAIRS: usize> ConstantTimeSlipReserve<PAIRS> {
    /// See [`PackedSlipReserve::try_new`].
    ///
    /// # Errors
    /// As there.
    pub fn try_new<const N: usize>(
        blocks: &[Block; N],
        breakaway: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        let packed = PackedSlipReserve::try_new(blocks, breakaway, units)?;
        Ok(Self { packed })
    }

    /// See [`PackedSlipReserve::finest_force`].
    pub fn finest_force(blocks: &[Block], breakaway: f64, length: f64) -> f64 {
        PackedSlipReserve::<PAIRS>::finest_force(blocks, breakaway, length)
    }
}

impl<const PAIRS: usize> Friction for ConstantTimeSlipReserve<PAIRS> {
    type Scalar = Whole;
    type State = PackedState<PAIRS>;

    fn at_rest(&self) -> Self::State {
        self.packed.at_rest()
    }

    #[inline(always)]
    fn step(&self, state: &mut Self::State, motion: Motion<Whole>) -> Whole {
        let dx = cut(motion.displacement);
        let advance = (dx ^ state.backward) - state.backward;
        let turned = advance >> 31;
        state.backward ^= turned;
        let advance = dsp::both((advance ^ turned) - turned);
        let turned = turned.cast_unsigned() >> 31;
        let packed = &self.packed;
        let start = packed.least;
        let against =
            dsp::turn_and_advance(&mut state.reserve, &packed.pairs, turned, advance, start);
        Whole::from_bits(state.backward.wrapping_sub(against ^ state.backward))
    }

    fn limit(&self) -> Option<Whole> {
        self.packed.limit()
    }
}
