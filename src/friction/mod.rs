//! What every friction model is: motion in, force out; and the models, one a file.

mod bouc_wen;
pub(crate) mod condition;
mod coulomb;
mod dahl;
mod elasto_plastic;
mod flow;
mod gms;
mod hsieh;
mod leuven;
mod lugre;
mod quasi_static;
mod stribeck;
mod two_state;

use crate::Scalar;

pub use bouc_wen::{BoucWen, BoucWenState};
use condition::Condition;
pub use coulomb::Coulomb;
pub use dahl::{Dahl, DahlState};
pub use elasto_plastic::{ElastoPlastic, ElastoPlasticState};
pub use gms::{Gms, GmsState};
pub use hsieh::{Hsieh, HsiehParams, HsiehState, REVERSALS};
pub use leuven::{Leuven, LeuvenForm, LeuvenState};
pub use lugre::{LuGre, LuGreState};
pub use quasi_static::{QuasiStaticGms, QuasiStaticState};
pub use stribeck::Sliding;
pub use two_state::{TwoState, TwoStateMemory};

/// The motion of one control tick, in the model's [`Units`](crate::Units).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Motion<S> {
    /// Displacement since the previous tick. Its sign gives the direction; 0 means that nothing moved.
    pub displacement: S,
    /// Velocity estimate. Models with sliding dynamics use its magnitude; quasi-static ones ignore it.
    pub velocity: S,
}

impl<S: Scalar> Motion<S> {
    /// A motion for models that depend on displacement alone.
    #[inline]
    pub fn quasi_static(displacement: S) -> Self {
        Self {
            displacement,
            velocity: S::ZERO,
        }
    }
}

/// A friction model: immutable parameters (`Self`) that advance a separate state by one tick.
///
/// The force has the sign of the motion that it opposes: pushing in the positive direction gives a positive
/// force, so adding it to a controller's output compensates friction.
///
/// | | model | memory |
/// |---|---|---|
/// | [`Gms`] | Generalized Maxwell-Slip, N blocks, sliding dynamics | non-local |
/// | [`QuasiStaticGms`] | the same with `F_s = F_c`, exact for any displacement step | non-local |
/// | [`Dahl`] | eq. (1) | one state |
/// | [`LuGre`] | eqs. (2)–(3) | one state |
/// | [`BoucWen`] | Dahl's law with its own shape on unloading | one state |
/// | [`ElastoPlastic`] | LuGre that is purely elastic below breakaway | one state |
/// | [`Leuven`] | Maxwell-slip hysteresis under a LuGre-like state, original and modified | non-local, leaks |
/// | [`TwoState`] | elasto-plastic branch from the last reversal, lagging level | the last reversal |
/// | [`Hsieh`] | eqs. (4)–(6) | non-local, creep |
/// | [`Coulomb`] | `F_c·sgn v + b·v`, the baseline | none |
/// | [`kernels`](crate::kernels) | the two Maxwell-slip laws in whole numbers, for a cycle budget | non-local |
///
/// Models are compared where one takes the place of another: equal parameters keep the memory ([`Friction::take_over`]).
pub trait Friction: Clone + PartialEq {
    /// The number type that the model computes in.
    type Scalar: Scalar;
    /// The model's memory.
    type State: Clone;

    /// It estimates the velocity itself ([`Friction::velocity`]), without lag.
    const OBSERVES: bool = false;

    /// The state of a body that was never moved: no force, no memory.
    fn at_rest(&self) -> Self::State;

    /// Tells the model where the axis is, in the model's units; call it before [`Friction::step`].
    ///
    /// Only models with effects of position ([`crate::effects::With`]) keep it; for the others it is no code. Those effects are off
    /// until it has been told once.
    #[inline]
    fn set_position(&self, _state: &mut Self::State, _position: Self::Scalar) {}

    /// Forgets the motion, as after a fault, but not what was learned ([`crate::control::Learning`]); a model that learns
    /// nothing is at rest.
    #[inline]
    fn release(&self, state: &mut Self::State) {
        *state = self.at_rest();
    }

    /// The memory with which this model goes on where `old` stopped with `state`.
    ///
    /// From equal parameters it must be `state` as it is: [`Controller::swap`](crate::control::Controller::swap) then changes no
    /// command. A model whose memory means the same with other parameters keeps what fits them; any other one starts at rest.
    fn take_over(&self, old: &Self, state: &Self::State) -> Self::State {
        if self == old {
            state.clone()
        } else {
            self.at_rest()
        }
    }

    /// The axis's velocity after a `displacement` that was measured: what the encoder's window says, unless the model observes the axis
    /// ([`crate::control::Observed`]).
    #[inline]
    fn velocity(
        &self,
        _state: &mut Self::State,
        _displacement: Self::Scalar,
        window: impl FnOnce() -> Self::Scalar,
    ) -> Self::Scalar {
        window()
    }

    /// Lets a model that observes the axis ask what force acts until the next tick, as cut by the limiter; `velocity_error` is by how
    /// much the reference is faster than the axis. For the others it is no code.
    #[inline]
    fn acted(
        &self,
        _state: &mut Self::State,
        _velocity_error: Self::Scalar,
        _force: impl FnOnce() -> Self::Scalar,
    ) {
    }

    /// Gives the memory of a model that is being left ([`Controller::swap`](crate::control::Controller::swap)) what this one observes
    /// with `state`, so that only the models' own forces fade. For those that do not observe it is no code.
    #[inline]
    fn hand_observed(&self, _state: &Self::State, _left: &mut Self::State) {}

    /// Lets the model ask what the drive spent on friction in the tick of the last [`Friction::step`], in force units; `None`
    /// where that is not known, as where the command was cut.
    ///
    /// Only models that learn from it ([`crate::control::Learning`]) ask, and not in every tick; for the others it is no code.
    #[inline]
    fn spent(&self, _state: &mut Self::State, _force: impl FnOnce() -> Option<Self::Scalar>) {}

    /// What a model that learns has to say.
    #[inline]
    fn condition(&self, _state: &Self::State) -> Condition<Self::Scalar> {
        Condition::NONE
    }

    /// Advances `state` by one tick and returns the friction force at its end, in the model's units.
    fn step(&self, state: &mut Self::State, motion: Motion<Self::Scalar>) -> Self::Scalar;

    /// The bound that |force| never exceeds whatever the motion, or `None` where a viscous term grows
    /// without one.
    fn limit(&self) -> Option<Self::Scalar>;
}
