//! The models that the paper only names, by what the literature says of each.
//!
//! `cargo test -p preslide-host-tests --test all -- family:: --nocapture` prints the figures.

use crate::laws::{self, built};
use crate::properties::in_steps;
use preslide::Bound::{AtLeast, AtMost};
use preslide::{
    BoucWen, Dahl, ElastoPlastic, Friction, Leuven, LeuvenForm, Sliding, TwoState, Units,
};
use preslide_host_tests::path::{COUNT, SAMPLE_TIME, motion};
use preslide_host_tests::refusal::{not_negative, positive, refused};
use preslide_host_tests::table3::{BREAKAWAY, blocks};
use proptest::prelude::*;

const ELASTIC: f64 = 1.5e-6;

fn bouc_wen(exponent: f64, shape: f64) -> BoucWen<f64> {
    BoucWen::try_new(320_000.0, BREAKAWAY, exponent, shape, Units::SI).expect("valid")
}

fn elasto_plastic() -> ElastoPlastic<f64> {
    let none = Sliding::none(BREAKAWAY);
    ElastoPlastic::try_new(195_000.0, 0.0, ELASTIC, BREAKAWAY, none, Units::SI).expect("valid")
}

fn leuven(form: LeuvenForm, exponent: f64, damping: f64) -> Leuven<6, f64> {
    let (blocks, none) = (blocks(), Sliding::none(BREAKAWAY));
    Leuven::try_new(form, &blocks, BREAKAWAY, exponent, damping, none, Units::SI).expect("valid")
}

fn two_state() -> TwoState<f64> {
    let none = Sliding::none(BREAKAWAY);
    TwoState::try_new(35e-6, BREAKAWAY, none, SAMPLE_TIME, Units::SI).expect("valid")
}

/// Forces along displacements, at the velocity `speed` (m/s) in their direction.
pub(crate) fn forces<M: Friction<Scalar = f64>>(
    model: &M,
    displacements: &[f64],
    speed: f64,
) -> Vec<f64> {
    let mut state = model.at_rest();
    displacements
        .iter()
        .map(|&displacement| {
            let velocity = speed * displacement.signum();
            model.step(&mut state, motion(displacement, velocity))
        })
        .collect()
}

/// Out, back and out again to the same place: force (N) at the end less force at the reversal.
fn loop_error<M: Friction<Scalar = f64>>(model: &M, out: f64, back: f64) -> f64 {
    let force = forces(model, &in_steps(&[out, -back, back], 200), 0.0);
    (force[599] - force[199]).abs()
}

#[test]
fn bouc_wen_with_the_exponent_1_and_shape_1_is_dahls_model() {
    let dahl = Dahl::<f64>::try_new(320_000.0, BREAKAWAY, 1.0, Units::SI).expect("valid");
    let path: Vec<f64> = laws::jumping()
        .iter()
        .map(|tick| f64::from(tick.0) * COUNT)
        .collect();
    let pairs = forces(&dahl, &path, 0.0)
        .into_iter()
        .zip(forces(&bouc_wen(1.0, 1.0), &path, 0.0));
    let largest = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(largest < 2e-7, "{largest:e}");
}

/// What each is said to do with an inner loop half way up the virgin curve.
#[test]
fn inner_loops_stay_open_but_for_the_elastic_range() {
    let bouc_wen = loop_error(&bouc_wen(1.6, 0.75), 1.5e-6, 1e-6);
    assert!(bouc_wen > 0.02, "Bouc-Wen {bouc_wen}");
    let two_state = loop_error(&two_state(), 20e-6, 15e-6);
    assert!(two_state > 0.02, "two-state {two_state}");
    let model = elasto_plastic();
    let elastic = loop_error(&model, 0.8 * ELASTIC, 0.7 * ELASTIC);
    assert!(elastic < 1e-14, "elasto-plastic below z_ba {elastic:e}");
    let yielding = loop_error(&model, 4.0 * ELASTIC, 1.5 * ELASTIC);
    assert!(yielding > 0.02, "elasto-plastic above z_ba {yielding}");
}

/// A ripple on a load: where the displacement that it causes creeps away, the model drifts.
#[test]
fn elasto_plastic_does_not_drift_below_breakaway_and_bouc_wen_does() {
    // Displacement ripples stand for force ripples: in the elastic range each gives the other.
    let ripple = in_steps(&[[2e-7, -2e-7]; 500].concat(), 4);
    let load = |out: f64| [in_steps(&[out], 50), ripple.clone()].concat();
    let drop = |force: &[f64]| (force[49] - force[force.len() - 1]).abs();
    let elasto_plastic = forces(&elasto_plastic(), &load(1e-6), 0.0);
    assert!(drop(&elasto_plastic) < 1e-12, "{:e}", drop(&elasto_plastic));
    let bouc_wen = forces(&bouc_wen(1.6, 0.75), &load(1e-6), 0.0);
    assert!(drop(&bouc_wen) > 0.1, "{}", drop(&bouc_wen));
}

