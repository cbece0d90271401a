//! What the drive spends on friction, compared with what the model says: the on-line watch and the adaptation.
//!
//! [`Learning`] wraps a friction model; it asks [`super::Controller`] in every [`LOOK_EVERY`]th tick what was spent, the motor
//! force less the mass times the acceleration ([`Friction::spent`]). Both forces are averaged over the same looks at a moving
//! axis, a *block*, so they have the same bandwidth: one that is long against the feedback's settling, and in which encoder steps
//! vanish. A block counts where the model's mean force along the motion is at least [`LearningSettings::excitation`] of its
//! limit; what follows a reversal does not. A look at rest tells nothing; one at a cut command, in a fade or in a late tick, and
//! any fault, drop the block. Where only such come, what was learned stays to the bit.
//!
//! | type | does |
//! |---|---|
//! | [`MismatchWatch`] | raises a flag where spent less modelled force leaves the range it had at commissioning |
//! | [`Adaptation`] | multiplies the model's force by a level that follows the spent one, within ± a range |
//! | `(MismatchWatch, Adaptation)` | both: the watch compares with the model as it was given, not as adapted, so that what the adaptation follows is seen all the same |
//!
//! What a motor constant or the winding's resistance changes looks like friction: the spent force is computed from the command.
//!
//! **Stability.** With [`super::VelocitySource::Reference`] the feed-forward with adaptation is `level·F̂(reference)`,
//! `1 − r ≤ level ≤ 1 + r`, whatever was measured. The axis is therefore the one without adaptation under a disturbance of at most
//! `r·limit`: a loop that is stable under bounded disturbances stays so, and its error grows by at most that disturbance's. This is
//! proven, for any input. Not proven, and not claimed, is that the level settles: while the axis slides, it integrates
//! the feedback's force at the rate `1/memory` (at most `1/(excitation²·memory)`), which takes the phase `atan(rate/ω_c)` from the
//! loop at its crossover `ω_c`. For the paper's axis (10 rad/s, at most 27; some 150 rad/s) that is 4°, at most 10°. With
//! [`super::VelocitySource::Measured`] the level multiplies the stiffness that the feedback has to exceed: take `(1 + r)·share` for the share.

mod adaptation;
mod mismatch;
mod run_length;

pub use crate::friction::condition::{Condition, NormalRange};
pub use adaptation::{Adaptation, AdaptationSettings, AdaptationState};
pub use mismatch::{MismatchSettings, MismatchState, MismatchWatch};
pub use run_length::decision_interval;

use crate::param::{Bound, ParamError, at_least, at_most, fits, positive, to_positive, to_scalar};
use crate::scalar::Arithmetic;
use crate::{Friction, Motion, Scalar, Units};

/// How to learn (SI).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LearningSettings {
    /// Moving ticks in a block, from [`LOOK_EVERY`] to 10000; those beyond a multiple of it are not counted.
    pub block: u32,
    /// Bound on the force that is learned from, and on the model's where it is adapted (N or N·m); the model's own bound holds
    /// where it is smaller.
    pub limit: f64,
    /// Share of the limit `e` (-), 0.1…1, that the model's mean force along the motion must reach for a block to count.
    pub excitation: f64,
    /// The adaptation.
    pub adaptation: AdaptationSettings,
    /// The watch.
    pub watch: MismatchSettings,
}

impl LearningSettings {
    /// For [`super::Settings::PAPER_AXIS`]. A block of 12.6 ms is twice the time constant of the loop's crossover; the adaptation
    /// forgets in 0.1 s of sliding, which at 0.2 mm/s is less than the 100 µm over which the stage's friction wanders, and leaves
    /// 5 % to the model, about what four blocks are off; a window of the watch is four times as long as those 100 µm. Memory,
    /// excitation and dead zone are the best of eight combinations on the simulated stage.
    pub const PAPER_AXIS: LearningSettings = LearningSettings {
        block: 252,
        limit: 5.0,
        excitation: 0.6,
        adaptation: AdaptationSettings {
            memory: 8.0,
            range: 0.2,
            dead_zone: 0.05,
        },
        watch: MismatchSettings {
            window: 400e-6,
            commissioning: 32,
            slack: 1.0,
            false_alarms: 1e-4,
        },
    };
}

