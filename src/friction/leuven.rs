//! The Leuven model: a hysteresis with non-local memory, driven by a state that slips like LuGre's.

use super::flow::{Flow, MOST_SUBSTEPS};
use super::gms::Blocks;
use super::hsieh::REVERSALS;
use super::stribeck::{Sliding, SpeedTable};
use crate::param::{Block, ParamError, Units, at_least, at_most, fits, not_negative, to_scalar};
use crate::{Friction, Motion, Scalar};

/// Which state equation a [`Leuven`] has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LeuvenForm {
    /// Swevers et al. (2000): relative to the force `F_b` of the last reversal that is not wiped out. `dz/dt`, and with
    /// it the force, jumps where an inner loop closes, because `F_b` does.
    Original,
    /// Lampaert et al. (2002): relative to the whole force. No jump.
    Modified,
}

/// `F = F_h(z) + σ1·dz/dt`, `dz/dt = v·(1 − sgn(u)·|u|ⁿ)`, with `u = F_h/(sgn(v)·s(v))` (modified) or
/// `u = (F_h − F_b)/(sgn(v)·s(v) − F_b)` (original).
///
/// Source: J. Swevers, F. Al-Bender, C. Ganseman and T. Prajogo, *An integrated friction model structure with improved
/// presliding behavior for accurate friction compensation*, IEEE T-AC 45(4) (2000) 675–686, the paper's reference 13;
/// V. Lampaert, J. Swevers and F. Al-Bender, *Modification of the Leuven integrated friction model structure*, IEEE
/// T-AC 47(4) (2002) 683–687. `F_h` is in both forms the later article's Maxwell-slip sum over `z`,
/// `z_i ← clamp(z_i + dz, −D_i, D_i)`, `F_h = Σ k_i·z_i`; `F_b` is kept beside it, 0 on the virgin curve.
///
/// Along the direction of motion, with `K` the stiffness of the blocks that stick and `S` the denominator of `u`:
/// `du/d|x| = (K/S)·(1 − sgn(u)·|u|ⁿ)` by fourth-order steps of at most `S/(16·K)`, from one yield or closure to the
/// next. As in [`LuGre`](crate::LuGre), `dz/dt` in the force is taken from the law with the caller's velocity and a viscous
/// term for sliding is left to be added outside.
///
/// **Limits.** Loops close in `z`. In `x` they close only as far as `|u|ⁿ` vanishes: a loop under load is travelled at
/// `1 + |u|ⁿ` downward and `1 − |u|ⁿ` upward, so it creeps along, less the larger `n`. Where a rising speed lowers
/// `s(v)` below `F_h`, `z` runs backward against the stiffness of every block: the force falls, and `F_h` then lies on
/// an inner branch. The original form is undefined where `s(v)` does not exceed `F_b`; `z` then stands still. More than
/// [`REVERSALS`] nested reversals forget the oldest pair of `F_b`, never the blocks.
///
/// `N ≤ 32` blocks. For identification and comparison on the host: a step costs at least four powers. Computed
/// in floats; fixed point saturates.
///
/// ```
/// use preslide::{Block, Friction, Leuven, LeuvenForm, Motion, Sliding, Units};
///
/// let blocks = [Block { stiffness: 1e5, weight: 0.6 }, Block { stiffness: 1e4, weight: 0.4 }];
/// let none = Sliding::none(0.9);
/// let leuven = Leuven::<2>::try_new(LeuvenForm::Modified, &blocks, 0.9, 10.0, 0.0, none, Units::SI)?;
/// let mut state = leuven.at_rest();
/// // 1 µm from rest: both blocks.
/// let force = leuven.step(&mut state, Motion { displacement: 1e-6, velocity: 1e-5 });
/// assert!((force - 0.11).abs() < 1e-3);
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Leuven<const N: usize, S = f32> {
    blocks: Blocks<N, S>,
    exponent: S,
    damping: S,
    /// `s(v)` and its reciprocal.
    strength: SpeedTable<S>,
    flow: Flow<S>,
    form: LeuvenForm,
}

/// What a [`Leuven`] remembers: the blocks' deflections, and the forces at the reversals for `F_b`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LeuvenState<const N: usize, S = f32> {
    deflection: [S; N],
    /// `F_h`.
    force: S,
    /// 1 forward, −1 backward.
    direction: S,
    moved: bool,
    /// `F_b` of the branches, the virgin curve's 0 first.
    reversals: [S; REVERSALS],
    count: usize,
}

