//! The slip-reserve form with two blocks in a word.

use super::Whole;
use super::dsp::{self, Pair};
use super::quantised::{Range, finest_force, quantise};
use crate::{Block, Friction, Motion, ParamError, Units};
use core::sync::atomic::{Ordering, compiler_fence};

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
#[derive(Clone, Debug, PartialEq)]
#[repr(C)]
pub struct PackedSlipReserve<const PAIRS: usize> {
    pairs: [Pair; PAIRS],
    /// `−ΣW_i`, where the sum of a tick begins.
    least: i32,
}

/// What a [`PackedSlipReserve`] remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PackedState<const PAIRS: usize> {
    /// 0 while the body moves forward, −1 backward: `(x ^ b) − b` is `dir·x`.
    backward: i32,
    reserve: [u32; PAIRS],
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
        let mut pairs = [Pair::default(); PAIRS];
        for (two, pair) in blocks.chunks(2).zip(&mut pairs) {
            for (half, block) in two.iter().enumerate() {
                pair.full |= block.full.cast_unsigned() << (16 * half);
                pair.stiffness |= block.stiffness.cast_unsigned() << (16 * half);
            }
        }
        Ok(Self {
            pairs,
            least: -limit,
        })
    }

    /// The finest unit of force (N or N·m) that it accepts for these blocks at the unit of length `length` (m or rad).
    pub fn finest_force(blocks: &[Block], breakaway: f64, length: f64) -> f64 {
        finest_force(blocks, breakaway, length, RANGE)
    }

    /// `2·D_i` (units of length) and `k_i` (units of force per unit of length) of `2·PAIRS` blocks; of an odd number the last are 0.
    pub fn blocks(&self) -> impl Iterator<Item = [i32; 2]> {
        let halves = |word: u32| [word & 0xffff, word >> 16].map(u32::cast_signed);
        self.pairs.iter().flat_map(move |pair| {
            let ([a, b], [k, l]) = (halves(pair.full), halves(pair.stiffness));
            [[a, k], [b, l]]
        })
    }

    /// The fence costs no instruction. It has the blocks stored here and loaded again below: kept in registers across
    /// both ways, they would make the ordinary tick save those registers.
    #[inline(always)]
    fn reverse(&self, state: &mut PackedState<PAIRS>) {
        state.backward = !state.backward;
        for (reserve, pair) in state.reserve.iter_mut().zip(&self.pairs) {
            // Half by half, since no half of `reserve` exceeds that of `full`.
            *reserve = pair.full.wrapping_sub(*reserve);
            compiler_fence(Ordering::SeqCst);
        }
    }
}

/// The displacement in 16 bits: one saturating instruction.
#[inline(always)]
fn cut(displacement: Whole) -> i32 {
    displacement
        .to_bits()
        .clamp(i16::MIN.into(), i16::MAX.into())
}

impl<const PAIRS: usize> Friction for PackedSlipReserve<PAIRS> {
    type Scalar = Whole;
    type State = PackedState<PAIRS>;

    fn at_rest(&self) -> Self::State {
        PackedState {
            backward: 0,
            // `D` in both halves: every `2·D` is even.
            reserve: self.pairs.map(|pair| pair.full >> 1),
        }
    }

    #[inline(always)]
    fn step(&self, state: &mut Self::State, motion: Motion<Whole>) -> Whole {
        let dx = cut(motion.displacement);
        // Compared as they are subtracted: one instruction.
        let (along, backward) = (dx ^ state.backward, state.backward);
        let advance = if along < backward {
            crate::hint::cold_path();
            self.reverse(state);
            backward - along
        } else {
            along - backward
        };
        // `−dir·F`: the sum begins at `−ΣW` instead of being taken from `ΣW`.
        let against = dsp::advance(
            &mut state.reserve,
            &self.pairs,
            dsp::both(advance),
            self.least,
        );
        let backward = state.backward;
        Whole::from_bits(backward.wrapping_sub(against ^ backward))
    }

    fn limit(&self) -> Option<Whole> {
        Some(Whole::from_bits(-self.least))
    }
}
