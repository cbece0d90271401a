//! The control task's promises: the limit, the faults, the swap and the reference, in every arithmetic.

use crate::measured::{calm, delayed, supplied};
use fixed::types::I16F16;
use preslide::control::learning::{Adaptation, MismatchWatch};
use preslide::control::{
    Axis, Coefficients, Command, Controller, Fault, Learning, LearningSettings, Measurement, Move,
    Observed, ObserverSettings, Pid, PidGains, PidState, Planner, Refused, Saturation,
    VelocitySource,
};
use preslide::{Bound, Friction, Gms, LuGre, QuasiStaticGms, Scalar, Sliding, Units};
use preslide_host_tests::path::COUNTS;
use preslide_host_tests::table3;
use proptest::prelude::*;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

type Both<S> = (MismatchWatch<S>, Adaptation<S>);

fn sliding() -> Sliding {
    Sliding {
        coulomb: 0.81,
        stribeck_velocity: 1e-3,
        stribeck_exponent: 1.0,
        attraction: 20.0,
    }
}

fn quasi_static<S: Scalar>(units: Units) -> QuasiStaticGms<3, S> {
    QuasiStaticGms::try_new(&table3::blocks::<3>(), 0.9, units).expect("Table 3 is valid")
}

fn controller<F: Friction>(settings: &Axis, friction: F, units: Units) -> Controller<F, u32> {
    let coefficients = Coefficients::try_new(settings, friction, units).expect("valid settings");
    let mut controller = Controller::new(coefficients, 0);
    assert_eq!(controller.enable(), Ok(()));
    controller
}

fn plan(axis: &Axis, distance: f64, speed: f64) -> Move {
    Move::plan(distance, speed, speed / 0.01, axis.grid()).expect("a valid move")
}