/// One tick's direction and the law's constants there.
#[derive(Clone, Copy)]
struct Branch<S> {
    direction: S,
    /// `sgn(v)·F_b`.
    base: S,
    /// `s − sgn(v)·F_b`.
    span: S,
    per_span: S,
}

impl<const N: usize, S: Scalar> Leuven<N, S> {
    /// `breakaway` is `F_s` (N or N·m), `exponent` is `n` (-), 1…20, `damping` is `σ1` (N·s/m or N·m·s/rad).
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, out of range, or does not fit `S` in `units`.
    pub fn try_new(
        form: LeuvenForm,
        blocks: &[Block; N],
        breakaway: f64,
        exponent: f64,
        damping: f64,
        sliding: Sliding,
        units: Units,
    ) -> Result<Self, ParamError> {
        let blocks = Blocks::try_new(blocks, breakaway, units)?;
        sliding.check(breakaway)?;
        at_least("exponent n", exponent, 1.0)?;
        at_most("exponent n", exponent, 20.0)?;
        not_negative("damping", damping)?;
        fits::<S>("exponent n", exponent)?;
        let strongest = breakaway / units.force;
        fits::<S>("twice the breakaway force", 2.0 * strongest)?;
        Ok(Self {
            blocks,
            exponent: to_scalar("exponent n", exponent)?,
            damping: to_scalar("damping", damping * units.velocity / units.force)?,
            strength: SpeedTable::try_new(
                &sliding,
                breakaway,
                units.velocity,
                ["force at steady sliding", "its reciprocal"],
                |weakening| [strongest * weakening, 1.0 / (strongest * weakening)],
            )?,
            flow: Flow::try_new()?,
            form,
        })
    }

    /// The branch on which the force now is; `None` where the original form has no `u`.
    fn branch(
        &self,
        state: &LeuvenState<N, S>,
        [strength, per_strength]: [S; 2],
    ) -> Option<Branch<S>> {
        let direction = state.direction;
        match self.form {
            LeuvenForm::Modified => Some(Branch {
                direction,
                base: S::ZERO,
                span: strength,
                per_span: per_strength,
            }),
            LeuvenForm::Original => {
                let last = state.reversals.get(state.count - 1);
                let base = last.copied().unwrap_or(S::ZERO).along(direction);
                let span = strength.sub_input(base);
                (span > S::ZERO).then(|| Branch {
                    direction,
                    base,
                    span,
                    per_span: span.reciprocal(),
                })
            }
        }
    }

    fn share(&self, state: &LeuvenState<N, S>, branch: &Branch<S>) -> S {
        let along = state.force.along(branch.direction);
        along.sub_input(branch.base).mul_input(branch.per_span)
    }

    /// `1 − sgn(u)·|u|ⁿ`.
    fn rate(&self, u: S) -> S {
        let power = u.magnitude().powf(self.exponent);
        if u < S::ZERO {
            S::ONE.add_input(power)
        } else {
            S::ONE.sub_input(power)
        }
    }

    /// The force beyond which the branch before the last goes on, along the direction of motion.
    fn closure(&self, state: &LeuvenState<N, S>) -> Option<S> {
        if self.form == LeuvenForm::Modified {
            return None;
        }
        match state.reversals.get(..state.count)? {
            // The first branch joins the virgin curve at the mirror image of its reversal (Masing).
            [_, first] => Some(first.opposite().along(state.direction)),
            [.., outer, _last] => Some(outer.along(state.direction)),
            _ => None,
        }
    }

    /// Moves every block by `dz` in the direction `along`, and the force with them.
    fn carry(&self, state: &mut LeuvenState<N, S>, dz: S, along: S) {
        for (z, bound) in state.deflection.iter_mut().zip(&self.blocks.yields) {
            *z = z.add_input(dz.along(along)).limited(*bound);
        }
        state.force = self.blocks.force(&state.deflection);
    }

