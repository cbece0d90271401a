//! A kernel in whole numbers as a friction model in a controller's units.

use super::quantised::{Range, Scale, WITHIN_A_TICK};
use super::{CountGms, PackedSlipReserve, SlipReserve, Whole, count_gms, packed};
use crate::param::fits;
use crate::{Block, Friction, Motion, ParamError, Scalar, Sliding, Units};
use core::sync::atomic::{Ordering, compiler_fence};

/// The kernel `K` for a controller that computes in `S`: a friction model like any other, so that effects
/// ([`With`](crate::effects::With)), [`Learning`](crate::control::Learning) and [`Observed`](crate::control::Observed) go around it.
///
/// Its units of length and of force are those of the controller divided by powers of two, as fine as the kernel's range allows: the
/// largest yield displacement is then 2¹³ to 2¹⁴ units, so that the whole numbers are finer than encoder counts wherever blocks yield
/// over fewer than 8192 of them. With `l` and `f` binary places:
///
/// `path ← remainder + 2^l·dx`, the kernel takes the whole units of `path`, `remainder ← path − whole`, `F = 2^-f·F_K`.
///
/// **Slow motion.** What is not a whole unit yet stays in the state, in 2⁻¹⁶ units, and is lost by no stop or reversal. In fixed point of
/// at most 16 bits of fraction a path is exact however long. A float's displacement is rounded towards 0, to 2⁻¹⁶ units, in each tick: that
/// takes a block through its yield displacement in no less than 2²⁹ ticks (7 hours at 20 kHz).
///
/// **Error.** Against the same law with reals: half a unit of length (1/16 384 of the largest yield displacement, at most; with [`CountGms`] a
/// whole one, always ahead) for the path, and the rounding of
/// each block's `D_i` and `k_i`: by 1 % at most, or for a stiffness that is small beside the others by what is 1/1000 of the breakaway
/// force. Beyond that parameters are refused.
///
/// ```
/// use preslide::kernels::{PackedSlipReserve, Scaled};
/// use preslide::{Block, Friction, Motion, Units};
/// let blocks = [Block { stiffness: 113_948.0, weight: 0.616 }, Block { stiffness: 8_870.0, weight: 0.384 }];
/// let gms = Scaled::<PackedSlipReserve<1>, f32>::try_new(&blocks, 0.9, Units::SI)?;
/// let mut state = gms.at_rest();
/// let mut force = 0.0;
/// for _ in 0..1000 {
///     force = gms.step(&mut state, Motion::quasi_static(1e-10)); // 0.1 nm a tick, far below a count
/// }
/// assert!((force - 1e-7 * (113_948.0 + 8_870.0)).abs() < 1e-4); // (N), after 0.1 µm
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[repr(C)]
pub struct Scaled<K, S: Scalar = f32> {
    scale: Scale,
    /// `scale.length` as a tick takes it.
    finer: S::Scaling,
    /// `scale.force`.
    coarser: S::Scaling,
    /// Greatest |force| in the controller's units.
    limit: S,
    kernel: K,
}

/// What a [`Scaled`] remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(C)]
pub struct ScaledState<M> {
    /// Path that the kernel has not been given yet ([`Arithmetic::to_path`]'s), and half a unit, so that the nearest unit is the whole part. Of a
    /// kernel that is told of reversals at once, without the half: the next unit in the direction of motion is given beforehand.
    remainder: i32,
    kernel: M,
}

/// A kernel in whole numbers, as [`Scaled`] takes it.
pub trait Kernel: Friction<Scalar = Whole> {
    /// It must learn of a reversal at once, and not only when a whole unit of length has been travelled: what slips relaxes in time.
    const IN_TIME: bool = false;
}

impl<const PAIRS: usize> Kernel for PackedSlipReserve<PAIRS> {}
impl<const N: usize> Kernel for SlipReserve<N> {}
impl<const N: usize> Kernel for CountGms<N> {
    const IN_TIME: bool = true;
}

impl<K: Kernel, S: Scalar> Scaled<K, S> {
    fn of(kernel: K, scale: Scale) -> Result<Self, ParamError> {
        // No force is larger, so that none needs to be cut in a tick.
        let limit = kernel.limit().map_or(i32::MAX, Whole::to_bits);
        let exact = f64::from(limit) * libm::exp2(-f64::from(scale.force));
        fits::<S>("breakaway force", exact)?;
        let coarser = S::coarser(scale.force);
        Ok(Self {
            finer: S::finer(scale.length),
            coarser,
            limit: S::from_whole(limit, coarser),
            scale,
            kernel,
        })
    }
}

