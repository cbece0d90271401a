//! Friction that is higher in one direction.

use super::{Bounds, Effect, Situation, level};
use crate::Scalar;
use crate::param::ParamError;

/// `coulomb_asymmetry`: `m = 1 + a·sgn F`, with `F` the friction model's force.
///
/// In sliding `sgn F = sgn v`. In pre-sliding the sign of the force is used and not that of the velocity, because the
/// force would otherwise jump by `2·a·F` at every reversal; this way it passes through zero.
#[derive(Clone, Debug, PartialEq)]
pub struct CoulombAsymmetry<S = f32> {
    asymmetry: S,
}

impl<S: Scalar> CoulombAsymmetry<S> {
    /// `asymmetry` is `a` (-): positive where friction in +x is the higher one; −1…1.
    ///
    /// # Errors
    /// [`ParamError`] where it is not in that range.
    pub fn try_new(asymmetry: f64) -> Result<Self, ParamError> {
        crate::param::at_most("friction asymmetry", asymmetry.abs(), 1.0)?;
        Ok(Self {
            asymmetry: level("friction asymmetry", asymmetry)?,
        })
    }
}

impl<S: Scalar> Effect<S> for CoulombAsymmetry<S> {
    type State = ();
    const LEVEL: bool = true;

    fn at_rest(&self) {}

    #[inline]
    fn level(&self, _state: &mut (), at: &Situation<S>) -> S {
        if at.friction > S::ZERO {
            self.asymmetry
        } else if at.friction < S::ZERO {
            -self.asymmetry
        } else {
            S::ZERO
        }
    }

    fn bounds(&self) -> Bounds<S> {
        Bounds::of_level(self.asymmetry.magnitude())
    }
}
