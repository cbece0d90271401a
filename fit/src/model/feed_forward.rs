//! A model file's friction and effects as a controller's feed-forward, chosen at run time: what `preslide export` fixes at
//! compile time for the firmware, here for the closed loop on the host.

use super::running::Running;
use super::{Model, refused};
use crate::effects::term::{FAR, Term};
use crate::effects::{form, term};
use crate::friction::Visitor;
use crate::kernel::Kernel;
use preslide::ParamError;
use preslide::effects::{Bounds, EncoderError, LARGEST_LEVEL, Situation, With};

/// All effects of a model, viscous and constant force among them, as one of the library's effects.
#[derive(Clone)]
pub struct Chosen {
    running: Running,
    encoders: Vec<EncoderError<f64>>,
    sample_time: f64,
}

/// Their memories, the velocity of the last tick, and the force of the tick whose level has been asked for.
#[derive(Clone)]
pub struct Memory {
    running: Running,
    velocity: f64,
    force: f64,
}

impl Clone for Term {
    fn clone(&self) -> Self {
        self.copy()
    }
}

impl Chosen {
    fn try_new(model: &Model, sample_time: f64) -> Result<Self, String> {
        let encoders = model.of(&form::ENCODER_ERROR).map(|effect| {
            term::encoder(effect).map_err(|e| format!("effect {}: {e}", effect.id()))
        });
        Ok(Self {
            running: Running::of(model, sample_time)?,
            encoders: encoders.collect::<Result<_, _>>()?,
            sample_time,
        })
    }
}

/// Its terms are functions, which cannot be compared.
impl PartialEq for Chosen {
    fn eq(&self, _: &Self) -> bool {
        false
    }
}

impl preslide::effects::Effect<f64> for Chosen {
    type State = Memory;
    const LEVEL: bool = true;
    const FORCE: bool = true;
    const SHIFT: bool = true;

    fn at_rest(&self) -> Memory {
        Memory {
            running: self.running.clone(),
            velocity: 0.0,
            force: 0.0,
        }
    }

    fn level(&self, state: &mut Memory, at: &Situation<f64>) -> f64 {
        let [level, load, of_speed] = state.running.tick(at);
        state.force = load + of_speed;
        if self.running.has_gear() {
            let acceleration = (at.velocity - state.velocity) / self.sample_time;
            state.force += self.running.of_transmitted(at.friction, load, acceleration);
            state.velocity = at.velocity;
        }
        level - 1.0
    }

    fn force(&self, state: &mut Memory, _at: &Situation<f64>) -> f64 {
        state.force
    }

    fn shift(&self, position: f64) -> f64 {
        self.encoders.iter().map(|e| e.shift(position)).sum()
    }

    /// The controller's own limit is the one that holds.
    fn bounds(&self) -> Bounds<f64> {
        Bounds {
            level: LARGEST_LEVEL,
            force: FAR,
            shift: self.encoders.iter().map(|e| e.bounds().shift).sum(),
        }
    }
}

/// Hands the friction model with its effects on to the visitor within.
struct Composing<V> {
    effects: Chosen,
    visitor: V,
}

impl<V: Visitor> Visitor for Composing<V> {
    type Outcome = Result<V::Outcome, ParamError>;

    fn visit<M: preslide::Friction<Scalar = f64, State: Send> + Send + 'static>(
        self,
        model: M,
    ) -> Self::Outcome {
        Ok(self.visitor.visit(With::try_new(model, self.effects)?))
    }
}

impl Model {
    /// Hands friction and effects, composed in SI for ticks of `sample_time` (s), to `visitor`.
    ///
    /// # Errors
    /// An effect that no controller can compensate; a parameter that the library refuses.
    pub fn feed_forward<V: Visitor>(
        &self,
        sample_time: f64,
        visitor: V,
    ) -> Result<V::Outcome, String> {
        self.only_usable()?;
        self.forward_law(sample_time, visitor)
    }

    /// The same with the friction in a kernel's form, which it must have the law of.
    ///
    /// # Errors
    /// As there; a model that is no Maxwell slip.
    pub fn feed_forward_by<V: Visitor>(
        &self,
        kernel: Kernel,
        sample_time: f64,
        visitor: V,
    ) -> Result<V::Outcome, String> {
        self.only_usable()?;
        let effects = Chosen::try_new(self, sample_time)?;
        let composing = Composing { effects, visitor };
        match kernel.visit(&self.friction, sample_time, composing) {
            Some(Ok(Ok(outcome))) => Ok(outcome),
            Some(Ok(Err(e)) | Err(e)) => Err(e.to_string()),
            None => Err(format!(
                "{} has no Maxwell-slip kernel",
                self.friction.kind()
            )),
        }
    }

    fn only_usable(&self) -> Result<(), String> {
        match refused(self).first() {
            Some((id, reason)) => Err(format!(
                "effect {id}: no controller can compensate it: {reason}"
            )),
            None => Ok(()),
        }
    }

    /// The same for a simulation, which takes every level and force; the effects on the drive's side are left to it.
    ///
    /// # Errors
    /// A parameter that the library refuses.
    pub fn forward_law<V: Visitor>(
        &self,
        sample_time: f64,
        visitor: V,
    ) -> Result<V::Outcome, String> {
        let effects = Chosen::try_new(self, sample_time)?;
        let composing = Composing { effects, visitor };
        match self.friction.visit(sample_time, composing) {
            Ok(Ok(outcome)) => Ok(outcome),
            Ok(Err(e)) | Err(e) => Err(e.to_string()),
        }
    }
}
