//! Motion fits on machines made by the simulation of model files, which shares no step with the closed form that is fitted.

use super::window::AS_IT_IS;
use super::*;
use crate::identify::{Options, identify};
use crate::model::Model;
use crate::recording::MotionKind;
use crate::recording::{LoadOptions, Needs, load_csv};
use crate::simulate::closed::motion_in_loop;
use crate::simulate::motion_with_inertia;
use std::f64::consts::TAU;
use std::fmt::Write as _;

/// A geared joint with an arm: a third of what the gear transmits is lost, a fifth of the inertia is the motor's.
const JOINT: &str = r#"
schema = "preslide.model/1"
motion = "rotary"
[inertia]
inertia_kg_m2 = 0.02
[friction]
kind = "coulomb"
coulomb_Nm = 0.1
viscous_Nm_s_per_rad = 0.05
[[effects]]
id = "gravity"
force_Nm = 0.6
angle_rad = 0.1
[[effects]]
id = "load_dependent_friction"
share_of_transmitted = 0.3
motor_inertia_kg_m2 = 0.004
"#;

/// A stage whose viscous friction differs by direction, with a Stribeck curve, a spring, drag and friction that changes along the travel.
const STAGE: &str = r#"
schema = "preslide.model/1"
motion = "linear"
[inertia]
mass_kg = 20.0
[friction]
kind = "coulomb"
coulomb_N = 8.0
viscous_N_s_per_m = 40.0
[[effects]]
id = "viscous_asymmetry"
half_difference_N_s_per_m = 6.0
[[effects]]
id = "quadratic_drag"
drag_N_s2_per_m2 = 30.0
[[effects]]
id = "stribeck"
level = 0.4
velocity_m_s = 0.02
exponent = 1.0
[[effects]]
id = "position_spring"
stiffness_N_per_m = 30.0
centre_m = 0.02
[[effects]]
id = "position_friction"
from_m = -0.3
to_m = 0.3
cosine1 = 0.15
cosine2 = -0.1
"#;

/// Three incommensurate sines and a slow one, of a unit's size.
fn push(t: f64) -> f64 {
    0.4 * ((TAU * 0.31 * t).sin() + (TAU * 0.83 * t + 1.0).sin() + (TAU * 1.7 * t + 2.0).sin())
}

fn effort_only(kind: MotionKind, seconds: f64, force: impl Fn(f64) -> f64) -> Recording {
    let name = match kind {
        MotionKind::Linear => "force_N",
        MotionKind::Rotary => "torque_Nm",
    };
    let rows: String = (0..(1e3 * seconds) as usize).fold(String::new(), |mut rows, i| {
        let t = i as f64 * 1e-3;
        let _ = writeln!(rows, "{t:.3},{:e}", force(t));
        rows
    });
    let options = LoadOptions {
        needs: Needs::Effort,
        ..LoadOptions::default()
    };
    load_csv(
        format!("t_s,{name}\n{rows}").as_bytes(),
        "push.csv",
        &options,
    )
    .expect("valid")
}

/// A recording of the made motion, its position in steps of `count`, with the reference where there is one.
fn recorded(
    t_s: &[f64],
    position: &[f64],
    effort: &[f64],
    reference: Option<&[f64]>,
    kind: MotionKind,
    count: f64,
) -> Recording {
    let (x, f) = match kind {
        MotionKind::Linear => ("x", "force_N"),
        MotionKind::Rotary => ("q", "torque_Nm"),
    };
    let unit = kind.unit();
    let mut text = format!("t_s,{x}_{unit},{f}");
    text.push_str(&reference.map_or("\n".to_owned(), |_| format!(",{x}_ref_{unit}\n")));
    for i in 0..t_s.len() {
        let read = (position[i] / count).round() * count;
        let _ = write!(text, "{:.3},{read:e},{:e}", t_s[i], effort[i]);
        let _ = match reference {
            Some(r) => writeln!(text, ",{:e}", r[i]),
            None => writeln!(text),
        };
    }
    load_csv(text.as_bytes(), "made.csv", &LoadOptions::default()).expect("valid")
}

fn fitted(recording: &Recording, controller: Option<&Controller>) -> MotionFit {
    let progress = Progress::new("test", 0);
    let force = identify(recording, &Options::default(), &progress).expect("a fit");
    let found = fit(recording, &force, controller, &progress).expect("a motion fit");
    println!("{}", found.table(recording).to_text());
    println!("{}", found.error_table(recording).to_text());
    println!("{}", found.notes(recording).join("\n"));
    found
}

