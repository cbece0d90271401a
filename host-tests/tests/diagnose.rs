//! The diagnosis on trials whose truth it does not see: a few of each kind, with names, figures and intervals asserted. How good it
//! is on many is printed by `cargo xtask trials`.

use preslide_host::diagnose::verdict::Verdict;
use preslide_host::diagnose::{Diagnosis, diagnose};
use preslide_host::model::Model;
use preslide_host::progress::Progress;
use preslide_host::recording::{LoadOptions, load};
use preslide_host_tests::trials::effect::{Id, Strength};
use preslide_host_tests::trials::files::{MODEL, RECORDING};
use preslide_host_tests::trials::{Kind, trial};

/// What the diagnosis says of a trial, from its files.
fn answer(seed: u64, kind: Kind) -> (Diagnosis, Model) {
    let folder = tempfile::tempdir().expect("a folder");
    trial(seed, kind).write(folder.path()).expect("written");
    let recording =
        load(&folder.path().join(RECORDING), &LoadOptions::default()).expect("a recording");
    let model = Model::load(&folder.path().join(MODEL)).expect("a model");
    let progress = Progress::new("diagnose", 0);
    let found = diagnose(&recording, Some(&model), &progress).expect("a diagnosis");
    let (extended, refused) = found.extended_model(&recording, Some(&model));
    assert!(refused.is_empty(), "{refused:?}");
    let text = extended.to_toml(&[]);
    let file = folder.path().join("extended.toml");
    std::fs::write(&file, &text).expect("written");
    let read = Model::load(&file).expect("the extended model is a model file");
    assert_eq!(read.effects, extended.effects);
    (found, read)
}

fn confident(found: &Diagnosis) -> Vec<&'static str> {
    found
        .effects
        .iter()
        .filter(|e| e.confident)
        .map(|e| e.id())
        .collect()
}

/// Seeds 0 to 4 modulo 5 are the five hysteresis laws.
#[test]
fn clean_recordings_of_two_laws_are_consistent() {
    for seed in [15, 24] {
        let (found, model) = answer(seed, Kind::Clean);
        assert_eq!(
            found.verdict,
            Verdict::Consistent,
            "seed {seed}: {:?}",
            confident(&found)
        );
        assert!(model.effects.is_empty());
    }
}

#[test]
fn a_stribeck_curve_is_named_with_its_velocity_and_honest_intervals() {
    let seed = 272;
    let (found, _) = answer(seed, Kind::Single(Id::Stribeck, Strength::Typical));
    assert_eq!(confident(&found), ["stribeck"], "seed {seed}");
    assert!(
        found.extended.test < 0.5 * found.baseline.test,
        "NMSE {} before, {} after",
        found.baseline.test,
        found.extended.test
    );
    let truth = trial(seed, Kind::Single(Id::Stribeck, Strength::Typical))
        .label
        .effects[0]
        .values;
    for (key, truth) in [
        ("level", truth[0]),
        ("velocity_m_s", truth[1]),
        ("exponent", truth[2]),
    ] {
        let all = &found.effects[0].parameters;
        let (_, stated) = all.iter().find(|p| p.0 == key).expect("stated");
        let [low, high] = stated.ci95.expect("an interval");
        assert!(
            low <= truth && truth <= high,
            "{key} {truth} is not in {low}…{high}"
        );
        assert!(
            (stated.value / truth - 1.0).abs() < 0.3,
            "{key} {} {truth}",
            stated.value
        );
    }
}

#[test]
fn a_constant_force_is_named_with_its_interval_and_its_double() {
    let kind = Kind::Single(Id::ConstantForce, Strength::Typical);
    let (found, model) = answer(10, kind);
    assert_eq!(confident(&found), ["constant_force"]);
    let effect = &found.effects[0];
    assert!(
        effect
            .ambiguous
            .iter()
            .any(|e| e.id() == "coulomb_asymmetry"),
        "no fit separates them"
    );
    let truth = trial(10, kind).label.effects[0].values[0];
    let [low, high] = effect.parameters[0].1.ci95.expect("an interval");
    assert!(
        low <= truth && truth <= high,
        "{truth} N is not in {low}…{high}"
    );
    assert!(
        (model.constant_force / truth - 1.0).abs() < 0.1,
        "{} {truth}",
        model.constant_force
    );
}

#[test]
fn a_memory_of_time_is_unknown_physics() {
    let (found, _) = answer(56, Kind::Outside(Id::RelaxingMemory));
    assert_ne!(
        found.verdict,
        Verdict::MissingPhysics,
        "{:?}",
        confident(&found)
    );
}
