//! Every effect of the catalogue on a small made motion.

use super::*;
use crate::diagnose::term::{Subject, Term};
use preslide_fit::friction::FrictionModel;
use preslide_fit::recording::{LoadOptions, MotionKind, Recording, load_csv};
use preslide_fit::signal::Deflection;
use preslide_fit::statistics::quantile_between_ranks;
use std::collections::HashSet;
use std::fmt::Write as _;

/// Sample time of the motion (s).
const STEP_S: f64 = 2e-3;
/// Ids that a model file keeps elsewhere, or not at all.
const NOT_IN_FILES: [&str; 2] = ["viscous", "axis_coupling"];

/// Strokes of several lengths and speeds with rests, `side` = −1 mirrored.
fn motion(kind: MotionKind, side: f64) -> Recording {
    let keys = match kind {
        MotionKind::Linear => "x_m,force_N",
        MotionKind::Rotary => "q_rad,torque_Nm",
    };
    let mut text = format!("t_s,{keys},temperature_C,load_N,repeat\n");
    for i in 0..6000 {
        let t = f64::from(i) * STEP_S;
        // Rests of two lengths, a third and a half of every two seconds, by a phase that stands still.
        let beat = t.rem_euclid(4.0);
        let phase = t - beat + (beat - 0.4).clamp(0.0, 1.6) + (beat - 3.0).clamp(0.0, 1.0);
        let x = 0.05 * (2.6 * phase).sin() + 0.012 * (7.1 * phase + 0.3).sin();
        let force = 0.8 * (40.0 * x).sin() + 0.3 * (2.6 * phase).cos();
        let (x, force) = (side * x, side * force);
        let (warm, load) = (20.0 + 0.5 * t, 30.0 + 6.0 * (0.7 * t).sin());
        writeln!(text, "{t},{x},{force},{warm},{load},{}", i / 1500).unwrap();
    }
    let options = LoadOptions {
        sign: Some(1.0),
        ..LoadOptions::default()
    };
    load_csv(text.as_bytes(), "made.csv", &options).unwrap()
}

/// The motion, the model and the effort that columns are made of.
pub(in crate::diagnose) struct Stage {
    pub(in crate::diagnose) s: Signals,
    pub(in crate::diagnose) core: Baseline,
    effort: Vec<f64>,
}

impl Stage {
    pub(in crate::diagnose) fn new(kind: MotionKind, side: f64) -> Self {
        let recording = motion(kind, side);
        let mut s = Signals::of(&recording);
        s.extra = vec![("other_m".to_owned(), s.t.iter().map(|t| t.sin()).collect())];
        let (mass, blocks) = (3.0, vec![(4000.0, 1e-4), (600.0, 1e-3)]);
        let n = s.x.len();
        let (mut friction, mut slipping) = (vec![0.0; n], vec![0.0; n]);
        for &(k, d) in &blocks {
            for (i, z) in Deflection::along(&s.x, &s.pieces, d).z.iter().enumerate() {
                friction[i] += k * z;
                slipping[i] += if z.abs() >= 0.999 * d { k * z } else { 0.0 };
            }
        }
        let size: Vec<f64> = friction.iter().map(|f: &f64| f.abs()).collect();
        let core = Baseline {
            mass,
            blocks,
            level: quantile_between_ranks(&size, 0.9),
            slipping,
            stiffness: vec![0.0; n],
            fitted: (0..n).map(|i| friction[i] + mass * s.a[i]).collect(),
            friction,
            viscous: 0.0,
            simulated_swing: None,
        };
        // The motion takes most where it accelerates, as a drive that saturates shows.
        let effort = core.fitted.clone();
        Self { s, core, effort }
    }

    pub(in crate::diagnose) fn scene(&self) -> Scene<'_> {
        Scene {
            s: &self.s,
            core: &self.core,
            effort: &self.effort,
        }
    }
}

/// The shapes of the grid, or one on a line.
pub(in crate::diagnose) fn shapes(effect: &dyn Effect, scene: &Scene) -> Vec<Vec<f64>> {
    match effect.line() {
        Some(Line::Force | Line::Level | Line::Effort) => vec![vec![0.004]],
        Some(Line::Time) => vec![vec![13.0]],
        None => effect.grid(scene),
    }
}

