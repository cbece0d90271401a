//! The lumped law in whole numbers.

use super::super::Whole;
use super::super::curves::Curves;
use super::super::product::upper;
use super::super::quantised::{extremes, longest, whole};
use super::{Lumped, LumpedState, Number, Spring};
use crate::param::{at_most, check_blocks};
use crate::{Block, Friction, Motion, ParamError, Sliding, Units};

/// The share 1.
const SHARE: f64 = 536_870_912.0; // 2²⁹

/// The largest yield displacement in the kernel's own parts of a unit of length, and the largest force.
const FULL: f64 = 134_217_728.0; // 2²⁷

/// Leaves the smallest yield displacement 11 bits.
const GREATEST_SPREAD: f64 = 65_536.0;

impl Number for i32 {
    const ZERO: Self = 0;
    const ONE: Self = SHARE as i32;
    const FORWARD: Self = 0;
    const MARGIN: Self = 2;

    #[inline(always)]
    fn along(self, direction: Self) -> Self {
        (self ^ direction).wrapping_sub(direction)
    }
    #[inline(always)]
    fn turned(direction: Self) -> Self {
        !direction
    }
    #[inline(always)]
    fn whole(self) -> Self {
        self << 3
    }
    #[inline(always)]
    fn of_whole(whole: Self) -> Self {
        whole >> 3
    }
    #[inline(always)]
    fn part(whole: Self, share: Self) -> Self {
        upper(whole, share)
    }
    #[inline(always)]
    fn lagging(self, lag: Self) -> Self {
        upper(2 * self, lag)
    }
    #[inline(always)]
    fn force(stiffness: Self, deflection: Self) -> Self {
        upper(stiffness, deflection)
    }
    #[inline(always)]
    fn per_weakening(self, per: Self) -> Self {
        ((i64::from(self) * i64::from(per)) >> 16) as i32
    }
}

/// The full GMS law in `i32` as one spring and one slider: what [`LumpedGms`](super::LumpedGms) is to [`Gms`](crate::Gms), this is to
/// [`CountGms`](crate::kernels::CountGms).
///
/// The travel between two events is a whole number of parts of a count, so that sticking is exact: a loop in which no block slips closes to the bit,
/// however often it is run, and nothing drifts. `σ` and `λ` come from the table of `CountGms`.
///
/// Accepts yield displacements up to 2²⁰ units of length, the largest up to 2¹⁶ times the smallest, units of force down to
/// [`LumpedCountGms::finest_force`], and a unit of velocity up to 1/63 of the speed at which the Stribeck curve has levelled out.
/// No input overflows: a displacement beyond `2·D_max` is cut, and slips every block all the same.
///
/// ```
/// use preslide::kernels::{LumpedCountGms, Whole};
/// use preslide::{Block, Friction, Motion, Sliding, Units};
/// let blocks = [Block { stiffness: 113_948.0, weight: 0.616 }, Block { stiffness: 8_870.0, weight: 0.384 }];
/// let sliding = Sliding { coulomb: 0.81, stribeck_velocity: 1e-3, stribeck_exponent: 2.0, attraction: 20.0 };
/// let force = LumpedCountGms::finest_force(&blocks, 0.9, 25e-9);
/// let units = Units { length: 25e-9, force, velocity: 1e-7 };
/// let gms = LumpedCountGms::try_new(&blocks, 0.9, sliding, 50e-6, units)?;
/// let mut state = gms.at_rest();
/// let motion = Motion { displacement: Whole::from_num(4), velocity: Whole::from_num(20_000) }; // 2 mm/s
/// let newtons = f64::from(gms.step(&mut state, motion).to_num::<i32>()) * force;
/// assert!((newtons - 4.0 * 25e-9 * (113_948.0 + 8_870.0)).abs() < 1e-4);
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LumpedCountGms<const N: usize> {
    lumped: Lumped<N, i32>,
    /// Longest displacement of a tick, in units of length, and the parts of a unit.
    longest: i32,
    unit: i32,
    limit: i32,
    curves: Curves,
}

/// What a [`LumpedCountGms`] remembers.
#[derive(Clone, Debug, PartialEq)]
pub struct LumpedCountGmsState<const N: usize>(LumpedState<N, i32>);

