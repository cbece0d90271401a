//! What no other test missed when `cargo mutants` changed it.

use crate::measured::{calm, carrying};
use crate::places::controller;
use fixed::types::I16F16;
use preslide::control::koopman::Guided;
use preslide::control::learning::{Adaptation, Learn, MismatchWatch};
use preslide::control::{
    Axis, Basics, Coefficients, Compensator, Controller, FeedForward, Hardware, Learning,
    LearningSettings, Limiter, Measurement, Motor, MotorDrive, Move, NoFriction, NormalRange, Pid,
    PidState, Planner, Reference, Rounding, Saturation,
};
use preslide::{
    Bound, Coulomb, ElastoPlastic, Friction, Leuven, LeuvenForm, QuasiStaticGms, Sliding, Units,
};
use preslide_host_tests::path::{COUNTS, motion};
use preslide_host_tests::table3::{blocks, falling};

/// `η·(k·τ)²/R` and what follows from it, by the numbers of the paper's axis with a gear and losses.
#[test]
fn a_motor_is_what_its_parts_make_it() {
    let motor = Motor {
        gear_ratio: 3.0,
        efficiency: 0.8,
        ..Motor::PAPER_AXIS
    };
    let transmission = 2.0 * std::f64::consts::PI * 3.0 / 2e-3;
    let per_ampere = 6.59e-3 * transmission;
    for (found, wanted) in [
        (motor.transmission(), transmission),
        (motor.force_per_volt(), 0.8 * per_ampere / 3.41),
        (motor.braking(), 0.8 * per_ampere * per_ampere / 3.41),
    ] {
        assert!(
            (found / wanted - 1.0).abs() < 1e-12,
            "{found}, not {wanted}"
        );
    }
}

/// A moving axis on which nothing is unusual takes the short path, and after a doubt or a push takes it again.
#[test]
fn nearly_all_ticks_of_a_moving_axis_are_ordinary() {
    let axis = Axis::PAPER_AXIS;
    let mut controller = controller(&axis, 0);
    controller.enable().expect("nothing speaks against it");
    let mut planner = Planner::try_new(&axis).expect("the paper's axis");
    let next: Move = planner.by(2e-3, 5e-3, 0.5).expect("within the limits");
    controller.start(next).expect("it stands");
    let (mut ordinary, mut ticks) = (0, 0);
    while !controller.is_idle() {
        // An axis that is where it should be; twice the supply sags for less than what is a fault.
        let supply = if ticks % 4000 == 2000 { 4000 } else { 6000 };
        let measured = Measurement {
            count: (controller.reference() >> 16) as u32,
            supply,
            ..calm(0)
        };
        ordinary += i32::from(match controller.ordinary_tick(measured) {
            Some(_) => true,
            None => {
                assert_eq!(controller.any_tick(measured).fault, None);
                false
            }
        });
        ticks += 1;
    }
    assert!(ordinary > ticks * 9 / 10, "{ordinary} of {ticks}");
}

/// A winding under pulses of half a per cent against a back-EMF (V), marched in nanoseconds: its mean current (A), the ones at the pulse's two
/// ends, and the one at `phase` of the period behind the pulse's middle.
fn marched(motor: &Motor, period: f64, phase: f64, back_emf: f64) -> [f64; 4] {
    const STEPS: usize = 50_000;
    let (dt, pulse) = (period / STEPS as f64, STEPS / 200);
    let sampled = pulse / 2 + (phase * STEPS as f64) as usize;
    let (mut current, mut seen) = (0.0, [0.0; 4]);
    // Settled, after twenty time constants.
    for _ in 0..10 {
        seen[0] = 0.0;
        for step in 0..STEPS {
            let volts = if step < pulse { motor.supply } else { 0.0 };
            match step {
                0 => seen[1] = current,
                _ if step == pulse => seen[2] = current,
                _ if step == sampled => seen[3] = current,
                _ => {}
            }
            current += (volts - back_emf - motor.resistance * current) / motor.inductance * dt;
            seen[0] += current / STEPS as f64;
        }
    }
    seen
}