    /// Goes along `left` of the displacement up to the next yield or closure, or a substep; what then is left, or
    /// `None` where the motion no longer changes the force.
    fn portion(&self, state: &mut LeuvenState<N, S>, branch: &Branch<S>, left: S) -> Option<S> {
        let u = self.share(state, branch);
        let rate = self.rate(u);
        if rate == S::ZERO {
            return None;
        }
        let rising = rate > S::ZERO;
        let along = if rising {
            branch.direction
        } else {
            -branch.direction
        };
        // The blocks that stick, and how far it is to the nearest yield.
        let (mut stiffness, mut room) = (S::ZERO, None);
        for ((k, bound), z) in self
            .blocks
            .stiffness
            .iter()
            .zip(&self.blocks.yields)
            .zip(&state.deflection)
        {
            let free = bound.sub_input(z.along(along));
            if free > S::ZERO {
                stiffness = stiffness.add_input(*k);
                room = Some(match room {
                    Some(nearest) if nearest < free => nearest,
                    _ => free,
                });
            }
        }
        let room = room?;
        let per_force = stiffness.mul_input(branch.per_span);
        let slope = |u: S| self.rate(u);
        let path = per_force.mul_input(left);
        let h = self.flow.portion(path);
        let reached = self.flow.substep(u, h, slope);
        let change = (reached - u).magnitude();
        let mut stop = per_force.mul_input(room);
        let mut closes = false;
        if let Some(closing) = self.closure(state).filter(|_| rising) {
            let to_closure = closing
                .sub_input(branch.base)
                .mul_input(branch.per_span)
                .sub_input(u);
            if to_closure < stop {
                (stop, closes) = (
                    if to_closure > S::ZERO {
                        to_closure
                    } else {
                        S::ZERO
                    },
                    true,
                );
            }
        }
        if change < stop {
            // Settled, or no closer than rounding lets it come.
            if change == S::ZERO {
                return None;
            }
            let dz = change
                .mul_input(branch.span)
                .mul_input(stiffness.reciprocal());
            self.carry(state, dz, along);
            return Some(if h < path {
                left.sub_input(h.mul_input(per_force.reciprocal()))
            } else {
                S::ZERO
            });
        }
        let to = if rising {
            u.add_input(stop)
        } else {
            u.sub_input(stop)
        };
        let used = self
            .flow
            .path_to(u, to, slope)
            .mul_input(per_force.reciprocal());
        if closes {
            let dz = stop
                .mul_input(branch.span)
                .mul_input(stiffness.reciprocal());
            self.carry(state, dz, along);
            state.count -= if state.count > 2 { 2 } else { 1 };
        } else {
            self.carry(state, room, along);
        }
        let rest = left.sub_input(used);
        Some(if rest > S::ZERO { rest } else { S::ZERO })
    }
}

impl<const N: usize, S: Scalar> Friction for Leuven<N, S> {
    type Scalar = S;
    type State = LeuvenState<N, S>;

    fn at_rest(&self) -> Self::State {
        LeuvenState {
            deflection: [S::ZERO; N],
            force: S::ZERO,
            direction: S::ONE,
            moved: false,
            reversals: [S::ZERO; REVERSALS],
            count: 1,
        }
    }

    fn step(&self, state: &mut Self::State, motion: Motion<S>) -> S {
        let dx = motion.displacement;
        let strength = self.strength.at(motion.velocity);
        if dx != S::ZERO {
            let direction = if dx > S::ZERO { S::ONE } else { -S::ONE };
            if direction != state.direction {
                state.direction = direction;
                // The first motion leaves the origin in either direction without turning.
                if state.moved {
                    if state.count == REVERSALS {
                        state.reversals.copy_within(3.., 1);
                        state.count -= 2;
                    }
                    if let Some(next) = state.reversals.get_mut(state.count) {
                        *next = state.force;
                        state.count += 1;
                    }
                }
            }
            state.moved = true;
            let mut left = dx.magnitude();
            for _ in 0..MOST_SUBSTEPS {
                if left == S::ZERO {
                    break;
                }
                let Some(branch) = self.branch(state, strength) else {
                    break;
                };
                match self.portion(state, &branch, left) {
                    Some(rest) => left = rest,
                    None => break,
                }
            }
        }
        if self.damping == S::ZERO {
            return state.force;
        }
        let rate = match self.branch(state, strength) {
            Some(branch) => self.rate(self.share(state, &branch)),
            None => S::ZERO,
        };
        let damped = self.damping.mul_input(motion.velocity.mul_input(rate));
        state.force.add_input(damped)
    }

    fn limit(&self) -> Option<S> {
        (self.damping == S::ZERO).then_some(self.blocks.limit)
    }
}
