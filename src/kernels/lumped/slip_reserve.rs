//! The quasi-static law event by event: a tick in which no block slips costs the same with one block as with ten.

use super::super::Whole;
use super::super::quantised::{finest_force, quantise};
use super::super::slip_reserve::RANGE;
use crate::{Block, Friction, Motion, ParamError, Units};

/// Farther than any block yields: what is left before the next one slips where none is to slip.
const NEVER: i32 = i32::MAX;

/// Quasi-static GMS in `i32` event by event: what [`SlipReserve`](crate::kernels::SlipReserve) computes, to the bit, cheap in the mean tick.
///
/// A block is a spring between the body at `x` and a slider at `c_i`: `F = Σ k_i·(x − c_i)`, and a slipping block drags its slider
/// along at a distance of `D_i`. What a block can still move before it slips is its *slip reserve* `w_i = D_i − dir·(x − c_i) ∈ [0, 2·D_i]`:
///
/// `w_i ← max(w_i − |dx|, 0)`; on a reversal `w_i ← 2·D_i − w_i`, `dir ← −dir`.
///
/// In the order of their `D_i` the reserves never fall: `0 ≤ w_j − w_i ≤ 2·(D_j − D_i)` for `D_i ≤ D_j` holds at rest, where `w = D`, and
/// both steps keep it. So the blocks that slip are always the first ones, and one comparison, with the reserve of the first that
/// sticks, decides for all. Until it is used up the force grows by `|dx|·Σ k_i` of those that stick, whatever `N` is. A reversal
/// takes a step for each block that slipped, and so does each block that begins to.
///
/// Accepts `D_i` up to 2²⁹ − 1 units of length and `ΣW_i` up to 2³⁰ − 1 units of force. No displacement
/// overflows.
///
/// ```
/// use preslide::kernels::{LumpedSlipReserve, Whole};
/// use preslide::{Block, Friction, Motion, Units};
/// let blocks = [Block { stiffness: 113_948.0, weight: 0.616 }, Block { stiffness: 8_870.0, weight: 0.384 }];
/// let force = LumpedSlipReserve::finest_force(&blocks, 0.9, 25e-9);
/// let units = Units { length: 25e-9, force, velocity: 1e-6 };
/// let gms = LumpedSlipReserve::try_new(&blocks, 0.9, units)?;
/// let mut state = gms.at_rest();
/// let counts = gms.step(&mut state, Motion::quasi_static(Whole::from_num(100_000))); // 2.5 mm: all blocks slip
/// assert!((f64::from(counts.to_num::<i32>()) * force - 0.9).abs() < 1e-6);
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[repr(C)]
pub struct LumpedSlipReserve<const N: usize> {
    limit: i32,
    /// That of all blocks.
    stiffness: i32,
    /// In the order in which they slip.
    springs: [Spring; N],
}

/// A block: `D_i` in units of length, and `k_i` in units of force per unit of length.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
struct Spring {
    yields: i32,
    stiffness: i32,
}

/// What a [`LumpedSlipReserve`] remembers.
#[derive(Clone, Debug, PartialEq)]
#[repr(C)]
pub struct LumpedSlipReserveState<const N: usize> {
    /// 0 while the body moves forward, −1 backward: `(x ^ b) − b` is `dir·x`.
    backward: i32,
    /// How far to where the next block slips, at least 1.
    left: u32,
    /// The force along the motion, and the stiffness of the blocks that stick.
    force: i32,
    stiffness: i32,
    /// Where the next block slips, along the motion. Places wrap around, their differences do not.
    slips: i32,
    /// How many blocks slip: the first ones.
    slipping: usize,
    /// Where the sliders of the others are.
    slider: [i32; N],
}

impl<const N: usize> LumpedSlipReserveState<N> {
    #[inline(always)]
    fn along(&self, x: i32) -> i32 {
        (x ^ self.backward).wrapping_sub(self.backward)
    }
}

/// By rising yield displacement. One function for every N, and a tenth of the library's.
#[inline(never)]
fn sort(springs: &mut [Spring]) {
    for _ in 1..springs.len() {
        for i in 1..springs.len() {
            if springs[i].yields < springs[i - 1].yields {
                springs.swap(i - 1, i);
            }
        }
    }
}

