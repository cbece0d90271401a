//! `m = 1 + a·exp(−((x − x_s)/w)²)`.

use super::lack::{both_directions, different_ends};
use super::{BARE, Card, Class, Effect, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::expr::Function::{Abs, Exp};
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::statistics::{bounds, spread};

/// Number of the width among the shape parameters.
const WIDTH: usize = 1;
/// Largest width, of the travel: three widths hold 97 % of a spot, and what fills more than half of the travel is a map of it. Chosen after
/// looking at axes of seeds 1, 2 and 3 (spots 0.09 to 0.13, maps that were taken for spots 0.25 to 0.43).
const WIDEST: f64 = 1.0 / 6.0;

/// Times its level that friction is more at a spot, at most: a drive is seldom good for as much. Set by hand, after a gap had made spots of 24.
const BINDS: f64 = 5.0;

/// `local_friction_spot`.
pub struct LocalFrictionSpot;

static CARD: Card = Card {
    id: form::LOCAL_FRICTION_SPOT.id,
    name: "friction spot",
    words: "a narrow place of higher or lower friction",
    class: Class::Place,
    axis: Axis::Position,
    experiment: "slow passes over the place, started from both sides",
    coefficient: "level",
    shape: &[
        ("position_m", Scale::Travel),
        ("width_m", Scale::Logarithmic),
    ],
    recurs: true,
    is_spot: true,
    lacks: both_directions,
    blurred: different_ends,
    formula: Some(|stated| {
        let aside = 1.0 / stated.get("width_m")? * stated.past("position_m")?;
        let bell = (-1.0 * aside.of(Abs).power(2.0)).of(Exp);
        Some(stated.friction(stated.get("level")? * bell))
    }),
    ..BARE
};

impl Effect for LocalFrictionSpot {
    fn card(&self) -> &Card {
        &CARD
    }

    fn grid(&self, scene: &Scene) -> Vec<Vec<f64>> {
        let (from, to) = bounds(&scene.s.x);
        let travel = to - from;
        let widths = spread(travel / 120.0, travel / 10.0, 4);
        let places = |width: f64| {
            let count = (travel / width).ceil() as usize;
            let place = move |i: usize| from + travel * i as f64 / count as f64;
            (0..=count).map(move |i| vec![place(i), width])
        };
        widths.into_iter().flat_map(places).collect()
    }

    fn within(&self, scene: &Scene, shape: &[f64], index: usize) -> f64 {
        let value = shape[index];
        if index == WIDTH {
            value.min(WIDEST * scene.s.travel())
        } else {
            value
        }
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        let &[position, width] = shape else {
            return Vec::new();
        };
        let x = &scene.s.x;
        vec![scene.friction(|i| (-((x[i] - position) / width).powi(2)).exp())]
    }

    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        // Friction does not push, and where it is many times its level the axis would bind: there it is something else.
        matches!(coefficients, [c] if *c > -1.0 && *c < BINDS)
    }
}
