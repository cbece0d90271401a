//! Blocks in whole numbers: the quasi-static law's, as all slip-reserve kernels share it, and what the full law takes of it.

use crate::param::{Block, Bound, ParamError, Units, check_blocks};

/// One block: `2·D_i` in units of length, and `k_i` in units of force per unit of length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(C)]
pub(super) struct Reserve {
    pub(super) full: i32,
    pub(super) stiffness: i32,
}

/// The largest values that a kernel holds.
#[derive(Clone, Copy)]
pub(super) struct Range {
    pub(super) yields: i32,
    pub(super) stiffness: i32,
}

/// The longest path of a tick is 2¹⁵ units of length: what is to slip on it must yield within half of that.
pub(super) const WITHIN_A_TICK: i32 = (1 << 14) - 1;

/// Binary places from a controller's units to a kernel's.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(C)]
pub(super) struct Scale {
    pub(super) length: u32,
    /// Beyond the 16 of [`Arithmetic::to_q16`](crate::scalar::Arithmetic::to_q16).
    pub(super) velocity: u32,
    pub(super) force: i32,
}

/// Floats hold twice as many.
const MOST_PLACES: f64 = 62.0;

/// The most binary places by which `value` stays within `most`.
fn places(value: f64, most: f64) -> f64 {
    libm::floor(libm::log2(most / value)).clamp(-MOST_PLACES, MOST_PLACES)
}

impl Scale {
    /// The finest unit of length in which no block yields beyond `longest`, and the finest of force, which `finest` says for a unit of
    /// length (m or rad) in N or N·m; with the kernel's units. What does not fit there either is the kernel's to refuse.
    pub(super) fn fitting(
        blocks: &[Block],
        breakaway: f64,
        units: Units,
        longest: f64,
        most_places: u32,
        finest: impl Fn(f64) -> f64,
    ) -> Result<(Self, Units), ParamError> {
        check_blocks(blocks, breakaway, units)?;
        let [largest, _] = extremes(blocks, breakaway, units.length);
        let length = places(largest, longest).clamp(0.0, most_places.into());
        let unit = units.length * libm::exp2(-length);
        let force = places(finest(unit), units.force);
        let scale = Self {
            length: length as u32,
            velocity: 0,
            force: force as i32,
        };
        let units = Units {
            length: unit,
            force: units.force * libm::exp2(-force),
            ..units
        };
        Ok((scale, units))
    }

    /// The same for the quasi-static law in a range, where rounding to it changes a block's yield displacement and stiffness by no more
    /// than a hundredth, or a stiffness that is small beside the others by no more than what is a thousandth of the breakaway force.
    pub(super) fn try_new(
        blocks: &[Block],
        breakaway: f64,
        units: Units,
        range: Range,
        most_places: u32,
    ) -> Result<(Self, Units), ParamError> {
        let finest = |length| finest_force(blocks, breakaway, length, range);
        let longest = range.yields.into();
        let (scale, units) = Self::fitting(blocks, breakaway, units, longest, most_places, finest)?;
        for (i, block) in blocks.iter().enumerate() {
            let exact = block.yield_displacement(breakaway) / units.length;
            let yields = libm::round(exact).max(1.0);
            let stiffness = block.weight * breakaway / units.force / yields;
            let slight = 1e-3 * breakaway / units.force / yields;
            let near = |parameter, exact: f64, held: f64, slight: f64| {
                if (held - exact).abs() <= f64::max(0.01 * exact, slight) {
                    return Ok(());
                }
                Err(ParamError {
                    parameter,
                    block: Some(i + 1),
                    value: exact,
                    bound: Bound::Rounded(held),
                })
            };
            near("yield displacement", exact, yields, 0.0)?;
            near("stiffness", stiffness, libm::round(stiffness), slight)?;
        }
        Ok((scale, units))
    }
}

/// Rounds the blocks, and returns `ΣW_i` with them.
pub(super) fn quantise<const N: usize>(
    blocks: &[Block; N],
    breakaway: f64,
    units: Units,
    range: Range,
) -> Result<([Reserve; N], i32), ParamError> {
    let mut reserves = [Reserve::default(); N];
    let limit = round(blocks, breakaway, units, range, &mut reserves)?;
    Ok((reserves, limit))
}

/// One function for every N: it is much code, for what runs once.
///
/// `D_i` is rounded to a whole unit of length, so that no force is left at rest and none is made by a reversal; `k_i`
/// then follows from `W_i = k_i·D_i`: a slipping block carries its force to within the rounding of `k_i`, whatever
/// became of `D_i`.
#[inline(never)]
fn round(
    blocks: &[Block],
    breakaway: f64,
    units: Units,
    range: Range,
    reserves: &mut [Reserve],
) -> Result<i32, ParamError> {
    check_blocks(blocks, breakaway, units)?;
    let mut limit = 0_i64;
    for (i, (block, reserve)) in blocks.iter().zip(reserves).enumerate() {
        let of_block = |e: ParamError| e.of_block(i);
        let yields = block.yield_displacement(breakaway) / units.length;
        let yields = whole("yield displacement", yields, range.yields).map_err(of_block)?;
        let stiffness = block.weight * breakaway / units.force / f64::from(yields);
        let stiffness = whole("stiffness", stiffness, range.stiffness).map_err(of_block)?;
        limit += i64::from(yields) * i64::from(stiffness);
        *reserve = Reserve {
            full: 2 * yields,
            stiffness,
        };
    }
    // `Σ k_i·w_i` reaches twice the limit.
    if limit > i64::from(i32::MAX / 2) {
        return Err(ParamError::new(
            "breakaway force",
            limit as f64,
            Bound::Representable(f64::from(i32::MAX / 2)),
        ));
    }
    Ok(limit as i32)
}

/// The finest unit of force in which [`quantise`] accepts the blocks.
pub(super) fn finest_force(blocks: &[Block], breakaway: f64, length: f64, range: Range) -> f64 {
    // 1 % of room for a sum of rounded stiffnesses and for weights that sum to a little more than 1.
    let for_sum = 2.02 * breakaway / f64::from(i32::MAX);
    blocks.iter().fold(for_sum, |finest, block| {
        let yields = libm::round(block.yield_displacement(breakaway) / length).max(1.0);
        finest.max(block.weight * breakaway / yields / f64::from(range.stiffness))
    })
}

/// Largest and smallest yield displacement, in units of length.
pub(super) fn extremes(blocks: &[Block], breakaway: f64, length: f64) -> [f64; 2] {
    let yields = blocks.iter();
    let yields = yields.map(|block| block.yield_displacement(breakaway) / length);
    yields.fold([0.0, f64::INFINITY], |[largest, smallest], d| {
        [f64::max(largest, d), f64::min(smallest, d)]
    })
}

/// The longest displacement that a tick must take: from one limit of the slowest block to the other.
pub(super) fn longest([largest, _]: [f64; 2]) -> f64 {
    libm::ceil(2.0 * largest) + 1.0
}

/// The nearest whole number, refused where it is 0 or above `greatest`.
pub(super) fn whole(parameter: &'static str, value: f64, greatest: i32) -> Result<i32, ParamError> {
    let refuse = |bound| Err(ParamError::new(parameter, value, bound));
    let rounded = libm::round(value);
    if !(rounded <= f64::from(greatest)) {
        refuse(Bound::Representable(f64::from(greatest)))
    } else if rounded < 1.0 {
        refuse(Bound::Resolvable)
    } else {
        Ok(rounded as i32)
    }
}
