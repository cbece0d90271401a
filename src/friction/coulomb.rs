//! Coulomb and viscous friction: the baseline that knows nothing of pre-sliding.

use crate::param::{ParamError, Units, not_negative, to_scalar};
use crate::{Friction, Motion, Scalar};

/// `F = F_c·sgn(v) + b·v`, with `sgn(0) = 0`.
///
/// Without memory: it says nothing at standstill, which is the case the other models exist for.
///
/// ```
/// use preslide::{Coulomb, Friction, Motion, Units};
///
/// let coulomb: Coulomb = Coulomb::try_new(0.9, 20.0, Units::SI)?;
/// let mut state = coulomb.at_rest();
/// // 10 mm/s forward: 0.9 N, and 0.2 N for the speed.
/// let force = coulomb.step(&mut state, Motion { displacement: 1e-6, velocity: 0.01 });
/// assert!((force - 1.1).abs() < 1e-6);
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Coulomb<S = f32> {
    coulomb: S,
    viscous: S,
}

impl<S: Scalar> Coulomb<S> {
    /// `coulomb` is `F_c` (N or N·m), `viscous` is `b` (N·s/m or N·m·s/rad).
    ///
    /// # Errors
    /// [`ParamError`] where a value is negative, not finite, or does not fit `S` in `units`.
    pub fn try_new(coulomb: f64, viscous: f64, units: Units) -> Result<Self, ParamError> {
        units.check()?;
        Ok(Self {
            coulomb: to_scalar(
                "Coulomb force",
                not_negative("Coulomb force", coulomb)? / units.force,
            )?,
            viscous: to_scalar(
                "viscous coefficient",
                not_negative("viscous coefficient", viscous)? * units.velocity / units.force,
            )?,
        })
    }
}

impl<S: Scalar> Friction for Coulomb<S> {
    type Scalar = S;
    type State = ();

    fn at_rest(&self) {}

    #[inline]
    fn step(&self, _state: &mut (), motion: Motion<S>) -> S {
        let v = motion.velocity;
        let dry = if v > S::ZERO {
            self.coulomb
        } else if v < S::ZERO {
            -self.coulomb
        } else {
            S::ZERO
        };
        if self.viscous == S::ZERO {
            return dry; // 0·∞ is NaN
        }
        dry.add_input(self.viscous.mul_input(v))
    }

    fn limit(&self) -> Option<S> {
        (self.viscous == S::ZERO).then_some(self.coulomb)
    }
}
