//! A change of any parameter that may be made while the axis is driven bumps nothing.

use crate::measured::calm;
use preslide::control::{Axis, Command, Controller, Measurement};
use proptest::prelude::*;

type Change = fn(&mut Axis, f64);

/// The parameters that the link sets while the axis is driven (`firmware/app/src/parameters.rs`, `Always`), each times a factor.
const CHANGES: [(&str, Change); 12] = [
    ("gains.proportional", |a, by| a.gains.proportional *= by),
    ("gains.integral", |a, by| a.gains.integral *= by),
    ("gains.derivative", |a, by| a.gains.derivative *= by),
    ("gains.integral_limit", |a, by| a.gains.integral_limit *= by),
    ("gains.deadband", |a, by| a.gains.deadband *= by),
    // From none to one, and of one that the axis has.
    ("notch.frequency", |a, by| a.notch.frequency = 300.0 * by),
    ("notch.width", |a, by| a.notch.width = (0.5 * by).min(1.0)),
    ("notch.depth", |a, by| a.notch.depth = (0.5 * by).min(1.0)),
    ("feed_forward.share", |a, by| {
        a.feed_forward.share = by.min(1.0)
    }),
    ("feed_forward.limit", |a, by| a.feed_forward.limit *= by),
    ("feed_forward.mass", |a, by| a.feed_forward.mass *= by),
    ("fade_time", |a, by| {
        a.fade_time = (a.fade_time * by).min(0.49)
    }),
];

/// An axis that stands off its reference, so that the integral and the feedback push; ticks of rest before the change.
fn pushed(rest: u32, off: u32) -> (Controller<super::Model, u32>, Measurement<u32>) {
    let axis = Axis::PAPER_AXIS;
    let mut controller = Controller::new(super::coefficients(&axis, false), 0_u32);
    let mut measured = calm(0);
    controller.tick(measured);
    assert_eq!(controller.enable(), Ok(()));
    for tick in 0..rest {
        // It slips away by a count every few ticks.
        measured.count = (tick / 4).min(off).wrapping_neg();
        controller.heard();
        controller.tick(measured);
    }
    (controller, measured)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    /// Beside an axis that goes on with the old parameters the changed one commands the same in the next tick, and comes away from it by
    /// no step: for 0.1 s, a quarter of the fade.
    #[test]
    fn no_change_of_a_parameter_bumps_the_command(
        which in 0..CHANGES.len(), by in -2.0..0.7_f64, rest in 100_u32..9000, off in 2_u32..60,
    ) {
        let (name, change) = CHANGES[which];
        let (mut changed, measured) = pushed(rest, off);
        let mut kept = changed.clone();
        let mut axis = Axis::PAPER_AXIS;
        change(&mut axis, 10_f64.powf(by));
        changed.swap(&super::coefficients(&axis, false));
        let mut last = 0;
        for tick in 0..2000 {
            let codes = [&mut changed, &mut kept].map(|one| {
                one.heard();
                let command: Command = one.tick(measured);
                command.fault.is_none().then_some(command.code)
            });
            let [Some(new), Some(old)] = codes else { break };
            let apart = new - old;
            // Rounding is a code of each; the fastest fade, ten times shorter, moves by some codes a tick.
            prop_assert!((apart - last).abs() <= 4, "{name}: {last} to {apart} in tick {tick}");
            last = apart;
        }
    }
}

/// What was seen: 3.6 N in the integral, and a limit of 1 N.
#[test]
fn a_lower_limit_of_the_integral_fades() {
    let (mut controller, measured) = pushed(6000, 10);
    let before = controller.tick(measured).code;
    let mut axis = Axis::PAPER_AXIS;
    axis.gains.integral_limit = 0.01;
    controller.swap(&super::coefficients(&axis, false));
    let next = controller.tick(measured).code;
    println!("{before}, then {next}");
    assert!(
        before > 50 && (next - before).abs() <= 2,
        "{before} to {next}"
    );
    for _ in 0..8100 {
        controller.heard();
        controller.tick(measured);
    }
    let after = controller.tick(measured).code;
    assert!(after < before - 40, "it must go in the end: {after}");
}
