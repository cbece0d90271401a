//! Hsieh and Pan's model (eqs. 4–6): a nonlinear spring with memory in series with a plastic module.

use crate::param::{
    ParamError, Units, at_most, fits, not_negative, positive, to_positive, to_scalar,
};
use crate::{Friction, Motion, Scalar};

/// Reversal points that [`HsiehState`] can remember; see there.
pub const REVERSALS: usize = 16;

/// Bisections of the series connection in one step.
const BISECTIONS: usize = 20;

/// The parameters of Hsieh's model, in SI, named as in the paper's Table 2.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HsiehParams {
    /// Stiffness `k_1s` (N/m): the slope of a branch far from its reversal.
    pub k1: f64,
    /// Stiffness `k_2s` (N/m): added to `k_1s` at a reversal.
    pub k2: f64,
    /// `β` [1/m]: how fast `k_2s` fades.
    pub beta: f64,
    /// Viscous coefficient `C_v` (N·s/m) (Table 2 prints no unit).
    pub viscous: f64,
    /// Creep rate `ρ` [1/s].
    pub creep: f64,
    /// Work hardening `ψ` (Nᵃ/m).
    pub hardening: f64,
    /// Work hardening exponent `a` (-).
    pub hardening_exponent: f64,
}

/// Hsieh's model at a fixed sample time: the parameters.
///
/// Spring (4): `F = σ_r + k_1s·d + sgn(d)·(k_2s/β)·(1 − e^(−β|d|))`, `d = x_s − x_r`, from the last reversal
/// `(x_r, σ_r)`; a loop that closes is wiped out and the branch before it goes on. Plasticity (5)–(6):
/// `x_h ← x_h + λ·max(|F|ᵃ/ψ − x_h, 0)`, `λ = 1 − e^(−ρ·T_s)`, `x_p` grows by as much in the direction of `F`, and
/// `x = x_s + x_p` is solved for the force at the end of the tick by bisection (20 halvings).
///
/// **Where the paper is ambiguous.** (a) `|F_f^a|` is read as `|F_f|ᵃ`: a power of a negative force is
/// undefined. (b) `C_v·dx_s/dt` is added to the output but does not drive the plastic module, and `dx_s/dt` is
/// the caller's velocity less the plastic rate: differenced at 20 kHz, `C_v = 5000` would turn one 25 nm count
/// into 2.5 N. (c) The branch after a reversal has the virgin branch's own shape and is not doubled (Masing),
/// as eq. (4) is printed; loops close all the same because a branch is odd in `d`.
///
/// A displacement that is not finite, or that would take the float out of its range, is ignored; fixed point
/// saturates.
///
/// For identification and comparison on the host. A step costs one exponential and one power while elastic,
/// and twenty of each while yielding: too slow for most control ticks, as the paper says of it.
///
/// ```
/// use preslide::{Friction, Hsieh, HsiehParams, Motion, Units};
///
/// let params = HsiehParams { k1: 1e3, k2: 1e5, beta: 1e5, viscous: 0.0, creep: 0.0, hardening: 1.0, hardening_exponent: 1.0 };
/// let hsieh: Hsieh = Hsieh::try_new(&params, 50e-6, Units::SI)?;
/// let mut state = hsieh.at_rest();
/// // 1 nm from rest: `k_1s + k_2s`.
/// let force = hsieh.step(&mut state, Motion::quasi_static(1e-9));
/// assert!((force / 1.01e-4 - 1.0).abs() < 1e-3);
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Hsieh<S = f32> {
    k1: S,
    saturation: S,
    beta: S,
    viscous: S,
    creep: S,
    /// `ψ` as a factor on `|F|ᵃ`, so that nothing is divided.
    per_hardening: S,
    exponent: S,
    rate: S,
}

/// What a [`Hsieh`] remembers: the spring, the plastic module and up to [`REVERSALS`] reversal points.
///
/// More nested reversals than that forget the oldest pair, which shows only when the motion later leaves the
/// loops that are remembered.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HsiehState<S = f32> {
    spring: S,
    hardened: S,
    force: S,
    up: bool,
    reversals: [Reversal<S>; REVERSALS],
    count: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Reversal<S> {
    displacement: S,
    force: S,
}

/// The branch that a spring displacement lies on: how many reversals are left, and whether the present point
/// is a new one.
#[derive(Clone, Copy)]
struct Branch {
    count: usize,
    turned: bool,
}

impl<S: Scalar> Hsieh<S> {
    /// Validates the parameters; `sample_time` is `T_s` in seconds.
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, out of range, or does not fit `S` in `units`. Fixed point
    /// seldom has the range for `β` and `ψ`; use a float.
    pub fn try_new(
        params: &HsiehParams,
        sample_time: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        units.check()?;
        positive("k1", params.k1)?;
        not_negative("k2", params.k2)?;
        positive("beta", params.beta)?;
        not_negative("viscous coefficient", params.viscous)?;
        not_negative("creep rate", params.creep)?;
        positive("hardening", params.hardening)?;
        positive("hardening exponent", params.hardening_exponent)?;
        at_most("hardening exponent", params.hardening_exponent, 20.0)?;
        positive("sample time", sample_time)?;
        fits::<S>("one", 1.0)?;
        let power_unit = libm::pow(units.force, params.hardening_exponent);
        Ok(Self {
            k1: to_positive("k1", params.k1 * units.length / units.force)?,
            saturation: to_scalar("k2/beta", params.k2 / params.beta / units.force)?,
            beta: to_positive("beta", params.beta * units.length)?,
            viscous: to_scalar(
                "viscous coefficient",
                params.viscous * units.velocity / units.force,
            )?,
            creep: to_scalar("creep per tick", -libm::expm1(-params.creep * sample_time))?,
            per_hardening: to_positive(
                "force per hardening",
                power_unit / params.hardening / units.length,
            )?,
            exponent: to_scalar("hardening exponent", params.hardening_exponent)?,
            rate: to_positive(
                "ticks per second",
                units.length / (sample_time * units.velocity),
            )?,
        })
    }

