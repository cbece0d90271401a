//! Figure 1 of the control loop, on one seed: what friction feed-forward is for.

use fixed::types::I16F16;
use preslide::control::{NoFriction, Settings};
use preslide::{Friction, QuasiStaticGms, Units};
use preslide_sim::stage::StageConfig;
use preslide_sim::tracking::{
    Axis, Experiment, FIXED_UNITS, IDENTIFICATION_SEED, Tracking, motions,
};

fn nested<F: Friction>(friction: F, units: Units) -> f64 {
    let settings = Settings::PAPER_AXIS;
    let stage = StageConfig {
        seed: 101,
        ..StageConfig::default()
    };
    let mut axis = Axis::try_new(&settings, friction, units, stage).expect("a valid axis");
    let moves: Vec<_> = motions::nested_triangles()
        .iter()
        .map(|step| step.plan(&settings).expect("a valid move"))
        .collect();
    let mut tracking = Tracking::default();
    axis.follow(&moves, |now| tracking.add(&now, settings.encoder.count));
    tracking.rms_m().expect("no fault")
}

/// Identified on one stage, used on another whose friction differs: GMS N = 4 in fixed point cuts the RMS error of the
/// nested reversals at least five times, and `f32` agrees with fixed point.
#[test]
fn four_blocks_cut_the_error_of_nested_reversals_five_times() {
    let settings = Settings::PAPER_AXIS;
    let stage = StageConfig {
        seed: IDENTIFICATION_SEED,
        ..StageConfig::default()
    };
    let experiment = Experiment::run(&settings, stage).expect("the experiment runs");
    let (blocks, breakaway) = experiment.blocks::<4>().expect("four blocks");
    let fixed =
        QuasiStaticGms::<4, I16F16>::try_new(&blocks, breakaway, FIXED_UNITS).expect("valid");
    let float = QuasiStaticGms::<4, f32>::try_new(&blocks, breakaway, Units::SI).expect("valid");
    let none = nested(NoFriction::<f32>::new(), Units::SI);
    let (fixed, float) = (nested(fixed, FIXED_UNITS), nested(float, Units::SI));
    println!("none {none:.3e} m, fixed {fixed:.3e} m, f32 {float:.3e} m");
    assert!(none > 5.0 * fixed, "{none} {fixed}");
    assert!((fixed / float - 1.0).abs() < 0.05, "{fixed} {float}");
}