/// Ticks from one look at what was spent to the next; the others only count down. The work is done once in so many ticks, and
/// the noise of a window hardly grows: it is friction's own, over lengths of hundreds of ticks. A prime number, so that what
/// repeats every two, five or ten ticks (a late tick, an encoder line at a round speed) is met in all of its phases.
pub const LOOK_EVERY: u32 = 7;

/// Means over a block, in the model's units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BlockMeans<S> {
    /// The model's force along the motion.
    pub model: S,
    /// What was spent along the motion.
    pub spent: S,
    /// Path (a sum, not a mean).
    pub path: S,
}

impl<S: Scalar> BlockMeans<S> {
    const EMPTY: Self = Self {
        model: S::ZERO,
        spent: S::ZERO,
        path: S::ZERO,
    };
}

/// Learns from blocks: [`MismatchWatch`], [`Adaptation`], both, or `()`.
pub trait Learn<S: Scalar>: Clone + PartialEq {
    /// What was learned.
    type State: Clone;
    /// It changes the level.
    const LEVEL: bool;

    /// Computes the coefficients, for a model whose force is at most `limit` (N or N·m), in `units`.
    ///
    /// # Errors
    /// [`ParamError`] where a setting is out of range or does not fit the number type.
    fn try_new(settings: &LearningSettings, limit: f64, units: Units) -> Result<Self, ParamError>;

    /// Nothing learned.
    fn start(&self) -> Self::State;

    /// Takes an excited block.
    fn block(&self, state: &mut Self::State, block: &BlockMeans<S>);

    /// What the model's force is multiplied by.
    #[inline]
    fn level(&self, _state: &Self::State) -> S {
        S::ONE
    }

    /// The largest [`Learn::level`].
    fn highest(&self) -> S {
        S::ONE
    }

    /// Adds what it has to say.
    fn tell(&self, state: &Self::State, condition: &mut Condition<S>);
}

/// Learns nothing.
impl<S: Scalar> Learn<S> for () {
    type State = ();
    const LEVEL: bool = false;

    fn try_new(_: &LearningSettings, _: f64, _: Units) -> Result<Self, ParamError> {
        Ok(())
    }

    fn start(&self) {}

    #[inline]
    fn block(&self, _state: &mut (), _block: &BlockMeans<S>) {}

    fn tell(&self, _state: &(), _condition: &mut Condition<S>) {}
}

impl<S: Scalar, A: Learn<S>, B: Learn<S>> Learn<S> for (A, B) {
    type State = (A::State, B::State);
    const LEVEL: bool = A::LEVEL || B::LEVEL;

    fn try_new(settings: &LearningSettings, limit: f64, units: Units) -> Result<Self, ParamError> {
        Ok((
            A::try_new(settings, limit, units)?,
            B::try_new(settings, limit, units)?,
        ))
    }

    fn start(&self) -> Self::State {
        (self.0.start(), self.1.start())
    }

    #[inline]
    fn block(&self, state: &mut Self::State, block: &BlockMeans<S>) {
        self.0.block(&mut state.0, block);
        self.1.block(&mut state.1, block);
    }

    #[inline]
    fn level(&self, state: &Self::State) -> S {
        match (A::LEVEL, B::LEVEL) {
            (true, true) => self.0.level(&state.0).mul_input(self.1.level(&state.1)),
            (true, false) => self.0.level(&state.0),
            (false, _) => self.1.level(&state.1),
        }
    }

    fn highest(&self) -> S {
        self.0.highest().mul_input(self.1.highest())
    }

    fn tell(&self, state: &Self::State, condition: &mut Condition<S>) {
        self.0.tell(&state.0, condition);
        self.1.tell(&state.1, condition);
    }
}

