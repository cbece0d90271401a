//! Axes that carry a load at rest, and current senses that are off: on the simulated stage.

use super::coefficients;
use preslide::control::{Axis, Controller, Fault, Measurement, Move};
use preslide_sim::stage::{Stage, StageConfig};

/// The stage under `force_n` of its place (m) and time (ticks), and a move of `distance_m` in the middle; the largest |code|, where the
/// axis ends up (m) and the fault.
fn carry(distance_m: f64, force_n: impl Fn(f64, u32) -> f64) -> (i32, f64, Option<Fault>) {
    let axis = Axis::PAPER_AXIS;
    let mut stage = Stage::try_new(StageConfig {
        seed: 7,
        ..StageConfig::default()
    })
    .expect("the default stage");
    let first = stage.reading().count.cast_unsigned();
    let mut controller = Controller::new(coefficients(&axis, false), first);
    let (mut push, mut fault) = (0, None);
    for tick in 0..120_000 {
        if tick == 100 {
            assert_eq!(controller.enable(), Ok(()));
        }
        if tick == 50_000 && distance_m != 0.0 {
            let next = Move::plan(distance_m, 1e-3, 0.1, axis.grid()).expect("a move");
            assert_eq!(controller.start(next), Ok(()));
        }
        controller.heard();
        let at_m = stage.truth().position_m;
        // The load comes over half a second: the stage begins at rest.
        let comes = (f64::from(tick) / 10_000.0).min(1.0);
        let force = -comes * force_n(at_m, tick);
        stage.set_external_force_n(force).expect("finite");
        let reading = stage.reading();
        let command = controller.tick(Measurement {
            count: reading.count.cast_unsigned(),
            supply: (reading.supply_v * 1e3).round() as u16,
            current: (reading.current_a * 1e4).round() as i16,
            late: false,
        });
        push = push.max(command.code.abs());
        fault = fault.or(command.fault);
        stage.tick(f64::from(command.code) / f64::from(axis.hardware.steps));
    }
    (push, stage.truth().position_m, fault)
}

/// A weight above what counts as a push (10 % of the duty are 3.64 N) is held, lifted and let down; a spring is stretched and held.
#[test]
fn weights_and_springs_are_held_and_moved_without_a_fault() {
    println!("load, move (mm): largest code, ends at (mm)");
    let weight = |newtons: f64| move |_: f64, _: u32| newtons;
    let spring = |at_m: f64, _: u32| 2000.0 * at_m;
    for (name, distance, (push, end, fault)) in [
        ("3.64 N", 0.0, carry(0.0, weight(3.64))),
        ("-3.64 N", 0.0, carry(0.0, weight(-3.64))),
        ("4.5 N", 1e-3, carry(1e-3, weight(4.5))),
        ("4.5 N", -1e-3, carry(-1e-3, weight(4.5))),
        ("2 N/mm", 2e-3, carry(2e-3, spring)),
    ] {
        println!("{name}, {:.1}: {push}, {:.4}", distance * 1e3, end * 1e3);
        assert_eq!(fault, None, "{name}");
        assert!(push > 850, "{name}: no push that counts");
        assert!((end - distance).abs() < 1e-6, "{name}: ends at {end}");
    }
}

/// An offset of four times the limit is found by whoever enables, however soon after power; half of the limit is none at any time.
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