#[test]
fn a_bridge_s_dead_time_is_made_up_for_by_what_each_edge_loses() {
    let axis = Axis::PAPER_AXIS;
    let (motor, plain) = (axis.motor, axis.hardware);
    let hardware = plain.with_dead_time(800e-9, 0.7);
    let phase = axis.sampling_phase();
    // Each edge costs half of the dead time's share, at the supply and two diodes.
    let edge = 0.5 * 800e-9 / hardware.sample_time() * (1.0 + 2.0 * 0.7 / motor.supply) * 8500.0;
    let code = |hardware: &Hardware, amperes: f64, back_emf: f64| {
        let drive = MotorDrive::<f64>::try_new(&motor, hardware, Units::SI).expect("valid");
        let force = amperes * motor.resistance * motor.force_per_volt();
        let velocity = back_emf / (motor.torque_constant * motor.transmission());
        let mut rounding = Rounding::new();
        // The mean of many: what rounding leaves over is carried.
        let codes = (0..4000).map(|_| drive.code(&mut rounding, force, velocity, 1.0));
        codes
            .map(|code| f64::from(code.expect("a number")))
            .sum::<f64>()
            / 4000.0
    };
    let codes_per_ampere = motor.resistance / motor.supply * 8500.0;
    for back_emf in [0.0, 0.02, -0.02] {
        let [mean, begin, end, sampled] = marched(&motor, hardware.sample_time(), phase, back_emf);
        assert!(
            (sampled - mean).abs() < 1e-4,
            "{sampled}, not {mean} at {phase}"
        );
        for times in [100.0, 1.0, -1.0, -100.0] {
            let [mean, back_emf] = [mean, back_emf].map(|one| one * times);
            let added = code(&hardware, mean, back_emf) - code(&plain, mean, back_emf);
            let of_edge = |current: f64| (times * current * codes_per_ampere).clamp(-edge, edge);
            let wanted = of_edge(begin) + of_edge(end);
            // A pulse of half a per cent is short to a few per cent.
            assert!(
                (added - wanted).abs() < 0.03 * wanted.abs() + 0.5,
                "{added} codes at {mean} A and {back_emf} V, not {wanted}"
            );
        }
    }
}

/// The integral does not go on in the direction in which the command is cut, nor within the dead band; elsewhere it does.
#[test]
fn the_integral_waits_where_more_of_it_would_be_cut() {
    let mut gains = Axis::PAPER_AXIS.gains;
    gains.deadband = 1e-7;
    let pid = Pid::<f64>::try_new(&gains, 50e-6, Units::SI).expect("valid");
    let grown = |cut, error: f64| {
        let mut state = PidState::new();
        let first = pid.step(&mut state, error, 0.0, cut);
        pid.step(&mut state, error, 0.0, cut) - first
    };
    for (cut, error, grows) in [
        (Saturation::None, 2e-7, true),
        (Saturation::None, -2e-7, true),
        (Saturation::None, 0.9e-7, false),
        (Saturation::None, -0.9e-7, false),
        (Saturation::Above, 2e-7, false),
        (Saturation::Above, -2e-7, true),
        (Saturation::Above, 0.9e-7, false),
        (Saturation::Above, -0.9e-7, false),
        (Saturation::Below, -2e-7, false),
        (Saturation::Below, 2e-7, true),
        (Saturation::Below, 0.9e-7, false),
        (Saturation::Below, -0.9e-7, false),
    ] {
        let by = grown(cut, error);
        assert_eq!(by != 0.0, grows, "{cut:?}, {error}: by {by} N");
        assert!(by * error >= 0.0);
    }
}

