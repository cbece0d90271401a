//! The control task's promises: the limit, the faults, the swap and the reference, in every arithmetic.

use fixed::types::I16F16;
use preslide::control::learning::{Adaptation, MismatchWatch};
use preslide::control::{
    Coefficients, Command, Controller, Drive, Fault, Learning, LearningSettings, Measurement, Move,
    Reference, Settings,
};
use preslide::{Block, Friction, Gms, LuGre, QuasiStaticGms, Scalar, Sliding, Units};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

type Both<S> = (MismatchWatch<S>, Adaptation<S>);

/// The fixed-point form's units: counts and millinewtons.
const COUNTS: Units = Units {
    length: 25e-9,
    force: 1e-3,
    velocity: 1e-3,
};

/// Table 3, three blocks.
const BLOCKS: [Block; 3] = [
    Block {
        stiffness: 325_379.0,
        weight: 0.352,
    },
    Block {
        stiffness: 40_535.0,
        weight: 0.307,
    },
    Block {
        stiffness: 7_886.0,
        weight: 0.341,
    },
];

fn sliding() -> Sliding {
    Sliding {
        coulomb: 0.81,
        stribeck_velocity: 1e-3,
        stribeck_exponent: 1.0,
        attraction: 20.0,
    }
}

fn quasi_static<S: Scalar>(units: Units) -> QuasiStaticGms<3, S> {
    QuasiStaticGms::try_new(&BLOCKS, 0.9, units).expect("Table 3 is valid")
}

fn controller<F: Friction>(settings: &Settings, friction: F, units: Units) -> Controller<F, u32> {
    let coefficients = Coefficients::try_new(settings, friction, units).expect("valid settings");
    Controller::new(coefficients, 0)
}

fn plan<S: Scalar>(settings: &Settings, distance: f64, speed: f64, units: Units) -> Move<S> {
    let Settings {
        encoder,
        sample_time,
        ..
    } = settings;
    Move::plan(
        distance,
        speed,
        speed / 0.01,
        encoder.count,
        *sample_time,
        units,
    )
    .expect("a valid move")
}

const HEALTHY: Measurement<u32> = Measurement {
    count: 0,
    supply: 6000,
    late: false,
};

/// Random counts, supplies, moves, swaps and restarts: whatever comes, the command stays within the limit, and it is
/// zero whenever there is a fault.
fn never_exceeds<F: Friction + Clone>(
    friction: F,
    units: Units,
    drive: Drive,
    ticks: usize,
    seed: u64,
) {
    let mut settings = Settings::PAPER_AXIS;
    settings.feed_forward.drive = drive;
    // Wide open, so that the limiter has work to do before a fault ends it.
    settings.watch.following_error = 0.5e-3;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut controller = controller(&settings, friction.clone(), units);
    let limit = (settings.duty_limit * settings.motor.steps) as i32;
    let (mut at_limit, mut faults, mut count) = (0_u32, 0_u32, 0_u32);
    for _ in 0..ticks {
        let chance: u32 = rng.random();
        count = match chance % 10_000 {
            0 => rng.random(),
            1..50 => count.wrapping_add(rng.random_range(0..80)).wrapping_sub(40),
            _ => count.wrapping_add(rng.random_range(0..5)).wrapping_sub(2),
        };
        if chance % 1000 == 7 {
            let distance = rng.random_range(-2e-3..2e-3);
            let speed = 10_f64.powf(rng.random_range(-6.0..-1.0));
            controller.start(plan(&settings, distance, speed, units));
        }
        if chance % 5000 == 9 {
            settings.gains.proportional = 10_f64.powf(rng.random_range(3.0..6.0));
            controller.swap(
                Coefficients::try_new(&settings, friction.clone(), units).expect("valid settings"),
            );
        }
        let supply = if chance % 100 == 3 {
            rng.next_u32() as u16
        } else {
            6000
        };
        let command = controller.tick(Measurement {
            count,
            supply,
            late: chance % 50 == 1,
        });
        assert!(command.code.abs() <= limit, "{command:?}");
        at_limit += u32::from(command.code.abs() == limit);
        if command.fault.is_some() {
            assert_eq!(command.code, 0);
            faults += 1;
            if chance.is_multiple_of(16) {
                controller.restart();
            }
        }
    }
    assert!(
        at_limit > 100 && faults > 100,
        "the run never came near the limit: {at_limit}, {faults}"
    );
}

