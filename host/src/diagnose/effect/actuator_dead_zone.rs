//! Command `= F + ½·width·sgn F`.

use super::{BARE, Card, Class, Effect, Part, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;

/// Share of the friction level over which the sign changes.
const SMALL: f64 = 0.03;

/// `actuator_dead_zone`.
pub struct ActuatorDeadZone;

static CARD: Card = Card {
    id: form::ACTUATOR_DEAD_ZONE.id,
    name: "dead zone of the drive",
    words: "a drive that gives nothing at small commands",
    class: Class::Drive,
    axis: Axis::Time,
    experiment: "a slow ramp of the command through zero at rest, with the force measured",
    shown_by: &[Part::Nested],
    coefficient: "width_N",
    acts_on_effort: true,
    ..BARE
};

impl Effect for ActuatorDeadZone {
    fn card(&self) -> &Card {
        &CARD
    }

    fn columns(&self, _: &[f64], scene: &Scene) -> Vec<Column> {
        let (fitted, level) = (&scene.core.fitted, scene.core.level);
        vec![scene.force(|i| 0.5 * (fitted[i] / (SMALL * level)).tanh())]
    }

    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        matches!(coefficients, [c] if *c > 0.0)
    }
}