impl<const N: usize> LumpedSlipReserve<N> {
    /// Validates the parameters; `breakaway` is `F_s` (N or N·m).
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite or not positive, the weights do not sum to 1, or a yield
    /// displacement, a stiffness or the breakaway force lies outside the range above in `units`.
    pub fn try_new(blocks: &[Block; N], breakaway: f64, units: Units) -> Result<Self, ParamError> {
        const { assert!(N > 0, "a Maxwell-slip model needs at least one block") };
        let (reserves, limit) = quantise(blocks, breakaway, units, RANGE)?;
        let mut springs = reserves.map(|block| Spring {
            yields: block.full / 2,
            stiffness: block.stiffness,
        });
        sort(&mut springs);
        let stiffness = springs.iter().map(|spring| spring.stiffness).sum();
        Ok(Self {
            limit,
            stiffness,
            springs,
        })
    }

    /// The finest unit of force (N or N·m) that it accepts for these blocks at the unit of length `length` (m or rad).
    pub fn finest_force(blocks: &[Block; N], breakaway: f64, length: f64) -> f64 {
        finest_force(blocks, breakaway, length, RANGE)
    }

    /// A tick in which the body turns or a block slips. Not inlined: the ordinary tick would save its registers.
    #[cold]
    #[inline(never)]
    fn event(&self, state: &mut LumpedSlipReserveState<N>, dx: i32) {
        let mut advance = state.along(dx.max(-i32::MAX));
        let mut place = state.slips.wrapping_sub(state.left.cast_signed());
        if advance < 0 {
            self.turn(state, place);
            place = place.wrapping_neg();
            advance = -advance;
        }
        place = place.wrapping_add(advance);
        let mut stiffness = state.stiffness;
        let mut force = state.force.wrapping_add(stiffness.wrapping_mul(advance));
        let mut slipping = state.slipping;
        let mut left = NEVER;
        while let (Some(slider), Some(spring)) =
            (state.slider.get(slipping), self.springs.get(slipping))
        {
            let slips = state.along(*slider).wrapping_add(spring.yields);
            left = slips.wrapping_sub(place);
            if left > 0 {
                break;
            }
            force = force.wrapping_add(spring.stiffness.wrapping_mul(left));
            stiffness -= spring.stiffness;
            slipping += 1;
            left = NEVER;
        }
        state.left = left.cast_unsigned();
        state.slips = place.wrapping_add(left);
        state.force = force;
        state.stiffness = stiffness;
        state.slipping = slipping;
    }

    /// The sliders that were dragged stay where they are, and every block sticks.
    #[inline(always)]
    fn turn(&self, state: &mut LumpedSlipReserveState<N>, place: i32) {
        let backward = state.backward;
        let dragged = state.slider.iter_mut().zip(&self.springs);
        for (slider, spring) in dragged.take(state.slipping) {
            let along = place.wrapping_sub(spring.yields);
            *slider = (along ^ backward).wrapping_sub(backward);
        }
        state.backward = !backward;
        state.force = state.force.wrapping_neg();
        state.stiffness = self.stiffness;
        state.slipping = 0;
    }
}

impl<const N: usize> Friction for LumpedSlipReserve<N> {
    type Scalar = Whole;
    type State = LumpedSlipReserveState<N>;

    fn at_rest(&self) -> Self::State {
        LumpedSlipReserveState {
            backward: 0,
            left: self.springs[0].yields.cast_unsigned(),
            force: 0,
            stiffness: self.stiffness,
            slips: self.springs[0].yields,
            slipping: 0,
            slider: [0; N],
        }
    }

    #[inline(always)]
    fn step(&self, state: &mut Self::State, motion: Motion<Whole>) -> Whole {
        let dx = motion.displacement.to_bits();
        // Turning back is farther, as an unsigned number, than any block is away.
        let advance = state.along(dx);
        if advance.cast_unsigned() < state.left {
            state.left -= advance.cast_unsigned();
            let grown = state.stiffness.wrapping_mul(advance);
            state.force = state.force.wrapping_add(grown);
        } else {
            self.event(state, dx);
        }
        Whole::from_bits(state.along(state.force))
    }

    fn limit(&self) -> Option<Whole> {
        Some(Whole::from_bits(self.limit))
    }
}