fn value(found: &MotionFit, name: &str) -> f64 {
    let own = found.parameters.iter().find(|p| p.0 == name);
    own.unwrap_or_else(|| panic!("no {name}")).1.value
}

/// Parameters, each right within a share of the truth.
fn holds(found: &MotionFit, truths: &[(&str, f64, f64)]) {
    for (name, right, within) in truths {
        let own = value(found, name);
        assert!(
            (own / right - 1.0).abs() < *within,
            "{name}: {own} for {right}"
        );
    }
}

fn taken(found: &MotionFit) -> Vec<&'static str> {
    let own = found.tried.iter().filter(|t| t.taken);
    own.map(|t| t.id).collect()
}

#[test]
fn the_closed_form_moves_as_the_model_file_does() {
    for (text, size) in [(JOINT, 1.6), (STAGE, 30.0)] {
        let model = Model::parse(text).expect("valid");
        let recording = effort_only(model.motion, 4.0, |t| size * push(t));
        let slow = motion_with_inertia(&model, &recording, 1).expect("simulated");
        let made = recorded(
            &slow.t_s,
            &slow.position,
            &recording.effort,
            None,
            model.motion,
            1e-9,
        );
        let travel = [-0.3, 0.3];
        let place = Place {
            kind: model.motion,
            travel,
        };
        let mut body = Body::of(&model, &place);
        for effect in &model.effects {
            if effect.id() == "load_dependent_friction" {
                body.transmitted = effect.get("share_of_transmitted");
                body.motor_inertia = effect.get("motor_mass_kg");
            }
            if effect.id() == "stribeck" {
                body.stribeck = effect.get("level");
                body.stribeck_speed = effect.get("velocity_m_s");
            }
            if effect.id() == "quadratic_drag" {
                body.drag = effect.get("drag_N_s2_per_m2");
            }
            if effect.id() == "position_friction" {
                body.along = [effect.get("cosine1"), effect.get("cosine2")];
            }
        }
        assert_eq!(body.model(&place).effects.len(), model.effects.len());
        let velocity = slow.velocity.expect("in time");
        let driven = Driven {
            recording: &made,
            velocity: &velocity,
            drive: Drive::Open,
            place,
        };
        let window = driven.window(0..made.len());
        let fast = driven.simulate(&body, &window, 32, AS_IT_IS);
        let errors: Vec<f64> = fast
            .iter()
            .zip(&slow.position)
            .map(|(a, b)| a - b)
            .collect();
        let apart = Apart::of(&errors);
        let [low, high] = [made.ends().0, made.ends().1];
        let most = errors.iter().fold(0.0, |most: f64, e| most.max(e.abs())) / (high - low);
        let bias = errors.iter().sum::<f64>() / errors.len() as f64 / (high - low);
        let rms = apart.rms / (high - low);
        println!(
            "of a travel of {:.3}: max {most:.1e}, RMS {rms:.1e}, bias {bias:.1e}",
            high - low
        );
        // Both are of first order in the step; the simulation stops halving at a thousandth of the travel.
        assert!(
            most < 2e-3 && rms < 1e-3 && bias.abs() < 1e-3,
            "{most:e} {rms:e} {bias:e}"
        );
    }
}

#[test]
fn friction_of_what_a_gear_transmits_comes_back_from_an_open_loop() {
    let model = Model::parse(JOINT).expect("valid");
    let recording = effort_only(model.motion, 12.0, |t| 0.8 * push(t));
    let made = motion_with_inertia(&model, &recording, 1).expect("simulated");
    let made = recorded(
        &made.t_s,
        &made.position,
        &recording.effort,
        None,
        model.motion,
        1e-5,
    );
    let found = fitted(&made, None);
    assert!(
        taken(&found).contains(&"load_dependent_friction"),
        "{:?}",
        found.tried
    );
    holds(
        &found,
        &[
            ("mass", 0.02, 0.02),
            ("share_of_transmitted", 0.3, 0.05),
            ("viscous", 0.05, 0.05),
            ("coulomb", 0.1, 0.05),
            ("motor_share_of_inertia", 0.2, 0.2),
        ],
    );
    // The encoder's count over the travel is 5e-6; what the two simulations differ by is a thousandth at most.
    let [low, high] = [made.ends().0, made.ends().1];
    assert!(
        found.errors[1].rms < 2e-3 * (high - low),
        "{:?}",
        found.errors
    );
    assert!(found.errors[1].rms < 0.5 * found.errors[0].rms);
}