/// The acceleration that is reported and fed forward is the second difference of the position.
#[test]
fn the_acceleration_is_that_of_the_position() {
    let mut axis = Axis::PAPER_AXIS;
    axis.limits.acceleration = 40.0;
    axis.limits.jerk = 1e5;
    let pace = *controller(&axis, 0).pace();
    let mut reference = Reference::at(0, &pace);
    let (mut at, mut speed, mut told) = (0, 0, 0);
    for (distance, acceleration) in [(2e-3, 39.0), (-2e-3, 20.0), (-5e-5, 1.0)] {
        let next = Move::plan(distance, 15e-3, acceleration, axis.grid()).expect("planned");
        assert_eq!(reference.start(next, &pace), Ok(()));
        while !reference.is_standing() {
            let sample = reference.step(&pace);
            let gained = (sample.position - at - speed) as f64 / 65_536.0;
            (at, speed) = (sample.position, sample.position - at);
            // Times the ticks of the smoothing, `2·a/j`, which it is still to be divided by; a bit of the position counts for that many.
            let off = f64::from(sample.change) - 16.0 * gained;
            assert!(off.abs() < 2.0, "{} for {gained}", sample.change);
            told += u32::from(sample.change != 0);
        }
    }
    assert!(told > 50);
}

/// What a motion within the limits makes must fit the number type.
#[test]
fn what_a_type_cannot_hold_is_refused_by_its_name() {
    let units = |velocity: f64| Units { velocity, ..COUNTS };
    let friction = NoFriction::<I16F16>::new;
    for (velocity, name) in [(5e-7, "top speed"), (2e-5, "acceleration limit")] {
        let error = Coefficients::try_new(&Axis::PAPER_AXIS, friction(), units(velocity));
        assert_eq!(error.expect_err("refused").parameter, name);
    }
    let mut axis = Axis::PAPER_AXIS;
    axis.limits.speed = 9000.0 * 25e-9 / 50e-6;
    axis.watch.top_speed = 9001.0 * 25e-9 / 50e-6;
    let error = Coefficients::try_new(&axis, NoFriction::<f64>::new(), Units::SI);
    assert_eq!(
        error.expect_err("refused").parameter,
        "speed limit in counts per tick"
    );
    let sliding = falling(4e-5, 20.0);
    let counts = units(1e-3);
    let error = ElastoPlastic::<I16F16>::try_new(195e3, 0.0, 1e-11, 0.9, sliding, counts);
    assert_eq!(error.expect_err("refused").parameter, "z/z_ss");
    // Between blocks that barely excite and one that does fully, information may grow by so many times; it is inverted by a step of Newton's.
    let mut learning = LearningSettings::PAPER_AXIS;
    learning.excitation = 0.25;
    learning.adaptation.memory = 20.0;
    let error = Adaptation::<f64>::try_new(&learning, 0.9, Units::SI);
    assert_eq!(error.expect_err("refused").bound, Bound::AtLeast(30.0));
    let stiff = ElastoPlastic::<f64>::try_new(195e3, 0.0, 1.0, 0.9, Sliding::none(0.9), Units::SI);
    let error = stiff.expect_err("refused");
    assert_eq!(error.parameter, "elastic deflection z_ba");
    assert!(matches!(error.bound, Bound::AtMost(most) if most <= 0.9 / 195e3));
    let (small, none) = (
        Units {
            force: 0.9 / 20_000.0,
            ..counts
        },
        Sliding::none(0.9),
    );
    let error =
        Leuven::<4, I16F16>::try_new(LeuvenForm::Original, &blocks(), 0.9, 2.0, 0.0, none, small);
    assert_eq!(
        error.expect_err("refused").parameter,
        "twice the breakaway force"
    );
}

