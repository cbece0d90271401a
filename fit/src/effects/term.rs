//! The library's terms at work, chosen at run time.

use super::Effect;
use preslide::effects::{self, EncoderError, Situation};
use preslide::{ParamError, Units};

/// An effect at work: change of the friction level (-) and force (N or N·m) of a tick.
pub trait Tick: FnMut(&Situation<f64>) -> (f64, f64) + Send {
    /// A copy with the memory of this moment.
    fn copy(&self) -> Term;
}

/// What a [`form::Form`](super::form::Form) makes of its values for simulations.
pub type Term = Box<dyn Tick>;

impl<T: FnMut(&Situation<f64>) -> (f64, f64) + Clone + Send + 'static> Tick for T {
    fn copy(&self) -> Term {
        Box::new(self.clone())
    }
}

/// Forces that grow without bound in the library need one; on the host it is out of the way.
pub(crate) const FAR: f64 = 1e12;

/// The library's effect as a term, where it takes the parameters.
pub(super) fn term<E>(effect: Result<E, ParamError>) -> Result<Option<Term>, ParamError>
where
    E: effects::Effect<f64, State: Send + 'static> + Clone + Send + 'static,
{
    let effect = effect?;
    let mut state = effect.at_rest();
    Ok(Some(Box::new(move |at: &Situation<f64>| {
        (effect.level(&mut state, at), effect.force(&mut state, at))
    })))
}

/// The library's correction of an encoder that reads with an error.
///
/// # Errors
/// Which parameter the library refuses.
pub(crate) fn encoder(effect: &Effect) -> Result<EncoderError<f64>, ParamError> {
    let [error, period, phase] = effect.numbers();
    EncoderError::try_new(error, period, phase, Units::SI)
}