/// 10⁷ ticks in all, over the models and arithmetics.
#[test]
fn the_command_never_exceeds_its_limit_over_ten_million_random_ticks() {
    let part = 10_000_000 / 7;
    let full =
        Gms::<3>::try_new(&BLOCKS, 0.9, sliding(), 50e-6, Units::SI).expect("Table 3 is valid");
    let lugre =
        LuGre::<f32>::try_new(195e3, 4416.0, 0.9, sliding(), Units::SI).expect("Table 2 is valid");
    never_exceeds(
        quasi_static::<f32>(Units::SI),
        Units::SI,
        Drive::Reference,
        part,
        1,
    );
    never_exceeds(
        quasi_static::<I16F16>(COUNTS),
        COUNTS,
        Drive::Reference,
        part,
        2,
    );
    never_exceeds(
        quasi_static::<I16F16>(COUNTS),
        COUNTS,
        Drive::Measured,
        part,
        3,
    );
    let learning = LearningSettings::PAPER_AXIS;
    let adaptive = |units| Learning::try_new(quasi_static(units), &learning, units);
    let fixed: Learning<_, Both<I16F16>> = adaptive(COUNTS).expect("valid");
    never_exceeds(fixed, COUNTS, Drive::Reference, part, 6);
    let learning = LearningSettings {
        block: 8,
        ..learning
    };
    let float = quasi_static::<f32>(Units::SI);
    let float: Learning<_, Both<f32>> =
        Learning::try_new(float, &learning, Units::SI).expect("valid");
    never_exceeds(float, Units::SI, Drive::Measured, part, 7);
    never_exceeds(full, Units::SI, Drive::Measured, part, 4);
    never_exceeds(lugre, Units::SI, Drive::Measured, part, 5);
}

/// Runs until the fault; how many ticks that took.
fn ticks_to_fault(
    mut controller: Controller<QuasiStaticGms<3>, u32>,
    mut measure: impl FnMut(u32) -> Measurement<u32>,
) -> (u32, Command) {
    for tick in 1..10_000 {
        let command = controller.tick(measure(tick));
        if command.fault.is_some() {
            return (tick, command);
        }
    }
    panic!("no fault in 10000 ticks");
}

#[test]
fn every_fault_ends_in_the_safe_state_within_its_ticks() {
    let settings = Settings::PAPER_AXIS;
    let fresh = || controller(&settings, quasi_static(Units::SI), Units::SI);
    let check = |(tick, command): (u32, Command), fault, ticks| {
        assert_eq!((command.fault, command.code, tick), (Some(fault), 0, ticks));
    };
    let jump = |tick| Measurement {
        count: if tick < 5 { 0 } else { 1000 },
        ..HEALTHY
    };
    check(ticks_to_fault(fresh(), jump), Fault::EncoderJump, 5);
    // 1 ms is 20 ticks that are ridden out.
    let sag = |_| Measurement {
        supply: 4000,
        ..HEALTHY
    };
    check(ticks_to_fault(fresh(), sag), Fault::SupplyOutOfRange, 21);
    let late = |_| Measurement {
        late: true,
        ..HEALTHY
    };
    check(
        ticks_to_fault(fresh(), late),
        Fault::Overrun,
        settings.watch.overruns + 1,
    );
    let mut pushed = fresh();
    pushed.start(plan(&settings, 1e-3, 1e-3, Units::SI));
    let (tick, command) = ticks_to_fault(pushed, |_| HEALTHY);
    assert_eq!(
        (command.fault, command.code),
        (Some(Fault::EncoderFrozen), 0)
    );
    // 100 ticks after the command passed the duty that moves the axis whatever the friction.
    assert!((100..1000).contains(&tick), "{tick}");
}

#[test]
fn a_count_that_wraps_is_no_jump() {
    let settings = Settings::PAPER_AXIS;
    let coefficients =
        Coefficients::try_new(&settings, quasi_static::<f32>(Units::SI), Units::SI).expect("valid");
    let mut controller = Controller::new(coefficients, u32::MAX - 3);
    for step in 0..10_u32 {
        let command = controller.tick(Measurement {
            count: (u32::MAX - 3).wrapping_add(step),
            ..HEALTHY
        });
        assert_eq!((command.fault, command.position), (None, i64::from(step)));
    }
}