/// Parts of a unit of length: the largest yield displacement is not to exceed [`FULL`], a displacement beyond twice of it not
/// the rest of 31 bits.
fn parts(largest: f64) -> f64 {
    libm::floor(FULL / (largest + 1.0)).max(1.0)
}

/// Rounds the blocks; returns `ΣW_i`.
fn quantise(
    blocks: &[Block],
    breakaway: f64,
    units: Units,
    unit: f64,
    springs: &mut [Spring<i32>],
) -> Result<i32, ParamError> {
    let (mut limit, mut sum) = (0.0, 0.0);
    for (i, (block, spring)) in blocks.iter().zip(springs).enumerate() {
        let of_block = |e: ParamError| e.of_block(i);
        let yields = block.yield_displacement(breakaway) / units.length * unit;
        let yields = whole("yield displacement", yields, FULL as i32).map_err(of_block)?;
        let weight = block.weight * breakaway / units.force;
        let stiffness = weight * 4_294_967_296.0 / f64::from(yields);
        let stiffness = whole("stiffness", stiffness, i32::MAX).map_err(of_block)?;
        limit += weight;
        sum += f64::from(stiffness);
        *spring = Spring {
            yields: yields.whole(),
            stiffness,
        };
    }
    at_most("sum of the stiffnesses", sum, f64::from(i32::MAX))?;
    at_most("breakaway force, in units of force,", limit, FULL)?;
    whole("breakaway force", limit, FULL as i32)
}

impl<const N: usize> LumpedCountGms<N> {
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
        let curves = Curves::try_new(&sliding, breakaway, sample_time, units, SHARE)?;
        let extremes = extremes(blocks, breakaway, units.length);
        let [largest, smallest] = extremes;
        at_most(
            "largest yield displacement, in units of length,",
            largest,
            1_048_576.0,
        )?;
        let spread = "largest yield displacement over the smallest";
        at_most(spread, largest / smallest, GREATEST_SPREAD)?;
        let unit = parts(largest);
        let mut springs = [Spring {
            yields: 0,
            stiffness: 0,
        }; N];
        let limit = quantise(blocks, breakaway, units, unit, &mut springs)?;
        let weakest = sliding.coulomb / breakaway;
        // Beyond these 16 bits there is no Stribeck effect to speak of: a block then counts as near its limit a little early.
        let per_weakening = 65_536.0 / (1.0 - weakest);
        Ok(Self {
            lumped: Lumped {
                springs,
                weakest: libm::floor(weakest * SHARE) as i32,
                per_weakening: if per_weakening < f64::from(i32::MAX) {
                    per_weakening as i32
                } else {
                    0
                },
                far: 4 * FULL as i32,
            },
            longest: longest(extremes) as i32,
            unit: unit as i32,
            // The upper word of a product is rounded down: by a unit of force a block, and by one for each lump.
            limit: limit + N as i32 + 4,
            curves,
        })
    }

    /// The finest unit of force (N or N·m) that it accepts for these blocks at the unit of length `length` (m or rad).
    pub fn finest_force(blocks: &[Block; N], breakaway: f64, length: f64) -> f64 {
        let [largest, _] = extremes(blocks, breakaway, length);
        let unit = parts(largest);
        let stiffness = blocks.iter().map(|block| block.stiffness).sum::<f64>();
        // 1 % of room for the rounding of the yield displacements, and for weights that sum to a little more than 1.
        1.01 * f64::max(2.0 * stiffness * length / unit, breakaway / FULL)
    }
}

impl<const N: usize> Friction for LumpedCountGms<N> {
    type Scalar = Whole;
    type State = LumpedCountGmsState<N>;

    fn at_rest(&self) -> Self::State {
        LumpedCountGmsState(self.lumped.at_rest())
    }

    #[inline(always)]
    fn step(&self, state: &mut Self::State, motion: Motion<Whole>) -> Whole {
        let displacement = motion.displacement.to_bits();
        let displacement = displacement.min(self.longest).max(-self.longest) * self.unit;
        let velocity = motion.velocity.to_bits();
        let sliding = || self.curves.at(velocity).into();
        let force = self
            .lumped
            .step(&mut state.0, displacement, velocity != 0, sliding);
        Whole::from_bits(force)
    }

    fn limit(&self) -> Option<Whole> {
        Some(Whole::from_bits(self.limit))
    }
}
