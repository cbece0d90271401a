//! `κ·(x − x0)`, the centre in the middle of the travel or free: of a shape `c` within `c` times [`ASIDE`] of the travel from there.

use super::gravity::is_one_slope;
use super::lack::different_ends;
use super::readout::known;
use super::{BARE, Card, Class, Effect, Fitted, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::signals::Signals;
use crate::diagnose::weak::Column;
use preslide_fit::effects::{Effect as Entry, form};
use preslide_fit::model::Model;
use preslide_fit::statistics::{Estimate, bounds};

/// Share of the travel by which a spring's centre may lie aside of the middle, a little beyond either end: farther out the constant is a matter
/// of its own.
pub const ASIDE: f64 = 0.6;

/// `position_spring`.
pub struct PositionSpring;

static CARD: Card = Card {
    id: form::POSITION_SPRING.id,
    name: "spring over the travel",
    words: "a force in proportion to the position: a cable or a spring, or, where it pushes, magnets or a weight above the axis",
    class: Class::Plain,
    axis: Axis::Position,
    experiment: "the same strokes about two distant positions",
    shape: &[("free_centre", Scale::Chosen)],
    blurred: different_ends,
    formula: Some(|stated| Some(stated.get("stiffness_N_per_m")? * stated.past("centre_m")?)),
    ..BARE
};

impl Effect for PositionSpring {
    fn card(&self) -> &Card {
        &CARD
    }

    fn equivalents(&self, s: &Signals) -> Vec<&'static str> {
        if is_one_slope(s) {
            vec![form::GRAVITY.id]
        } else {
            Vec::new()
        }
    }

    fn shape_in(&self, _: &Entry, model: &Model) -> Vec<f64> {
        // Its centre is free where no constant force stands for it.
        let free = model.constant_force == 0.0;
        free.then_some(1.0).into_iter().collect()
    }

    fn grid(&self, _: &Scene) -> Vec<Vec<f64>> {
        vec![Vec::new(), vec![1.0]]
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        let (from, to) = bounds(&scene.s.x);
        let spring = scene.force(|i| scene.s.x[i] - 0.5 * (from + to));
        let centre = shape
            .first()
            .map(|far| scene.force(|_| far * ASIDE * (to - from)));
        std::iter::once(spring).chain(centre).collect()
    }

    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        match coefficients {
            // One that pushes is possible, too: magnets, an axis that leans over.
            [stiffness] => *stiffness != 0.0,
            // Its centre lies within the travel, or nearly so.
            [stiffness, aside] => stiffness.abs() > aside.abs(),
            _ => false,
        }
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        let (from, to) = bounds(&fitted.scene.s.x);
        let stiffness = fitted.coefficient(0);
        let along = fitted.shape.first().unwrap_or(&1.0) * ASIDE * (to - from);
        let aside = match fitted.coefficient(1) {
            0.0 => 0.0,
            share => along * share / stiffness,
        };
        let centre = 0.5 * (from + to) - aside;
        let errors = fitted.error(0).zip(fitted.error(1));
        let error =
            errors.map(|(own, of_aside)| (along * of_aside).hypot(aside * own) / stiffness.abs());
        vec![
            fitted.entry("stiffness_N_per_m", 0),
            match error {
                Some(_) => ("centre_m".to_owned(), fitted.estimate(centre, error)),
                None => known("centre_m", centre),
            },
        ]
    }
}
