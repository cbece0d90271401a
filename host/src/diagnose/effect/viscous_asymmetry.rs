//! `d·|v|`: viscous friction is `d` more forwards than its mean, and `d` less backwards.

use super::lack::{both_directions, several_speeds};
use super::{BARE, Card, Class, Effect, Part, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;

/// `viscous_asymmetry`.
pub struct ViscousAsymmetry;

static CARD: Card = Card {
    id: form::VISCOUS_ASYMMETRY.id,
    name: "viscous friction that differs by direction",
    words: "viscous friction that is higher one way than the other",
    class: Class::Plain,
    axis: Axis::Velocity,
    experiment: "strokes at 1, 3 and 10 times the speed, in both directions",
    shown_by: &[Part::Speeds],
    coefficient: "half_difference_N_s_per_m",
    lacks: |s| both_directions(s).or_else(|| several_speeds(s)),
    ..BARE
};

impl Effect for ViscousAsymmetry {
    fn card(&self) -> &Card {
        &CARD
    }

    fn columns(&self, _: &[f64], scene: &Scene) -> Vec<Column> {
        let v = &scene.s.v;
        vec![scene.force(|i| v[i].abs())]
    }
}