#[test]
fn a_loop_reports_its_contents_and_a_plain_axis_none() {
    let plain = "schema = \"preslide.model/1\"\nmotion = \"linear\"\n[inertia]\nmass_kg = 3.0\n[friction]\nkind = \"coulomb\"\ncoulomb_N = 4.0\nviscous_N_s_per_m = 25.0\n[[effects]]\nid = \"constant_force\"\nforce_N = 0.7\n";
    let model = Model::parse(plain).expect("valid");
    let controller = Controller::parse("schema = \"preslide.controller/1\"\nrate_Hz = 1000\nproportional_N_per_m = 900\nderivative_N_s_per_m = 30\nlimit_N = 60\n").expect("valid");
    let reference: Vec<f64> = (0..10_000)
        .map(|i| 0.1 * push(f64::from(i) * 1e-3))
        .collect();
    let t_s: Vec<f64> = (0..reference.len()).map(|i| i as f64 * 1e-3).collect();
    let zero = vec![1.0; t_s.len()];
    let asked = recorded(&t_s, &reference, &zero, None, model.motion, 1e-9);
    let made = motion_in_loop(&model, &asked, &controller).expect("stable");
    let made = recorded(
        &t_s,
        &made.position,
        &made.force,
        Some(&reference),
        model.motion,
        1e-7,
    );
    let found = fitted(&made, Some(&controller));
    assert!(
        found.closed_loop && taken(&found).is_empty(),
        "{:?}",
        found.tried
    );
    holds(
        &found,
        &[
            ("mass", 3.0, 0.02),
            ("viscous", 25.0, 0.02),
            ("coulomb", 4.0, 0.02),
            ("offset", 0.7, 0.05),
        ],
    );
    let mut alone = made;
    alone.reference = None;
    let force = identify(&alone, &Options::default(), &Progress::new("test", 0)).expect("a fit");
    let told = fit(&alone, &force, Some(&controller), &Progress::new("test", 0));
    let told = told.expect_err("no reference");
    assert!(told.contains("x_ref_m") && told.contains("--map"), "{told}");
}

/// An offset beside a spring depends on where it is taken: that at the middle of the travel is called so.
#[test]
fn an_offset_beside_a_spring_names_its_place() {
    let text = "schema = \"preslide.model/1\"\nmotion = \"linear\"\n[inertia]\nmass_kg = 5.0\n[friction]\nkind = \"coulomb\"\ncoulomb_N = 4.0\nviscous_N_s_per_m = 30.0\n[[effects]]\nid = \"position_spring\"\nstiffness_N_per_m = 300.0\ncentre_m = 0.02\n";
    let model = Model::parse(text).expect("valid");
    let pushed = effort_only(model.motion, 12.0, |t| 40.0 * push(t));
    let made = motion_with_inertia(&model, &pushed, 1).expect("simulated");
    let recording = recorded(
        &made.t_s,
        &made.position,
        &pushed.effort,
        None,
        model.motion,
        1e-7,
    );
    let found = fitted(&recording, None);
    let names: Vec<&str> = found.parameters.iter().map(|p| p.0).collect();
    assert!(names.contains(&"spring"), "{names:?}");
    let (low, high) = recording.ends();
    let there = 300.0 * (0.5 * (low + high) - 0.02);
    let told = value(&found, "offset_at_mid_travel");
    println!("{told} N at mid-travel, {there} N made");
    assert!((told - there).abs() < 0.2, "{told} N, {there} N made");
}

/// Blocks under a force of this size.
fn pushed(size: f64) -> Recording {
    let text = "schema = \"preslide.model/1\"\nmotion = \"linear\"\n[inertia]\nmass_kg = 5.0\n[friction]\nkind = \"gms\"\nbreakaway_N = 8.0\nviscous_N_s_per_m = 30.0\nblocks = [{ stiffness_N_per_m = 2e5, weight = 0.25 }, { stiffness_N_per_m = 8e4, weight = 0.375 }, { stiffness_N_per_m = 2e4, weight = 0.375 }]\n";
    let model = Model::parse(text).expect("valid");
    let recording = effort_only(model.motion, 12.0, |t| size * push(t));
    let made = motion_with_inertia(&model, &recording, 1).expect("simulated");
    recorded(
        &made.t_s,
        &made.position,
        &recording.effort,
        None,
        model.motion,
        1e-9,
    )
}

#[test]
fn a_motion_within_pre_sliding_is_refused_with_the_reason() {
    let recording = pushed(7.0);
    let progress = Progress::new("test", 0);
    let force = identify(&recording, &Options::default(), &progress).expect("a fit");
    let told = fit(&recording, &force, None, &progress).expect_err("no sliding");
    assert!(
        told.contains("pre-sliding") && told.contains("leave it out"),
        "{told}"
    );
}
