//! Command `= F + ½·width·sgn F`.

use super::readout::enter;
use super::{Class, Effect, Fitted, Part, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;

/// Share of the friction level over which the sign changes.
const SMALL: f64 = 0.03;

/// `actuator_dead_zone`.
pub struct ActuatorDeadZone;

impl Effect for ActuatorDeadZone {
    fn id(&self) -> &'static str {
        form::ACTUATOR_DEAD_ZONE.id
    }

    fn name(&self) -> &'static str {
        "dead zone of the drive"
    }

    fn words(&self) -> &'static str {
        "a drive that gives nothing at small commands"
    }

    fn class(&self) -> Class {
        Class::Drive
    }

    fn axis(&self) -> Axis {
        Axis::Time
    }

    fn experiment(&self) -> &'static str {
        "a slow ramp of the command through zero at rest, with the force measured"
    }

    fn shown_by(&self) -> &'static [Part] {
        &[Part::Nested]
    }

    fn columns(&self, _: &[f64], scene: &Scene) -> Vec<Column> {
        let (fitted, level) = (&scene.core.fitted, scene.core.level);
        vec![scene.force(|i| 0.5 * (fitted[i] / (SMALL * level)).tanh())]
    }

    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        matches!(coefficients, [c] if *c > 0.0)
    }

    fn acts_on_effort(&self) -> bool {
        true
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        fitted.one("width_N", self)
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        enter(self.id(), values, &[], model)
    }
}
