//! The full GMS law in whole numbers: no exponential and no division in the control tick.

use super::Whole;
use super::curves::Curves;
use super::product::upper;
use super::quantised::{Scale, WITHIN_A_TICK, extremes, longest, whole};
use crate::param::{at_most, check_blocks};
use crate::{Block, Friction, Motion, ParamError, Sliding, Units};

/// Leaves at least 8 bits for the reciprocal of the largest yield displacement: an error of 0.2 %, usually far less.
const GREATEST_SPREAD: f64 = 1_048_576.0;

/// The full GMS law in `i32`: that of [`Gms`](crate::Gms), stick and slip, Stribeck curve and lag, on counts.
///
/// A block's force is kept as the share `q_i = dir·F_i/(α_i·F_s) ∈ [−1, 1]` of its breakaway force. The threshold
/// `σ(v)` and the lag `λ(v)` of [`Gms`](crate::Gms) are then the same two numbers for every block:
///
/// - sticking: `q_i ← q_i + |dx|/D_i`; the block slips from `q_i ≥ σ(v)` on;
/// - slipping: `q_i ← q_i + λ(v)·(σ(v) − q_i)`;
/// - `F = dir·F_s·Σ α_i·q_i`; on a reversal every `q_i` changes its sign and every block sticks.
///
/// `σ` and `λ` come from a table of 63 intervals with linear interpolation. A product keeps its upper 32 bits.
///
/// Accepts `D_max²/D_min` up to 2²⁰ units of length (at 25 nm a count and `D_min` = 1 µm, `D_max` up to 160 µm), units of
/// force down to [`CountGms::finest_force`], and a unit of velocity up to 1/63 of the speed at which the Stribeck curve
/// has levelled out. No input overflows: a displacement beyond `2·D_max` is cut, and slips every block all the same.
///
/// ```
/// use preslide::kernels::{CountGms, Whole};
/// use preslide::{Block, Friction, Motion, Sliding, Units};
/// let blocks = [Block { stiffness: 113_948.0, weight: 0.616 }, Block { stiffness: 8_870.0, weight: 0.384 }];
/// let sliding = Sliding { coulomb: 0.81, stribeck_velocity: 1e-3, stribeck_exponent: 2.0, attraction: 20.0 };
/// let force = CountGms::finest_force(&blocks, 0.9, 25e-9);
/// let units = Units { length: 25e-9, force, velocity: 1e-7 };
/// let gms = CountGms::try_new(&blocks, 0.9, sliding, 50e-6, units)?;
/// let mut state = gms.at_rest();
/// let motion = Motion { displacement: Whole::from_num(4), velocity: Whole::from_num(20_000) }; // 2 mm/s
/// let newtons = f64::from(gms.step(&mut state, motion).to_num::<i32>()) * force;
/// assert!((newtons - 4.0 * 25e-9 * (113_948.0 + 8_870.0)).abs() < 1e-4);
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[repr(C)]
pub struct CountGms<const N: usize> {
    blocks: [ShareBlock; N],
    /// Longest displacement of a tick.
    longest: i32,
    /// 1 of the scale of `q`.
    one: i32,
    curves: Curves,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
struct ShareBlock {
    /// `1/D_i`, in the scale of `q` per unit of length.
    rate: i32,
    /// `α_i·F_s`, so that the upper word of its product with `q` is in units of force.
    share: i32,
}

/// What a [`CountGms`] remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(C)]
pub struct CountGmsState<const N: usize> {
    /// 0 while the body moves forward, −1 backward: `(x ^ b) − b` is `dir·x`.
    backward: i32,
    slipping: u32,
    share: [i32; N],
}

/// The scale of `q`, a power of two: `q` and the longest displacement must not overflow together.
fn scale(extremes: [f64; 2]) -> f64 {
    let room = f64::from(i32::MAX) / (1.0 + (longest(extremes) + 1.0) / extremes[1]);
    libm::exp2(libm::floor(libm::log2(room)).min(28.0))
}

/// The places of [`Scaled`](super::Scaled): speed in parts of 2¹⁷ or more of that at which the Stribeck curve has levelled out.
pub(super) fn places<const N: usize>(
    blocks: &[Block; N],
    breakaway: f64,
    sliding: &Sliding,
    units: Units,
    most_places: u32,
) -> Result<(Scale, Units), ParamError> {
    sliding.check(breakaway)?;
    let [largest, smallest] = extremes(blocks, breakaway, units.length);
    let longest = (GREATEST_SPREAD * smallest / largest).min(WITHIN_A_TICK.into());
    let finest = |length| CountGms::finest_force(blocks, breakaway, length);
    let (scale, units) = Scale::fitting(blocks, breakaway, units, longest, most_places, finest)?;
    let velocity = libm::ceil(libm::log2(units.velocity / sliding.levelled()) + 1.0);
    let velocity = velocity.clamp(0.0, 40.0);
    let unit = units.velocity * libm::exp2(-16.0 - velocity);
    Ok((
        Scale {
            velocity: velocity as u32,
            ..scale
        },
        Units {
            velocity: unit,
            ..units
        },
    ))
}

impl<const N: usize> CountGms<N> {
    /// Validates the parameters and computes the table.
    ///
    /// `breakaway` is `F_s` (N or N·m), `sample_time` is `T_s` (s), at most 1 s.
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite or not positive, `F_c > F_s`, the weights do not sum to 1,
    /// or something lies outside the range above in `units`.
    pub fn try_new(
        blocks: &[Block; N],
        breakaway: f64,
        sliding: Sliding,
        sample_time: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        const {
            assert!(N > 0, "a Maxwell-slip model needs at least one block");
            assert!(N <= 32, "the slip flags of at most 32 blocks fit one word");
        }
        check_blocks(blocks, breakaway, units)?;
        let extremes = extremes(blocks, breakaway, units.length);
        let [largest, smallest] = extremes;
        let spread =
            "square of the largest yield displacement over the smallest, in units of length,";
        at_most(spread, largest * largest / smallest, GREATEST_SPREAD)?;
        let one = scale(extremes);
        let curves = Curves::try_new(&sliding, breakaway, sample_time, units, one)?;
        let per_force = breakaway / units.force * 4_294_967_296.0 / one;

        let mut shares = [ShareBlock::default(); N];
        for (i, (block, share)) in blocks.iter().zip(&mut shares).enumerate() {
            let of_block = |e: ParamError| e.of_block(i);
            let rate = one * units.length / block.yield_displacement(breakaway);
            *share = ShareBlock {
                rate: whole("reciprocal yield displacement", rate, i32::MAX).map_err(of_block)?,
                share: whole(
                    "weight times breakaway force",
                    block.weight * per_force,
                    i32::MAX,
                )
                .map_err(of_block)?,
            };
        }
        Ok(Self {
            blocks: shares,
            longest: longest(extremes) as i32,
            one: one as i32,
            curves,
        })
    }