fn parts(column: &Column) -> [&Vec<f64>; 3] {
    [&column.value, &column.sloped, &column.curved]
}

#[test]
fn cards_are_whole_ids_unique_and_model_files_know_them() {
    let ids: HashSet<&str> = ALL.iter().map(|e| e.id()).collect();
    assert_eq!(ids.len(), ALL.len());
    for effect in ALL {
        let id = effect.id();
        assert_eq!(by_id(id).map(Effect::id), Some(id));
        let told = [effect.name(), effect.words(), effect.experiment()];
        assert!(told.iter().all(|words| !words.is_empty()), "{id}: {told:?}");
        // A known id lacks its keys, another is refused as such.
        let refused = Entry::new(id, &[]).unwrap_err();
        assert_eq!(
            refused.starts_with("id:"),
            NOT_IN_FILES.contains(&id),
            "{refused}"
        );
    }
}

#[test]
fn columns_cover_the_samples_and_are_finite() {
    let linear = Stage::new(MotionKind::Linear, 1.0);
    let rotary = Stage::new(MotionKind::Rotary, 1.0);
    for effect in ALL {
        let stage = if effect.id() == "gravity" {
            assert!(effect.grid(&linear.scene()).is_empty());
            &rotary
        } else {
            &linear
        };
        let scene = stage.scene();
        let shapes = shapes(effect, &scene);
        assert!(!shapes.is_empty(), "{}", effect.id());
        for shape in shapes {
            // Fewer where a mean or a centre is not free, or a column of the recording makes a shape needless.
            assert!(shape.len() <= effect.card().shape.len(), "{}", effect.id());
            let within = |i| effect.within(&scene, &shape, i);
            let inside: Vec<f64> = (0..shape.len()).map(within).collect();
            let columns = effect.columns(&inside, &scene);
            assert!(!columns.is_empty(), "{} {shape:?}", effect.id());
            for column in &columns {
                let filled: Vec<_> = parts(column)
                    .into_iter()
                    .filter(|p| !p.is_empty())
                    .collect();
                assert!(
                    filled.iter().any(|p| p.iter().any(|v| *v != 0.0)),
                    "{} {shape:?}",
                    effect.id()
                );
                for part in filled {
                    assert_eq!(part.len(), scene.s.x.len());
                    assert!(
                        part.iter().all(|v| v.is_finite()),
                        "{} {shape:?}",
                        effect.id()
                    );
                }
            }
        }
    }
}

#[test]
fn what_has_a_sign_is_refused_the_other() {
    let refused: [(&str, &[f64]); 13] = [
        ("dwell_aging", &[-0.1]),
        ("drive_compliance", &[-1e-6]),
        ("position_spring", &[0.0]),
        ("position_spring", &[-1.0, 1.1]),
        ("creep", &[-1e-9]),
        ("actuator_dead_zone", &[-0.1]),
        ("stribeck", &[-0.1]),
        ("stribeck", &[2.1]),
        ("frictional_lag", &[-0.1]),
        ("local_friction_spot", &[-1.1]),
        ("backlash", &[0.2]),
        ("actuator_saturation", &[0.5]),
        ("actuator_saturation", &[1.5]),
    ];
    for (id, coefficients) in refused {
        let effect = by_id(id).unwrap();
        assert!(!effect.admits(&[], coefficients), "{id} {coefficients:?}");
    }
    for effect in ALL.iter().filter(|e| e.card().bound == Bound::NonNegative) {
        assert!(!effect.admits(&[], &[-1.0]), "{}", effect.id());
    }
    let load = by_id("load_dependent_friction").unwrap();
    assert!(!load.admits(&[1.0], &[-0.1]) && load.admits(&[], &[-0.1]));
}