impl<K, S: Scalar> Scaled<K, S> {
    /// The kernel.
    pub fn kernel(&self) -> &K {
        &self.kernel
    }

    /// Binary places from the controller's units to the kernel's: of length, of velocity beside 16 more, and of force.
    pub fn places(&self) -> (u32, u32, i32) {
        (self.scale.length, self.scale.velocity, self.scale.force)
    }
}

impl<const PAIRS: usize, S: Scalar> Scaled<PackedSlipReserve<PAIRS>, S> {
    /// Validates the parameters of `2·PAIRS − 1` or `2·PAIRS` blocks; `breakaway` is `F_s` (N or N·m).
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite or not positive, the weights do not sum to 1, the breakaway force does not fit `S` in
    /// `units`, or the kernel's range does not hold a block's yield displacement or stiffness well enough (see above).
    pub fn try_new<const N: usize>(
        blocks: &[Block; N],
        breakaway: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        let (scale, units) =
            Scale::try_new(blocks, breakaway, units, packed::RANGE, S::MOST_PLACES)?;
        PackedSlipReserve::try_new(blocks, breakaway, units)
            .and_then(|kernel| Self::of(kernel, scale))
    }
}

impl<const N: usize, S: Scalar> Scaled<SlipReserve<N>, S> {
    /// Validates the parameters; `breakaway` is `F_s` (N or N·m).
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite or not positive, the weights do not sum to 1, the breakaway force does not fit `S` in
    /// `units`, or the kernel's range does not hold a block's yield displacement or stiffness well enough (see above).
    pub fn try_new(blocks: &[Block; N], breakaway: f64, units: Units) -> Result<Self, ParamError> {
        let range = Range {
            yields: WITHIN_A_TICK,
            stiffness: i32::MAX,
        };
        let (scale, units) = Scale::try_new(blocks, breakaway, units, range, S::MOST_PLACES)?;
        SlipReserve::try_new(blocks, breakaway, units).and_then(|kernel| Self::of(kernel, scale))
    }
}

impl<const N: usize, S: Scalar> Scaled<CountGms<N>, S> {
    /// Validates the parameters and computes the table; `breakaway` is `F_s` (N or N·m), `sample_time` is `T_s` (s), at most 1 s.
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite or not positive, `F_c > F_s`, the weights do not sum to 1, the breakaway force does not
    /// fit `S` in `units`, or the kernel's range does not hold the parameters.
    pub fn try_new(
        blocks: &[Block; N],
        breakaway: f64,
        sliding: Sliding,
        sample_time: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        let (scale, units) = count_gms::places(blocks, breakaway, &sliding, units, S::MOST_PLACES)?;
        CountGms::try_new(blocks, breakaway, sliding, sample_time, units)
            .and_then(|kernel| Self::of(kernel, scale))
    }
}

impl<K: Kernel, S: Scalar> Friction for Scaled<K, S> {
    type Scalar = S;
    type State = ScaledState<K::State>;

    fn at_rest(&self) -> Self::State {
        ScaledState {
            remainder: i32::from(!K::IN_TIME) << (S::beyond(self.finer) - 1),
            kernel: self.kernel.at_rest(),
        }
    }

    fn take_over(&self, old: &Self, state: &Self::State) -> Self::State {
        if self.scale.length != old.scale.length {
            return self.at_rest();
        }
        ScaledState {
            remainder: state.remainder,
            kernel: self.kernel.take_over(&old.kernel, &state.kernel),
        }
    }

    #[inline(always)]
    fn step(&self, state: &mut Self::State, motion: Motion<S>) -> S {
        compiler_fence(Ordering::SeqCst);
        let moved = motion.displacement.to_path(self.finer);
        let beyond = S::beyond(self.finer);
        let path = state.remainder.saturating_add(moved);
        let whole = match moved {
            0 if K::IN_TIME => 0,
            1.. if K::IN_TIME => path.saturating_add((1 << beyond) - 1) >> beyond,
            _ => path >> beyond,
        };
        state.remainder = path.wrapping_sub(whole << beyond);
        // What moves too slowly for the controller's velocity, or for a whole unit, moves all the same.
        let moves = i32::from(K::IN_TIME && moved != 0);
        let motion = Motion {
            displacement: Whole::from_bits(whole),
            velocity: Whole::from_bits(motion.velocity.to_q16(self.scale.velocity) | moves),
        };
        let force = self.kernel.step(&mut state.kernel, motion);
        S::from_whole(force.to_bits(), self.coarser)
    }

    fn limit(&self) -> Option<S> {
        Some(self.limit)
    }
}