/// With `σ1` the force jumps where the original form closes an inner loop, however fine the motion; the later form's
/// changes shrink with the motion.
#[test]
fn leuven_jumps_at_loop_closure_in_its_original_form_only() {
    const SPEED: f64 = 0.01;
    const DAMPING: f64 = 10.0;
    let largest_change = |form, steps: usize| {
        let model = leuven(form, 2.0, DAMPING);
        let force = forces(&model, &in_steps(&[4e-6, -2e-6, 6e-6], steps), SPEED);
        // After the second reversal, at which sigma_1·dz/dt itself changes sign.
        let rising = &force[2 * steps + 1..];
        rising
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).abs())
            .fold(0.0, f64::max)
    };
    let [coarse, fine] = [1_000, 100_000].map(|steps| largest_change(LeuvenForm::Original, steps));
    println!("Leuven, original: jump {coarse:.3e} N, {fine:.3e} N a hundred times finer");
    assert!(fine > 5e-3 && fine > 0.5 * coarse, "{coarse:e} {fine:e}");
    let [coarse, fine] = [1_000, 100_000].map(|steps| largest_change(LeuvenForm::Modified, steps));
    println!("Leuven, modified: change {coarse:.3e} N, {fine:.3e} N a hundred times finer");
    assert!(fine < 0.02 * coarse && fine < 1e-4, "{coarse:e} {fine:e}");
}

/// In `x` the Leuven model's loops close as far as `|u|ⁿ` vanishes.
#[test]
fn leuven_closes_loops_better_the_sharper_its_exponent() {
    let error = |exponent| loop_error(&leuven(LeuvenForm::Modified, exponent, 0.0), 4e-6, 2e-6);
    let [blunt, middle, sharp] = [1.0, 4.0, 20.0].map(error);
    println!("Leuven, loop closure for n = 1, 4, 20: {blunt:.1e}, {middle:.1e}, {sharp:.1e} N");
    assert!(
        blunt > 5.0 * middle && middle > 20.0 * sharp,
        "{blunt:e} {middle:e} {sharp:e}"
    );
}

#[test]
fn bad_parameters_are_refused_by_the_error_that_names_them() {
    let si = Units::SI;
    let bouc_wen = |k, f, n, shape| BoucWen::<f64>::try_new(k, f, n, shape, si).err();
    let none = Sliding::none(1.0);
    let elasto_plastic =
        |k, d, z, f, sliding| ElastoPlastic::<f64>::try_new(k, d, z, f, sliding, si).err();
    let leuven = |n, d| {
        Leuven::<6, f64>::try_new(LeuvenForm::Modified, &blocks(), 1.0, n, d, none, si).err()
    };
    let two_state = |s, f, time| TwoState::<f64>::try_new(s, f, none, time, si).err();
    assert_eq!(bouc_wen(1.0, 1.0, 1.0, 1.0), None);
    assert_eq!(elasto_plastic(1.0, 0.0, 0.0, 1.0, none), None);
    assert_eq!(leuven(1.0, 0.0), None);
    assert_eq!(two_state(1.0, 1.0, 1e-3), None);
    positive("stiffness", |bad| bouc_wen(bad, 1.0, 1.0, 1.0));
    positive("Coulomb force", |bad| bouc_wen(1.0, bad, 1.0, 1.0));
    positive("stiffness", |bad| elasto_plastic(bad, 0.0, 0.0, 1.0, none));
    positive("breakaway force", |bad| {
        elasto_plastic(1.0, 0.0, 0.0, bad, none)
    });
    positive("pre-sliding distance", |bad| two_state(bad, 1.0, 1e-3));
    positive("breakaway force", |bad| two_state(1.0, bad, 1e-3));
    positive("sample time", |bad| two_state(1.0, 1.0, bad));
    refused(two_state(1.0, 1.0, 2.0), "sample time", AtMost(1.0));
    not_negative("damping", |bad| elasto_plastic(1.0, bad, 0.0, 1.0, none));
    not_negative("damping", |bad| leuven(1.0, bad));
    let weak = Sliding {
        coulomb: 0.5,
        ..none
    };
    let late = elasto_plastic(1.0, 0.0, 0.46, 1.0, weak);
    refused(late, "elastic deflection z_ba", AtMost(0.45));
    for bad in [0.9, f64::NAN] {
        refused(bouc_wen(1.0, 1.0, bad, 1.0), "exponent n", AtLeast(1.0));
        refused(leuven(bad, 0.0), "exponent n", AtLeast(1.0));
    }
    refused(bouc_wen(1.0, 1.0, 1.0, 0.4), "shape sigma", AtLeast(0.5));
    refused(bouc_wen(1.0, 1.0, 1.0, 2.1), "shape sigma", AtMost(2.0));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    /// Without a Stribeck curve and damping the force depends on the turning points alone: one tick a leg or many.
    #[test]
    fn rate_independence(
        legs in prop::collection::vec(1e-8..5e-5_f64, 1..10),
        steps in 2..100_usize,
    ) {
        let legs: Vec<f64> = legs.iter().enumerate().map(|(i, leg)| if i % 2 == 0 { *leg } else { -leg }).collect();
        for law in laws::all() {
            let model = &law.models[0];
            let still = model.along(Sliding::none);
            let model = built(still.as_ref().unwrap_or(model), Units::SI).expect("valid");
            let coarse = forces(&model, &legs, 0.0);
            let fine = forces(&model, &in_steps(&legs, steps), 5.0);
            for (i, force) in coarse.iter().enumerate() {
                let other = fine[steps * (i + 1) - 1];
                prop_assert!((force - other).abs() < law.steps, "{}, leg {i}: {force} {other}", law.name);
            }
        }
    }
}