#[test]
fn a_swap_does_not_bump_the_command() {
    let mut settings = Settings::PAPER_AXIS;
    let mut controller = controller(&settings, quasi_static::<I16F16>(COUNTS), COUNTS);
    controller.start(plan(&settings, 10e-6, 50e-6, COUNTS));
    // The axis follows one count behind for a while, then stands.
    let mut before = controller.tick(HEALTHY);
    for _ in 0..500 {
        before = controller.tick(Measurement {
            count: ((before.reference >> 16) - 1).max(0) as u32,
            ..HEALTHY
        });
    }
    let count = ((before.reference >> 16) - 1) as u32;
    before = controller.tick(Measurement { count, ..HEALTHY });
    settings.gains.proportional *= 3.0;
    settings.gains.derivative *= 2.0;
    controller.swap(
        Coefficients::try_new(&settings, quasi_static(COUNTS), COUNTS).expect("valid settings"),
    );
    let after = controller.tick(Measurement { count, ..HEALTHY });
    assert!(
        before.code.abs() > 50,
        "the command should be more than rounding: {before:?}"
    );
    // The reference moved on by a tenth of a count; without the fade the step would be hundreds of codes.
    assert!(
        (after.code - before.code).abs() <= 5,
        "{before:?} {after:?}"
    );
}

#[test]
fn moves_end_where_they_should_to_the_last_bit() {
    let settings = Settings::PAPER_AXIS;
    for (distance, speed) in [
        (100e-9, 20e-6),
        (-37e-9, 5e-9),
        (1e-3, 1e-3),
        (-0.3e-6, 1e-2),
        (2.5e-9, 1e-6),
    ] {
        let mut reference = Reference::<f32>::at(-7);
        let start = reference.step().position;
        let planned: Move<f32> = plan(&settings, distance, speed, Units::SI);
        reference.start(planned);
        let (mut last, mut ticks) = (start, 0);
        while !reference.is_idle() {
            let now = reference.step();
            assert!(
                ((now.position - last) as f64) * distance.signum() >= 0.0,
                "it must not turn back"
            );
            (last, ticks) = (now.position, ticks + 1);
        }
        assert_eq!(ticks, planned.ticks());
        let travelled = (last - start) as f64 / 65536.0 * 25e-9;
        assert!(
            (travelled - distance).abs() < 25e-9 / 30_000.0,
            "{distance} {travelled}"
        );
    }
}

#[test]
fn settings_that_cannot_be_are_refused_by_name() {
    let refused = |change: fn(&mut Settings)| {
        let mut settings = Settings::PAPER_AXIS;
        change(&mut settings);
        Coefficients::try_new(&settings, quasi_static::<f32>(Units::SI), Units::SI)
            .expect_err("must be refused")
            .parameter
    };
    assert_eq!(
        refused(|s| s.gains.proportional = f64::NAN),
        "proportional gain"
    );
    assert_eq!(refused(|s| s.gains.integral = -1.0), "integral gain");
    assert_eq!(refused(|s| s.sample_time = 0.0), "sample time");
    assert_eq!(
        refused(|s| s.motor.resistance = f64::INFINITY),
        "resistance"
    );
    assert_eq!(refused(|s| s.motor.efficiency = 1.2), "efficiency");
    assert_eq!(refused(|s| s.duty_limit = 1.5), "duty limit");
    assert_eq!(
        refused(|s| s.feed_forward.share = 2.0),
        "feed-forward share"
    );
    assert_eq!(
        refused(|s| s.watch.supply_min = 0.0),
        "lowest supply voltage"
    );
    assert_eq!(refused(|s| s.encoder.count = f64::NAN), "length of a count");
    let mut large = Settings::PAPER_AXIS;
    large.gains.proportional = 1e10;
    let error = Coefficients::try_new(&large, quasi_static::<I16F16>(COUNTS), COUNTS)
        .expect_err("too large");
    assert_eq!(error.parameter, "proportional gain");
}