/// While another model fades in, what acts is of both, and tells nothing of either: it is learned from what comes after.
#[test]
fn nothing_is_learned_while_a_model_fades() {
    let mut axis = Axis::PAPER_AXIS;
    // The axis is a tick behind its reference, which takes other forces than the model's.
    axis.feed_forward.share = 0.5;
    let settings = LearningSettings {
        block: 14,
        ..LearningSettings::PAPER_AXIS
    };
    let coefficients = |breakaway: f64| {
        let model = QuasiStaticGms::<4, f64>::try_new(&blocks::<4>(), breakaway, Units::SI)?;
        let model = Learning::<_, Adaptation<f64>>::try_new(model, &settings, Units::SI)?;
        Coefficients::try_new(&axis, model, Units::SI)
    };
    let mut controller = Controller::new(coefficients(0.9).expect("valid"), 0_u32);
    controller.enable().expect("nothing speaks against it");
    let mut planner = Planner::try_new(&axis).expect("the paper's axis");
    let next = planner.by(8e-3, 5e-3, 0.5).expect("within the limits");
    controller.start(next).expect("it stands");
    let fades = (axis.fade_time / axis.sample_time()) as u32;
    let mut levels = Vec::new();
    for tick in 0..6000 + 2 * fades {
        if tick == 6000 {
            controller.swap(&coefficients(0.7).expect("valid"));
        }
        let count = (controller.reference() >> 16) as u32;
        // Late now and then, so that not all ticks are ordinary.
        let late = tick % 50 == 0;
        let command = controller.tick(Measurement {
            count,
            late,
            ..calm(0)
        });
        assert_eq!(command.fault, None);
        levels.push(controller.condition().level.expect("it adapts"));
    }
    let [before, fading, after] =
        [5999, 6000 + fades - 20, 6000 + 2 * fades - 1].map(|tick| levels[tick as usize]);
    assert!((before - 1.0).abs() > 0.01, "{before}");
    assert_eq!(fading, levels[6000]);
    assert!((after - fading).abs() > 0.01, "{after}");
}

#[test]
fn the_watch_counts_its_windows() {
    let settings = LearningSettings::PAPER_AXIS;
    let watch = MismatchWatch::<f64>::try_new(&settings, 0.9, Units::SI).expect("valid");
    let mut state = watch.start();
    for windows in 0..2 * settings.watch.commissioning {
        assert_eq!(state.windows(), windows);
        assert_eq!(state.range(), NormalRange::Learning);
        watch.window(&mut state, 0.1);
    }
    assert_eq!(state.range(), NormalRange::Inside);
    let guided = Guided::try_new(NoFriction::<f32>::new(), 20, 1.0, Units::SI).expect("valid");
    let mut state = guided.at_rest();
    assert!(!state.is_guided());
    state.order(0.5);
    assert!(state.is_guided());
    assert_eq!(guided.limit(), Some(1.0));
    // Of a sense whose readings are 30 too high.
    let mut controller = controller(&Axis::PAPER_AXIS, 0);
    for offset in [30, -30] {
        for _ in 0..5000 {
            let _ = controller.tick(carrying(offset));
        }
        assert!((controller.current_at_rest() - offset).abs() <= 1);
    }
}

#[test]
fn what_is_fed_forward_is_limited_both_ways() {
    let settings = FeedForward {
        share: 0.5,
        limit: 0.3,
        ..Axis::PAPER_AXIS.feed_forward
    };
    let friction = Coulomb::<f64>::try_new(0.8, 0.0, Units::SI).expect("valid");
    let compensator = Compensator::try_new(friction, &settings, Units::SI).expect("valid");
    let step = |velocity| {
        let motion = motion(0.0, velocity);
        compensator.step(&mut (), motion)
    };
    assert_eq!((step(1e-6), step(-1e-6)), (0.15, -0.15));
    assert_eq!(NoFriction::<f64>::new().limit(), Some(0.0));
}

