//! Any law of the library as one type, so that a check of all of them is compiled once for each number type.

use preslide::{Friction, Motion, ParamError, Scalar, Units};
use preslide_fit::friction::{FrictionModel, Visitor};
use preslide_host_tests::path::SAMPLE_TIME;
use std::any::Any;
use std::rc::Rc;

/// A model of the library.
#[derive(Clone)]
pub struct AnyLaw<S>(Rc<dyn Model<S>>);

/// What it remembers.
pub struct AnyState(Box<dyn State>);

/// The library's model of `model` in `units`, for ticks of [`SAMPLE_TIME`].
pub fn built<S: Scalar + Send + 'static>(
    model: &FrictionModel,
    units: Units,
) -> Result<AnyLaw<S>, ParamError> {
    model.visit_in(SAMPLE_TIME, units, Hold)
}

struct Hold;

impl<S: Scalar + 'static> Visitor<S> for Hold {
    type Outcome = AnyLaw<S>;

    fn visit<M: Friction<Scalar = S> + 'static>(self, model: M) -> AnyLaw<S> {
        AnyLaw(Rc::new(model))
    }
}

trait State: Any {
    fn copied(&self) -> Box<dyn State>;
}

impl<T: Any + Clone> State for T {
    fn copied(&self) -> Box<dyn State> {
        Box::new(self.clone())
    }
}

impl Clone for AnyState {
    fn clone(&self) -> Self {
        Self((*self.0).copied())
    }
}

trait Model<S>: Any {
    fn is(&self, other: &dyn Any) -> bool;
    fn rest(&self) -> Box<dyn State>;
    fn goes_on(&self, old: &dyn Any, state: &dyn Any) -> Option<Box<dyn State>>;
    fn advance(&self, state: &mut dyn Any, motion: Motion<S>) -> Option<S>;
    fn most(&self) -> Option<S>;
}

impl<S, M: Friction<Scalar = S> + 'static> Model<S> for M {
    fn is(&self, other: &dyn Any) -> bool {
        other.downcast_ref() == Some(self)
    }

    fn rest(&self) -> Box<dyn State> {
        Box::new(self.at_rest())
    }

    fn goes_on(&self, old: &dyn Any, state: &dyn Any) -> Option<Box<dyn State>> {
        let state = self.take_over(old.downcast_ref()?, state.downcast_ref()?);
        Some(Box::new(state))
    }

    fn advance(&self, state: &mut dyn Any, motion: Motion<S>) -> Option<S> {
        Some(self.step(state.downcast_mut()?, motion))
    }

    fn most(&self) -> Option<S> {
        self.limit()
    }
}

impl<S: 'static> PartialEq for AnyLaw<S> {
    fn eq(&self, other: &Self) -> bool {
        self.0.is(&*other.0 as &dyn Any)
    }
}

impl<S: Scalar + 'static> Friction for AnyLaw<S> {
    type Scalar = S;
    type State = AnyState;

    fn at_rest(&self) -> AnyState {
        AnyState(self.0.rest())
    }

    fn take_over(&self, old: &Self, state: &AnyState) -> AnyState {
        let state = self.0.goes_on(&*old.0, &*state.0);
        AnyState(state.expect("the memory of a model of the same law"))
    }

    fn step(&self, state: &mut AnyState, motion: Motion<S>) -> S {
        let force = self.0.advance(&mut *state.0, motion);
        force.expect("its own memory")
    }

    fn limit(&self) -> Option<S> {
        self.0.most()
    }
}
