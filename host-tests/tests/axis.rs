//! One description of the axis: what is edited in axis.toml moves the firmware's defaults, the capture's scale and the simulation.

use preslide::control::Axis;
use preslide_axis::{AxisFile, OWN, rust};
use preslide_host::capture::Scale;
use preslide_sim::stage::{Stage, StageConfig};

fn edited(from: &str, to: &str) -> Axis {
    assert!(OWN.contains(from), "axis.toml has no `{from}`");
    let file = AxisFile::parse("mine.toml", &OWN.replace(from, to)).expect("an axis");
    file.axis()
}

/// Counts that the stage's encoder comes on by under a duty for 10 ms.
fn counts(axis: &Axis) -> i32 {
    let mut stage = Stage::try_new(StageConfig::default().on(axis)).expect("a stage");
    for _ in 0..axis.hardware.rate_hz / 100 {
        stage.tick(0.3);
    }
    stage.reading().count
}

#[test]
fn the_paper_s_axis_is_the_default_stage_s() {
    let own = AxisFile::parse("axis.toml", OWN).expect("an axis").axis();
    assert_eq!(StageConfig::default().on(&own), StageConfig::default());
}

#[test]
fn a_number_that_is_edited_moves_firmware_capture_and_simulation() {
    let own = Axis::PAPER_AXIS;
    let coarse = edited("count = 25e-9", "count = 50e-9");
    // What the build compiles in is this text.
    assert!(rust(&own).contains("count: 2.5e-8") && rust(&coarse).contains("count: 5e-8"));
    assert_eq!(Scale::of(&coarse, 1).count, 50e-9);
    let (fine, half) = (counts(&own), counts(&coarse));
    assert!(
        fine > 1000 && (fine - 2 * half).abs() <= 8,
        "{fine}, {half}"
    );

    let strong = edited("torque_constant = 6.59e-3", "torque_constant = 13.18e-3");
    assert!(rust(&strong).contains("torque_constant: 0.01318"));
    let (before, after) = (Scale::of(&own, 1), Scale::of(&strong, 1));
    assert_eq!(after.effort_per_a, 2.0 * before.effort_per_a);
    assert!(counts(&strong) > counts(&own), "twice the force for a duty");

    let slow = edited("rate_hz = 20000", "rate_hz = 10000");
    assert!(rust(&slow).contains("rate_hz: 10000"));
    assert_eq!(Scale::of(&slow, 1).sample_time_s, 1e-4);
    // The same 10 ms; the current of a period is its mean.
    let (often, seldom) = (counts(&own), counts(&slow));
    assert!((often - seldom).abs() < often / 20, "{often}, {seldom}");

    let heavy = edited("mass = 4.05", "mass = 8.1");
    assert!(rust(&heavy).contains("mass: 8.1"));
    assert!(counts(&heavy) < counts(&own), "twice the mass");
}