/// What a refusal says would do does, but for a count in a tick.
#[test]
fn the_bound_that_a_refusal_names_is_taken() {
    type Change = fn(&mut Axis, f64);
    let changes: [(&str, f64, Change); 6] = [
        ("top speed", 1e9, |a, v| a.watch.top_speed = v),
        ("largest current", 1e9, |a, v| a.watch.current_max = v),
        ("rated current", 1e9, |a, v| a.watch.current_rated = v),
        ("highest supply voltage", 1e9, |a, v| a.watch.supply_max = v),
        ("frozen duty", 1e9, |a, v| a.watch.frozen_duty = v),
        ("overruns", 4.3e9, |a, v| a.watch.overruns = v as u32),
    ];
    let error = |axis: &Axis| {
        let friction = NoFriction::<f64>::new();
        Coefficients::try_new(axis, friction, Units::SI).err()
    };
    for (name, value, change) in changes {
        let mut axis = Axis::PAPER_AXIS;
        change(&mut axis, value);
        let refused = error(&axis).expect(name);
        let Bound::Reachable(bound) = refused.bound else {
            panic!("{refused}");
        };
        assert_eq!(refused.parameter, name);
        change(&mut axis, bound * (1.0 - 1e-4));
        assert!(
            error(&axis).is_none_or(|error| error.parameter != name),
            "{refused}"
        );
        change(&mut axis, bound * (1.0 + 1e-3) + 1.0);
        assert_eq!(
            error(&axis).map(|error| error.parameter),
            Some(name),
            "{refused}"
        );
    }
    let Err(refused) = Limiter::try_new(1e-6, 8500.0) else {
        panic!("less than a code");
    };
    let Bound::AtLeast(bound) = refused.bound else {
        panic!("{refused}");
    };
    assert_eq!(
        Limiter::try_new(bound * 1.000_001, 8500.0).map(|l| l.largest()),
        Ok(1)
    );
}

/// Twice the current at half the force per ampere and a quarter of the resistance at half the supply is the same machine; one of thrice the
/// mass and force has thrice the forces.
#[test]
fn basics_follow_the_machine_s_scale() {
    let basics = Basics {
        hardware: Hardware::edge_aligned(170_000_000, 20_000),
        count: 25e-9,
        mass: 4.05,
        force_per_ampere: 20.7,
        resistance: 3.41,
        supply: 6.0,
        current: 0.68,
        speed: 15e-3,
        travel: None,
    };
    let own = basics.axis().expect("valid");
    let wound = Basics {
        force_per_ampere: basics.force_per_ampere / 2.0,
        resistance: basics.resistance / 4.0,
        supply: basics.supply / 2.0,
        current: basics.current * 2.0,
        ..basics
    };
    let wound = wound.axis().expect("valid");
    let heavy = Basics {
        mass: basics.mass * 3.0,
        force_per_ampere: basics.force_per_ampere * 3.0,
        supply: basics.supply * 3.0,
        resistance: basics.resistance * 3.0,
        ..basics
    };
    let heavy = heavy.axis().expect("valid");
    let told = |axis: &Axis, force: f64, current: f64| {
        [
            ("K_p", axis.gains.proportional, force),
            ("K_i", axis.gains.integral, force),
            ("integral", axis.gains.integral_limit, force),
            ("fed forward", axis.feed_forward.limit, force),
            ("acceleration", axis.limits.acceleration, 1.0),
            ("error", axis.watch.following_error, 1.0),
            ("largest", axis.watch.current_max, current),
            ("offset", axis.watch.current_offset, current),
            ("duty", axis.duty_limit, 1.0),
        ]
    };
    for (axis, force, current) in [(&wound, 1.0, 2.0), (&heavy, 3.0, 1.0)] {
        let pairs = told(axis, force, current).into_iter();
        for ((what, found, times), (_, own, _)) in pairs.zip(told(&own, 1.0, 1.0)) {
            let off = (found / own / times - 1.0).abs();
            assert!(off < 1e-9, "{what}: {found}, {own}");
        }
    }
}