/// Random counts, supplies, moves, swaps and restarts: whatever comes, the command stays within the limit, and it is
/// zero whenever there is a fault. A second controller, which takes no tick for an ordinary one, commands the same.
fn never_exceeds<F: Friction + Clone>(
    friction: F,
    units: Units,
    drive: VelocitySource,
    ticks: usize,
    seed: u64,
) {
    let mut settings = Axis::PAPER_AXIS;
    settings.feed_forward.drive = drive;
    // Wide open, so that the limiter has work to do before a fault ends it.
    settings.watch.following_error = 0.5e-3;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut controller = controller(&settings, friction.clone(), units);
    let mut thorough = controller.clone();
    let limit = (settings.duty_limit * f64::from(settings.hardware.steps)) as i32;
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
            let speed = 10_f64.powf(rng.random_range(-6.0..-1.8));
            // Refused while disabled, and above 1 m/s².
            let next = plan(&settings, distance, speed);
            assert_eq!(controller.start(next), thorough.start(next));
        }
        if chance % 5000 == 9 {
            settings.gains.proportional = 10_f64.powf(rng.random_range(3.0..6.0));
            settings.notch.frequency = [0.0, 370.0][rng.random_range(0..2)];
            for controller in [&mut controller, &mut thorough] {
                let friction = friction.clone();
                controller.swap(
                    &Coefficients::try_new(&settings, friction, units).expect("valid settings"),
                );
            }
        }
        let supply = if chance % 100 == 3 {
            rng.next_u32() as u16
        } else {
            6000
        };
        let measured = Measurement {
            count,
            supply,
            current: rng.random_range(-2000..2000),
            late: chance % 50 == 1,
        };
        let command = controller.tick(measured);
        assert_eq!(command, thorough.any_tick(measured));
        assert!(command.code.abs() <= limit, "{command:?}");
        at_limit += u32::from(command.code.abs() == limit);
        if command.fault.is_some() {
            assert_eq!(command.code, 0);
            faults += 1;
            if chance.is_multiple_of(16) {
                for controller in [&mut controller, &mut thorough] {
                    controller.acknowledge();
                    let _ = controller.enable();
                }
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
    let part = 10_000_000 / 9;
    let full = Gms::<3>::try_new(&table3::blocks::<3>(), 0.9, sliding(), 50e-6, Units::SI)
        .expect("Table 3 is valid");
    let lugre =
        LuGre::<f32>::try_new(195e3, 4416.0, 0.9, sliding(), Units::SI).expect("Table 2 is valid");
    never_exceeds(
        quasi_static::<f32>(Units::SI),
        Units::SI,
        VelocitySource::Reference,
        part,
        1,
    );
    never_exceeds(
        quasi_static::<I16F16>(COUNTS),
        COUNTS,
        VelocitySource::Reference,
        part,
        2,
    );
    never_exceeds(
        quasi_static::<I16F16>(COUNTS),
        COUNTS,
        VelocitySource::Measured,
        part,
        3,
    );
    let observer = ObserverSettings::PAPER_AXIS;
    let float = quasi_static::<f32>(Units::SI);
    let float = Observed::try_new(float, &observer, 50e-6, Units::SI).expect("valid");
    never_exceeds(float, Units::SI, VelocitySource::Reference, part, 8);
    let fixed = quasi_static::<I16F16>(COUNTS);
    let fixed = Observed::try_new(fixed, &observer, 50e-6, COUNTS).expect("valid");
    never_exceeds(fixed, COUNTS, VelocitySource::Measured, part, 9);
    let learning = LearningSettings::PAPER_AXIS;
    let adaptive = |units| Learning::try_new(quasi_static(units), &learning, units);
    let fixed: Learning<_, Both<I16F16>> = adaptive(COUNTS).expect("valid");
    never_exceeds(fixed, COUNTS, VelocitySource::Reference, part, 6);
    let learning = LearningSettings {
        block: 8,
        ..learning
    };
    let float = quasi_static::<f32>(Units::SI);
    let float: Learning<_, Both<f32>> =
        Learning::try_new(float, &learning, Units::SI).expect("valid");
    never_exceeds(float, Units::SI, VelocitySource::Measured, part, 7);
    never_exceeds(full, Units::SI, VelocitySource::Measured, part, 4);
    never_exceeds(lugre, Units::SI, VelocitySource::Measured, part, 5);
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
    let settings = Axis::PAPER_AXIS;
    let fresh = || controller(&settings, quasi_static(Units::SI), Units::SI);
    let check = |(tick, command): (u32, Command), fault, ticks| {
        assert_eq!((command.fault, command.code, tick), (Some(fault), 0, ticks));
    };
    let jump = |tick| calm(if tick < 5 { 0 } else { 1000 });
    check(ticks_to_fault(fresh(), jump), Fault::EncoderJump, 5);
    // 1 ms is 20 ticks that are ridden out.
    let sag = |_| supplied(4000);
    check(ticks_to_fault(fresh(), sag), Fault::SupplyOutOfRange, 21);
    let late = |_| delayed();
    check(
        ticks_to_fault(fresh(), late),
        Fault::Overrun,
        settings.watch.overruns + 1,
    );
    let mut pushed = fresh();
    assert_eq!(pushed.start(plan(&settings, 1e-3, 1e-3)), Ok(()));
    let (tick, command) = ticks_to_fault(pushed, |_| calm(0));
    assert_eq!(
        (command.fault, command.code),
        (Some(Fault::EncoderFrozen), 0)
    );
    // 100 ticks after the command passed the duty that moves the axis whatever the friction.
    assert!((100..1000).contains(&tick), "{tick}");
}

#[test]
fn a_count_that_wraps_is_no_jump() {
    let settings = Axis::PAPER_AXIS;
    let coefficients =
        Coefficients::try_new(&settings, quasi_static::<f32>(Units::SI), Units::SI).expect("valid");
    let mut controller = Controller::new(coefficients, u32::MAX - 3);
    assert_eq!(controller.enable(), Ok(()));
    for step in 0..10_u32 {
        let command = controller.tick(calm((u32::MAX - 3).wrapping_add(step)));
        assert_eq!((command.fault, command.position), (None, i64::from(step)));
    }
}

/// An axis that turns without end at 10 rev/s of 2²⁰ counts: 10¹⁰ counts, past every width that a position could be kept in, with
/// the counter one count behind the reference.
#[test]
fn a_rotary_axis_turns_ten_billion_counts_without_a_fault() {
    let turn = 1_u32 << 20;
    let mut axis = Axis::PAPER_AXIS;
    axis.encoder.count = std::f64::consts::TAU / f64::from(turn);
    axis.encoder.turn = turn;
    axis.motor.screw_lead = std::f64::consts::TAU;
    axis.limits.travel = None;
    axis.limits.speed = 10.5 * std::f64::consts::TAU;
    axis.limits.acceleration = 500.0;
    axis.limits.jerk = 500.0 * 625.0;
    axis.watch.top_speed = 12.0 * std::f64::consts::TAU;
    axis.watch.following_error = 1100.0 * axis.encoder.count;
    axis.silence = 0.0;
    let friction = preslide::control::NoFriction::<f32>::new();
    let mut controller = controller(&axis, friction, Units::SI);
    let jog = Planner::try_new(&axis).and_then(|p| p.jog(10.0 * std::f64::consts::TAU));
    assert_eq!(controller.jog(jog.expect("within the limits")), Ok(()));
    let (mut count, mut furthest, mut ticks) = (0_u32, 0, 0_u64);
    while furthest < 10_000_000_000 {
        let command = controller.tick(Measurement { count, ..calm(0) });
        assert_eq!(command.fault, None, "after {ticks} ticks at {furthest}");
        assert!(command.position > furthest - 1000, "it must not turn back");
        assert!((command.reference - (command.position << 16)).abs() < 1100 << 16);
        furthest = command.position;
        count = ((command.reference >> 16) - 1) as u32;
        ticks += 1;
    }
    println!(
        "{furthest} counts, {} turns, in {ticks} ticks",
        furthest >> 20
    );
}

#[test]
fn boots_disabled_and_stays_so_until_enabled() {
    let axis = Axis::PAPER_AXIS;
    let friction = quasi_static::<f32>(Units::SI);
    let coefficients = Coefficients::try_new(&axis, friction, Units::SI).expect("valid");
    let mut controller = Controller::new(coefficients, 0_u32);
    let mut planner = Planner::try_new(&axis).expect("valid");
    let next = planner.by(1e-3, 1e-3, 0.1).expect("within the limits");
    assert_eq!(controller.start(next), Err(Refused::NotEnabled));
    for tick in 0..1000 {
        let carried = calm(tick * 5);
        let command = controller.tick(carried);
        assert_eq!(
            (command.code, command.enabled, command.fault),
            (0, false, None)
        );
    }
    assert_eq!(controller.enable(), Ok(()));
    assert_eq!(controller.start(next), Ok(()));
    let here = calm(999 * 5);
    assert!(controller.tick(here).enabled);
    // A fault disables; acknowledging it alone does not enable.
    let jump = calm(99_999);
    assert_eq!(controller.tick(jump).fault, Some(Fault::EncoderJump));
    assert_eq!(controller.enable(), Err(Fault::EncoderJump));
    controller.acknowledge();
    let command = controller.tick(jump);
    assert_eq!(
        (command.code, command.enabled, command.fault),
        (0, false, None)
    );
    assert_eq!(controller.enable(), Ok(()));
    controller.disable();
    let command = controller.tick(jump);
    assert_eq!(
        (command.code, command.enabled, command.fault),
        (0, false, None)
    );
}

#[test]
fn reversed_leads_and_counter_are_the_axis_s_business_alone() {
    let run = |encoder: bool, motor: bool| {
        let mut axis = Axis::PAPER_AXIS;
        axis.encoder.reversed = encoder;
        axis.motor.reversed = motor;
        let mut controller = controller(&axis, quasi_static::<f32>(Units::SI), Units::SI);
        assert_eq!(controller.start(plan(&axis, 1e-4, 1e-3)), Ok(()));
        let mut commands = Vec::new();
        let mut count = 0;
        for _ in 0..2000 {
            let wired: i32 = if encoder { -count } else { count };
            let mut command = controller.tick(calm(wired.cast_unsigned()));
            count = ((command.reference >> 16) - 3) as i32;
            command.code *= if motor { -1 } else { 1 };
            commands.push(command);
        }
        commands
    };
    let straight = run(false, false);
    assert!(straight.iter().any(|command| command.code > 100));
    assert_eq!(run(true, false), straight);
    assert_eq!(run(false, true), straight);
    assert_eq!(run(true, true), straight);
}

#[test]
fn a_following_error_and_a_number_that_is_none_end_in_the_safe_state() {
    let axis = Axis::PAPER_AXIS;
    let mut left_behind = controller(&axis, quasi_static(Units::SI), Units::SI);
    assert_eq!(left_behind.start(plan(&axis, 1e-3, 1e-2)), Ok(()));
    // One count now and then keeps it from reading as frozen.
    let crawling = |tick: u32| calm(tick / 40 * 2);
    let (_, command) = ticks_to_fault(left_behind, crawling);
    assert_eq!(
        (command.fault, command.code, command.enabled),
        (Some(Fault::FollowingError), 0, false)
    );

    let mut poisoned = controller(&axis, Poisoned(10), Units::SI);
    let command = (0..10)
        .map(|_| poisoned.tick(calm(0)))
        .last()
        .expect("ten ticks");
    assert_eq!(command.fault, Some(Fault::NotANumber));
    assert_eq!((command.code, command.enabled), (0, false));
}

/// A model that answers NaN from the tick given on.
#[derive(Clone, Debug, PartialEq)]
struct Poisoned(u32);

impl Friction for Poisoned {
    type Scalar = f32;
    type State = u32;

    fn at_rest(&self) -> u32 {
        0
    }

    fn step(&self, ticks: &mut u32, _: preslide::Motion<f32>) -> f32 {
        *ticks += 1;
        if *ticks < self.0 { 0.0 } else { f32::NAN }
    }

    fn limit(&self) -> Option<f32> {
        None
    }
}

#[test]
fn settings_that_cannot_be_are_refused_by_name() {
    let refused = |change: fn(&mut Axis)| {
        let mut settings = Axis::PAPER_AXIS;
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
    assert_eq!(refused(|s| s.hardware.rate_hz = 0), "control rate");
    assert_eq!(refused(|s| s.hardware.steps = 0), "PWM steps");
    assert_eq!(refused(|s| s.limits.jerk = 0.0), "jerk limit");
    assert_eq!(refused(|s| s.limits.speed = 30e-3), "top speed");
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
    let mut large = Axis::PAPER_AXIS;
    large.gains.proportional = 1e10;
    let error = Coefficients::try_new(&large, quasi_static::<I16F16>(COUNTS), COUNTS)
        .expect_err("too large");
    assert_eq!(error.parameter, "proportional gain");
}

/// An axis enabled again begins as one that never moved does: its reference is the same to the last bit, however soon after it was
/// disabled in motion, with a smoothing longer or shorter than before, and whatever is asked first.
#[test]
fn an_axis_enabled_again_begins_as_a_new_one() {
    let mut rng = ChaCha8Rng::seed_from_u64(15);
    let friction = preslide::control::NoFriction::<f32>::new;
    let mut used = controller(&Axis::PAPER_AXIS, friction(), Units::SI);
    let (mut count, mut ticks) = (0_u32, 0);
    for round in 0..2000 {
        // Smoothing of 256, 64 and 8 ticks.
        let mut axis = Axis::PAPER_AXIS;
        // Without friction braking takes more than it would stand.
        axis.watch.frozen_time = 1e3;
        axis.limits.jerk = [160.0, 625.0, 5000.0][rng.random_range(0..3)];
        let coefficients = Coefficients::try_new(&axis, friction(), Units::SI).expect("valid");
        used.disable();
        used.swap(&coefficients);
        for _ in 0..rng.random_range(0..5) {
            used.tick(Measurement { count, ..calm(0) });
        }
        assert_eq!(used.enable(), Ok(()));
        let start = used.position();
        used.set_position(start, start);
        let mut new = controller(&axis, friction(), Units::SI);
        new.set_position(0, start);
        let planner = Planner::try_new(&axis).expect("valid");
        let (origin, rest) = (count, rng.random_range(0..40));
        for tick in 0..rest + rng.random_range(1..600) {
            if tick == rest || rng.random_range(0..200) == 0 {
                let speed = rng.random_range(-4e-3..4e-3);
                let next = plan(&axis, rng.random_range(-1e-4..1e-4), f64::abs(speed));
                let jogs = rng.random_range(0..3) == 0;
                let asked = [&mut used, &mut new].map(|one| {
                    if jogs {
                        one.jog(planner.jog(speed).expect("within the limits"))
                    } else {
                        one.start(next)
                    }
                });
                assert_eq!(asked[0], asked[1]);
            }
            let [kept, fresh] = [(&mut used, count), (&mut new, count.wrapping_sub(origin))]
                .map(|(one, count)| one.tick(Measurement { count, ..calm(0) }).reference);
            assert_eq!(kept, fresh, "round {round}, tick {tick}");
            // The axis follows to the count.
            count = origin.wrapping_add(((kept >> 16) - start) as u32);
            ticks += 1;
        }
    }
    println!("{ticks} ticks, none apart");
}

proptest! {
    /// Gains that fixed point holds are within a hundredth of what was asked for; others are refused as rounded or as too large.
    #[test]
    fn a_gain_is_held_to_a_hundredth_or_refused(kp in 0.0..9.0_f64, ki in 0.0..10.0_f64, kd in -3.0..5.0_f64) {
        let [proportional, integral, derivative] = [kp, ki, kd].map(|power| 10_f64.powf(power));
        let gains = PidGains { proportional, integral, derivative, integral_limit: 30.0, deadband: 0.0 };
        let sample_time = Axis::PAPER_AXIS.sample_time();
        match Pid::<I16F16>::try_new(&gains, sample_time, COUNTS) {
            Err(error) => prop_assert!(
                error.parameter.contains("gain")
                    && matches!(error.bound, Bound::Rounded(_) | Bound::Resolvable | Bound::Representable(_)),
                "{error}"
            ),
            Ok(pid) => {
                // As large an error as makes no force saturate: in counts, and in mm/s.
                let per_count = proportional * COUNTS.length / COUNTS.force;
                let rate = integral * sample_time * COUNTS.length / COUNTS.force;
                let error = (10_000.0 / (per_count + rate)).clamp(1.0, 10_000.0).floor();
                let speed = (10_000.0 / derivative).clamp(1.0, 10_000.0).floor();
                let force = |error: f64, speed: f64| {
                    let at = |value: f64| I16F16::from_num(value);
                    pid.step(&mut PidState::new(), at(error), at(speed), Saturation::None).to_num::<f64>()
                };
                let asked = [(per_count + rate) * error, derivative * speed];
                for (got, asked) in [force(error, 0.0), force(0.0, speed)].into_iter().zip(asked) {
                    prop_assert!((got - asked).abs() <= 0.0101 * asked + 2.0 / 65536.0, "{got} for {asked}");
                }
            }
        }
    }
}
