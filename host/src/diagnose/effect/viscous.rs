//! `b·v`.

use super::lack::several_speeds;
use super::readout::value_of;
use super::{BARE, Card, Class, Effect, Part, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::expr::Expr;
use crate::diagnose::expr::Input::Velocity;
use crate::diagnose::normal::Bound;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;

/// Key of its coefficient.
const COEFFICIENT: &str = "viscous_N_s_per_m";

/// `viscous`.
pub struct Viscous;

static CARD: Card = Card {
    id: form::VISCOUS.id,
    name: "viscous friction",
    words: "a force proportional to velocity",
    class: Class::Plain,
    axis: Axis::Velocity,
    experiment: "strokes at 1, 3 and 10 times the speed, long enough for constant velocity",
    shown_by: &[Part::Speeds],
    coefficient: COEFFICIENT,
    bound: Bound::NonNegative,
    lacks: several_speeds,
    formula: Some(|stated| Some(stated.get(COEFFICIENT)? * Expr::from(Velocity))),
    ..BARE
};

impl Effect for Viscous {
    fn card(&self) -> &Card {
        &CARD
    }

    fn columns(&self, _: &[f64], scene: &Scene) -> Vec<Column> {
        vec![Column {
            sloped: scene.s.x.clone(),
            ..Column::default()
        }]
    }

    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        matches!(coefficients, [c] if *c > 0.0)
    }

    fn in_model(&self, model: &Model) -> Vec<Vec<f64>> {
        let present = model.viscous != 0.0;
        present.then(Vec::new).into_iter().collect()
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        model.viscous += value_of(values, COEFFICIENT);
        Ok(())
    }
}
