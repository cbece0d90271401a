//! The LuGre model (eqs. 2–3): bristles with an average deflection.

use super::stribeck::{Sliding, SpeedTable};
use crate::param::{
    ParamError, Units, fits, not_negative, positive, to_positive, to_scalar, unsaturated,
};
use crate::{Friction, Motion, Scalar};

/// `dz/dt = v − z·(σ0/s(v))·|v|` (eq. 2), `F = σ0·z + σp·dz/dt` (eq. 3).
///
/// With `g = s(v)/σ0` the deflection is solved exactly for a speed that is constant over the tick, which is
/// stable at any speed:
///
/// `z ← sgn(dx)·g + (z − sgn(dx)·g)·exp(−|dx|/g)`.
///
/// `dz/dt` is eq. (2) evaluated at the end of the tick with the caller's velocity estimate: differencing `z`
/// would turn one 25 nm count at 20 kHz into 0.5 mm/s, 2.2 N with the paper's `σp`. Eq. (3) has no viscous term
/// for sliding; add one outside if the machine needs it. The Stribeck curve is that of [`Sliding`]; its
/// attraction parameter is not used here. Inner loops do not close (no non-local memory).
///
/// ```
/// use preslide::{Friction, LuGre, Motion, Sliding, Units};
///
/// let sliding = Sliding { coulomb: 0.7, stribeck_velocity: 1e-3, stribeck_exponent: 2.0, attraction: 1.0 };
/// let lugre: LuGre = LuGre::try_new(1e5, 0.0, 0.9, sliding, Units::SI)?;
/// let mut state = lugre.at_rest();
/// let slow = Motion { displacement: 1e-3, velocity: 1e-5 };
/// let fast = Motion { displacement: 1e-3, velocity: 1e-2 };
/// // Slow sliding takes the breakaway force, fast sliding Coulomb's.
/// assert!((lugre.step(&mut state, slow) - 0.9).abs() < 1e-3);
/// assert!((lugre.step(&mut state, fast) - 0.7).abs() < 1e-3);
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LuGre<S = f32> {
    pub(crate) stiffness: S,
    pub(crate) damping: S,
    pub(crate) largest: S,
    /// What |`σ0·z`| reaches.
    limit: S,
    /// `g(v)` and `1/g(v)`.
    pub(crate) deflection: SpeedTable<S>,
}

/// What a [`LuGre`] remembers: the average deflection `z`, in the model's unit of length.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LuGreState<S = f32> {
    deflection: S,
}

impl<S: Scalar> LuGre<S> {
    /// `stiffness` is `σ0` (N/m or N·m/rad), `damping` is `σp` (N·s/m or N·m·s/rad), `breakaway` is `F_s`
    /// (N or N·m).
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, out of range, or does not fit `S` in `units`.
    pub fn try_new(
        stiffness: f64,
        damping: f64,
        breakaway: f64,
        sliding: Sliding,
        units: Units,
    ) -> Result<Self, ParamError> {
        units.check()?;
        positive("stiffness", stiffness)?;
        not_negative("damping", damping)?;
        positive("breakaway force", breakaway)?;
        sliding.check(breakaway)?;
        let largest = breakaway / stiffness / units.length;
        fits::<S>("twice the largest deflection", 2.0 * largest)?;
        let scaled_stiffness: S = to_positive("stiffness", stiffness * units.length / units.force)?;
        let scaled_largest: S = to_positive("largest deflection", largest)?;
        // Fixed point products round down, so a negative force reaches further than a positive one.
        let reach = scaled_stiffness.mul_input(-scaled_largest);
        Ok(Self {
            stiffness: scaled_stiffness,
            damping: to_scalar("damping", damping * units.velocity / units.force)?,
            largest: scaled_largest,
            limit: unsaturated("breakaway force", reach)?,
            deflection: SpeedTable::try_new(
                &sliding,
                breakaway,
                units.velocity,
                ["deflection at steady sliding", "its reciprocal"],
                |weakening| [largest * weakening, 1.0 / (largest * weakening)],
            )?,
        })
    }
}

impl<S: Scalar> Friction for LuGre<S> {
    type Scalar = S;
    type State = LuGreState<S>;

    fn at_rest(&self) -> Self::State {
        LuGreState {
            deflection: S::ZERO,
        }
    }

    /// The bristles keep their deflection, as far as it fits.
    fn take_over(&self, _old: &Self, state: &Self::State) -> Self::State {
        LuGreState {
            deflection: state.deflection.limited(self.largest),
        }
    }

    #[inline]
    fn step(&self, state: &mut Self::State, motion: Motion<S>) -> S {
        let Motion {
            displacement: dx,
            velocity: v,
        } = motion;
        let [steady, per_steady] = self.deflection.at(v);
        if dx != S::ZERO {
            let end = if dx > S::ZERO { steady } else { -steady };
            let decay = (-per_steady.mul_input(dx.magnitude())).exp();
            let z = end + (state.deflection - end) * decay;
            state.deflection = z.limited(self.largest);
        }
        let elastic = self.stiffness * state.deflection;
        if self.damping == S::ZERO {
            return elastic;
        }
        let strain = state.deflection.mul_input(per_steady);
        let rate = v.sub_input(v.magnitude().mul_input(strain));
        elastic.add_input(self.damping.mul_input(rate))
    }

    fn limit(&self) -> Option<S> {
        (self.damping == S::ZERO).then_some(self.limit)
    }
}
