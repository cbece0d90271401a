//! A play of the whole width `gap` between motor and load.

use super::drive_compliance::MOTOR_SHARE;
use super::grid::one;
use super::lack::both_directions;
use super::readout::enter;
use super::{Class, Effect, Fitted, Part, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::signals::Signals;
use crate::diagnose::weak::Column;
use crate::identify::estimate::Estimate;
use crate::identify::stop::Deflection;
use crate::model::Model;

/// Key of the coefficient: how much of the difference that the gap makes is there.
const SHARE: &str = "share";
/// Share of the friction level over which the transmitted effort changes sides.
const SMALL: f64 = 0.05;

/// `backlash`.
pub struct Backlash;

impl Effect for Backlash {
    fn id(&self) -> &'static str {
        "backlash"
    }

    fn name(&self) -> &'static str {
        "backlash"
    }

    fn words(&self) -> &'static str {
        "a gap between motor and load"
    }

    fn class(&self) -> Class {
        Class::Drive
    }

    fn axis(&self) -> Axis {
        Axis::SinceReversal
    }

    fn experiment(&self) -> &'static str {
        "slow reversals under a constant push to one side"
    }

    fn shown_by(&self) -> &'static [Part] {
        &[Part::Nested]
    }

    fn lacks(&self, s: &Signals) -> Option<&'static str> {
        both_directions(s)
    }

    fn shape(&self) -> &'static [(&'static str, Scale)] {
        &[("gap_m", Scale::Logarithmic)]
    }

    fn grid(&self, scene: &Scene) -> Vec<Vec<f64>> {
        let shortest = shortest_yield(scene);
        let longest = (200.0 * shortest).min(scene.s.travel() / 20.0);
        one(shortest, longest, 9)
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        let &[gap] = shape else {
            return Vec::new();
        };
        let (s, core) = (scene.s, scene.core);
        // The gap is crossed where the transmitted effort changes sign.
        let side = scene.sampled(|i| {
            let transmitted = core.fitted[i] - MOTOR_SHARE * core.mass * s.a[i];
            0.5 * gap * (transmitted / (SMALL * core.level)).tanh()
        });
        // A gap is not small beside the yields: the blocks follow the load's path itself.
        let load = scene.sampled(|i| s.x[i] - side[i]);
        let mut value: Vec<f64> = core.friction.iter().map(|f| -f).collect();
        for &(k, d) in &core.blocks {
            let z = Deflection::along(&load, &s.pieces, d).z;
            value.iter_mut().zip(&z).for_each(|(c, z)| *c += k * z);
        }
        let mass = (1.0 - MOTOR_SHARE) * core.mass;
        vec![Column {
            value,
            sloped: Vec::new(),
            curved: side.iter().map(|e| -mass * e).collect(),
        }]
    }

    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        // The whole difference that the gap makes, or it is none.
        matches!(coefficients, [c] if (0.4..1.6).contains(c))
    }

    fn acts_on_effort(&self) -> bool {
        true
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        fitted.one(SHARE, self)
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        enter(self.id(), values, &[SHARE], model)
    }
}

/// The shortest yield that carries a hundredth of the friction (m or rad).
fn shortest_yield(scene: &Scene) -> f64 {
    let core = scene.core;
    let carrying = core
        .blocks
        .iter()
        .filter(|(k, d)| k * d > 0.01 * core.level);
    carrying.map(|b| b.1).fold(1.0, f64::min)
}
