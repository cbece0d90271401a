//! The lumped law in floating point.

use super::{Lumped, LumpedState, Number, Spring};
use crate::friction::{Blocks, SpeedTable};
use crate::param::to_scalar;
use crate::{Block, Friction, Motion, ParamError, Scalar, Sliding, Units};

/// `f32` or `f64`.
pub trait Float: Scalar + Number {}

macro_rules! float {
    ($($t:ty)*) => {$(
        impl Float for $t {}

        impl Number for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const FORWARD: Self = 1.0;
            const MARGIN: Self = 0.0;

            #[inline(always)]
            fn along(self, direction: Self) -> Self {
                self * direction
            }
            #[inline(always)]
            fn turned(direction: Self) -> Self {
                -direction
            }
            #[inline(always)]
            fn whole(self) -> Self {
                self
            }
            #[inline(always)]
            fn of_whole(whole: Self) -> Self {
                whole
            }
            #[inline(always)]
            fn part(whole: Self, share: Self) -> Self {
                whole * share
            }
            #[inline(always)]
            fn lagging(self, lag: Self) -> Self {
                self * lag
            }
            #[inline(always)]
            fn force(stiffness: Self, deflection: Self) -> Self {
                stiffness * deflection
            }
            #[inline(always)]
            fn per_weakening(self, per: Self) -> Self {
                self * per
            }
        }
    )*};
}

float!(f32 f64);

/// Yield displacements that the body may slide between two events where all blocks slip: the travel, which is then idle, is
/// begun anew before it grows beyond all bounds.
const FAR: f64 = 1_048_576.0;

/// Rounding may take the sum beyond `ΣW_i` by less than this share of it.
const ROUNDING: f64 = 1e-6;

/// The full GMS law in floating point: that of [`Gms`](crate::Gms), as one spring and one slider.
///
/// Blocks that stick are springs side by side: `F = F_0 + (Σ k_i)·x`. Those that slip relax towards the same threshold `σ(v)` at
/// the same rate `λ(v)`, so that one recurrence carries all of them: with `m ← m + λ·(σ − m)` and `P ← P − λ·P`
/// a block that was at `D_i·m + e_i` is at `D_i·m + P·e_i`. A tick costs the same with two blocks as with ten, until an *event*:
///
/// - a block reaches its threshold (a bound on the travel, linear in `σ`, says that none does), or
/// - the motion turns while one slips, or where one might slip the other way.
///
/// **The mean is bought with the worst tick.** The tick of an event takes every block by itself and costs twice as much as any of
/// [`Gms`](crate::Gms): `firmware/cycles/cortex-m4.csv` has both. Where the worst tick is what you budget, take `Gms`.
///
/// Sums are formed anew at every event; between two of them the travel is summed as `Gms` sums a block's deflection, with the same
/// rounding. The forces of the two differ by that rounding, and by what `Gms` says of a block that comes back to exactly its limit.
///
/// `N ≤ 32` blocks, `f32` or `f64`; parameters and range are those of [`Gms`](crate::Gms).
///
/// ```
/// use preslide::kernels::LumpedGms;
/// use preslide::{Block, Friction, Motion, Sliding, Units};
/// let blocks = [Block { stiffness: 113_948.0, weight: 0.616 }, Block { stiffness: 8_870.0, weight: 0.384 }];
/// let sliding = Sliding { coulomb: 0.81, stribeck_velocity: 1e-3, stribeck_exponent: 2.0, attraction: 20.0 };
/// let gms = LumpedGms::<2>::try_new(&blocks, 0.9, sliding, 50e-6, Units::SI)?;
/// let mut state = gms.at_rest();
/// let force = gms.step(&mut state, Motion { displacement: 1e-7, velocity: 2e-3 });
/// assert!((force - 1e-7 * (113_948.0 + 8_870.0)).abs() < 1e-6);
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LumpedGms<const N: usize, S: Float = f32> {
    lumped: Lumped<N, S>,
    sliding: SpeedTable<S>,
    limit: S,
}

/// What a [`LumpedGms`] remembers.
#[derive(Clone, Debug, PartialEq)]
pub struct LumpedGmsState<const N: usize, S: Float = f32>(LumpedState<N, S>);

impl<const N: usize, S: Float> LumpedGms<N, S> {
    /// Validates the parameters and computes the tables.
    ///
    /// `breakaway` is `F_s` (N or N·m), `sample_time` is `T_s` (s), at most 1 s.
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite or not positive, `F_c > F_s`, the weights do not sum to 1,
    /// or a value or a bound on the state does not fit `S` in `units`.
    pub fn try_new(
        blocks: &[Block; N],
        breakaway: f64,
        sliding: Sliding,
        sample_time: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        const { assert!(N <= 32, "the slip flags of at most 32 blocks fit one word") };
        let blocks = Blocks::<N, S>::try_new(blocks, breakaway, units)?;
        let table = SpeedTable::of_law(&sliding, breakaway, sample_time, units)?;
        let largest = blocks
            .yields
            .iter()
            .fold(0.0, |most, d| d.to_f64().max(most));
        let weakest = sliding.coulomb / breakaway;
        let per_weakening = if weakest < 1.0 {
            1.0 / (1.0 - weakest)
        } else {
            0.0
        };
        Ok(Self {
            limit: to_scalar("breakaway force", blocks.limit.to_f64() * (1.0 + ROUNDING))?,
            lumped: Lumped {
                springs: core::array::from_fn(|i| Spring {
                    yields: blocks.yields[i],
                    stiffness: blocks.stiffness[i],
                }),
                weakest: to_scalar("Coulomb force", weakest)?,
                per_weakening: to_scalar("Coulomb force", per_weakening)?,
                far: to_scalar("yield displacement", largest * FAR)?,
            },
            sliding: table,
        })
    }
}

impl<const N: usize, S: Float> Friction for LumpedGms<N, S> {
    type Scalar = S;
    type State = LumpedGmsState<N, S>;

    fn at_rest(&self) -> Self::State {
        LumpedGmsState(self.lumped.at_rest())
    }

    #[inline(always)]
    fn step(&self, state: &mut Self::State, motion: Motion<S>) -> S {
        let velocity = motion.velocity;
        self.lumped.step(
            &mut state.0,
            motion.displacement,
            velocity != <S as Scalar>::ZERO,
            || self.sliding.at(velocity),
        )
    }

    fn limit(&self) -> Option<S> {
        Some(self.limit)
    }
}