    /// The finest unit of force (N or N·m) that it accepts for these blocks at the unit of length `length` (m or rad).
    pub fn finest_force(blocks: &[Block; N], breakaway: f64, length: f64) -> f64 {
        let heaviest = blocks.iter().fold(0.0, |most: f64, b| most.max(b.weight));
        2.02 * heaviest * breakaway / scale(extremes(blocks, breakaway, length))
    }

    /// `1/D_i` and `α_i·F_s` of each block, as a tick multiplies by them.
    pub fn blocks(&self) -> impl Iterator<Item = [i32; 2]> {
        self.blocks.iter().map(|b| [b.rate, b.share])
    }

    /// The longest displacement of a tick (units of length).
    pub fn longest(&self) -> i32 {
        self.longest
    }

    /// The table: its intervals per unit of velocity, times 2³², and of each `σ` in the middle (in the scale of `q`), its difference across,
    /// and the same of `λ` (times 2³¹).
    pub fn curves(&self) -> (u32, impl Iterator<Item = [i32; 4]>) {
        self.curves.numbers()
    }

    /// `F_s·Σ α_i·q_i`, in units of force.
    #[inline]
    fn force(&self, shares: &[i32; N]) -> i32 {
        let products = self
            .blocks
            .iter()
            .zip(shares)
            .map(|(block, &q)| upper(block.share, q));
        products.fold(0, i32::wrapping_add)
    }
}

impl<const N: usize> CountGmsState<N> {
    #[inline(always)]
    fn signed(&self, along: i32) -> i32 {
        (along ^ self.backward).wrapping_sub(self.backward)
    }
}

impl<const N: usize> Friction for CountGms<N> {
    type Scalar = Whole;
    type State = CountGmsState<N>;

    fn at_rest(&self) -> Self::State {
        CountGmsState {
            backward: 0,
            slipping: 0,
            share: [0; N],
        }
    }

    #[inline(always)]
    fn step(&self, state: &mut Self::State, motion: Motion<Whole>) -> Whole {
        let dx = motion.displacement.to_bits().clamp(-i32::MAX, i32::MAX);
        let velocity = motion.velocity.to_bits();
        if dx == 0 && velocity == 0 {
            return Whole::from_bits(state.signed(self.force(&state.share)));
        }
        let mut advance = state.signed(dx);
        if advance < 0 {
            advance = -advance;
            state.backward = !state.backward;
            state.slipping = 0;
            state.share = state.share.map(|q| -q);
        }
        let advance = advance.min(self.longest);
        let (bound, lag) = self.curves.at(velocity);
        let mut slipping = state.slipping;
        let mut force = 0_i32;
        for (i, (share, block)) in state.share.iter_mut().zip(&self.blocks).enumerate() {
            let old = *share;
            let mut new = old.wrapping_add(block.rate.wrapping_mul(advance));
            let slips = slipping >> i & 1 == 1;
            if slips || new >= bound {
                slipping |= 1 << i;
                new = if slips || old >= bound {
                    old + upper(lag, 2 * (bound - old))
                } else {
                    bound
                };
            }
            *share = new;
            force = force.wrapping_add(upper(block.share, new));
        }
        state.slipping = slipping;
        Whole::from_bits(state.signed(force))
    }

    fn limit(&self) -> Option<Whole> {
        // The upper word of a negative product is rounded away from zero: a unit of force a block.
        let limit = self.force(&[-self.one; N]);
        Some(Whole::from_bits(-limit))
    }
}
