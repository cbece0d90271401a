//! `F` held within ± limit.

use super::grid::one;
use super::readout::enter;
use super::{BARE, Card, Class, Effect, Part, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::model::Model;
use preslide_fit::statistics::{Estimate, quantile_between_ranks};

/// Share of the samples that stay below the limit at least: the column is made of the measured effort, and with a limit below most of
/// it the effort would explain itself.
const RARE: f64 = 0.95;
/// Share of what the motion takes at the largest efforts that must be inertia's. A drive that gives less than it is asked for accelerates less;
/// where the motion is steady it gives what friction takes, and an effort above that is a force that the model lacks.
const ACCELERATES: f64 = 0.3;
/// Key of the coefficient: how much of the command above the limit is lost.
const SHARE: &str = "share";
/// Key of the end of a reading, which is the sensor's and no machine's.
pub const READING: &str = "reading_limit_N";

/// `actuator_saturation`.
pub struct ActuatorSaturation;

static CARD: Card = Card {
    id: form::ACTUATOR_SATURATION.id,
    name: "saturation of the drive",
    words: "a drive that gives less than it is asked for",
    class: Class::Drive,
    axis: Axis::Time,
    experiment: "the same motion with half the acceleration",
    shown_by: &[Part::Fast],
    coefficient: SHARE,
    shape: &[("limit_N", Scale::Logarithmic)],
    acts_on_effort: true,
    ..BARE
};

impl Effect for ActuatorSaturation {
    fn card(&self) -> &Card {
        &CARD
    }

    fn grid(&self, scene: &Scene) -> Vec<Vec<f64>> {
        let rare = exceeded(scene, RARE);
        if !accelerates(scene, rare) {
            return Vec::new();
        }
        one(rare, 0.95 * exceeded(scene, 0.9999), 16)
    }

    fn within(&self, scene: &Scene, shape: &[f64], index: usize) -> f64 {
        shape[index].max(exceeded(scene, RARE))
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        let &[limit] = shape else {
            return Vec::new();
        };
        let effort = scene.effort;
        vec![scene.force(|i| effort[i].signum() * (effort[i].abs() - limit).max(0.0))]
    }

    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        // All that is commanded above the limit is lost, and no more: a load that rings asks for more than it takes, too.
        matches!(coefficients, [c] if (0.7..1.2).contains(c))
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        if values.iter().any(|(key, _)| key == READING) {
            return Err("the reading ends there, not the drive, and a model file describes the machine; the parameters are fitted without the samples at the end".to_owned());
        }
        enter(self.id(), values, &[SHARE], model)
    }
}

/// Whether inertia takes its share of the motion where the effort is larger than this.
fn accelerates(scene: &Scene, least: f64) -> bool {
    let core = scene.core;
    let (mut inertia, mut whole) = (0.0, 0.0);
    for (i, effort) in scene.effort.iter().enumerate() {
        if effort.abs() > least {
            let own = core.mass * scene.s.a[i] * effort.signum();
            inertia += own;
            whole += own + core.friction[i] * effort.signum();
        }
    }
    inertia >= ACCELERATES * whole
}

/// The effort that the share `q` of the samples stays below (N or N·m).
fn exceeded(scene: &Scene, q: f64) -> f64 {
    let size: Vec<f64> = scene.effort.iter().map(|f| f.abs()).collect();
    quantile_between_ranks(&size, q)
}
