//! Axes that carry a load at rest, and current senses that are off: on the simulated stage.

use super::coefficients;
use crate::measured::read;
use preslide::control::{Axis, Controller, Fault, Measurement, Move};
use preslide_sim::stage::{Stage, StageConfig};

/// When the move begins.
const MOVES: u32 = 50_000;

/// The stage under `force_n` of its place (m), which comes in so many `ticks`, and a move of `distance_m` at [`MOVES`], from which on the
/// count may be `frozen`; the largest |code|, where the axis ends up (m), and the tick of the fault with it.
fn carry(
    distance_m: f64,
    ticks: f64,
    force_n: impl Fn(f64) -> f64,
    frozen: bool,
) -> (i32, f64, Option<(u32, Fault)>) {
    let axis = Axis::PAPER_AXIS;
    let mut stage = Stage::try_new(StageConfig {
        seed: 7,
        ..StageConfig::default()
    })
    .expect("the default stage");
    let first = stage.reading().count.cast_unsigned();
    let mut controller = Controller::new(coefficients(&axis, false), first);
    let (mut push, mut fault, mut count) = (0, None, first);
    for tick in 0..120_000 {
        if tick == 100 {
            assert_eq!(controller.enable(), Ok(()));
        }
        if tick == MOVES && distance_m != 0.0 {
            let next = Move::plan(distance_m, 1e-3, 0.1, axis.grid()).expect("a move");
            assert_eq!(controller.start(next), Ok(()));
        }
        controller.heard();
        let at_m = stage.truth().position_m;
        // The stage begins at rest, and nothing holds it before it is enabled.
        let comes = ((f64::from(tick) - 100.0) / ticks).clamp(0.0, 1.0);
        let force = -comes * force_n(at_m);
        stage.set_external_force_n(force).expect("finite");
        let reading = stage.reading();
        if !frozen || tick < MOVES {
            count = reading.count.cast_unsigned();
        }
        let command = controller.tick(Measurement {
            count,
            ..read(&reading)
        });
        push = push.max(command.code.abs());
        fault = fault.or(command.fault.map(|fault| (tick, fault)));
        stage.tick(f64::from(command.code) / f64::from(axis.hardware.steps));
    }
    (push, stage.truth().position_m, fault)
}

/// A weight above what counts as a push (10 % of the duty are 3.64 N) is held, lifted and let down; a spring is stretched and held.
#[test]
fn weights_and_springs_are_held_and_moved_without_a_fault() {
    println!("load, move (mm): largest code, ends at (mm)");
    let weight = |newtons: f64| move |_: f64| newtons;
    let spring = |at_m: f64| 2000.0 * at_m;
    // Stretched by 2 mm where the axis begins, and let go.
    let stretched = |at_m: f64| 2000.0 * (at_m + 2e-3);
    // In half a second, and in the 10 ms of a brake that opens.
    let (slow, brake) = (10_000.0, 200.0);
    for (name, distance, (push, end, fault)) in [
        ("3.64 N", 0.0, carry(0.0, slow, weight(3.64), false)),
        ("-3.64 N", 0.0, carry(0.0, slow, weight(-3.64), false)),
        ("4.5 N", 1e-3, carry(1e-3, slow, weight(4.5), false)),
        ("4.5 N", -1e-3, carry(-1e-3, slow, weight(4.5), false)),
        ("2 N/mm", 2e-3, carry(2e-3, slow, spring, false)),
        ("-2 N/mm", -2e-3, carry(-2e-3, slow, spring, false)),
        (
            "2 N/mm, let go",
            -2e-3,
            carry(-2e-3, slow, stretched, false),
        ),
        (
            "3.64 N, brake opens",
            0.0,
            carry(0.0, brake, weight(3.64), false),
        ),
        (
            "-3.64 N, brake opens",
            1e-3,
            carry(1e-3, brake, weight(-3.64), false),
        ),
    ] {
        println!("{name}, {:.1}: {push}, {:.4}", distance * 1e3, end * 1e3);
        assert_eq!(fault, None, "{name}");
        assert!(push > 850, "{name}: no push that counts");
        assert!((end - distance).abs() < 1e-6, "{name}: ends at {end}");
    }
}

