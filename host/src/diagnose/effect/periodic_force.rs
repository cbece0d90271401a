//! `A·cos(2πx/p + φ)`.

use super::readout::enter;
use super::wave::{amplitude_phase_and_shape, wave};
use super::{Class, Effect, Fitted, Line, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;

/// `periodic_force`.
pub struct PeriodicForce;

impl Effect for PeriodicForce {
    fn id(&self) -> &'static str {
        form::PERIODIC_FORCE.id
    }

    fn name(&self) -> &'static str {
        "cogging or torque ripple"
    }

    fn words(&self) -> &'static str {
        "a force with a fixed period in position: cogging or torque ripple"
    }

    fn class(&self) -> Class {
        Class::Place
    }

    fn axis(&self) -> Axis {
        Axis::Position
    }

    fn experiment(&self) -> &'static str {
        "slow constant-speed passes at two speeds and with the motor off (pushed): cogging stays"
    }

    fn recurs(&self) -> bool {
        true
    }

    fn shape(&self) -> &'static [(&'static str, Scale)] {
        &[("period_m", Scale::Period)]
    }

    fn grid(&self, _: &Scene) -> Vec<Vec<f64>> {
        Vec::new()
    }

    fn line(&self) -> Option<Line> {
        Some(Line::Force)
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        let &[period] = shape else {
            return Vec::new();
        };
        wave(&scene.s.x, period).map(Column::of).to_vec()
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        amplitude_phase_and_shape("force_N", self, fitted)
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        enter(self.id(), values, &[], model)
    }
}
