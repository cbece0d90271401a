//! `m = 1 + a·cos(2πx/p + φ)`.

use super::lack::both_directions;
use super::readout::enter;
use super::torque_ripple::TorqueRipple;
use super::wave::{amplitude_phase_and_shape, wave};
use super::{Class, Effect, Fitted, Line, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::signals::Signals;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;

/// `periodic_friction`.
pub struct PeriodicFriction;

impl Effect for PeriodicFriction {
    fn id(&self) -> &'static str {
        form::PERIODIC_FRICTION.id
    }

    fn name(&self) -> &'static str {
        "friction ripple"
    }

    fn words(&self) -> &'static str {
        "a friction level with a fixed period in position: screw or ball passage"
    }

    fn class(&self) -> Class {
        Class::Place
    }

    fn axis(&self) -> Axis {
        Axis::Position
    }

    fn experiment(&self) -> &'static str {
        "slow passes over several periods in both directions: friction flips with the direction"
    }

    fn recurs(&self) -> bool {
        true
    }

    /// A ripple of all that resists the motion, viscous friction too, differs from it by inertia and weight alone.
    fn in_place(&self) -> &'static [&'static dyn Effect] {
        &[&TorqueRipple]
    }

    fn lacks(&self, s: &Signals) -> Option<&'static str> {
        both_directions(s)
    }

    fn shape(&self) -> &'static [(&'static str, Scale)] {
        &[("period_m", Scale::Period)]
    }

    fn grid(&self, _: &Scene) -> Vec<Vec<f64>> {
        Vec::new()
    }

    fn line(&self) -> Option<Line> {
        Some(Line::Level)
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        let &[period] = shape else {
            return Vec::new();
        };
        wave(&scene.s.x, period)
            .map(|wave| scene.friction(|i| wave[i]))
            .to_vec()
    }

    /// Friction does not push: its level stays above zero.
    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        coefficients.iter().map(|c| c * c).sum::<f64>() < 1.0
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        amplitude_phase_and_shape("level", self, fitted)
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        enter(self.id(), values, &[], model)
    }
}
