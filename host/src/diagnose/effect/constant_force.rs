//! `F0`: gravity, tilt, current offset.

use super::coulomb_asymmetry::CoulombAsymmetry;
use super::lack::both_directions;
use super::readout::value_of;
use super::{Class, Effect, Fitted, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::signals::Signals;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;

/// Key of its force.
const FORCE: &str = "force_N";

/// `constant_force`.
pub struct ConstantForce;

impl Effect for ConstantForce {
    fn id(&self) -> &'static str {
        form::CONSTANT_FORCE.id
    }

    fn name(&self) -> &'static str {
        "constant force"
    }

    fn words(&self) -> &'static str {
        "a constant force: gravity, tilt or a current offset"
    }

    fn class(&self) -> Class {
        Class::Plain
    }

    fn axis(&self) -> Axis {
        Axis::Velocity
    }

    fn experiment(&self) -> &'static str {
        "turn the stage end for end: a tilt changes its sign, an asymmetry of friction does not; or change the load"
    }

    fn lacks(&self, s: &Signals) -> Option<&'static str> {
        both_directions(s)
    }

    fn equivalents(&self, _: &Signals) -> &'static [&'static dyn Effect] {
        &[&CoulombAsymmetry]
    }

    /// Two names of one force to every fit: together each would have a part of it.
    fn excludes(&self, _: &[f64]) -> &'static [&'static dyn Effect] {
        &[&CoulombAsymmetry]
    }

    fn columns(&self, _: &[f64], scene: &Scene) -> Vec<Column> {
        vec![scene.force(|_| 1.0)]
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        fitted.one(FORCE, self)
    }

    fn in_model(&self, model: &Model) -> Vec<Vec<f64>> {
        let listed = model.effects.iter().any(|e| e.id() == self.id());
        let present = model.constant_force != 0.0 || listed;
        present.then(Vec::new).into_iter().collect()
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        model.constant_force += value_of(values, FORCE);
        Ok(())
    }
}
