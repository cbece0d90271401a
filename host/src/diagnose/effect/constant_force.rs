//! `F0`: gravity, tilt, current offset.

use super::lack::both_directions;
use super::readout::value_of;
use super::{BARE, Card, Class, Effect, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::expr::Expr;
use crate::diagnose::signals::Signals;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;

/// Key of its force.
const FORCE: &str = "force_N";

/// `constant_force`.
pub struct ConstantForce;

static CARD: Card = Card {
    id: form::CONSTANT_FORCE.id,
    name: "constant force",
    words: "a constant force: gravity, tilt or a current offset",
    class: Class::Plain,
    axis: Axis::Velocity,
    experiment: "turn the stage end for end: a tilt changes its sign, an asymmetry of friction does not; or change the load",
    coefficient: FORCE,
    lacks: both_directions,
    formula: Some(|stated| Some(Expr::Number(stated.get(FORCE)?))),
    ..BARE
};

impl Effect for ConstantForce {
    fn card(&self) -> &Card {
        &CARD
    }

    fn equivalents(&self, _: &Signals) -> Vec<&'static str> {
        vec![form::COULOMB_ASYMMETRY.id]
    }

    /// Two names of one force to every fit: together each would have a part of it.
    fn excludes(&self, _: &[f64]) -> Vec<&'static str> {
        vec![form::COULOMB_ASYMMETRY.id]
    }

    fn columns(&self, _: &[f64], scene: &Scene) -> Vec<Column> {
        vec![scene.force(|_| 1.0)]
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
