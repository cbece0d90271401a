//! `m = 1 + c·(load − load0)` with a measured load, else friction that grows by a share of what is transmitted: of a measured load that pushes
//! both ways, its size; without one, the effort beside friction.

use super::readout::{enter, known, value_of};
use super::{BARE, Card, Class, Effect, Fitted, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::expr::Expr;
use crate::diagnose::expr::Input::Load;
use crate::diagnose::signals::mean;
use crate::diagnose::weak::Column;
use preslide_fit::effects::{Effect as Entry, form};
use preslide_fit::model::Model;
use preslide_fit::statistics::{Estimate, bounds, quantile_between_ranks};

/// Key of the friction that a unit of transmitted effort brings (-), as in a gear.
const SHARE: &str = "share_of_transmitted";
/// Key of its mean (N or N·m), which the friction level is that of.
const MEAN: &str = "transmitted_N";
/// Share of the friction level by which the transmitted effort must vary.
const LEAST: f64 = 0.1;

/// `load_dependent_friction`.
pub struct LoadDependentFriction;

static CARD: Card = Card {
    id: form::LOAD_DEPENDENT_FRICTION.id,
    name: "load-dependent friction",
    words: "a friction level that follows the load",
    class: Class::Law,
    axis: Axis::Load,
    experiment: "the same strokes at two loads",
    // No motion varies the load.
    shown_by: &[],
    shape: &[("transmitted", Scale::Chosen)],
    lacks: |s| {
        let varies = |load: &Vec<f64>| {
            let (from, to) = bounds(load);
            to - from >= 0.1 * to.abs()
        };
        (!s.load.as_ref().is_some_and(varies)).then_some("varied load")
    },
    formula: Some(|stated| {
        let more = Expr::from(Load) + Expr::Number(-stated.get("load_N")?);
        Some(stated.friction(stated.get("level_per_N")? * more))
    }),
    ..BARE
};

impl Effect for LoadDependentFriction {
    fn card(&self) -> &Card {
        &CARD
    }

    fn shape_in(&self, _: &Entry, _: &Model) -> Vec<f64> {
        Vec::new()
    }

    fn grid(&self, scene: &Scene) -> Vec<Vec<f64>> {
        if scene.s.load.as_ref().is_some_and(|load| !is_signed(load)) {
            return vec![Vec::new()];
        }
        let load = transmitted(scene);
        let varies = quantile_between_ranks(&load, 0.95) - quantile_between_ranks(&load, 0.05);
        let told = varies > LEAST * scene.core.level;
        told.then(|| vec![1.0]).into_iter().collect()
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        if !shape.is_empty() {
            let load = transmitted(scene);
            let mean = mean(&load);
            return vec![scene.friction(|i| (load[i] - mean) / scene.core.level)];
        }
        let load = scene.s.load.iter();
        load.map(|load| {
            let mean = mean(load);
            scene.friction(|i| load[i] - mean)
        })
        .collect()
    }

    fn admits(&self, shape: &[f64], coefficients: &[f64]) -> bool {
        // More load does not lessen friction; a column's load may count either way.
        shape.is_empty() || matches!(coefficients, [c] if *c > 0.0)
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        match &fitted.scene.s.load {
            Some(load) if fitted.shape.is_empty() => {
                vec![fitted.entry("level_per_N", 0), known("load_N", mean(load))]
            }
            _ => vec![
                fitted.entry(SHARE, 0),
                known(MEAN, mean(&transmitted(&fitted.scene))),
            ],
        }
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        if !values.iter().any(|(key, _)| key == SHARE) {
            return enter(self.id(), values, &[], model);
        }
        // Friction as fitted is that at the mean of what is transmitted, the model's that of an unloaded gear.
        let share = value_of(values, SHARE);
        let level = model.friction.breakaway().unwrap_or(0.0);
        let unloaded = 1.0 - share * value_of(values, MEAN) / level;
        let friction = (unloaded > 0.0).then(|| model.friction.scaled(unloaded));
        let friction = friction.flatten().ok_or(
            "friction of what is transmitted is more than all of the friction; identify --criterion motion fits it to the motion",
        )?;
        model.friction = friction;
        let values = [share, 0.0];
        model
            .effects
            .push(Entry::of(&form::TRANSMITTED_FRICTION, &values));
        Ok(())
    }
}

/// Whether a load pushes both ways, as through a gear: friction follows its size.
fn is_signed(load: &[f64]) -> bool {
    let (low, high) = bounds(load);
    low < 0.0 && high > 0.0
}

/// Size of what is transmitted (N or N·m): a measured load's, or that of the effort that the model has beside friction: weight, inertia. That
/// the effect is itself a part of the fitted effort is of second order.
fn transmitted(scene: &Scene) -> Vec<f64> {
    if let Some(load) = &scene.s.load {
        return load.iter().map(|load| load.abs()).collect();
    }
    scene.sampled(|i| (scene.core.fitted[i] - scene.core.friction[i]).abs())
}
