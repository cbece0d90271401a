//! The two-state elasto-plastic model: a branch from the last reversal, and a level that lags.

use super::stribeck::{Sliding, SpeedTable};
use crate::param::{ParamError, Units, at_most, fits, positive, to_positive, unsaturated};
use crate::{Friction, Motion, Scalar};

/// `F = F_r + (sgn(v)·w − F_r)·f0(ζ)`, `f0 = ζ·(1 − ln ζ)` for `ζ = |x − x_r|/s < 1`, else 1: two states, `ζ` and the
/// level `w`.
///
/// From the last reversal `(x_r, F_r)` the force rises over the pre-sliding distance `s` to the level `w` of sliding,
/// along the curve of T. Koizumi and H. Shibasaki (Wear 93 (1984) 281–290) that M. Ruderman uses for hysteretic
/// pre-sliding; the level follows the Stribeck curve with a lag, `dw/dt = C·(1 − w/s(v))`, solved exactly for a
/// speed that is constant over a tick: `w ← w + λ(v)·(s(v) − w)`, `λ = 1 − exp(−C·T_s/s(v))`, as in [`Gms`](crate::Gms).
///
/// Source: after M. Ruderman and T. Bertram, *Two-state dynamic friction model with elasto-plasticity*, Mech. Syst.
/// Signal Process. 39 (2013) 316–322, the paper's reference 12. **That article was not at hand**: the branch is the one
/// of Ruderman's later work, the lag is that of GMS, and the parameters are named here. Take results for what this
/// recurrence does, not for a verdict on the article.
///
/// **Limits.** Only the last reversal is remembered, which is what the paper calls vague: an inner loop ends on a
/// branch of its own and stays open, and a ripple on a load drifts. `df0/dζ = −ln ζ` is infinite at a reversal, so no
/// stiffness can be given and a small motion feels stiffer the smaller it is. `|F| ≤ F_s` always.
///
/// ```
/// use preslide::{Friction, Motion, Sliding, TwoState, Units};
///
/// let sliding = Sliding { coulomb: 0.9, stribeck_velocity: 1e-3, stribeck_exponent: 2.0, attraction: 1.0 };
/// let model: TwoState = TwoState::try_new(10e-6, 0.9, sliding, 50e-6, Units::SI)?;
/// let mut state = model.at_rest();
/// // A branch ends where its pre-sliding distance does, at the breakaway force.
/// let mut force = 0.0;
/// for _ in 0..20 {
///     force = model.step(&mut state, Motion { displacement: 1e-6, velocity: 0.02 });
/// }
/// assert!((force - 0.9).abs() < 1e-2);
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TwoState<S = f32> {
    breakaway: S,
    per_distance: S,
    /// `s(v)` and `λ(v)`.
    level: SpeedTable<S>,
}

/// What a [`TwoState`] remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TwoStateMemory<S = f32> {
    /// `ζ`, at most 1.
    travelled: S,
    /// `w`.
    level: S,
    /// `F_r`.
    start: S,
    force: S,
    /// 1 forward, −1 backward.
    direction: S,
}

impl<S: Scalar> TwoState<S> {
    /// `distance` is `s` (m or rad), `breakaway` is `F_s` (N or N·m), `sample_time` is `T_s` (s), at most 1 s.
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, out of range, or does not fit `S` in `units`.
    pub fn try_new(
        distance: f64,
        breakaway: f64,
        sliding: Sliding,
        sample_time: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        units.check()?;
        positive("pre-sliding distance", distance)?;
        positive("breakaway force", breakaway)?;
        sliding.check(breakaway)?;
        positive("sample time", sample_time)?;
        at_most("sample time", sample_time, 1.0)?;
        let strongest = breakaway / units.force;
        // On a reversal from slip the force has 2·F_s to go.
        fits::<S>("twice the breakaway force", 2.0 * strongest)?;
        fits::<S>("one", 2.0)?;
        let relaxation = sliding.attraction * sample_time / breakaway;
        let breakaway_scaled: S = to_positive("breakaway force", strongest)?;
        Ok(Self {
            breakaway: unsaturated("breakaway force", breakaway_scaled)?,
            per_distance: to_positive("reciprocal of the distance", units.length / distance)?,
            level: SpeedTable::try_new(
                &sliding,
                breakaway,
                units.velocity,
                ["force at steady sliding", "lag per tick"],
                |weakening| [strongest * weakening, -libm::expm1(-relaxation / weakening)],
            )?,
        })
    }
}

impl<S: Scalar> Friction for TwoState<S> {
    type Scalar = S;
    type State = TwoStateMemory<S>;

    fn at_rest(&self) -> Self::State {
        TwoStateMemory {
            travelled: S::ZERO,
            level: self.breakaway,
            start: S::ZERO,
            force: S::ZERO,
            direction: S::ONE,
        }
    }

    fn step(&self, state: &mut Self::State, motion: Motion<S>) -> S {
        let dx = motion.displacement;
        if dx == S::ZERO && motion.velocity == S::ZERO {
            return state.force;
        }
        let [steady, lag] = self.level.at(motion.velocity);
        state.level = (state.level + lag * (steady - state.level)).limited(self.breakaway);
        let mut advance = dx.along(state.direction);
        if advance < S::ZERO {
            state.direction = -state.direction;
            state.start = state.force;
            state.travelled = S::ZERO;
            advance = dx.magnitude();
        }
        let travelled = state
            .travelled
            .add_input(self.per_distance.mul_input(advance));
        // NaN counts as far.
        state.travelled = if travelled < S::ONE {
            travelled
        } else {
            S::ONE
        };
        if state.travelled == S::ZERO {
            return state.force;
        }
        let share = if state.travelled < S::ONE {
            state.travelled * (S::ONE - state.travelled.ln())
        } else {
            S::ONE
        };
        let gap = state.level.along(state.direction) - state.start;
        state.force = (state.start + gap * share.limited(S::ONE)).limited(self.breakaway);
        state.force
    }

    fn limit(&self) -> Option<S> {
        Some(self.breakaway)
    }
}
