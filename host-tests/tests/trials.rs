//! The trial generator on trial: its integrator at half its step, its truth against its recordings, its
//! files, and the judge.

use std::collections::BTreeSet;

use preslide_fit::model::Model;
use preslide_fit::recording::{LoadOptions, load_csv};
use preslide_host_tests::answer::Diagnosis;
use preslide_host_tests::judge::source::trials::case;
use preslide_host_tests::trials::effect::{CATALOGUE, Id, OUTSIDE, Strength};
use preslide_host_tests::trials::law::{Hysteresis, LAWS};
use preslide_host_tests::trials::plant::{Marching, Tick, march};
use preslide_host_tests::trials::scenario::Scenario;
use preslide_host_tests::trials::truth::{deterministic, rms};
use preslide_host_tests::trials::{Kind, catalogue_plan, draw::Draw, trial};

/// A scenario cut to its first seconds, which hold every part of one repeat's triangles and slides.
fn short(seed: u64, kind: Kind, seconds: f64) -> Scenario {
    let mut scenario = Scenario::new(seed, kind, &[1.0, 1.0]);
    scenario.motion.ticks.truncate((seconds / 0.25e-3) as usize);
    scenario
}

/// RMS differences of motor position (m) and force (N) between two marches.
fn apart(a: &[Tick], b: &[Tick]) -> (f64, f64) {
    let pairs = || a.iter().zip(b);
    (
        rms(pairs().map(|(a, b)| a.motor[0] - b.motor[0])),
        rms(pairs().map(|(a, b)| a.commanded - b.commanded)),
    )
}

