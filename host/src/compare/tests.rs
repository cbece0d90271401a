//! Known parameters recovered, and the figures on a real recording.

use super::*;
use crate::friction::FrictionModel;
use crate::recording::{LoadOptions, load, load_csv};
use std::fmt::Write as _;
use std::path::Path as FilePath;

/// Integration steps per sample of the made recording.
const FINE: usize = 40;

/// A recording whose friction is `dF/dt` of the published equation, integrated by Heun's method, which shares
/// nothing with the library's closed forms; the motion is two sines, so that strokes differ.
///
/// `law(v, z)` is `dz/dt`, `force(v, z)` the friction.
fn made(law: impl Fn(f64, f64) -> f64, force: impl Fn(f64, f64) -> f64) -> Recording {
    let (sample_time, samples) = (2e-3, 10_000);
    let place = |t: f64| 60e-6 * (2.0 * t).sin() + 25e-6 * (5.3 * t).sin();
    let speed = |t: f64| 120e-6 * (2.0 * t).cos() + 25e-6 * 5.3 * (5.3 * t).cos();
    let mut text = String::from("t_s,x_m,friction_N\n");
    let mut z = 0.0;
    for i in 0..samples {
        let t = i as f64 * sample_time;
        let friction = force(speed(t), z) + 300.0 * speed(t) - 0.05;
        writeln!(text, "{t},{},{friction}", place(t)).unwrap();
        let h = sample_time / FINE as f64;
        for j in 0..FINE {
            let t = t + j as f64 * h;
            let slope = law(speed(t), z);
            let ahead = law(speed(t + h), z + h * slope);
            z += 0.5 * h * (slope + ahead);
        }
    }
    load_csv(text.as_bytes(), "made.csv", &LoadOptions::default()).unwrap()
}

fn near(found: f64, truth: f64, tolerance: f64) {
    assert!(
        (found / truth - 1.0).abs() < tolerance,
        "{found} instead of {truth}"
    );
}

fn of_kind<'a>(comparison: &'a Comparison, name: &str) -> &'a Compared {
    comparison
        .models
        .iter()
        .find(|m| m.name().starts_with(name))
        .unwrap_or_else(|| panic!("no {name}"))
}

/// Span, data and rows as `compare` makes them, for one family.
fn fit_of(recording: &Recording, family: Family) -> Fit {
    let kinematics = Kinematics::of(recording);
    let rows: Vec<usize> = (0..recording.len()).collect();
    let data = Data {
        motion: recording.kind,
        path: Path {
            position: &recording.position,
            velocity: &kinematics.velocity,
            pieces: &recording.pieces,
            sample_time: recording.sample_time_s(),
        },
        effort: &recording.effort,
        filter: None,
        acceleration: None,
    };
    let span = Span {
        shortest: 1e-8,
        longest: 85e-6,
        speed: 250e-6,
        sample_time: 2e-3,
        duration: 20.0,
    };
    data.fit(family, &span, &rows, SEED).unwrap()
}

#[test]
fn recovers_dahl() {
    let (stiffness, coulomb, exponent) = (320_000.0, 0.9, 1.6);
    let recording = made(
        |v, f| {
            let rest = 1.0 - f / coulomb * v.signum();
            stiffness * v * rest.abs().powf(exponent) * rest.signum()
        },
        |_, f| f,
    );
    let fit = fit_of(&recording, Family::Dahl);
    let FrictionModel::Dahl {
        stiffness: k,
        coulomb: c,
        exponent: n,
    } = fit.model.friction
    else {
        panic!("{:?}", fit.model.friction);
    };
    near(k, stiffness, 0.01);
    near(c, coulomb, 0.01);
    near(n, exponent, 0.01);
    near(fit.model.viscous, 300.0, 0.05);
    near(fit.model.constant_force, -0.05, 0.01);
    assert!(fit.nmse < 1e-4, "{}", fit.nmse);
    assert!(fit.at_edge.is_empty());
}

