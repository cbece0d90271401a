//! The quasi-static law with one clamp, at zero, per block.

use super::Whole;
use super::dsp::settled;
use super::quantised::{Range, Reserve, finest_force, quantise};
use crate::{Block, Friction, Motion, ParamError, Units};
use core::sync::atomic::{Ordering, compiler_fence};

/// 31 bits signed: what one saturating instruction limits a displacement to.
const LARGEST: i32 = (1 << 30) - 1;

/// Blocks whose loads the compiler may gather: more would not fit the registers that a function need not save.
const TOGETHER: usize = if cfg!(short_products) { 1 } else { 2 };

pub(super) const RANGE: Range = Range {
    yields: LARGEST / 2,
    stiffness: i32::MAX,
};

/// Quasi-static GMS in `i32`: the law of [`QuasiStaticGms`](crate::QuasiStaticGms) on counts, in safe code.
///
/// Each block keeps what it can still move before it slips, its *slip reserve* `w_i = D_i − dir·z_i ∈ [0, 2·D_i]`:
///
/// `w_i ← max(w_i − |dx|, 0)`, `F = dir·(ΣW_i − Σ k_i·w_i)`; on a reversal `w_i ← 2·D_i − w_i`, `dir ← −dir`.
///
/// Accepts `D_i` up to 2²⁹ − 1 units of length and `ΣW_i` up to 2³⁰ − 1 units of force. No displacement
/// overflows: one longer than 2³⁰ is cut, and slips every block as it would uncut.
///
/// ```
/// use preslide::kernels::{SlipReserve, Whole};
/// use preslide::{Block, Friction, Motion, Units};
/// let blocks = [Block { stiffness: 113_948.0, weight: 0.616 }, Block { stiffness: 8_870.0, weight: 0.384 }];
/// let force = SlipReserve::finest_force(&blocks, 0.9, 25e-9);
/// let units = Units { length: 25e-9, force, velocity: 1e-6 };
/// let gms = SlipReserve::try_new(&blocks, 0.9, units)?;
/// let mut state = gms.at_rest();
/// let counts = gms.step(&mut state, Motion::quasi_static(Whole::from_num(100_000))); // 2.5 mm: all blocks slip
/// assert!((f64::from(counts.to_num::<i32>()) * force - 0.9).abs() < 1e-6);
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[repr(C)]
pub struct SlipReserve<const N: usize> {
    limit: i32,
    blocks: [Reserve; N],
}

/// What a [`SlipReserve`] remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(C)]
pub struct SlipReserveState<const N: usize> {
    /// 0 while the body moves forward, −1 backward: `(x ^ b) − b` is `dir·x`.
    backward: i32,
    reserve: [i32; N],
}

impl<const N: usize> SlipReserve<N> {
    /// Validates the parameters; `breakaway` is `F_s` (N or N·m).
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite or not positive, the weights do not sum to 1, or a yield
    /// displacement, a stiffness or the breakaway force lies outside the range above in `units`.
    pub fn try_new(blocks: &[Block; N], breakaway: f64, units: Units) -> Result<Self, ParamError> {
        const { assert!(N > 0, "a Maxwell-slip model needs at least one block") };
        let (blocks, limit) = quantise(blocks, breakaway, units, RANGE)?;
        Ok(Self { limit, blocks })
    }

    /// The finest unit of force (N or N·m) that it accepts for these blocks at the unit of length `length` (m or rad).
    pub fn finest_force(blocks: &[Block; N], breakaway: f64, length: f64) -> f64 {
        finest_force(blocks, breakaway, length, RANGE)
    }

    /// `2·D_i` (units of length) and `k_i` (units of force per unit of length) of each block.
    pub fn blocks(&self) -> impl Iterator<Item = [i32; 2]> {
        self.blocks.iter().map(|b| [b.full, b.stiffness])
    }

    /// The fence costs no instruction. It has the blocks stored here and loaded again below: kept in registers across
    /// both ways, they would make the ordinary tick save those registers.
    #[inline]
    fn reverse(&self, state: &mut SlipReserveState<N>) {
        state.backward = !state.backward;
        for (reserve, block) in state.reserve.iter_mut().zip(&self.blocks) {
            *reserve = block.full - *reserve;
        }
        compiler_fence(Ordering::SeqCst);
    }
}

impl<const N: usize> Friction for SlipReserve<N> {
    type Scalar = Whole;
    type State = SlipReserveState<N>;

    fn at_rest(&self) -> Self::State {
        SlipReserveState {
            backward: 0,
            reserve: self.blocks.map(|block| block.full / 2),
        }
    }

    #[inline(always)]
    fn step(&self, state: &mut Self::State, motion: Motion<Whole>) -> Whole {
        let dx = motion.displacement.to_bits().clamp(-LARGEST - 1, LARGEST);
        let mut advance = (dx ^ state.backward) - state.backward;
        if advance < 0 {
            advance = -advance;
            self.reverse(state);
        }
        let mut lacking = 0_i32;
        let blocks = state
            .reserve
            .chunks_mut(TOGETHER)
            .zip(self.blocks.chunks(TOGETHER));
        for (reserves, blocks) in blocks {
            for (reserve, block) in reserves.iter_mut().zip(blocks) {
                let left = *reserve - advance;
                *reserve = if left > 0 { left } else { 0 };
                lacking = lacking.wrapping_add(block.stiffness.wrapping_mul(*reserve));
                lacking = settled(lacking);
            }
            compiler_fence(Ordering::SeqCst);
        }
        // Construction has proved that the sum fits.
        let along = self.limit.wrapping_sub(lacking);
        Whole::from_bits((along ^ state.backward).wrapping_sub(state.backward))
    }

    fn limit(&self) -> Option<Whole> {
        Some(Whole::from_bits(self.limit))
    }
}
