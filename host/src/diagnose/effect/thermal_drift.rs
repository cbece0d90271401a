//! `m = 1 + β·(T − T0)` with a measured temperature, else `m = 1 + a·exp(−t/τ)`.

use super::grid::one;
use super::readout::known;
use super::{BARE, Card, Class, Effect, Fitted, Part, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::expr::Expr;
use crate::diagnose::expr::Function::Exp;
use crate::diagnose::expr::Input::{Temperature, Time};
use crate::diagnose::signals::{Signals, mean};
use crate::diagnose::weak::Column;
use preslide_fit::effects::{Effect as Entry, form};
use preslide_fit::model::Model;
use preslide_fit::statistics::{Estimate, bounds};

/// `thermal_drift`.
pub struct ThermalDrift;

static CARD: Card = Card {
    id: form::THERMAL_DRIFT.id,
    name: "thermal drift",
    words: "a friction level that follows temperature",
    class: Class::Drift,
    axis: Axis::Temperature,
    experiment: "the same strokes cold and warm, temperature recorded",
    coefficient: "level",
    shown_by: &[Part::Again],
    shape: &[("time_constant_s", Scale::Chosen)],
    lacks: |s| match &s.temperature {
        None => Some("temperature"),
        Some(t) if bounds(t).1 - bounds(t).0 < 1.0 => Some("temperature range"),
        Some(_) => None,
    },
    formula: Some(|stated| {
        let change = match stated.get("time_constant_s") {
            Some(constant) => stated.get("level")? * (-1.0 / constant * Expr::from(Time)).of(Exp),
            None => {
                let warmer = Expr::from(Temperature) + Expr::Number(-stated.get("temperature_C")?);
                stated.get("level_per_K")? * warmer
            }
        };
        Some(stated.friction(change))
    }),
    ..BARE
};

impl Effect for ThermalDrift {
    fn card(&self) -> &Card {
        &CARD
    }

    fn equivalents(&self, s: &Signals) -> Vec<&'static str> {
        if goes_one_way(s) {
            vec![form::RUN_IN.id]
        } else {
            Vec::new()
        }
    }

    fn shape_in(&self, entry: &Entry, _: &Model) -> Vec<f64> {
        let warming = entry.has("time_constant_s");
        let shape = warming.then(|| entry.get("time_constant_s"));
        shape.into_iter().collect()
    }

    fn grid(&self, scene: &Scene) -> Vec<Vec<f64>> {
        if scene.s.temperature.is_some() {
            return vec![Vec::new()];
        }
        let duration = scene.s.duration();
        one(duration / 10.0, duration * 2.0, 4)
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        let s = scene.s;
        match (shape, &s.temperature) {
            (&[time_constant], _) => vec![scene.friction(|i| (-s.t[i] / time_constant).exp())],
            (_, Some(temperature)) => {
                let mean = mean(temperature);
                vec![scene.friction(|i| temperature[i] - mean)]
            }
            _ => Vec::new(),
        }
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        match &fitted.scene.s.temperature {
            Some(temperature) if fitted.shape.is_empty() => vec![
                fitted.entry("level_per_K", 0),
                known("temperature_C", mean(temperature)),
            ],
            _ => fitted.one(&CARD),
        }
    }
}

/// Whether the temperature only rises or only falls, or was not measured: what runs in goes the same way.
pub(super) fn goes_one_way(s: &Signals) -> bool {
    /// Of its range, that it may have gone back: noise.
    const BACK: f64 = 0.1;
    let Some(temperature) = &s.temperature else {
        return true;
    };
    let (low, high) = bounds(temperature);
    let (mut lowest, mut highest, mut fallen, mut risen) = (high, low, 0.0_f64, 0.0_f64);
    for t in temperature {
        (lowest, highest) = (lowest.min(*t), highest.max(*t));
        (fallen, risen) = (fallen.max(highest - t), risen.max(t - lowest));
    }
    fallen.min(risen) <= BACK * (high - low)
}