/// The friction model `F` with what `L` learns about it. Effects belong inside: `Learning<With<F, E>, L>`.
///
/// Another model or other settings of the learner ([`super::Controller::swap`]) begin to learn anew; new gains, a fault and
/// the next enabling keep what was learned.
///
/// **Bound.** `|F| ≤ (1 + r)·limit`, `r` the adaptation's range. Without adaptation the force is the model's, to the bit.
///
/// ```
/// use preslide::control::learning::Adaptation;
/// use preslide::control::{Learning, LearningSettings};
/// use preslide::{Block, Friction, Motion, QuasiStaticGms, Units};
///
/// let blocks = [Block { stiffness: 1e5, weight: 1.0 }];
/// let gms = QuasiStaticGms::<1>::try_new(&blocks, 0.9, Units::SI)?;
/// // A level that follows the machine, within the settings' range.
/// let learning: Learning<_, Adaptation<f32>> = Learning::try_new(gms, &LearningSettings::PAPER_AXIS, Units::SI)?;
/// let mut state = learning.at_rest();
/// assert!(learning.step(&mut state, Motion::quasi_static(1e-6)) > 0.0);
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Learning<F: Friction, L> {
    friction: F,
    learner: L,
    limit: F::Scalar,
    /// Twice the limit: more than that was not spent on friction.
    most: F::Scalar,
    excited: F::Scalar,
    looks: u32,
    per_look: F::Scalar,
}

/// What a [`Learning`] remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LearningState<M, B, S> {
    friction: M,
    learned: B,
    /// The last tick's force before the level, and its displacement.
    force: S,
    displacement: S,
    /// Of the running block: sums over its looks, and their number.
    block: BlockMeans<S>,
    looks: u32,
    /// Ticks to the next look, or to the block's end.
    wait: u32,
}

impl<M, B, S: Scalar> LearningState<M, B, S> {
    /// What was learned.
    pub fn learned(&mut self) -> &mut B {
        &mut self.learned
    }

    fn drop_block(&mut self) {
        self.block = BlockMeans::EMPTY;
        self.looks = 0;
    }
}

impl<F: Friction, L: Learn<F::Scalar>> Learning<F, L> {
    /// `friction` must have been built in the same `units`.
    ///
    /// # Errors
    /// [`ParamError`] where a setting is out of range or does not fit the number type.
    pub fn try_new(
        friction: F,
        settings: &LearningSettings,
        units: Units,
    ) -> Result<Self, ParamError> {
        units.check()?;
        let limit = positive("limit of the learned force", settings.limit)? / units.force;
        let limit = match friction.limit().map(Scalar::to_f64) {
            Some(own) if own < limit => own,
            _ => limit,
        };
        let ticks = settings.block.into();
        at_least("ticks of a block", ticks, LOOK_EVERY.into())?;
        at_most("ticks of a block", ticks, 10_000.0)?;
        let looks = settings.block / LOOK_EVERY;
        let excitation = at_least("excitation", settings.excitation, 0.1)?;
        at_most("excitation", excitation, 1.0)?;
        let learner = L::try_new(settings, limit * units.force, units)?;
        fits::<F::Scalar>("bound of the learned force", 2.0 * limit)?;
        Ok(Self {
            friction,
            learner,
            limit: to_positive("limit of the learned force", limit)?,
            most: to_scalar("bound of the learned force", 2.0 * limit)?,
            excited: to_positive("excitation", excitation * limit)?,
            looks,
            per_look: to_positive("share of a look in a block", 1.0 / f64::from(looks))?,
        })
    }

    /// What learns.
    pub fn learner(&self) -> &L {
        &self.learner
    }

    /// Ends a block. What cannot be, not a number too, is limited here and not at every look: the controller cuts a force that
    /// large and does not tell it. A function of its own, so that the registers it needs are not saved in every tick.
    #[inline(never)]
    fn end_block(&self, state: &mut LearningState<F::State, L::State, F::Scalar>) {
        let block = BlockMeans {
            model: state.block.model.limited(self.limit),
            spent: state.block.spent.limited(self.most),
            path: (state.block.path).mul_input(F::Scalar::from_int(LOOK_EVERY as i32)),
        };
        state.drop_block();
        if block.model >= self.excited {
            self.learner.block(&mut state.learned, &block);
        }
    }
}

