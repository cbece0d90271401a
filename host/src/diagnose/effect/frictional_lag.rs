//! `m = 1 + a·exp(−(|v|/v_s)^δ)`, following with a time constant.

use super::grid::falling;
use super::lack::several_speeds;
use super::stribeck::{EXPONENT, STEEPEST, exponent, falls, storable};
use super::{BARE, Card, Class, Effect, Part, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::statistics::spread;

/// Place of the time constant in the shape.
const LAG: usize = 2;
/// Shortest time constant (s): 0.6 of the 12.5 ms that the narrowest kernel reaches to either side. A shorter lag is none that rows
/// so far apart could tell.
const SHORTEST_S: f64 = 0.6 * 12.5e-3;

/// `frictional_lag`.
pub struct FrictionalLag;

static CARD: Card = Card {
    id: form::FRICTIONAL_LAG.id,
    name: "frictional lag",
    words: "friction that follows the velocity with a delay",
    class: Class::Law,
    axis: Axis::Speed,
    experiment: "sliding with sinusoidal velocity that does not reverse, at two frequencies",
    shown_by: &[Part::Speeds],
    coefficient: "level",
    shape: &[
        ("velocity_m_s", Scale::Logarithmic),
        ("exponent", Scale::Logarithmic),
        ("time_constant_s", Scale::Logarithmic),
    ],
    lacks: several_speeds,
    ..BARE
};

impl Effect for FrictionalLag {
    fn card(&self) -> &Card {
        &CARD
    }

    fn excludes(&self, _: &[f64]) -> Vec<&'static str> {
        vec![form::STRIBECK.id]
    }

    fn grid(&self, scene: &Scene) -> Vec<Vec<f64>> {
        let s = scene.s;
        let longest = (s.duration() / 50.0).clamp(0.02, 0.2);
        let lags = spread(s.dt.max(5e-3), longest, 4);
        falling(s, 5)
            .into_iter()
            .flat_map(|v| lags.iter().map(move |&lag| vec![v, 1.0, lag]))
            .collect()
    }

    fn within(&self, _: &Scene, shape: &[f64], index: usize) -> f64 {
        let value = shape[index];
        match index {
            EXPONENT => exponent(value),
            LAG => value.max(SHORTEST_S),
            _ => value,
        }
    }

    fn storable(&self, shape: &[f64]) -> Vec<f64> {
        storable(shape)
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        let &[velocity, exponent, lag] = shape else {
            return Vec::new();
        };
        let s = scene.s;
        let share = (-s.dt / lag).exp();
        let mut lagging = vec![0.0; s.x.len()];
        for piece in &s.pieces {
            let mut state: Option<f64> = None;
            for i in piece.clone() {
                let now = falls(s.v[i], velocity, exponent);
                let next = state.map_or(now, |last| now + (last - now) * share);
                lagging[i] = next;
                state = Some(next);
            }
        }
        vec![scene.friction(|i| lagging[i])]
    }

    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        matches!(coefficients, [c] if (0.0..STEEPEST).contains(c))
    }
}
