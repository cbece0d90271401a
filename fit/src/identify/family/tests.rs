//! Known parameters recovered.

use super::bench::SEED;
use super::fit::{Data, Fit};
use super::*;
use crate::friction::FrictionModel;
use crate::identify::plain::Plain;
use crate::identify::{Options, STEPS, identify};
use crate::progress::Progress;
use crate::recording::{LoadOptions, Recording, load_csv};
use crate::signal::Kinematics;
use preslide_host_tests::made::{Blocks, sines};
use preslide_host_tests::path::recorded;
use std::fmt::Write as _;

fn made(law: impl Fn(f64, f64) -> f64, force: impl Fn(f64, f64) -> f64) -> Recording {
    let text = recorded(law, force);
    load_csv(text.as_bytes(), "made.csv", &LoadOptions::default()).unwrap()
}

fn near(found: f64, truth: f64, tolerance: f64) {
    assert!(
        (found / truth - 1.0).abs() < tolerance,
        "{found} instead of {truth}"
    );
}

/// Span, data and rows as `compare` makes them, for one family.
fn fit_of(recording: &Recording, family: Family) -> Fit {
    let kinematics = Kinematics::of(recording);
    let rows: Vec<usize> = (0..recording.len()).collect();
    let data = Data {
        recording,
        path: kinematics.path(recording),
        effort: &recording.effort,
        filter: None,
        columns: Plain::of(false).columns(recording, &kinematics),
        plain: Plain::of(false),
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
    // The noise's variance is NOISE²/3, about 0.002 % of the force's.
    assert!(fit.nmse < 3e-3, "{}", fit.nmse);
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

/// `identify` with a model that the user wants: its parameters stand in the answer with intervals that hold the truth, and
/// the model is the one that is written.
#[test]
fn a_wanted_model_is_identified_with_confidence() {
    let recording = made(|v, f| 1e5 * v * (1.0 - f / 0.9 * v.signum()), |_, f| f);
    let progress = Progress::new("test", STEPS + 2);
    let mut found = identify(&recording, &Options::default(), &progress).unwrap();
    found
        .choose_family(&recording, Family::DahlLinear, &progress)
        .unwrap();
    let best = found.best();
    assert_eq!(best.model.friction.kind(), "dahl");
    assert!(best.nmse_test < 3e-3, "{}", best.nmse_test);
    let truth = [("stiffness_N_per_m", 1e5), ("coulomb_N", 0.9)];
    for (key, truth) in truth {
        let (_, estimate) = best.parameters.iter().find(|p| p.0 == key).unwrap();
        let [from, to] = estimate.ci95.unwrap();
        assert!((from..to).contains(&truth), "{key}: {from} to {to}");
        assert!(to / from < 1.01, "{key}: {from} to {to} is no news");
    }
    let exponent = best.parameters.iter().find(|p| p.0 == "exponent").unwrap();
    assert!(exponent.1.ci95.is_none(), "the exponent is not fitted");
    assert!(
        found
            .recommendation
            .starts_with("As requested: Dahl, n = 1")
    );
    let json = found.to_json(&recording, 1.0);
    assert_eq!(json["recommended"]["kind"], "dahl");
    let last = json["friction"].as_array().unwrap().last().unwrap();
    assert!(last["parameters"]["stiffness_N_per_m"]["ci95"].is_array());
}

/// A law that is not the machine's bends viscous friction by more than the folds scatter.
#[test]
fn intervals_of_a_law_that_fits_worse_reach_to_the_better_fit() {
    let mut blocks = Blocks::new(&[(2e5, 1e-5), (8e4, 3.75e-5), (2e4, 1.5e-4)]);
    let mut text = "t_s,x_m,force_N\n".to_owned();
    for i in 0..20_000 {
        let t = f64::from(i) * 1e-3;
        let sines = sines(
            &[[0.04, 1.95, 0.0], [0.01, 10.7, 1.0], [5e-4, 44.0, 2.0]],
            t,
        );
        let [x, v, a] = sines;
        let force = 5.0 * a + 30.0 * v + blocks.force(x);
        let _ = writeln!(text, "{t:.3},{x:.9},{force:.6}");
    }
    let recording = load_csv(text.as_bytes(), "made.csv", &LoadOptions::default()).unwrap();
    let progress = Progress::new("test", STEPS + 2);
    let mut found = identify(&recording, &Options::default(), &progress).unwrap();
    found
        .choose_family(&recording, Family::Dahl, &progress)
        .unwrap();
    for (name, truth) in [("mass", 5.0), ("viscous", 30.0)] {
        let own = found
            .best()
            .rigid_body
            .iter()
            .find(|p| p.0 == name)
            .unwrap();
        println!("{name}: {:?}", own.1);
        let [low, high] = own.1.ci95.unwrap();
        assert!((low..high).contains(&truth), "{name}: {:?}", own.1);
    }
    let said = found.notes(&recording).join("\n");
    assert!(
        said.contains("the intervals are those of Dahl alone"),
        "{said}"
    );
}
