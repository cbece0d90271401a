//! The slip-reserve form with two blocks in a word.

use super::Whole;
use super::dsp::{add_products, subtract_to_zero};
use super::quantised::{Range, finest_force, quantise};
use crate::{Block, Friction, Motion, ParamError, Units};

pub(super) const RANGE: Range = Range {
    yields: i16::MAX as i32 / 2,
    stiffness: i16::MAX as i32,
};

/// Quasi-static GMS in 16 bits, two blocks at a time: [`SlipReserve`](super::SlipReserve) for cores with DSP instructions.
///
/// `PAIRS` words hold up to `2·PAIRS` blocks. The recurrence is that of `SlipReserve`, and so are the bits of its force.
/// Accepts `D_i` up to 16 383 units of length, `k_i` up to 32 767 units of force per unit of length, and
/// `ΣW_i` up to 2³⁰ − 1 units of force. A displacement beyond ±32 768 is cut and slips every block all the same.
/// On a core without the instructions portable code gives the same bits, more slowly.
#[derive(Clone, Debug)]
pub struct PackedSlipReserve<const PAIRS: usize> {
    pub(super) limit: i32,
    /// `2·D` of the first block in the low half, of the second in the high half.
    pub(super) full: [u32; PAIRS],
    pub(super) stiffness: [u32; PAIRS],
}

/// What a [`PackedSlipReserve`] or a [`ConstantTimeSlipReserve`](super::ConstantTimeSlipReserve) remembers.
#[derive(Clone, Debug, PartialEq)]
pub struct PackedState<const PAIRS: usize> {
    /// 0 while the body moves forward, −1 backward: `(x ^ b) − b` is `dir·x`.
    pub(super) backward: i32,
    pub(super) reserve: [u32; PAIRS],
}

impl<const PAIRS: usize> PackedSlipReserve<PAIRS> {
    /// Validates the parameters of `2·PAIRS − 1` or `2·PAIRS` blocks; `breakaway` is `F_s` (N or N·m).
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite or not positive, the weights do not sum to 1, or a yield
    /// displacement, a stiffness or the breakaway force lies outside the range above in `units`.
    pub fn try_new<const N: usize>(
        blocks: &[Block; N],
        breakaway: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        const {
            assert!(N > 0, "a Maxwell-slip model needs at least one block");
            assert!(
                N.div_ceil(2) == PAIRS,
                "N blocks take N/2 pairs, rounded up"
            );
        }
        let (blocks, limit) = quantise(blocks, breakaway, units, RANGE)?;
        let mut packed = Self {
            limit,
            full: [0; PAIRS],
            stiffness: [0; PAIRS],
        };
        let words = packed.full.iter_mut().zip(&mut packed.stiffness);
        for (pair, (full, stiffness)) in blocks.chunks(2).zip(words) {
            for (half, block) in pair.iter().enumerate() {
                *full |= block.full.cast_unsigned() << (16 * half);
                *stiffness |= block.stiffness.cast_unsigned() << (16 * half);
            }
        }
        Ok(packed)
    }

    /// The finest unit of force (N or N·m) that it accepts for these blocks at the unit of length `length` (m or rad).
    pub fn finest_force(blocks: &[Block], breakaway: f64, length: f64) -> f64 {
        finest_force(blocks, breakaway, length, RANGE)
    }
}

/// The displacement in 16 bits: one saturating instruction.
#[inline(always)]
pub(super) fn cut(displacement: Whole) -> i32 {
    displacement
        .to_bits()
        .clamp(i16::MIN.into(), i16::MAX.into())
}

/// `advance ∈ [0, 32768]` in both halves of a word.
#[inline(always)]
pub(super) fn both(advance: i32) -> u32 {
    let advance = advance.cast_unsigned();
    advance | advance << 16
}

impl<const PAIRS: usize> Friction for PackedSlipReserve<PAIRS> {
    type Scalar = Whole;
    type State = PackedState<PAIRS>;

    fn at_rest(&self) -> Self::State {
        PackedState {
            backward: 0,
            // `D` in both halves: every `2·D` is even.
            reserve: self.full.map(|full| full >> 1),
        }
    }

    #[inline]
    fn step(&self, state: &mut Self::State, motion: Motion<Whole>) -> Whole {
        let dx = cut(motion.displacement);
        let mut advance = (dx ^ state.backward) - state.backward;
        if advance < 0 {
            advance = -advance;
            state.backward = !state.backward;
            for (reserve, full) in state.reserve.iter_mut().zip(&self.full) {
                // Half by half, since no half of `reserve` exceeds that of `full`.
                *reserve = full.wrapping_sub(*reserve);
            }
        }
        let advance = both(advance);
        let mut lacking = 0;
        for (reserve, stiffness) in state.reserve.iter_mut().zip(&self.stiffness) {
            *reserve = subtract_to_zero(*reserve, advance);
            lacking = add_products(*reserve, *stiffness, lacking);
        }
        let along = self.limit.wrapping_sub(lacking);
        Whole::from_bits((along ^ state.backward).wrapping_sub(state.backward))
    }

    fn limit(&self) -> Option<Whole> {
        Some(Whole::from_bits(self.limit))
    }
}