#[test]
fn recovers_lugre() {
    let (stiffness, damping) = (195_000.0, 800.0);
    let (breakaway, coulomb, stribeck) = (1.2, 0.8, 60e-6);
    let rate = |v: f64, z: f64| {
        let s = coulomb + (breakaway - coulomb) * (-(v / stribeck).powi(2)).exp();
        v - z * stiffness * v.abs() / s
    };
    let recording = made(rate, |v, z| stiffness * z + damping * rate(v, z));
    let fit = fit_of(&recording, Family::LuGre);
    let FrictionModel::LuGre {
        stiffness: k,
        damping: p,
        breakaway: s,
        sliding,
    } = fit.model.friction
    else {
        panic!("{:?}", fit.model.friction);
    };
    near(k, stiffness, 0.02);
    near(p, damping, 0.1);
    near(s, breakaway, 0.02);
    near(sliding.coulomb, coulomb, 0.02);
    near(sliding.stribeck_velocity, stribeck, 0.05);
    assert!(fit.nmse < 1e-2, "{}", fit.nmse);
}

/// The whole comparison on a recording that Dahl made: Dahl wins, the parameters stand in the JSON, and what
/// cannot be is refused.
#[test]
fn finds_the_model_that_made_the_recording() {
    let recording = made(|v, f| 1e5 * v * (1.0 - f / 0.9 * v.signum()), |_, f| f);
    let progress = Progress::new("test", steps());
    let comparison = compare(&recording, &Options::default(), &progress).unwrap();
    let dahl = of_kind(&comparison, "Dahl");
    assert!(dahl.nmse_test < 1e-3, "{}", dahl.nmse_test);
    assert!(!dahl.memory.is_nonlocal());
    let gms = of_kind(&comparison, "GMS");
    assert!(gms.memory.is_nonlocal() && gms.nmse_test > dahl.nmse_test);
    let json = comparison.to_json(&recording, 1.0);
    assert_eq!(json["schema"], "preslide.comparison/1");
    assert_eq!(json["models"][1]["kind"], "dahl");
    assert!(json["models"][1]["loop_closure_N"].as_f64().unwrap() > 1e-3);
    let stiffness = &json["models"][1]["model"]["friction"]["stiffness_N_per_m"];
    near(stiffness.as_f64().unwrap(), 1e5, 0.02);
    assert!(comparison.recommendation().starts_with("Use Dahl, n = 1"));
}

/// A real recording, or `None` and a loud line where there is none.
fn real(name: &str) -> Option<Recording> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/recordings");
    let folder = FilePath::new(folder);
    if !folder.exists() {
        eprintln!("SKIPPED: ../shared/recordings is absent, so no comparison on {name}");
        return None;
    }
    Some(load(&folder.join(name), &LoadOptions::default()).unwrap())
}

/// Some steps of the optimiser lead where no LuGre force resists this motion; the fit must come back from them. A
/// model that contains another must fit no worse.
#[test]
fn models_fit_no_worse_than_their_special_cases() {
    let Some(recording) = real("pneumatic_seal/O-ring_3bar.csv") else {
        return;
    };
    let progress = Progress::new("test", steps());
    let comparison = compare(&recording, &Options::default(), &progress).unwrap();
    let train = |name: &str| of_kind(&comparison, name).nmse_train;
    assert!(train("LuGre") < 1.001 * train("Dahl, n = 1"));
    assert!(train("Dahl") < 1.001 * train("Dahl, n = 1"));
}

#[test]
fn tribometer() {
    let Some(recording) = real("tribometer_reciprocating/reciprocating_5N.csv") else {
        return;
    };
    let options = Options {
        train: Some((100.0, 145.0)),
        test: Some((145.0, 190.0)),
    };
    let progress = Progress::new("test", steps());
    let comparison = compare(&recording, &options, &progress).unwrap();
    let held_out = |name: &str| of_kind(&comparison, name).nmse_test;
    assert!(held_out("Coulomb") > 50.0);
    // A free exponent goes to its lower bound, where Dahl's spring is almost one Maxwell-slip block.
    assert!(held_out("Dahl") < 0.30, "{}", held_out("Dahl"));
    assert!(
        (1.0..1.6).contains(&held_out("Dahl, n = 1")),
        "{}",
        held_out("Dahl, n = 1")
    );
    assert!(held_out("LuGre") < 1.6, "{}", held_out("LuGre"));
    assert!(held_out("Hsieh") < 0.35, "{}", held_out("Hsieh"));
    let gms: Vec<&Compared> = comparison
        .models
        .iter()
        .filter(|m| m.model.friction.kind() == "gms")
        .collect();
    assert!(
        gms.iter()
            .all(|m| m.nmse_test < 0.30 && m.memory.is_nonlocal())
    );
    assert!(comparison.recommendation().starts_with("Use GMS, N = 1"));
    for open in ["Dahl", "LuGre"] {
        assert!(!of_kind(&comparison, open).memory.is_nonlocal());
    }
}
