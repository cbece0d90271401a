//! `m = 1 + Σ c_j·cos(jπu)` over the travel: preload, wear.

use super::cosines::{COUNTS, cosines, map};
use super::lack::{both_directions, different_ends};
use super::{BARE, Card, Class, Effect, Fitted, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::weak::Column;
use preslide_fit::effects::{Effect as Entry, form};
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;
use std::f64::consts::PI;

/// Places at which the level is looked at.
const PLACES: i32 = 64;

/// `position_friction`.
pub struct PositionFriction;

static CARD: Card = Card {
    id: form::POSITION_FRICTION.id,
    name: "friction map over the travel",
    words: "a friction level that varies over the travel",
    class: Class::Place,
    axis: Axis::Position,
    experiment: "slow passes over the whole travel in both directions, repeated later",
    shape: &[("terms", Scale::Chosen)],
    lacks: both_directions,
    blurred: different_ends,
    formula: Some(|stated| Some(stated.friction(stated.cosines("")?))),
    ..BARE
};

impl Effect for PositionFriction {
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
        let columns = cosines(scene.s, count);
        columns.iter().map(|c| scene.friction(|i| c[i])).collect()
    }

    /// Friction does not push: its level stays above zero along the travel.
    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        let level = |u: f64| -> f64 {
            let cosines = coefficients.iter().zip(1..);
            1.0 + cosines
                .map(|(c, j)| c * (PI * f64::from(j) * u).cos())
                .sum::<f64>()
        };
        (0..=PLACES).all(|i| level(f64::from(i) / f64::from(PLACES)) > 0.0)
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        map(fitted, fitted.coefficients.len(), "")
    }
}
