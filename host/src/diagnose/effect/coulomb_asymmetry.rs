//! `m = 1 + a·sgn F`, which is `sgn v` in sliding.

use super::constant_force::ConstantForce;
use super::lack::both_directions;
use super::readout::enter;
use super::{Class, Effect, Fitted, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::signals::Signals;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;

/// Share of the friction level over which its sign changes.
pub(in crate::diagnose) const SMALL: f64 = 0.1;

/// `coulomb_asymmetry`.
pub struct CoulombAsymmetry;

impl Effect for CoulombAsymmetry {
    fn id(&self) -> &'static str {
        form::COULOMB_ASYMMETRY.id
    }

    fn name(&self) -> &'static str {
        "friction that differs by direction"
    }

    fn words(&self) -> &'static str {
        "friction that differs by direction"
    }

    fn class(&self) -> Class {
        Class::Plain
    }

    fn axis(&self) -> Axis {
        Axis::Velocity
    }

    fn experiment(&self) -> &'static str {
        "turn the stage end for end, or change the load: an asymmetry scales with the friction level"
    }

    fn lacks(&self, s: &Signals) -> Option<&'static str> {
        both_directions(s)
    }

    fn equivalents(&self, _: &Signals) -> &'static [&'static dyn Effect] {
        &[&ConstantForce]
    }

    /// Two names of one force to every fit: together each would have a part of it.
    fn excludes(&self, _: &[f64]) -> &'static [&'static dyn Effect] {
        &[&ConstantForce]
    }

    fn columns(&self, _: &[f64], scene: &Scene) -> Vec<Column> {
        let (friction, level) = (&scene.core.friction, scene.core.level);
        vec![scene.friction(|i| (friction[i] / (SMALL * level)).tanh())]
    }

    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        // Friction does not push, in neither direction.
        matches!(coefficients, [c] if c.abs() < 1.0)
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        fitted.one("asymmetry", self)
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        enter(self.id(), values, &[], model)
    }
}
