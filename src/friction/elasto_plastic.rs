//! The single-state elasto-plastic model: LuGre with a range in which nothing yields.

use super::flow::Flow;
use super::stribeck::Sliding;
use crate::param::{ParamError, Units, at_most, fits, not_negative, to_positive, to_scalar};
use crate::{Friction, LuGre, Motion, Scalar};
use core::f64::consts::FRAC_PI_2;

/// Largest `z_ba` as a share of `F_c/σ0`: a narrower transition would fit between two substeps.
const WIDEST: f64 = 0.9;

/// `dz/dt = v·(1 − α(z, v)·z/z_ss(v))`, `F = σ0·z + σ1·dz/dt`, with `z_ss = s(v)/σ0`.
///
/// Source: P. Dupont, V. Hayward, B. Armstrong and F. Altpeter, *Single state elasto-plastic friction models*, IEEE
/// T-AC 47(5) (2002) 787–792, the paper's reference 19. `α = 0` where the motion unloads (`sgn z ≠ sgn v`) or
/// `|z| ≤ z_ba`, 1 from `z_ss` on, and between them half a period of a sine,
/// `α = ½·(1 + sin(π·(|z| − (z_ss + z_ba)/2)/(z_ss − z_ba)))`, computed as `sin²(π/2·(|z| − z_ba)/(z_ss − z_ba))`.
///
/// Along the direction of motion, with `u = |z|/z_ss`: elastic up to `z_ba` (exact, `u ← u + |dx|/z_ss`), then
/// `du/d|x| = (1 − α·u)/z_ss` by fourth-order steps of at most `z_ss/16`. As in [`LuGre`](crate::LuGre), `dz/dt` is taken
/// from the law with the caller's velocity and a viscous term for sliding is left to be added outside.
///
/// **Limits.** A load whose ripple stays below `σ0·z_ba` does not drift at all, which LuGre's does. Above it, inner
/// loops stay open: there is no non-local memory, and a loop below `z_ba` encloses no area, so that small motion is
/// not damped but by `σ1`. `s(v)` weakens with speed, so that a soft drive sticks and slips.
///
/// ```
/// use preslide::{ElastoPlastic, Friction, Motion, Sliding, Units};
///
/// let none = Sliding::none(0.9);
/// let model: ElastoPlastic = ElastoPlastic::try_new(1e5, 0.0, 5e-6, 0.9, none, Units::SI)?;
/// let mut state = model.at_rest();
/// // A load that stays below the elastic deflection does not drift: there and back leaves nothing.
/// for dx in [4e-6, -4e-6] {
///     model.step(&mut state, Motion::quasi_static(dx));
/// }
/// assert!(model.step(&mut state, Motion::quasi_static(0.0)).abs() < 1e-6);
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ElastoPlastic<S = f32> {
    /// `σ0`, `σ1` and `z_ss(v)`, LuGre's `g(v)`.
    bristle: LuGre<S>,
    /// `z_ba`.
    elastic: S,
    quarter_turn: S,
    flow: Flow<S>,
}

/// What an [`ElastoPlastic`] remembers: the deflection `z`, in the model's unit of length.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ElastoPlasticState<S = f32> {
    deflection: S,
}

impl<S: Scalar> ElastoPlastic<S> {
    /// `stiffness` is `σ0` (N/m or N·m/rad), `damping` is `σ1` (N·s/m or N·m·s/rad), `elastic` is `z_ba` (m or rad), at
    /// most 0.9 of `F_c/σ0`, `breakaway` is `F_s` (N or N·m).
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, out of range, or does not fit `S` in `units`.
    pub fn try_new(
        stiffness: f64,
        damping: f64,
        elastic: f64,
        breakaway: f64,
        sliding: Sliding,
        units: Units,
    ) -> Result<Self, ParamError> {
        let bristle = LuGre::try_new(stiffness, damping, breakaway, sliding, units)?;
        not_negative("elastic deflection z_ba", elastic)?;
        let least = sliding.coulomb / stiffness;
        at_most("elastic deflection z_ba", elastic, WIDEST * least)?;
        fits::<S>("z/z_ss", 2.0 * breakaway / sliding.coulomb)?;
        Ok(Self {
            bristle,
            elastic: to_scalar("elastic deflection z_ba", elastic / units.length)?,
            quarter_turn: to_positive("quarter turn", FRAC_PI_2)?,
            flow: Flow::try_new()?,
        })
    }

    /// `α` at `u = |z|/z_ss ≥ elastic`, with `elastic = z_ba/z_ss` and `per_width = 1/(1 − elastic)`.
    fn yielding(&self, u: S, elastic: S, per_width: S) -> S {
        let place = (u - elastic).mul_input(per_width);
        if place < S::ONE {
            let sine = (self.quarter_turn * place).sin();
            sine * sine
        } else {
            S::ONE
        }
    }
}

impl<S: Scalar> Friction for ElastoPlastic<S> {
    type Scalar = S;
    type State = ElastoPlasticState<S>;

    fn at_rest(&self) -> Self::State {
        ElastoPlasticState {
            deflection: S::ZERO,
        }
    }

    fn step(&self, state: &mut Self::State, motion: Motion<S>) -> S {
        let Motion {
            displacement: dx,
            velocity: v,
        } = motion;
        let [steady, per_steady] = self.bristle.deflection.at(v);
        let elastic = self.elastic.mul_input(per_steady);
        let per_width = (S::ONE - elastic).reciprocal();
        if dx != S::ZERO {
            let direction = if dx > S::ZERO { S::ONE } else { -S::ONE };
            let z = state.deflection.along(direction);
            let free = z.add_input(dx.magnitude());
            let along = if free < self.elastic {
                free
            } else {
                let (start, path) = if z < self.elastic {
                    (self.elastic, free.sub_input(self.elastic))
                } else {
                    (z, dx.magnitude())
                };
                let start = start.mul_input(per_steady);
                let path = path.mul_input(per_steady);
                let u = self.flow.along(start, path, |u| {
                    S::ONE - self.yielding(u, elastic, per_width) * u
                });
                u.mul_input(steady)
            };
            state.deflection = along.limited(self.bristle.largest).along(direction);
        }
        let force = self.bristle.stiffness * state.deflection;
        if self.bristle.damping == S::ZERO {
            return force;
        }
        let direction = if v < S::ZERO { -S::ONE } else { S::ONE };
        let u = state.deflection.along(direction).mul_input(per_steady);
        let slip = if u > elastic {
            self.yielding(u, elastic, per_width).mul_input(u)
        } else {
            S::ZERO
        };
        let rate = v.mul_input(S::ONE.sub_input(slip));
        force.add_input(self.bristle.damping.mul_input(rate))
    }

    fn limit(&self) -> Option<S> {
        self.bristle.limit()
    }
}
