//! The force is recorded `τ` after the motion: `−τ·dF/dt`.

use super::readout::enter;
use super::{Class, Effect, Fitted, Part, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;

/// `channel_delay`.
pub struct ChannelDelay;

/// The column of a delay of an effort at the samples.
pub(in crate::diagnose) fn late(effort: &[f64]) -> Column {
    Column {
        sloped: effort.iter().map(|f| -f).collect(),
        ..Column::default()
    }
}

impl Effect for ChannelDelay {
    fn id(&self) -> &'static str {
        form::CHANNEL_DELAY.id
    }

    fn name(&self) -> &'static str {
        "time shift between channels"
    }

    fn words(&self) -> &'static str {
        "force and position sampled at different times"
    }

    fn class(&self) -> Class {
        Class::Drive
    }

    fn axis(&self) -> Axis {
        Axis::Acceleration
    }

    fn experiment(&self) -> &'static str {
        "fast sine motion at two frequencies: a delay's phase grows in proportion"
    }

    fn shown_by(&self) -> &'static [Part] {
        &[Part::Fast, Part::Nested]
    }

    fn columns(&self, _: &[f64], scene: &Scene) -> Vec<Column> {
        vec![late(&scene.core.fitted)]
    }

    /// A sample between reading the position and writing the force is how controllers work.
    fn is_harmless(&self, scene: &Scene, coefficients: &[f64]) -> bool {
        coefficients.iter().all(|delay| delay.abs() <= scene.s.dt)
    }

    fn acts_on_effort(&self) -> bool {
        true
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        fitted.one("delay_s", self)
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        enter(self.id(), values, &[], model)
    }
}