/// Friction and what acts through the motion flips with it, a constant and an asymmetry do not.
#[test]
fn forces_flip_with_a_mirrored_motion_where_the_physics_does() {
    let there = Stage::new(MotionKind::Linear, 1.0);
    let back = Stage::new(MotionKind::Linear, -1.0);
    for effect in ALL {
        // Not the same place, or no part of this axis's motion.
        let is_placed = effect.axis() == Axis::Position && effect.id() != "position_spring";
        if is_placed || ["external_vibration", "axis_coupling"].contains(&effect.id()) {
            continue;
        }
        let side = match effect.id() {
            "constant_force" | "coulomb_asymmetry" | "viscous_asymmetry" => 1.0,
            _ => -1.0,
        };
        for shape in shapes(effect, &there.scene())
            .into_iter()
            .filter(|s| s != &[1.0])
        {
            let (a, b) = (
                effect.columns(&shape, &there.scene()),
                effect.columns(&shape, &back.scene()),
            );
            for (a, b) in a
                .iter()
                .zip(&b)
                .flat_map(|(a, b)| parts(a).into_iter().zip(parts(b)))
            {
                let top = a.iter().fold(0.0f64, |top, v| top.max(v.abs()));
                let off = a
                    .iter()
                    .zip(b)
                    .fold(0.0f64, |off, (a, b)| off.max((a - side * b).abs()));
                assert!(
                    off <= 1e-6 * top,
                    "{} {shape:?}: {off:e} of {top:e}",
                    effect.id()
                );
            }
        }
    }
}

/// A ripple of the level is one wherever it is higher and lower, a ripple of the force is not.
#[test]
fn what_acts_through_the_level_flips_with_friction() {
    let levels = [
        "periodic_friction",
        "position_friction",
        "local_friction_spot",
        "thermal_drift",
        "run_in",
    ];
    let forces = [
        "constant_force",
        "position_spring",
        "periodic_force",
        "position_force",
        "viscous",
    ];
    let stage = Stage::new(MotionKind::Linear, 1.0);
    let told = |id: &str| {
        let effect = by_id(id).unwrap();
        let mut shapes = shapes(effect, &stage.scene()).into_iter();
        let level =
            |shape: Vec<f64>| Term::new(Subject::Effect(effect), &shape).is_level(&stage.scene());
        let first = level(shapes.next().unwrap());
        assert!(shapes.all(|s| level(s) == first), "{id}");
        first
    };
    assert!(levels.into_iter().all(told), "{:?}", levels.map(told));
    assert!(!forces.into_iter().any(told), "{:?}", forces.map(told));
}

/// A made fit with admissible coefficients enters a model file and is read from it with the same shape.
#[test]
fn model_files_take_the_parameters_and_give_the_shape_back() {
    let stage = Stage::new(MotionKind::Linear, 1.0);
    let scene = stage.scene();
    for effect in ALL {
        for shape in shapes(effect, &scene) {
            let shape = effect.storable(&shape);
            let count = effect.columns(&shape, &scene).len();
            let moved = ["backlash", "drive_compliance"].contains(&effect.id());
            let swings = shape.first() == Some(&0.0) && effect.id() == "drive_compliance";
            let behind_a_gap = shape.len() == 5 && !swings;
            let encoder_on_load = moved && shape.len() > 1 && !swings && !behind_a_gap;
            let size = match effect.id() {
                _ if encoder_on_load => 1.0,
                _ if swings => 0.5 / shape.get(3).unwrap_or(&1.0),
                "backlash" | "actuator_saturation" => 1.0,
                // The library takes no encoder that reads backwards.
                "encoder_error" => 1e-5,
                _ => 0.01,
            };
            let mut coefficients = vec![size; count];
            if let (Some(aside), true) = (coefficients.get_mut(1), effect.id() == "position_spring")
            {
                *aside = 0.002;
            }
            assert!(
                effect.admits(&shape, &coefficients),
                "{} {shape:?}",
                effect.id()
            );
            let fitted = Fitted {
                shape: &shape,
                coefficients: &coefficients,
                shape_errors: &vec![Some(1e-6); shape.len()],
                errors: &vec![Some(1e-3); count],
                folds: 6,
                at_shape: &|_| Some(0.012),
                scene,
            };
            let values = effect.values(&fitted);
            assert!(
                values.iter().all(|(_, e)| e.value.is_finite()),
                "{values:?}"
            );
            let mut model = Model::of_friction(
                MotionKind::Linear,
                FrictionModel::maxwell_slip(&[4000.0], &[1e-4]),
            );
            let entered = effect.extend(&values, &mut model);
            match effect.id() {
                "axis_coupling" => {
                    assert!(entered.is_err());
                    let extra = &scene.s.extra;
                    let told = extra.iter().any(|(name, _)| values[0].0.ends_with(name));
                    assert!(told, "{values:?}");
                }
                _ if encoder_on_load => {
                    assert!(entered.unwrap_err().contains("the encoder is on the load"));
                    assert_eq!(values.last().unwrap().0, "motor_share");
                    assert!(model.effects.is_empty());
                }
                _ if behind_a_gap => {
                    assert!(entered.unwrap_err().contains("the load swings behind"));
                    assert!(model.effects.is_empty());
                }
                // Of half the inertia on either side, 4k/M is the square of the resonance.
                _ if swings => {
                    entered.unwrap();
                    let told = model.effects[0].get("frequency_Hz") / shape[1];
                    assert!((told - f64::sqrt(2.0)).abs() < 1e-12, "{told}");
                }
                "viscous" => assert_eq!(model.viscous, 0.01),
                "constant_force" => assert_eq!(model.constant_force, 0.01),
                id => {
                    entered.unwrap();
                    let entry = &model.effects[0];
                    assert_eq!(entry.id(), id);
                    let kept = effect.shape_in(entry, &model);
                    for (((key, _), own), kept) in effect.card().shape.iter().zip(&shape).zip(kept)
                    {
                        // That only slipping blocks weaken is no matter of a model file.
                        let same = (own - kept).abs() <= 1e-12 * own.abs();
                        assert!(same || *key == "slipping_only", "{id} {shape:?}: {kept}");
                    }
                }
            }
        }
    }
}