/// A too coarse step makes physics of its own (the design, "Verify any generator at half its step"). With
/// the loop closed over the true position, halving the step moves the stage by a fraction of a count and the
/// force by less than the smallest force noise, and halving again by less.
#[test]
fn half_the_step_changes_nothing_that_can_be_seen() {
    half_the_step_changes_nothing(0);
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn half_the_step_changes_nothing_under_any_law() {
    (1..5).for_each(half_the_step_changes_nothing);
}

/// Each kind under one of the five laws; another number gives it another.
fn half_the_step_changes_nothing(number: u64) {
    let kinds = [
        Kind::Clean,
        Kind::Pair(Id::Stribeck, Id::Viscous),
        Kind::Pair(Id::QuadraticDrag, Id::PeriodicForce),
        Kind::Single(Id::DriveCompliance, Strength::Typical),
        Kind::Single(Id::Backlash, Strength::Typical),
        Kind::Single(Id::Creep, Strength::Typical),
    ];
    for (of_kind, kind) in (0..).zip(kinds) {
        let scenario = short(5 + (of_kind + number) % 5, kind, 12.0);
        let run = |steps| {
            march(
                &scenario,
                Marching {
                    steps,
                    ideal_encoder: true,
                    noise: true,
                },
            )
        };
        let (whole, half, quarter) = (run(5), run(10), run(20));
        let (x, force) = apart(&whole, &half);
        let (finer_x, _) = apart(&half, &quarter);
        println!(
            "{kind:?} {}: {x:.1e} m {force:.1e} N, then {finer_x:.1e} m",
            scenario.law.name()
        );
        assert!(x < 5e-9, "{kind:?} {}: {x:e} m", scenario.law.name());
        assert!(
            force < 0.5e-3,
            "{kind:?} {}: {force:e} N",
            scenario.law.name()
        );
        assert!(
            finer_x < 0.75 * x + 1e-11,
            "{kind:?} {}: {x:e} then {finer_x:e} m",
            scenario.law.name()
        );
    }
}

/// Without noise, the deterministic force is the force that the loop applied, for every effect: what is
/// called the truth is what was simulated. It is computed at the controller's ticks, so dither between them
/// is lost; the bound is a tenth of what friction's variability leaves (30 to 60 mN).
#[test]
fn without_noise_the_truth_is_the_recording() {
    for (i, &id) in CATALOGUE.iter().chain(&OUTSIDE).enumerate() {
        let scenario = short(5 + i as u64, Kind::Single(id, Strength::Strong), 12.0);
        let ticks = march(
            &scenario,
            Marching {
                noise: false,
                ..Marching::default()
            },
        );
        let truth = deterministic(&scenario, &ticks, &[]);
        let commanded: Vec<f64> = ticks.iter().map(|t| t.commanded).collect();
        let recorded =
            preslide_host_tests::trials::truth::sample(&scenario, &commanded, &scenario.effects);
        let error = rms(truth.iter().zip(&recorded).map(|(a, b)| a - b));
        assert!(error < 4e-3, "{}: {error:e} N", id.name());
    }
}

#[test]
fn a_seed_gives_the_same_trial_and_another_seed_another() {
    let kind = Kind::Single(Id::Stribeck, Strength::Typical);
    let (a, b, c) = (trial(11, kind), trial(11, kind), trial(16, kind));
    assert_eq!(a.recording, b.recording);
    assert_eq!(a.label, b.label);
    assert_ne!(a.recording.x_m, c.recording.x_m);
    assert_eq!(a.label.law, c.label.law);
}

#[test]
fn some_effects_act_by_their_strength() {
    effects_act_by_their_strength(6);
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn every_effect_acts_by_its_strength() {
    effects_act_by_their_strength(1);
}

/// Every effect changes the force, and more when it is stronger; the motion asked for stays the same.
fn effects_act_by_their_strength(every: usize) {
    let all = CATALOGUE.iter().chain(&OUTSIDE).enumerate();
    for (i, &id) in all.step_by(every) {
        let size = |strength| {
            let mut scenario = Scenario::new(5 + i as u64, Kind::Single(id, strength), &[]);
            scenario.motion.ticks.retain(|tick| tick.repeat == 0);
            let ticks = march(&scenario, Marching::default());
            let (with, without) = (
                deterministic(&scenario, &ticks, &[]),
                deterministic(&scenario, &ticks, &[id]),
            );
            let total = rms(with.iter().copied());
            (rms(with.iter().zip(&without).map(|(a, b)| a - b)), total)
        };
        let (weak, typical, strong) = (
            size(Strength::Weak),
            size(Strength::Typical),
            size(Strength::Strong),
        );
        println!(
            "{:<24} {:.4} {:.4} {:.4} N of {:.3} N",
            id.name(),
            weak.0,
            typical.0,
            strong.0,
            typical.1
        );
        // How much a resonance rings in a closed loop does not grow with its compliance, nor does a model's
        // mismatch with its wrong stiffness: it crosses the true one.
        let ringing = matches!(id, Id::DriveCompliance | Id::PreslidingShape);
        assert!(weak.0 > 1e-4, "{}: {} N", id.name(), weak.0);
        assert!(
            ringing || typical.0 > 1.1 * weak.0,
            "{}: {} after {} N",
            id.name(),
            typical.0,
            weak.0
        );
        assert!(
            ringing || strong.0 > 1.1 * typical.0,
            "{}: {} after {} N",
            id.name(),
            strong.0,
            typical.0
        );
        assert!(
            strong.1 < 3.0,
            "{}: the loop is not stable: {} N",
            id.name(),
            strong.1
        );
    }
}

/// Return-point memory: after an inner loop the outer branch continues as if it had not been. Exact for
/// Masing's laws and parallel elements; the damped elements are driven slowly.
#[test]
fn clean_laws_close_their_loops() {
    for law in LAWS {
        let mut hysteresis = Hysteresis::draw(law, 0.9, &mut Draw::new(3, 0));
        let mut x = 0.0;
        let mut go = |to: f64| {
            let mut force = 0.0;
            let steps = 4000;
            let dx = (to - x) / f64::from(steps);
            for _ in 0..steps {
                force = hysteresis.step(dx, 1e-6 * dx.signum(), 1.0, 1.0);
            }
            x = to;
            force
        };
        go(60e-6);
        go(-40e-6);
        let before = go(20e-6);
        let inner = go(5e-6);
        let after = go(20e-6);
        assert!(
            before - inner > 0.1,
            "{}: the inner loop is flat",
            law.name()
        );
        assert!(
            (after - before).abs() < 2e-4,
            "{}: {before} N, then {after} N",
            law.name()
        );
        let slid = go(20e-3);
        assert!(
            (slid - 0.9).abs() < 0.02,
            "{}: slides at {slid} N",
            law.name()
        );
    }
}

/// On clean trials of each law the true model leaves noise and variability only, and a refitted baseline
/// of many blocks leaves hardly more: an alarm there is without cause.
#[test]
fn clean_trials_leave_nothing_to_find() {
    for seed in 5..10 {
        let made = trial(seed, Kind::Clean);
        let a = &made.achievable;
        println!(
            "{}: {:.3} % over {:.3} %",
            made.label.law.name(),
            a.baseline_nmse,
            a.floor_nmse
        );
        assert!(made.label.effects.is_empty());
        assert!(a.with == a.without);
        assert!(
            (0.01..2.0).contains(&a.floor_nmse),
            "{}: {}",
            made.label.law.name(),
            a.floor_nmse
        );
        assert!(
            a.baseline_nmse < 1.5 * a.floor_nmse,
            "{}: {}",
            made.label.law.name(),
            a.baseline_nmse
        );
    }
}

#[test]
fn a_masking_effect_is_three_times_the_hidden_one() {
    let made = trial(7, Kind::Masked(Id::PeriodicForce, Id::Viscous));
    let ratio = made.achievable.effect_rms[1] / made.achievable.effect_rms[0];
    assert!((2.7..3.3).contains(&ratio), "{ratio}");
}

#[test]
fn an_effect_in_a_corner_acts_there_only() {
    let made = trial(12, Kind::Corner(Id::PeriodicForce));
    let region = made.label.region.expect("a corner has a region");
    let (mut inside, mut outside) = (Vec::new(), Vec::new());
    let (a, x) = (&made.achievable, &made.recording.x_m);
    for ((with, without), x) in a.with.iter().zip(&a.without).zip(x) {
        // Two millimetres off, the effect has faded.
        if *x < region.from - 2e-3 || *x > region.to + 2e-3 {
            outside.push(with - without);
        } else if *x > region.from && *x < region.to {
            inside.push(with - without);
        }
    }
    assert!(inside.len() > 500 && outside.len() > 500);
    assert!(rms(inside.into_iter()) > 20.0 * rms(outside.into_iter()));
}

/// What the diagnosis is given is read by the tool's own reader without a complaint, and holds what was generated.
#[test]
fn a_recording_comes_back_as_it_was() {
    let made = trial(21, Kind::Pair(Id::ThermalDrift, Id::LoadDependentFriction));
    let mut csv = Vec::new();
    made.write_csv(&mut csv).expect("memory");
    let recording =
        load_csv(&csv[..], "recording.csv", &LoadOptions::default()).expect("a recording");
    assert!(recording.warnings.is_empty(), "{:?}", recording.warnings);
    assert_eq!(recording.repeat, made.recording.repeat);
    assert_eq!(recording.segment, made.recording.segment);
    let worst = |a: &[f64], b: &[f64]| {
        a.iter()
            .zip(b)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max)
    };
    assert!(worst(&recording.position, &made.recording.x_m) < 1e-10);
    assert!(worst(&recording.effort, &made.recording.force_n) < 1e-4);
    assert!(recording.temperature_c.is_some() && recording.load_n.is_some());

    let model = Model::parse(&made.model_toml).expect("a model");
    assert!((model.inertia / made.label.mass - 1.0).abs() < 0.04);
}

#[test]
fn positions_are_whole_counts_and_lengths_are_as_stated() {
    for (seed, kind) in catalogue_plan(12) {
        let scenario = Scenario::new(seed, kind, &[1.0, 1.0]);
        let seconds = scenario.motion.ticks.len() as f64 * 0.25e-3;
        println!(
            "{seed}: {seconds:.0} s in {} repeats",
            scenario.motion.repeats
        );
        assert!((40.0..180.0).contains(&seconds), "{seconds} s");
    }
    let made = trial(6, Kind::Clean);
    let count = Scenario::new(6, Kind::Clean, &[]).encoder_count;
    assert!(
        made.recording
            .x_m
            .iter()
            .all(|x| ((x / count) - (x / count).round()).abs() < 1e-6)
    );
}

/// Every kind of the plan is there, each law takes its share, and no seed comes twice.
#[test]
fn the_plan_is_balanced() {
    let plan = catalogue_plan(300);
    let seeds: BTreeSet<u64> = plan.iter().map(|(seed, _)| *seed).collect();
    assert_eq!(seeds.len(), 300);
    for (kind, at_least) in [
        ("clean", 60),
        ("single", 105),
        ("pair", 30),
        ("masked", 15),
        ("wrong_baseline", 15),
        ("corner", 15),
        ("outside", 45),
    ] {
        let own = plan.iter().filter(|(_, k)| k.name() == kind).count();
        assert!(own >= at_least, "{kind}: {own}");
    }
    for law in 0..5 {
        let clean = plan
            .iter()
            .filter(|(seed, kind)| *kind == Kind::Clean && seed % 5 == law)
            .count();
        assert_eq!(clean, 12);
    }
    for id in CATALOGUE {
        let typical = Kind::Single(id, Strength::Typical);
        assert!(
            plan.iter().any(|(_, kind)| *kind == typical),
            "{}",
            id.name()
        );
    }
}

fn answer(effects: &str, unknown: &str) -> Result<Diagnosis, String> {
    Diagnosis::parse(&format!(
        r#"{{ "schema": "preslide.diagnosis/1", "verdict": "missing-physics", "effects": [{effects}], "unknown": {unknown},
            "baseline": {{ "nmse_test": 4.0 }}, "extended": {{ "nmse_test": 1.0 }}, "seconds": 1.0 }}"#
    ))
}

