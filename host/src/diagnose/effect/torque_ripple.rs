//! `F = command·(1 + a·cos(2πx/p + φ))`: the motor's constant over its angle.

use super::readout::enter;
use super::wave::{amplitude_phase_and_shape, wave};
use super::{Class, Effect, Fitted, Line, Part, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;

/// `torque_ripple`.
pub struct TorqueRipple;

impl Effect for TorqueRipple {
    fn id(&self) -> &'static str {
        form::TORQUE_RIPPLE.id
    }

    fn name(&self) -> &'static str {
        "ripple in proportion to the current"
    }

    fn words(&self) -> &'static str {
        "a motor whose force for a given current varies with its position: torque ripple"
    }

    fn class(&self) -> Class {
        Class::Drive
    }

    fn axis(&self) -> Axis {
        Axis::Position
    }

    fn experiment(&self) -> &'static str {
        "slow constant-speed passes with two loads or against a spring: torque ripple grows with the force, cogging stays"
    }

    fn shown_by(&self) -> &'static [Part] {
        &[Part::Passes, Part::Fast]
    }

    fn shape(&self) -> &'static [(&'static str, Scale)] {
        &[("period_m", Scale::Period)]
    }

    fn grid(&self, _: &Scene) -> Vec<Vec<f64>> {
        Vec::new()
    }

    fn line(&self) -> Option<Line> {
        Some(Line::Effort)
    }

    /// What the drive is asked for beyond the force, to first order in the share.
    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        let &[period] = shape else {
            return Vec::new();
        };
        let waves = wave(&scene.s.x, period);
        let more = waves.map(|wave| scene.force(|i| -wave[i] * scene.core.fitted[i]));
        more.to_vec()
    }

    fn acts_on_effort(&self) -> bool {
        true
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        amplitude_phase_and_shape("share", self, fitted)
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        enter(self.id(), values, &[], model)
    }
}
