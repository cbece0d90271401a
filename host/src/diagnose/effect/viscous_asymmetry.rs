//! `d·|v|`: viscous friction is `d` more forwards than its mean, and `d` less backwards.

use super::lack::{both_directions, several_speeds};
use super::readout::enter;
use super::{Class, Effect, Fitted, Part, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::signals::Signals;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;

/// `viscous_asymmetry`.
pub struct ViscousAsymmetry;

impl Effect for ViscousAsymmetry {
    fn id(&self) -> &'static str {
        form::VISCOUS_ASYMMETRY.id
    }

    fn name(&self) -> &'static str {
        "viscous friction that differs by direction"
    }

    fn words(&self) -> &'static str {
        "viscous friction that is higher one way than the other"
    }

    fn class(&self) -> Class {
        Class::Plain
    }

    fn axis(&self) -> Axis {
        Axis::Velocity
    }

    fn experiment(&self) -> &'static str {
        "strokes at 1, 3 and 10 times the speed, in both directions"
    }

    fn shown_by(&self) -> &'static [Part] {
        &[Part::Speeds]
    }

    fn lacks(&self, s: &Signals) -> Option<&'static str> {
        both_directions(s).or_else(|| several_speeds(s))
    }

    fn columns(&self, _: &[f64], scene: &Scene) -> Vec<Column> {
        let v = &scene.s.v;
        vec![scene.force(|i| v[i].abs())]
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        fitted.one("half_difference_N_s_per_m", self)
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        enter(self.id(), values, &[], model)
    }
}