fn name(rank: u32, id: &str, level: &str, rivals: &str, parameters: &str) -> String {
    format!(
        r#"{{ "id": "{id}", "rank": {rank}, "level": "{level}", "confidence": 0.9,
             "ambiguous_with": [{rivals}], "parameters": {{ {parameters} }},
             "where": [ {{ "axis": "velocity", "from": 0.0, "to": 0.001 }} ] }}"#
    )
}

#[test]
fn the_judge_knows_right_from_wrong() {
    let made = trial(9, Kind::Single(Id::ConstantForce, Strength::Strong));
    let truth = made.label.effects[0].values[0];
    let judge = |effects: &str| case(&made.label, answer(effects, "null"), 1.0);

    let interval = format!(
        r#""force_N": {{ "value": {}, "ci95": [{}, {}] }}"#,
        1.1 * truth,
        truth - 0.1,
        truth + 0.1
    );
    let right = judge(&name(1, "constant_force", "confident", "", &interval));
    assert!(right.first_right() && right.false_names().count() == 0);
    let (key, distance) = &right.distances()[0];
    assert_eq!(key, "constant_force.force_N");
    assert!(*distance < 1e-6, "{distance}");

    // The one exact equivalence: right with the ambiguity stated, wrong without.
    let double = |rivals: &str| judge(&name(1, "coulomb_asymmetry", "confident", rivals, ""));
    let (stated, silent) = (double(r#""constant_force""#), double(""));
    assert!(stated.first_right() && !silent.first_right());
    assert_eq!(silent.false_names().count(), 1);
    // A stated rival of another kind makes nothing right.
    let other = judge(&name(1, "viscous", "confident", r#""constant_force""#, ""));
    assert!(!other.first_right() && other.finds_or_declares(&other.truth[0]));
    assert_eq!(other.false_names().count(), 0);
    // So is a number of the user's model that is said to be wrong, where it is the effect's own.
    let wrong = |key: &str| {
        let mut told = answer("", "null").unwrap();
        told.wrong = vec![key.to_owned()];
        let told = case(&made.label, Ok(told), 1.0);
        told.finds_or_declares(&told.truth[0])
    };
    assert!(wrong("constant_force.force_N") && !wrong("viscous_N_s_per_m"));

    let second = judge(
        &[
            name(2, "constant_force", "suspected", "", ""),
            name(1, "viscous", "confident", "", ""),
        ]
        .join(","),
    );
    assert!(!second.first_right() && !second.finds(&second.truth[0]));
    assert_eq!(second.false_names().count(), 1);

    let clean = trial(9, Kind::Clean).label;
    let told = |effects: &str| case(&clean, answer(effects, "null"), 1.0);
    let creep = |level: &str| told(&name(1, "creep", level, "", ""));
    assert_eq!(creep("suspected").false_names().count(), 0);
    assert_eq!(creep("confident").false_names().count(), 1);
    assert!(answer("", r#"{ "axis": "time" }"#).is_ok_and(|said| said.unknown));
    assert!(answer("{}", "null").is_err());
}
