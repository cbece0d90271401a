//! Effects of every kind, and what their tests share.

mod along;
mod file;
mod mechanics;

use super::*;
use crate::friction::{FrictionModel, Path};
use crate::model::{Measured, Model, Now, Stepper};
use crate::recording::MotionKind;
use std::f64::consts::TAU;

/// Every effect of the catalogue, `constant_force` aside, which a model keeps on its own, and gravity, which only a rotary axis has.
fn every() -> Vec<Effect> {
    let elsewhere = [&form::CONSTANT_FORCE, &form::GRAVITY];
    let forms = form::ALL
        .into_iter()
        .filter(|form| !elsewhere.contains(form));
    forms.map(example).collect()
}

fn example(form: &'static Form) -> Effect {
    Effect::of(form, form.example)
}

fn model(effects: Vec<Effect>) -> Model {
    Model {
        motion: MotionKind::Linear,
        effort_unit: None,
        inertia: 2.0,
        viscous: 3.0,
        friction: FrictionModel::Coulomb { coulomb: 0.8 },
        constant_force: 0.05,
        effects,
        mechanics: Vec::new(),
    }
}

const STEP: f64 = 1e-3;

/// 10 mm back and forth, two runs of 2 s with a gap of a second between them: time, position, velocity, acceleration.
fn sine() -> [Vec<f64>; 4] {
    let t: Vec<f64> = (0..4000)
        .map(|i| f64::from(i) * STEP + if i < 2000 { 0.0 } else { 1.0 })
        .collect();
    let w = TAU * 0.9;
    let of = |f: &dyn Fn(f64) -> f64| t.iter().map(|t| f(*t)).collect();
    let x = of(&|t| 0.005 + 0.01 * (w * t).sin());
    let v = of(&|t| 0.01 * w * (w * t).cos());
    let a = of(&|t| -0.01 * w * w * (w * t).sin());
    [t, x, v, a]
}

/// The force of a model with one effect along [`sine`], acceleration, temperature and load recorded.
fn along(effects: Vec<Effect>, friction: FrictionModel) -> Vec<f64> {
    let [t, x, v, a] = sine();
    let path = Path {
        position: &x,
        velocity: &v,
        pieces: &[0..2000, 2000..4000],
        sample_time: STEP,
    };
    let temperature: Vec<f64> = t.iter().map(|t| 20.0 + t).collect();
    let load: Vec<f64> = t.iter().map(|t| 30.0 + 2.0 * t).collect();
    let measured = Measured {
        t_s: Some(&t),
        acceleration: Some(&a),
        temperature_c: Some(&temperature),
        load_n: Some(&load),
    };
    let model = Model {
        friction,
        ..model(effects)
    };
    model
        .force_along(path, &measured)
        .expect("all that effects need")
}

/// Largest difference, leaving out what is within `margin` samples of an end of a piece or of a sign change of the velocity.
fn difference(found: &[f64], margin: usize, wanted: impl Fn(usize) -> f64) -> f64 {
    let [_, _, v, _] = sine();
    let near_a_turn = |i: usize| {
        let (from, to) = (i.saturating_sub(margin), (i + margin).min(v.len() - 1));
        v[from].signum() != v[to].signum() || i % 2000 < margin || i % 2000 >= 2000 - margin
    };
    (0..v.len())
        .filter(|&i| margin == 0 || !near_a_turn(i))
        .map(|i| (found[i] - wanted(i)).abs())
        .fold(0.0, f64::max)
}
