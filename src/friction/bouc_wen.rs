//! The Bouc-Wen model: one state, with a shape of its own on loading and on unloading.

use super::flow::Flow;
use crate::param::{ParamError, Units, at_least, at_most, fits, positive, to_positive, to_scalar};
use crate::{Friction, Motion, Scalar};

/// `dz/dt = v − β·|v|·|z|ⁿ⁻¹·z − γ·v·|z|ⁿ`, `F = σ0·z`: Bouc-Wen without a spring beside it.
///
/// Source: M. Ismail, F. Ikhouane and J. Rodellar, *The hysteresis Bouc-Wen model, a survey*, Arch. Comput. Methods
/// Eng. 16 (2009) 161–188, the paper's reference 15, in its normalised form: with `F_c = σ0·(β + γ)^(−1/n)`,
/// `σ = β/(β + γ)` and `u = sgn(v)·F/F_c`, `κ = σ0/F_c`,
///
/// `du/d|x| = κ·(1 − uⁿ)` while loading (`u ≥ 0`), `κ·(1 + (2σ − 1)·|u|ⁿ)` while unloading (`u < 0`),
///
/// integrated along the displacement of a tick by fourth-order steps of at most 1/16 of `1/κ`; a tick within that
/// takes one step, four powers. `|F| ≤ F_c` always. The spring `α·k·x` of the full model is elasticity, not
/// friction: add it outside.
///
/// **Limits.** `σ = 1`, `n = 1` is Dahl's model with `n = 1`. Rate-independent: no Stribeck effect, so no stick-slip.
/// No non-local memory: inner loops stay open and a ripple on a load drifts. `n` is 1…20 and `σ` 1/2…2: below 1/2 the
/// model produces energy (the survey, section 5), beyond 2 it unloads at more than four times its own stiffness.
///
/// ```
/// use preslide::{BoucWen, Friction, Motion, Units};
///
/// let bouc_wen: BoucWen = BoucWen::try_new(1e5, 0.9, 2.0, 1.0, Units::SI)?;
/// let mut state = bouc_wen.at_rest();
/// bouc_wen.step(&mut state, Motion::quasi_static(1e-3));
/// // Back from sliding, each micrometre takes off twice its stiffness.
/// let force = bouc_wen.step(&mut state, Motion::quasi_static(-1e-6));
/// assert!(force > 0.69 && force < 0.73);
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BoucWen<S = f32> {
    coulomb: S,
    per_length: S,
    exponent: S,
    /// `2σ − 1`.
    unloading: S,
    flow: Flow<S>,
}

/// What a [`BoucWen`] remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BoucWenState<S = f32> {
    /// `F/F_c` (-).
    share: S,
}

impl<S: Scalar> BoucWen<S> {
    /// `stiffness` is `σ0` (N/m or N·m/rad), `coulomb` is `F_c` (N or N·m), `exponent` is `n` (-), 1…20, `shape` is
    /// `σ` (-), 0.5…2.
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, out of range, or does not fit `S` in `units`.
    pub fn try_new(
        stiffness: f64,
        coulomb: f64,
        exponent: f64,
        shape: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        units.check()?;
        positive("stiffness", stiffness)?;
        positive("Coulomb force", coulomb)?;
        at_least("exponent n", exponent, 1.0)?;
        at_most("exponent n", exponent, 20.0)?;
        at_least("shape sigma", shape, 0.5)?;
        at_most("shape sigma", shape, 2.0)?;
        fits::<S>("exponent n", exponent)?;
        Ok(Self {
            coulomb: to_positive("Coulomb force", coulomb / units.force)?,
            per_length: to_positive(
                "stiffness over Coulomb force",
                stiffness * units.length / coulomb,
            )?,
            exponent: to_scalar("exponent n", exponent)?,
            unloading: to_scalar("shape sigma", 2.0 * shape - 1.0)?,
            flow: Flow::try_new()?,
        })
    }
}

impl<S: Scalar> Friction for BoucWen<S> {
    type Scalar = S;
    type State = BoucWenState<S>;

    fn at_rest(&self) -> Self::State {
        BoucWenState { share: S::ZERO }
    }

    /// A share of the Coulomb force, whatever that is.
    fn take_over(&self, _old: &Self, state: &Self::State) -> Self::State {
        state.clone()
    }

    fn step(&self, state: &mut Self::State, motion: Motion<S>) -> S {
        let dx = motion.displacement;
        if dx != S::ZERO {
            let direction = if dx > S::ZERO { S::ONE } else { -S::ONE };
            let path = self.per_length.mul_input(dx.magnitude());
            let u = self.flow.along(state.share.along(direction), path, |u| {
                let power = u.magnitude().powf(self.exponent);
                if u < S::ZERO {
                    S::ONE + self.unloading * power
                } else {
                    S::ONE - power
                }
            });
            state.share = u.limited(S::ONE).along(direction);
        }
        self.coulomb * state.share
    }

    fn limit(&self) -> Option<S> {
        Some(self.coulomb)
    }
}
