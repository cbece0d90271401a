//! A model file's friction and effects as a controller's feed-forward, chosen at run time: what `preslide export` fixes at
//! compile time for the firmware, here for the closed loop on the host.

use super::{Model, refused};
use crate::effects::Effect;
use crate::effects::form::{self, encoder_error};
use crate::effects::term::{FAR, Term};
use crate::friction::Visitor;
use preslide::ParamError;
use preslide::effects::{Bounds, EncoderError, LARGEST_LEVEL, Situation, With};

/// All effects of a model, viscous and constant force among them, as one of the library's effects.
#[derive(Clone)]
pub struct Chosen {
    terms: Vec<Term>,
    encoders: Vec<EncoderError<f64>>,
    viscous: f64,
    constant: f64,
}

/// Their memories, and the force of the tick whose level has been asked for.
#[derive(Clone)]
pub struct Memory {
    terms: Vec<Term>,
    force: f64,
}

impl Clone for Term {
    fn clone(&self) -> Self {
        self.copy()
    }
}

impl Chosen {
    fn try_new(model: &Model, sample_time: f64) -> Result<Self, String> {
        let said = |effect: &Effect, e: ParamError| format!("effect {}: {e}", effect.id());
        let (mut terms, mut encoders) = (Vec::new(), Vec::new());
        for effect in &model.effects {
            terms.extend(effect.term(sample_time).map_err(|e| said(effect, e))?);
            if effect.is(&form::ENCODER_ERROR) {
                encoders.push(encoder_error::correction(effect).map_err(|e| said(effect, e))?);
            }
        }
        Ok(Self {
            terms,
            encoders,
            viscous: model.viscous,
            constant: model.constant_force,
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
            terms: self.terms.clone(),
            force: 0.0,
        }
    }

    fn level(&self, state: &mut Memory, at: &Situation<f64>) -> f64 {
        let mut sum = 0.0;
        state.force = self.constant + self.viscous * at.velocity;
        for term in &mut state.terms {
            let (level, force) = term(at);
            sum += level;
            state.force += force;
        }
        sum
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

    fn visit<M: preslide::Friction<Scalar = f64>>(self, model: M) -> Self::Outcome {
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
        if let Some((id, reason)) = refused(self).first() {
            return Err(format!(
                "effect {id}: no controller can compensate it: {reason}"
            ));
        }
        self.forward_law(sample_time, visitor)
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