impl<F: Friction, L: Learn<F::Scalar>> Friction for Learning<F, L> {
    type Scalar = F::Scalar;
    type State = LearningState<F::State, L::State, F::Scalar>;

    fn at_rest(&self) -> Self::State {
        LearningState {
            friction: self.friction.at_rest(),
            learned: self.learner.start(),
            force: F::Scalar::ZERO,
            displacement: F::Scalar::ZERO,
            block: BlockMeans::EMPTY,
            looks: 0,
            wait: 0,
        }
    }

    fn release(&self, state: &mut Self::State) {
        self.friction.release(&mut state.friction);
        state.force = F::Scalar::ZERO;
        state.displacement = F::Scalar::ZERO;
        state.drop_block();
    }

    fn take_over(&self, old: &Self, state: &Self::State) -> Self::State {
        if self == old {
            return state.clone();
        }
        LearningState {
            friction: self.friction.take_over(&old.friction, &state.friction),
            ..self.at_rest()
        }
    }

    #[inline]
    fn set_position(&self, state: &mut Self::State, position: F::Scalar) {
        self.friction.set_position(&mut state.friction, position);
    }

    #[inline(always)]
    fn step(&self, state: &mut Self::State, motion: Motion<F::Scalar>) -> F::Scalar {
        let mut force = self.friction.step(&mut state.friction, motion);
        if L::LEVEL {
            force = force.limited(self.limit);
        }
        state.force = force;
        state.displacement = motion.displacement;
        if L::LEVEL {
            force = force.mul_input(self.learner.level(&state.learned));
        }
        force
    }

    fn limit(&self) -> Option<F::Scalar> {
        if !L::LEVEL {
            return self.friction.limit();
        }
        // Products are rounded down, so that of the negative limit is the larger one.
        let highest = self.learner.highest();
        Some(self.limit.opposite().mul_input(highest).opposite())
    }

    #[inline(always)]
    fn spent(&self, state: &mut Self::State, force: impl FnOnce() -> Option<F::Scalar>) {
        if let Some(left) = state.wait.checked_sub(1) {
            state.wait = left;
            return;
        }
        // The tick after the block's last look ends it, so that no tick has both to do.
        if state.looks == self.looks {
            state.wait = LOOK_EVERY - 2;
            return self.end_block(state);
        }
        state.wait = LOOK_EVERY - 1;
        let Some(spent) = force() else {
            return state.drop_block();
        };
        let moved = state.displacement;
        let path = moved.magnitude();
        // False for NaN as well.
        if !(path > F::Scalar::ZERO) {
            return;
        }
        let share = if moved < F::Scalar::ZERO {
            -self.per_look
        } else {
            self.per_look
        };
        let sums = &mut state.block;
        sums.model = sums.model.add_input(state.force.mul_input(share));
        sums.spent = sums.spent.add_input(spent.mul_input(share));
        sums.path = sums.path.add_input(path);
        state.looks += 1;
        if state.looks == self.looks {
            state.wait = 0;
        }
    }

    fn condition(&self, state: &Self::State) -> Condition<F::Scalar> {
        let mut condition = Condition::NONE;
        self.learner.tell(&state.learned, &mut condition);
        condition
    }
}

/// `1/limit` in model units, refused where the number type holds it to less than a tenth.
fn reciprocal<S: Scalar>(limit: f64) -> Result<S, ParamError> {
    let name = "reciprocal of the force's limit";
    let scalar: S = to_positive(name, 1.0 / limit)?;
    if (scalar.to_f64() * limit - 1.0).abs() > 0.1 {
        return Err(ParamError::new(name, 1.0 / limit, Bound::Resolvable));
    }
    Ok(scalar)
}
