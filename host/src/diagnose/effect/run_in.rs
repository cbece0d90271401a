//! `m = 1 + a·exp(−s/λ)` in travelled path.

use super::grid::one;
use super::readout::enter;
use super::thermal_drift::{ThermalDrift, goes_one_way};
use super::{Class, Effect, Fitted, Part, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::signals::Signals;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;

/// `run_in`.
pub struct RunIn;

/// Longest way of a decay, in recorded ones: over a longer one a falling level looks like another level.
const LONGEST: f64 = 2.0;

impl Effect for RunIn {
    fn id(&self) -> &'static str {
        form::RUN_IN.id
    }

    fn name(&self) -> &'static str {
        "run-in"
    }

    fn words(&self) -> &'static str {
        "a friction level that decays with travelled path"
    }

    fn class(&self) -> Class {
        Class::Drift
    }

    fn axis(&self) -> Axis {
        Axis::Path
    }

    fn experiment(&self) -> &'static str {
        "a rest of an hour in between: run-in stays, temperature does not"
    }

    fn lacks(&self, s: &Signals) -> Option<&'static str> {
        let path = s.path.last().copied().unwrap_or(0.0);
        (path < 10.0 * s.travel()).then_some("a long run")
    }

    fn equivalents(&self, s: &Signals) -> &'static [&'static dyn Effect] {
        if goes_one_way(s) {
            &[&ThermalDrift]
        } else {
            &[]
        }
    }

    fn shape(&self) -> &'static [(&'static str, Scale)] {
        &[("path_m", Scale::Logarithmic)]
    }

    fn grid(&self, scene: &Scene) -> Vec<Vec<f64>> {
        let path = scene.s.path.last().copied().unwrap_or(0.0);
        one(path / 20.0, path * LONGEST, 5)
    }

    fn within(&self, scene: &Scene, shape: &[f64], index: usize) -> f64 {
        let path = scene.s.path.last().copied().unwrap_or(0.0);
        shape[index].min(path * LONGEST)
    }

    fn shown_by(&self) -> &'static [Part] {
        &[Part::Again]
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        let &[decay] = shape else {
            return Vec::new();
        };
        let path = &scene.s.path;
        vec![scene.friction(|i| (-path[i] / decay).exp())]
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        fitted.one("level", self)
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        enter(self.id(), values, &[], model)
    }
}