#[test]
fn gravity_enters_a_model_file_as_it_was_fitted() {
    let stage = Stage::new(MotionKind::Rotary, 1.0);
    let scene = stage.scene();
    let gravity = by_id("gravity").unwrap();
    let fitted = Fitted {
        shape: &[],
        coefficients: &[0.6, -0.8],
        shape_errors: &[],
        errors: &[None, None],
        folds: 6,
        at_shape: &|_| None,
        scene,
    };
    let values = gravity.values(&fitted);
    let of = |key: &str| values.iter().find(|v| v.0 == key).unwrap().1.value;
    let mut model = Model::of_friction(
        MotionKind::Rotary,
        FrictionModel::maxwell_slip(&[4000.0], &[1e-4]),
    );
    gravity.extend(&values, &mut model).unwrap();
    let wave = &model.effects[0];
    for q in [-2.0f64, 0.1, 0.7, 3.0] {
        let force = 0.6 * q.sin() - 0.8 * q.cos();
        let named = of("force_N") * (q - of("angle_rad")).sin();
        let kept = wave.get("force_N") * (q - wave.get("angle_rad")).sin();
        assert!(
            (named - force).abs() < 1e-12 && (kept - force).abs() < 1e-12,
            "{q}: {force} {named} {kept}"
        );
    }
}

#[test]
fn friction_follows_the_transmitted_effort_where_no_load_is_recorded() {
    let mut stage = Stage::new(MotionKind::Linear, 1.0);
    let load = by_id("load_dependent_friction").unwrap();
    assert_eq!(load.grid(&stage.scene()), [Vec::<f64>::new()]);
    stage.s.load = None;
    assert_eq!(load.grid(&stage.scene()), [[1.0]]);
    stage.core.fitted = stage.core.friction.iter().map(|f| f + 5.0).collect();
    assert!(load.grid(&stage.scene()).is_empty());
}

#[test]
fn a_decay_longer_than_the_recording_tells_is_none() {
    let stage = Stage::new(MotionKind::Linear, 1.0);
    let run_in = by_id("run_in").unwrap();
    let grid = run_in.grid(&stage.scene());
    let within = |path: f64| run_in.within(&stage.scene(), &[path], 0);
    let longest = grid.last().expect("a grid")[0];
    assert!((within(20.0 * longest) / longest - 1.0).abs() < 1e-9);
    assert_eq!(within(grid[0][0]), grid[0][0]);
}
