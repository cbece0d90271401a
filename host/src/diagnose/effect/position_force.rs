//! `Σ c_j·cos(jπu)` over the travel, with its mean where that is no force of its own.

use super::cosines::{COUNTS, cosines, map};
use super::lack::different_ends;
use super::readout::{enter, value_of};
use super::{BARE, Card, Class, Effect, Fitted, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::expr::Expr;
use crate::diagnose::weak::Column;
use preslide_fit::effects::{Effect as Entry, form};
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;

/// Key of the mean, which a model file has as its constant force.
const MEAN: &str = "constant_N";

/// `position_force`.
pub struct PositionForce;

static CARD: Card = Card {
    id: form::POSITION_FORCE.id,
    name: "force map over the travel",
    words: "a force that depends on position, the same in both directions",
    class: Class::Place,
    axis: Axis::Position,
    experiment: "slow passes over the whole travel in both directions",
    shape: &[("terms", Scale::Chosen), ("with_mean", Scale::Chosen)],
    blurred: different_ends,
    formula: Some(|stated| {
        let map = stated.cosines("_N")?;
        Some(match stated.get("constant_N") {
            Some(mean) => map + Expr::Number(mean),
            None => map,
        })
    }),
    ..BARE
};

impl Effect for PositionForce {
    fn card(&self) -> &Card {
        &CARD
    }

    fn shape_in(&self, entry: &Entry, _: &Model) -> Vec<f64> {
        vec![entry.cosines().len() as f64]
    }

    fn grid(&self, _: &Scene) -> Vec<Vec<f64>> {
        COUNTS.map(|count| vec![count]).to_vec()
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        let Some(&count) = shape.first() else {
            return Vec::new();
        };
        let mean = shape.get(1).map(|_| vec![1.0; scene.s.x.len()]);
        let columns = cosines(scene.s, count).into_iter().chain(mean);
        columns.map(Column::of).collect()
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        let count = fitted.shape.first().map_or(0, |count| *count as usize);
        let mut values = map(fitted, count, "_N");
        if fitted.coefficients.len() > count {
            values.insert(0, fitted.entry(MEAN, count));
        }
        values
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        enter(self.id(), values, &[MEAN], model)?;
        model.constant_force += value_of(values, MEAN);
        Ok(())
    }
}
