//! `c·v·|v|`.

use super::lack::several_speeds;
use super::{BARE, Card, Class, Effect, Part, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::normal::Bound;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;

/// `quadratic_drag`.
pub struct QuadraticDrag;

static CARD: Card = Card {
    id: form::QUADRATIC_DRAG.id,
    name: "quadratic drag",
    words: "a force that grows with the square of velocity",
    class: Class::Plain,
    axis: Axis::Velocity,
    experiment: "constant speeds over a decade, up to the highest",
    shown_by: &[Part::Speeds],
    coefficient: "drag_N_s2_per_m2",
    bound: Bound::NonNegative,
    lacks: several_speeds,
    ..BARE
};

impl Effect for QuadraticDrag {
    fn card(&self) -> &Card {
        &CARD
    }

    fn columns(&self, _: &[f64], scene: &Scene) -> Vec<Column> {
        let v = &scene.s.v;
        vec![scene.force(|i| v[i] * v[i].abs())]
    }

    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        matches!(coefficients, [c] if *c > 0.0)
    }
}
