//! Dahl's model (eq. 1): one state, a spring that yields gradually.

use crate::param::{ParamError, Units, at_least, at_most, fits, positive, to_positive, to_scalar};
use crate::{Friction, Motion, Scalar};

/// `dF/dx = σ0·|1 − (F/F_c)·sgn v|ⁿ·sgn(1 − (F/F_c)·sgn v)` (eq. 1).
///
/// With `u = 1 − (F/F_c)·sgn v ∈ [0, 2]`, `κ = σ0/F_c` and `e = n − 1`, eq. (1) reads `du/d|x| = −κ·uⁿ` and is
/// solved exactly over the displacement of a tick:
///
/// `u ← u·(1 + e·κ·|dx|·uᵉ)^(−1/e)`, or `u ← u·exp(−κ·|dx|)` for `n = 1`; `F = F_c·sgn v·(1 − u)`.
///
/// For `n < 1` the bracket reaches zero at a finite displacement, where the force is `F_c`. `|F| ≤ F_c` always.
/// The model has no non-local memory: inner loops do not close (the paper, "Experimental set-up"). An
/// exponent within 1e-4 of 1 is taken as 1; in fixed point `e·κ·|dx|` also needs digits, so let `n` be 1 or
/// differ from 1 by a tenth.
///
/// ```
/// use preslide::{Dahl, Friction, Motion, Units};
///
/// let dahl: Dahl = Dahl::try_new(1e5, 0.9, 1.0, Units::SI)?;
/// let mut state = dahl.at_rest();
/// // 1 µm from rest: a spring of 1e5 N/m, less what slips.
/// let force = dahl.step(&mut state, Motion::quasi_static(1e-6));
/// assert!(force > 0.09 && force < 0.1);
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Dahl<S = f32> {
    coulomb: S,
    per_length: S,
    excess: S,
    root: S,
}

/// What a [`Dahl`] remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DahlState<S = f32> {
    /// `F/F_c` (-).
    share: S,
}

impl<S: Scalar> Dahl<S> {
    /// `stiffness` is `σ0` (N/m or N·m/rad), `coulomb` is `F_c` (N or N·m), `exponent` is `n` (-), 0.1…5.
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, out of range, or does not fit `S` in `units`.
    pub fn try_new(
        stiffness: f64,
        coulomb: f64,
        exponent: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        units.check()?;
        positive("stiffness", stiffness)?;
        positive("Coulomb force", coulomb)?;
        at_least("exponent n", exponent, 0.1)?;
        at_most("exponent n", exponent, 5.0)?;
        // On a reversal at full force, `u = 2`.
        fits::<S>("u on a reversal", 2.0)?;
        let excess = if (exponent - 1.0).abs() < 1e-4 {
            0.0
        } else {
            exponent - 1.0
        };
        let root = if excess == 0.0 { 0.0 } else { -1.0 / excess };
        Ok(Self {
            coulomb: to_positive("Coulomb force", coulomb / units.force)?,
            per_length: to_positive(
                "stiffness over Coulomb force",
                stiffness * units.length / coulomb,
            )?,
            excess: to_scalar("exponent n", excess)?,
            root: to_scalar("exponent 1/(1 - n)", root)?,
        })
    }
}

impl<S: Scalar> Friction for Dahl<S> {
    type Scalar = S;
    type State = DahlState<S>;

    fn at_rest(&self) -> Self::State {
        DahlState { share: S::ZERO }
    }

    /// A share of the Coulomb force, whatever that is.
    fn take_over(&self, _old: &Self, state: &Self::State) -> Self::State {
        state.clone()
    }

    #[inline]
    fn step(&self, state: &mut Self::State, motion: Motion<S>) -> S {
        let dx = motion.displacement;
        if dx != S::ZERO {
            let forward = dx > S::ZERO;
            let along = |value: S| if forward { value } else { -value };
            let u = S::ONE - along(state.share);
            let path = self.per_length.mul_input(dx.magnitude());
            let u = if u <= S::ZERO {
                S::ZERO
            } else if self.excess == S::ZERO {
                u * (-path).exp()
            } else {
                // The bracket less 1, which keeps its digits where the exponent is near 1.
                let growth = self.excess.mul_input(path.mul_input(u.powf(self.excess)));
                if growth > -S::ONE {
                    u.mul_input(self.root.mul_input(growth.ln_1p()).exp())
                } else {
                    S::ZERO
                }
            };
            state.share = along(S::ONE - u).limited(S::ONE);
        }
        self.coulomb * state.share
    }

    fn limit(&self) -> Option<S> {
        Some(self.coulomb)
    }
}
