//! `c·v·|v|`.

use super::lack::several_speeds;
use super::readout::enter;
use super::{Class, Effect, Fitted, Part, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::normal::Bound;
use crate::diagnose::signals::Signals;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;

/// `quadratic_drag`.
pub struct QuadraticDrag;

impl Effect for QuadraticDrag {
    fn id(&self) -> &'static str {
        form::QUADRATIC_DRAG.id
    }

    fn name(&self) -> &'static str {
        "quadratic drag"
    }

    fn words(&self) -> &'static str {
        "a force that grows with the square of velocity"
    }

    fn class(&self) -> Class {
        Class::Plain
    }

    fn axis(&self) -> Axis {
        Axis::Velocity
    }

    fn experiment(&self) -> &'static str {
        "constant speeds over a decade, up to the highest"
    }

    fn shown_by(&self) -> &'static [Part] {
        &[Part::Speeds]
    }

    fn lacks(&self, s: &Signals) -> Option<&'static str> {
        several_speeds(s)
    }

    fn columns(&self, _: &[f64], scene: &Scene) -> Vec<Column> {
        let v = &scene.s.v;
        vec![scene.force(|i| v[i] * v[i].abs())]
    }

    fn bound(&self) -> Bound {
        Bound::NonNegative
    }

    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        matches!(coefficients, [c] if *c > 0.0)
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        fitted.one("drag_N_s2_per_m2", self)
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        enter(self.id(), values, &[], model)
    }
}
