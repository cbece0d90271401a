//! The Generalized Maxwell-Slip model: N spring-slider blocks in parallel, with sliding dynamics.

use super::stribeck::{Sliding, SpeedTable};
use crate::param::{Block, ParamError, Units, check_blocks, fits, to_positive, unsaturated};
use crate::{Friction, Motion, Scalar};
use core::sync::atomic::{Ordering, compiler_fence};

/// Stiffness and yield displacement of N blocks, in the model's units.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Blocks<const N: usize, S> {
    pub(crate) stiffness: [S; N],
    pub(crate) yields: [S; N],
    /// What |`F`| reaches: every product rounded as the run-time sum rounds it on its wider side.
    pub(crate) limit: S,
}

/// Fills in `k_i` and `D_i`; returns the limit. One function for every N: it is much code, for what runs once.
fn in_units<S: Scalar>(
    blocks: &[Block],
    breakaway: f64,
    units: Units,
    stiffness: &mut [S],
    yields: &mut [S],
) -> Result<S, ParamError> {
    for (i, block) in blocks.iter().enumerate() {
        let of_block = |e: ParamError| e.of_block(i);
        let displacement = block.yield_displacement(breakaway) / units.length;
        // On a reversal from slip a deflection changes by up to 2·D.
        fits::<S>("twice the yield displacement", 2.0 * displacement).map_err(of_block)?;
        yields[i] = to_positive("yield displacement", displacement).map_err(of_block)?;
        stiffness[i] = to_positive("stiffness", block.stiffness * units.length / units.force)
            .map_err(of_block)?;
    }
    // Fixed point products round down, so a negative force reaches further than a positive one.
    let mut reach = S::ZERO;
    for (k, d) in stiffness.iter().zip(yields.iter()) {
        reach = reach.add_input(k.mul_input(-*d));
    }
    unsaturated("breakaway force", reach)
}

impl<const N: usize, S: Scalar> Blocks<N, S> {
    pub(crate) fn try_new(
        blocks: &[Block; N],
        breakaway: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        const { assert!(N > 0, "a Maxwell-slip model needs at least one block") };
        check_blocks(blocks, breakaway, units)?;
        let mut stiffness = [S::ZERO; N];
        let mut yields = [S::ZERO; N];
        let limit = in_units(blocks, breakaway, units, &mut stiffness, &mut yields)?;
        Ok(Self {
            stiffness,
            yields,
            limit,
        })
    }

    /// `F = Σ k_i·z_i` (eq. 12).
    #[inline]
    pub(crate) fn force(&self, deflection: &[S; N]) -> S {
        let mut force = S::ZERO;
        for (k, z) in self.stiffness.iter().zip(deflection) {
            force = force + *k * *z;
        }
        force
    }
}

/// The full GMS law (eqs. 10–12) at a fixed sample time: the parameters.
///
/// Each block keeps its deflection `z_i` and sticks or slips; with `D_i = α_i·F_s/k_i`,
/// `σ(v) = s(v)/F_s ∈ [F_c/F_s, 1]` and `dir` the direction of motion:
///
/// - sticking (10): `z_i ← z_i + dx`; the block slips from `dir·z_i ≥ D_i·σ(v)` on;
/// - slipping (11): `dir·z_i ← dir·z_i + λ(v)·(D_i·σ(v) − dir·z_i)`, `λ(v) = 1 − exp(−C·T_s/s(v))`;
/// - on a reversal of the displacement every slipping block sticks again;
/// - `F = Σ k_i·z_i` (12).
///
/// **Where the paper is ambiguous or wrong.** (a) Eq. (11) with a positive `s` is unstable for `v < 0`; it is
/// read as `dF_i/dt = C·(sgn(v)·α_i − F_i/s(|v|))`, which is the published law for `v > 0` and odd in `v`.
/// (b) The text gives no way back from slip to stick. As printed, a block that slipped never sticks again (it wedges at
/// the first reversal; `preslide reproduce` shows it); read as in (a) it first slips back, in time and not in
/// displacement. Al-Bender, Lampaert and Swevers (IEEE T-AC 50(11), 2005)
/// have it stick when the velocity crosses zero, and so does this. A tick without motion is no crossing:
/// with a quantised encoder most ticks of a slow slide have none. (c) "|F_i| < |W_i|" is tested in the
/// direction of motion only: a block that unloads sticks even where a rising speed has lowered its limit
/// below the force it still carries. (d) The law is discontinuous: a block that comes back to exactly its limit,
/// as happens in encoder counts, slips or sticks by the last bit, and while the limit then rises the one lags
/// where the other follows the motion. Two arithmetics can so differ for some ticks by up to `α_i·(F_s − F_c)`.
///
/// The discretisation of (11) is its exact solution for a speed that is constant over the tick, so it is
/// stable for every `C·T_s ≥ 0` (`C = ∞` means no lag), and `|z_i| ≤ D_i` always, hence `|F| ≤ ΣW`
/// ([`Friction::limit`]) even for NaN or infinite input.
///
/// `N ≤ 32` blocks, arithmetic `S` (`f32` unless chosen otherwise). Accepts every model whose `k_i`, `2·D_i` and `ΣW_i` in
/// `units` fit `S`: in `f32` any machine's, in `I16F16` `D_i` up to 16 383 units of length and `ΣW_i` up to 32 767 of force.
///
/// ```
/// use preslide::{Block, Friction, Gms, Motion, Sliding, Units};
/// // Table 3, three blocks, with 10 % Stribeck effect.
/// let blocks = [(325_379.0, 0.352), (40_535.0, 0.307), (7_886.0, 0.341)]
///     .map(|(stiffness, weight)| Block { stiffness, weight });
/// let sliding = Sliding { coulomb: 0.81, stribeck_velocity: 1e-3, stribeck_exponent: 2.0, attraction: 20.0 };
/// let gms = Gms::<3>::try_new(&blocks, 0.9, sliding, 50e-6, Units::SI)?;
/// let mut state = gms.at_rest();
/// let force = gms.step(&mut state, Motion { displacement: 1e-7, velocity: 2e-3 });
/// assert!((force - 0.0374).abs() < 1e-4);
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Gms<const N: usize, S = f32> {
    blocks: Blocks<N, S>,
    /// `σ(v)` and `λ(v)`.
    sliding: SpeedTable<S>,
}