    /// The branch that the spring is on once it has moved to `spring`.
    fn branch(&self, state: &HsiehState<S>, spring: S) -> Branch {
        let up = if spring == state.spring {
            state.up
        } else {
            spring > state.spring
        };
        // The first motion leaves the origin in either direction without turning.
        let untouched = state.count == 1 && state.spring == S::ZERO;
        let mut branch = Branch {
            count: state.count,
            turned: up != state.up && !untouched,
        };
        loop {
            // The loop closes at the reversal before the one that the branch starts from. The first entry is
            // the virgin curve's origin, which is no reversal.
            let closing = branch.count
                - if branch.turned {
                    1
                } else {
                    2.min(branch.count)
                };
            if closing == 0 {
                return branch;
            }
            let corner = state.reversals[closing].displacement;
            let inside = if up { spring < corner } else { spring > corner };
            if inside {
                return branch;
            }
            branch = Branch {
                count: closing,
                turned: false,
            };
        }
    }

    /// Eq. (4) without its viscous term.
    fn spring_force(&self, state: &HsiehState<S>, branch: Branch, spring: S) -> S {
        let from = if branch.turned {
            Reversal {
                displacement: state.spring,
                force: state.force,
            }
        } else {
            state.reversals[branch.count - 1]
        };
        let d = spring.sub_input(from.displacement);
        let faded = S::ONE - (-self.beta.mul_input(d.magnitude())).exp();
        let curved = self.saturation * faded;
        let curved = if d < S::ZERO { -curved } else { curved };
        from.force.add_input(self.k1.mul_input(d)).add_input(curved)
    }

    /// Growth of the work hardening in a tick at the force `force` (eq. 5).
    fn growth(&self, hardened: S, force: S) -> S {
        let target = self
            .per_hardening
            .mul_input(force.magnitude().powf(self.exponent));
        if target > hardened {
            self.creep * (target - hardened)
        } else {
            S::ZERO
        }
    }
}

impl<S: Scalar> Friction for Hsieh<S> {
    type Scalar = S;
    type State = HsiehState<S>;

    fn at_rest(&self) -> Self::State {
        HsiehState {
            spring: S::ZERO,
            hardened: S::ZERO,
            force: S::ZERO,
            up: true,
            reversals: [Reversal {
                displacement: S::ZERO,
                force: S::ZERO,
            }; REVERSALS],
            count: 1,
        }
    }

    fn step(&self, state: &mut Self::State, motion: Motion<S>) -> S {
        // All elastic, unless the force that this gives makes the plastic module move.
        let elastic = state.spring.add_input(motion.displacement);
        let mut spring = elastic;
        let mut branch = self.branch(state, spring);
        let mut force = self.spring_force(state, branch, spring);
        let mut growth = self.growth(state.hardened, force);
        if growth > S::ZERO {
            let pulls = force < S::ZERO;
            let after = |yielded: S| {
                if pulls {
                    elastic.add_input(yielded)
                } else {
                    elastic.sub_input(yielded)
                }
            };
            // `spring + sgn(F)·growth(force(spring))` rises with `spring`: the root lies between these two.
            let (mut yielded, mut width) = (growth, growth);
            for _ in 0..BISECTIONS {
                width = width.half();
                spring = after(yielded);
                branch = self.branch(state, spring);
                let trial = self.spring_force(state, branch, spring);
                growth = if (trial < S::ZERO) == pulls {
                    self.growth(state.hardened, trial)
                } else {
                    S::ZERO
                };
                yielded = if growth > yielded {
                    yielded.add_input(width)
                } else {
                    yielded - width
                };
            }
            growth = yielded;
            spring = after(yielded);
            branch = self.branch(state, spring);
            force = self.spring_force(state, branch, spring);
        }
        let outcome = force.magnitude().add_input(growth);
        if outcome.sub_input(outcome) != S::ZERO {
            return state.force; // not finite: the input was not, or took the float out of its range
        }

        if branch.turned {
            if state.count == REVERSALS {
                state.reversals.copy_within(3.., 1);
                state.count -= 2;
            }
            state.reversals[state.count] = Reversal {
                displacement: state.spring,
                force: state.force,
            };
            state.count += 1;
        } else {
            state.count = branch.count;
        }
        if spring != state.spring {
            state.up = spring > state.spring;
        }
        state.spring = spring;
        state.hardened = state.hardened.add_input(growth);
        state.force = force;
        if self.viscous == S::ZERO {
            return force;
        }
        let against = if force < S::ZERO { growth } else { -growth };
        let rate = motion.velocity.add_input(self.rate.mul_input(against));
        force.add_input(self.viscous.mul_input(rate))
    }

    fn limit(&self) -> Option<S> {
        None
    }
}
