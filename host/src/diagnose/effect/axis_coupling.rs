//! A force in proportion to a further column, its velocity, its direction or its acceleration: gravity, viscous coupling, friction or
//! inertia of another axis.

use super::{BARE, Card, Class, Effect, Fitted, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::signals::mean;
use crate::diagnose::weak::Column;
use preslide_fit::model::Model;
use preslide_fit::recording::Extra;
use preslide_fit::statistics::{Estimate, bounds};

/// Forms, by their number, in front of the column's name.
const FORMS: [&str; 4] = ["", "velocity_of_", "direction_of_", "acceleration_of_"];
/// Share of the highest speed over which a direction changes.
const SMALL: f64 = 0.02;

/// `axis_coupling`.
pub struct AxisCoupling;

static CARD: Card = Card {
    id: "axis_coupling",
    name: "coupling to another axis",
    words: "a force that follows the motion of another axis",
    class: Class::Law,
    axis: Axis::ColumnVelocity(0),
    experiment: "move the other axis alone while this one is held, then this one alone",
    shape: &[("column", Scale::Chosen), ("form", Scale::Chosen)],
    recurs: true,
    ..BARE
};

impl Effect for AxisCoupling {
    fn card(&self) -> &Card {
        &CARD
    }

    fn grid(&self, scene: &Scene) -> Vec<Vec<f64>> {
        let moves = |values: &[f64]| {
            let (from, to) = bounds(values);
            to > from
        };
        let columns = scene.s.extra.iter().enumerate();
        columns
            .filter(|(_, (name, values))| moves(values) && Extra::is_motion(name))
            .flat_map(|(i, _)| (0..FORMS.len()).map(move |form| vec![i as f64, form as f64]))
            .collect()
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        let &[column, form] = shape else {
            return Vec::new();
        };
        let s = scene.s;
        let Some((_, values)) = s.extra.get(column as usize) else {
            return Vec::new();
        };
        vec![Column::of(match form as u8 {
            // A constant is a matter of its own.
            0 => {
                let mean = mean(values);
                values.iter().map(|value| value - mean).collect()
            }
            1 => s.smooth_slope(values),
            2 => direction(&s.smooth_slope(values)),
            _ => s.smooth_slope(&s.smooth_slope(values)),
        })]
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        let &[column, form] = fitted.shape else {
            return Vec::new();
        };
        let name = fitted.scene.s.extra.get(column as usize);
        let name = name.map_or("further column", |extra| &extra.0);
        let of = FORMS[form as usize % FORMS.len()];
        vec![fitted.entry(&format!("coupling_to_{of}{name}"), 0)]
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        let _ = (values, model);
        Err(
            "a model file has no other axis; compensate the coupling where both axes are known"
                .to_owned(),
        )
    }
}

/// Sign of a velocity, smooth through zero.
fn direction(velocity: &[f64]) -> Vec<f64> {
    let top = velocity
        .iter()
        .fold(f64::MIN_POSITIVE, |top, v| top.max(v.abs()));
    velocity
        .iter()
        .map(|v| (v / (SMALL * top)).tanh())
        .collect()
}
