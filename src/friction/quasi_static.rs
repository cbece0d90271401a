//! The Maxwell-slip model without sliding dynamics: `F_s = F_c`, exact for any displacement step.

use super::gms::Blocks;
use crate::param::{Block, ParamError, Units};
use crate::{Friction, Motion, Scalar};

/// Quasi-static GMS: eqs. (10) and (12) with a constant limit, `W_i = α_i·F_s`.
///
/// `z_i ← clamp(z_i + dx, −D_i, D_i)`, `F = Σ k_i·z_i`, with `D_i = α_i·F_s/k_i`.
///
/// The clamp is the exact solution for any displacement step that does not turn back within the tick, however
/// large; velocity and time do not enter (rate independence). `N` blocks, arithmetic `S`. Accepts every model whose `k_i`,
/// `2·D_i` and `ΣW_i` in `units` fit `S`: in `f32` any machine's, in `I16F16` `D_i` up to 16 383 units of length and `ΣW_i` up
/// to 32 767 of force.
///
/// ```
/// use preslide::{Block, Friction, Motion, QuasiStaticGms, Units};
/// let blocks = [Block { stiffness: 113_948.0, weight: 0.616 }, Block { stiffness: 8_870.0, weight: 0.384 }];
/// let gms = QuasiStaticGms::<2, f64>::try_new(&blocks, 0.9, Units::SI)?;
/// let mut state = gms.at_rest();
/// let force = gms.step(&mut state, Motion::quasi_static(1e-3));
/// assert!((force - 0.9).abs() < 1e-12); // every block slips: the breakaway force
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct QuasiStaticGms<const N: usize, S = f32> {
    blocks: Blocks<N, S>,
}

/// What a [`QuasiStaticGms`] remembers: the deflections `z_i`, in the model's units.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct QuasiStaticState<const N: usize, S = f32> {
    deflection: [S; N],
}

impl<const N: usize, S: Scalar> QuasiStaticGms<N, S> {
    /// Validates the parameters; `breakaway` is `F_s` (N or N·m).
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite or not positive, the weights do not sum to 1, or a value or
    /// a bound on the state does not fit `S` in `units`.
    pub fn try_new(blocks: &[Block; N], breakaway: f64, units: Units) -> Result<Self, ParamError> {
        Ok(Self {
            blocks: Blocks::try_new(blocks, breakaway, units)?,
        })
    }
}

impl<const N: usize, S: Scalar> Friction for QuasiStaticGms<N, S> {
    type Scalar = S;
    type State = QuasiStaticState<N, S>;

    fn at_rest(&self) -> Self::State {
        QuasiStaticState {
            deflection: [S::ZERO; N],
        }
    }

    /// The blocks keep their deflections, as far as they yield no earlier now.
    fn take_over(&self, _old: &Self, state: &Self::State) -> Self::State {
        let mut kept = state.clone();
        for (z, d) in kept.deflection.iter_mut().zip(&self.blocks.yields) {
            *z = z.limited(*d);
        }
        kept
    }

    #[inline]
    fn step(&self, state: &mut Self::State, motion: Motion<S>) -> S {
        for (z, d) in state.deflection.iter_mut().zip(&self.blocks.yields) {
            *z = z.add_input(motion.displacement).limited(*d);
        }
        self.blocks.force(&state.deflection)
    }

    fn limit(&self) -> Option<S> {
        Some(self.blocks.limit)
    }
}
