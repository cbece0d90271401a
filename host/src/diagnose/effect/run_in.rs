//! `m = 1 + a·exp(−s/λ)` in travelled path.

use super::grid::one;
use super::thermal_drift::goes_one_way;
use super::{BARE, Card, Class, Effect, Part, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::expr::Expr;
use crate::diagnose::expr::Function::Exp;
use crate::diagnose::expr::Input::Path;
use crate::diagnose::signals::Signals;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;

/// `run_in`.
pub struct RunIn;

/// Longest way of a decay, in recorded ones: over a longer one a falling level looks like another level.
const LONGEST: f64 = 2.0;

static CARD: Card = Card {
    id: form::RUN_IN.id,
    name: "run-in",
    words: "a friction level that decays with travelled path",
    class: Class::Drift,
    axis: Axis::Path,
    experiment: "a rest of an hour in between: run-in stays, temperature does not",
    shown_by: &[Part::Again],
    coefficient: "level",
    shape: &[("path_m", Scale::Logarithmic)],
    lacks: |s| {
        let path = s.path.last().copied().unwrap_or(0.0);
        (path < 10.0 * s.travel()).then_some("a long run")
    },
    formula: Some(|stated| {
        let left = (-1.0 / stated.get("path_m")? * Expr::from(Path)).of(Exp);
        Some(stated.friction(stated.get("level")? * left))
    }),
    ..BARE
};

impl Effect for RunIn {
    fn card(&self) -> &Card {
        &CARD
    }

    fn equivalents(&self, s: &Signals) -> Vec<&'static str> {
        if goes_one_way(s) {
            vec![form::THERMAL_DRIFT.id]
        } else {
            Vec::new()
        }
    }

    fn grid(&self, scene: &Scene) -> Vec<Vec<f64>> {
        let path = scene.s.path.last().copied().unwrap_or(0.0);
        one(path / 20.0, path * LONGEST, 5)
    }

    fn within(&self, scene: &Scene, shape: &[f64], index: usize) -> f64 {
        let path = scene.s.path.last().copied().unwrap_or(0.0);
        shape[index].min(path * LONGEST)
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        let &[decay] = shape else {
            return Vec::new();
        };
        let path = &scene.s.path;
        vec![scene.friction(|i| (-path[i] / decay).exp())]
    }
}
