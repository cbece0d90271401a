//! Force to motion and back, against the library and against closed forms.

use preslide::Block;
use preslide_fit::friction::{FrictionModel, Path};
use preslide_fit::model::Model;
use preslide_fit::recording::{LoadOptions, MotionKind, Needs, Recording, load_csv};
use preslide_fit::simulate::*;
use preslide_host::paper;
use preslide_host_tests::refusal::refuses;
use preslide_host_tests::table3::falling;

fn model(friction: FrictionModel) -> Model {
    Model::of_friction(MotionKind::Linear, friction)
}

/// The paper's experiment: up, back, nested reversals, below breakaway throughout.
fn ramp(highest: f64) -> (Vec<f64>, Vec<f64>) {
    let h = highest;
    ramp::Ramp {
        corners: vec![0.0, h, 0.0, 0.6 * h, -h, 0.3 * h, -0.5 * h, 0.1 * h, h, -h],
        rate: 0.01,
    }
    .samples(10.0)
    .expect("valid")
}

/// Largest difference between the applied force and the force that the library gives for the found motion.
fn round_trip(friction: FrictionModel, highest: f64) -> f64 {
    let (t_s, force) = ramp(highest);
    let found = motion_of_force(&model(friction.clone()), &t_s, &force, 0.1).expect("valid");
    assert!(found.breakaway.is_none(), "{:?}", found.breakaway);
    assert_eq!(found.position.len(), force.len());
    let velocity: Vec<f64> = std::iter::once(0.0)
        .chain(found.position.windows(2).map(|p| (p[1] - p[0]) / 0.1))
        .collect();
    let velocity = match friction {
        FrictionModel::Hsieh(_) => velocity,
        _ => vec![0.0; force.len()],
    };
    let back = friction
        .force(Path {
            position: &found.position,
            velocity: &velocity,
            pieces: std::slice::from_ref(&(0..force.len())),
            sample_time: 0.1,
        })
        .expect("valid");
    back.iter()
        .zip(&force)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

#[test]
fn motion_of_force_of_motion_is_exact() {
    // Positions are rounded where they accumulate: 40 µm·ε·Σk = 4e-15 N a step.
    for column in paper::TABLE_3 {
        let breakaway: f64 = column.weights().iter().sum::<f64>() * paper::BREAKAWAY;
        let error = round_trip(column.model(), breakaway);
        assert!(error < 1e-12, "GMS, {} blocks: {error:e}", column.size());
    }
    let dahl = round_trip(paper::dahl(), 0.88);
    assert!(dahl < 1e-11, "Dahl: {dahl:e}");
    let lugre = round_trip(paper::lugre(), 0.88);
    assert!(lugre < 1e-11, "LuGre: {lugre:e}");
    // The library solves Hsieh's series connection by bisection to 2⁻²⁰ of a step's plastic growth.
    let hsieh = round_trip(paper::hsieh(), 0.88);
    assert!(hsieh < 1e-5, "Hsieh: {hsieh:e}");
}

/// Two blocks by hand: k = 1, 0.5 N/m, D = 1, 4 m, so F_s = 3 N.
#[test]
fn two_blocks_as_by_hand() {
    let two = model(FrictionModel::maxwell_slip(&[1.0, 0.5], &[1.0, 4.0]));
    let force = [0.0, 1.5, 2.0, 0.0, -3.0, 3.0];
    let t_s: Vec<f64> = (0..force.len()).map(|i| i as f64).collect();
    let found = motion_of_force(&two, &t_s, &force, 1.0).expect("valid");
    // Down from 2: both stick (1.5 N/m) over 4/3 m.  Then the first yields at -1 after 2 m in all, at -1 N,
    // and the second goes on at 0.5 N/m over 4 m to -4. Up by 8 m to +4.
    let expected = [0.0, 1.0, 2.0, 2.0 - 4.0 / 3.0, -4.0, 4.0];
    for (x, expected) in found.position.iter().zip(expected) {
        assert!((x - expected).abs() < 1e-14, "{:?}", found.position);
    }
}

/// Dahl with n = 1: x = −(F_c/σ0)·ln(1 − F/F_c) on the virgin branch.
#[test]
fn dahl_as_in_closed_form() {
    let dahl = model(FrictionModel::Dahl {
        stiffness: 3e5,
        coulomb: 0.9,
        exponent: 1.0,
    });
    let force: Vec<f64> = (0..90).map(|i| 0.01 * f64::from(i)).collect();
    let t_s: Vec<f64> = (0..90).map(f64::from).collect();
    let found = motion_of_force(&dahl, &t_s, &force, 1.0).expect("valid");
    for (x, f) in found.position.iter().zip(&force) {
        let expected = -(0.9 / 3e5) * (1.0 - f / 0.9_f64).ln();
        assert!(
            (x - expected).abs() < 1e-12 * 3e-6 + 1e-11 * expected,
            "{x} instead of {expected}"
        );
    }
}

#[test]
fn beyond_breakaway_the_body_slides_away_at_a_named_time() {
    let t_s: Vec<f64> = (0..=10).map(f64::from).collect();
    let force: Vec<f64> = t_s.iter().map(|t| 0.2 * t).collect();
    for friction in [
        paper::REFERENCE.model(),
        paper::dahl(),
        paper::lugre(),
        FrictionModel::Coulomb { coulomb: 0.9 },
    ] {
        let found = motion_of_force(&model(friction.clone()), &t_s, &force, 1.0).expect("valid");
        let breakaway = found.breakaway.expect("slides away");
        assert!(
            (breakaway.time_s - 4.5).abs() < 1e-9,
            "{friction:?}: {breakaway:?}"
        );
        assert!((breakaway.force - 0.9).abs() < 1e-9);
        assert_eq!(found.position.len(), 5);
        assert!(found.position.iter().all(|x| x.abs() < 1e-3));
    }
    // A constant force of 0.3 N leaves 0.6 N downward… and 1.2 N upward.
    let mut tilted = model(paper::REFERENCE.model());
    tilted.constant_force = 0.3;
    let found = motion_of_force(&tilted, &t_s, &force, 1.0).expect("valid");
    let breakaway = found.breakaway.expect("slides away");
    assert!((breakaway.force - 1.2).abs() < 1e-9 && (breakaway.time_s - 6.0).abs() < 1e-9);
}

#[test]
fn hsieh_depends_on_time_and_says_so() {
    let hsieh = model(paper::hsieh());
    let (t_s, force) = ramp(0.8);
    let end = |sample_time: f64| {
        let found = motion_of_force(&hsieh, &t_s, &force, sample_time).expect("valid");
        assert!(found.notes.iter().any(|n| n.contains("depends on time")));
        found.position[900]
    };
    assert!((end(0.1) - end(1e-4)).abs() > 1e-9);
}

/// A column computed from position, velocity and acceleration.
type Computed<'a> = dyn Fn(f64, f64, f64) -> f64 + 'a;

/// Sine motion in the recording format; `extra` heads and fills a further column.
fn sine(axis: &str, extra: Option<(&str, &Computed)>) -> String {
    let mut text = format!(
        "t_s,{axis}{}\n",
        extra.map_or(String::new(), |e| format!(",{}", e.0))
    );
    for i in 0..4000 {
        let t = f64::from(i) * 1e-3;
        let w = 4.0 * std::f64::consts::PI;
        let (x, v, a) = (
            0.01 * (w * t).sin(),
            0.01 * w * (w * t).cos(),
            -0.01 * w * w * (w * t).sin(),
        );
        text += &format!("{t},{x:e}");
        if let Some((_, of)) = &extra {
            text += &format!(",{}", of(x, v, a));
        }
        text.push('\n');
    }
    text
}

fn load(text: &str, needs: Needs) -> Result<Recording, String> {
    let options = LoadOptions {
        needs,
        ..LoadOptions::default()
    };
    load_csv(text.as_bytes(), "motion.csv", &options).map_err(|e| e.to_string())
}

/// Everything in the force: inertia, viscous and constant part, and a block that is always slipping or a spring.
#[test]
fn force_of_motion_has_every_part() {
    let machine = Model {
        inertia: 3.0,
        viscous: 2.0,
        constant_force: -0.5,
        ..model(FrictionModel::maxwell_slip(&[100.0], &[1.0]))
    };
    let effort = |x: f64, v: f64, a: f64| 100.0 * x + 2.0 * v + 3.0 * a - 0.5;
    let recording = load(&sine("x_m", Some(("force_N", &effort))), Needs::Motion).expect("valid");
    let found = force_of_motion(&machine, &recording).expect("valid");
    let agreement = found.agreement.as_ref().expect("an effort");
    assert!(agreement.nmse < 0.01, "{}", agreement.nmse);
    assert!(agreement.rms < 0.05, "{}", agreement.rms);
    // Without an effort the same force comes out, and nothing is compared.
    let bare = force_of_motion(
        &machine,
        &load(&sine("x_m", None), Needs::Motion).expect("valid"),
    );
    let bare = bare.expect("valid");
    assert!(bare.agreement.is_none());
    assert_eq!(bare.force, found.force);
    // The output is a recording again, to the last digit.
    let again = load(&bare.to_csv(), Needs::Both).expect("valid");
    assert_eq!((again.position, again.effort), (bare.position, bare.force));
    assert_eq!(again.velocity, bare.velocity);
}

#[test]
fn wrong_axes_and_missing_columns_are_refused_with_a_remedy() {
    let recording = load(&sine("q_rad", None), Needs::Motion).expect("valid");
    refuses(
        force_of_motion(&model(paper::dahl()), &recording),
        &["motion.csv", "--map"],
    );

    refuses(load(&sine("x_m", None), Needs::Both), &["force_N"]);
    refuses(load("t_s,force_N\n0,1\n1,2\n", Needs::Both), &["x_m"]);
    refuses(load("t_s,x_m\n0,1\n1,2\n", Needs::Effort), &["torque_Nm"]);
    refuses(
        load("t_s,current_A\n0,1\n1,2\n", Needs::Effort),
        &["force_N"],
    );
    refuses(load("force_N\n0\n1\n", Needs::Effort), &["t_s"]);
    refuses(
        load("t_s,x_m,force_N\n0,1,x\n1,2,2\n", Needs::Effort),
        &["line 2"],
    );

    let ramp = load("t_s,force_N\n0,0\n0.01,0.1\n0.02,0.2\n", Needs::Effort).expect("valid");
    assert!(
        ramp.position.is_empty() && ramp.warnings.is_empty(),
        "{:?}",
        ramp.warnings
    );
    assert_eq!(ramp.effort, [0.0, 0.1, 0.2]);
    let torque = load("t_s,torque_Nm\n0,0\n1,0.1\n", Needs::Effort).expect("valid");
    assert_eq!(torque.kind, MotionKind::Rotary);
}

/// Sliding dynamics do not enter the quasi-static limit: the same motion as without them.
#[test]
fn sliding_dynamics_do_not_enter() {
    let blocks = vec![
        Block {
            stiffness: 1e5,
            weight: 0.6,
        },
        Block {
            stiffness: 1e4,
            weight: 0.4,
        },
    ];
    let sliding = falling(0.6, 10.0);
    let gms = |sliding| {
        model(FrictionModel::Gms {
            breakaway: 0.9,
            blocks: blocks.clone(),
            sliding,
        })
    };
    let (t_s, force) = ramp(0.9);
    let with = motion_of_force(&gms(Some(sliding)), &t_s, &force, 0.1).expect("valid");
    let without = motion_of_force(&gms(None), &t_s, &force, 0.1).expect("valid");
    assert_eq!(with.position, without.position);
    assert!(with.notes.len() > without.notes.len());
}
