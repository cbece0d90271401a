//! `b·v`.

use super::lack::several_speeds;
use super::readout::value_of;
use super::{Class, Effect, Fitted, Part, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::normal::Bound;
use crate::diagnose::signals::Signals;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;

/// Key of its coefficient.
const COEFFICIENT: &str = "viscous_N_s_per_m";

/// `viscous`.
pub struct Viscous;

impl Effect for Viscous {
    fn id(&self) -> &'static str {
        form::VISCOUS.id
    }

    fn name(&self) -> &'static str {
        "viscous friction"
    }

    fn words(&self) -> &'static str {
        "a force proportional to velocity"
    }

    fn class(&self) -> Class {
        Class::Plain
    }

    fn axis(&self) -> Axis {
        Axis::Velocity
    }

    fn experiment(&self) -> &'static str {
        "strokes at 1, 3 and 10 times the speed, long enough for constant velocity"
    }

    fn shown_by(&self) -> &'static [Part] {
        &[Part::Speeds]
    }

    fn lacks(&self, s: &Signals) -> Option<&'static str> {
        several_speeds(s)
    }

    fn columns(&self, _: &[f64], scene: &Scene) -> Vec<Column> {
        vec![Column {
            sloped: scene.s.x.clone(),
            ..Column::default()
        }]
    }

    fn bound(&self) -> Bound {
        Bound::NonNegative
    }

    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        matches!(coefficients, [c] if *c > 0.0)
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        fitted.one(COEFFICIENT, self)
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
