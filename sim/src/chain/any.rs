//! One type for every model, so that the controller around it is compiled once: for each of a hundred laws, sizes and kernels it took nearly half of
//! this package's time.

use preslide::{Friction, Motion};
use std::rc::Rc;

/// A model with its state.
trait Law {
    fn again(&self) -> Box<dyn Law>;
    fn set_position(&mut self, position: f64);
    fn step(&mut self, motion: Motion<f64>) -> f64;
    fn limit(&self) -> Option<f64>;
}

#[derive(Clone)]
struct Held<M: Friction> {
    model: M,
    state: M::State,
}

impl<M: Friction<Scalar = f64> + 'static> Law for Held<M> {
    fn again(&self) -> Box<dyn Law> {
        Box::new(self.clone())
    }

    fn set_position(&mut self, position: f64) {
        self.model.set_position(&mut self.state, position);
    }

    fn step(&mut self, motion: Motion<f64>) -> f64 {
        self.model.step(&mut self.state, motion)
    }

    fn limit(&self) -> Option<f64> {
        self.model.limit()
    }
}

/// A law with its effects, at rest.
#[derive(Clone)]
pub(super) struct AnyFriction(Rc<dyn Law>);

impl AnyFriction {
    /// Of a model that neither observes nor learns: what those add to the trait is not handed on.
    pub fn of<M: Friction<Scalar = f64> + 'static>(model: M) -> Self {
        const { assert!(!M::OBSERVES) };
        let state = model.at_rest();
        Self(Rc::new(Held { model, state }))
    }
}

/// The same one, or a clone of it.
impl PartialEq for AnyFriction {
    fn eq(&self, other: &Self) -> bool {
        Rc::as_ptr(&self.0).cast::<()>() == Rc::as_ptr(&other.0).cast::<()>()
    }
}

/// A state of [`AnyFriction`].
pub(super) struct AnyState(Box<dyn Law>);

impl Clone for AnyState {
    fn clone(&self) -> Self {
        Self(self.0.again())
    }
}

impl Friction for AnyFriction {
    type Scalar = f64;
    type State = AnyState;

    fn at_rest(&self) -> AnyState {
        AnyState(self.0.again())
    }

    fn set_position(&self, state: &mut AnyState, position: f64) {
        state.0.set_position(position);
    }

    fn step(&self, state: &mut AnyState, motion: Motion<f64>) -> f64 {
        state.0.step(motion)
    }

    fn limit(&self) -> Option<f64> {
        self.0.limit()
    }
}