/// What a [`Gms`] remembers.
///
/// The deflections are kept along the direction of motion and the flags as bits, one word for all blocks: a block
/// then costs two comparisons, whichever way the body moves.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GmsState<const N: usize, S = f32> {
    along: [S; N],
    slipping: u32,
    /// 1 forward, −1 backward.
    direction: S,
}

impl<const N: usize, S: Scalar> Gms<N, S> {
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
        let blocks = Blocks::try_new(blocks, breakaway, units)?;
        let sliding = SpeedTable::of_law(&sliding, breakaway, sample_time, units)?;
        Ok(Self { blocks, sliding })
    }

    /// The yield displacements `D_i`, in the model's units.
    pub fn yields(&self) -> &[S; N] {
        &self.blocks.yields
    }
}

impl<const N: usize, S: Scalar> GmsState<N, S> {
    /// The blocks' deflections `z_i`, in the model's units.
    pub fn deflection(&self) -> [S; N] {
        self.along.map(|z| z.along(self.direction))
    }

    /// Which blocks slip.
    pub fn slipping(&self) -> [bool; N] {
        core::array::from_fn(|i| self.slipping >> i & 1 == 1)
    }
}

impl<const N: usize, S: Scalar> Friction for Gms<N, S> {
    type Scalar = S;
    type State = GmsState<N, S>;

    fn at_rest(&self) -> Self::State {
        const { assert!(N <= 32, "the slip flags of at most 32 blocks fit one word") };
        GmsState {
            along: [S::ZERO; N],
            slipping: 0,
            direction: S::ONE,
        }
    }

    fn take_over(&self, old: &Self, state: &Self::State) -> Self::State {
        if self == old {
            return state.clone();
        }
        // A block that now yields earlier slips from its new limit on; one that yields later sticks again.
        let mut along = state.along;
        for (z, bound) in along.iter_mut().zip(&self.blocks.yields) {
            *z = z.limited(*bound);
        }
        GmsState {
            along,
            slipping: 0,
            direction: state.direction,
        }
    }

    #[inline(always)]
    fn step(&self, state: &mut Self::State, motion: Motion<S>) -> S {
        let dx = motion.displacement;
        let mut advance = dx.along(state.direction);
        // The ordinary tick first: it then takes one comparison.
        if !(advance > S::ZERO) {
            if advance != S::ZERO {
                state.direction = -state.direction;
                state.slipping = 0;
                state.along = state.along.map(|z| -z);
                advance = dx.magnitude();
            } else if motion.velocity == S::ZERO {
                return self.blocks.force(&state.along).along(state.direction);
            }
        }
        let [weakening, lag] = self.sliding.at(motion.velocity);
        let mut slipping = state.slipping;
        let mut force = S::ZERO;
        // One block behind: the compiler then multiplies and adds, one cycle each, where a multiply-accumulate takes
        // three on a Cortex-M4.
        let mut product = S::ZERO;
        for i in 0..N {
            let bound = self.blocks.yields[i] * weakening;
            let mut z = state.along[i];
            if slipping >> i & 1 == 1 {
                z = z + lag * (bound - z);
            } else {
                z = z.add_input(advance);
                if !(z < bound) {
                    slipping |= 1 << i;
                    // Read again rather than kept, which would cost every sticking block a copy.
                    compiler_fence(Ordering::SeqCst);
                    let old = state.along[i];
                    z = if old < bound {
                        bound
                    } else {
                        old + lag * (bound - old)
                    };
                }
            }
            state.along[i] = z;
            force = if i > 1 { force + product } else { product };
            product = self.blocks.stiffness[i] * z;
        }
        force = force + product;
        state.slipping = slipping;
        force.along(state.direction)
    }

    fn limit(&self) -> Option<S> {
        Some(self.blocks.limit)
    }
}