/// An encoder that freezes as a move begins is found on every axis, the later the more of the push a load takes, and at the latest by the
/// following error.
#[test]
fn a_frozen_encoder_is_found_under_a_load_though_later() {
    println!("load (N), move (mm): fault after (ticks)");
    for (newtons, distance) in [
        (0.0, 1e-3),
        (2.0, 1e-3),
        (3.64, 1e-3),
        (3.64, -1e-3),
        (4.5, 1e-3),
        (4.5, -1e-3),
    ] {
        let (_, _, fault) = carry(distance, 10_000.0, |_| newtons, true);
        let (tick, fault) = fault.expect("a fault");
        let after = tick - MOVES;
        println!("{newtons}, {:.0}: {fault:?} after {after}", distance * 1e3);
        // The reference is 50 um ahead after 2200 ticks.
        assert!(after <= 2200, "{newtons} {distance}: {after}");
        assert!(matches!(
            fault,
            Fault::EncoderFrozen | Fault::FollowingError
        ));
    }
}

/// Of a weight that was held for half a second and taken off, the watch remembers nothing in the motion that follows: its ticks are ordinary again,
/// which is what the budget of a tick counts on.
#[test]
fn ticks_after_a_push_are_ordinary_again() {
    let axis = Axis::PAPER_AXIS;
    let mut stage = Stage::try_new(StageConfig::default()).expect("the default stage");
    let first = stage.reading().count.cast_unsigned();
    let mut controller = Controller::new(coefficients(&axis, false), first);
    let (mut push, mut even, mut ordinary) = (0, 0, 0);
    for tick in 0..60_000_u32 {
        match tick {
            100 => assert_eq!(controller.enable(), Ok(())),
            600 => {
                let far = Move::plan(5e-3, 2e-3, 0.2, axis.grid()).expect("a move");
                assert_eq!(controller.start(far), Ok(()));
            }
            _ => {}
        }
        controller.heard();
        // Comes in a tenth of a second, stays for half a second, and goes as it came.
        let share = (f64::from(tick) - 2000.0).min(16_000.0 - f64::from(tick)) / 2000.0;
        let force = -4.5 * share.clamp(0.0, 1.0);
        stage.set_external_force_n(force).expect("finite");
        let reading = stage.reading();
        let measured = read(&reading);
        let known = controller.ordinary_tick(measured);
        // At 2 mm/s, long after the weight is off.
        let cruises = (20_000..45_000).contains(&tick);
        even += u32::from(cruises);
        ordinary += u32::from(cruises && known.is_some());
        let command = known.unwrap_or_else(|| controller.any_tick(measured));
        assert_eq!(command.fault, None, "tick {tick}");
        push = push.max(command.code.abs());
        stage.tick(f64::from(command.code) / f64::from(axis.hardware.steps));
    }
    println!("{ordinary} of {even} ticks ordinary, largest code {push}");
    assert!(push > 850, "no push that counts: {push}");
    assert!(ordinary * 10 >= even * 9, "{ordinary} of {even}");
}

/// An offset of four times the limit is found at enabling, however soon after power; half of the limit is none at any time.
#[test]
fn an_offset_of_the_current_is_known_before_the_bridge_is_driven() {
    let axis = Axis::PAPER_AXIS;
    let limit = (axis.watch.current_offset / axis.hardware.current_code) as i16;
    for (offset, expected) in [(4 * limit, Some(Fault::CurrentOffset)), (limit / 2, None)] {
        for ticks in 0..100 {
            let mut controller = Controller::new(coefficients(&axis, false), 0_u32);
            let measured = |tick: i16| Measurement {
                count: 0,
                supply: 6000,
                // And some noise.
                current: offset + (tick * 37 % 21) - 10,
                late: false,
            };
            for tick in 0..ticks {
                controller.tick(measured(tick));
            }
            let refused = controller.enable().err();
            let command = controller.tick(measured(ticks));
            assert_eq!(command.fault.or(refused), expected, "after {ticks} ticks");
            assert!(expected.is_none() || command.code == 0);
        }
    }
}
