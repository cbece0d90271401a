//! An axis from its basics: what follows holds on any mass, and is near what the paper's axis was given by hand.

use preslide::Units;
use preslide::control::{
    Axis, Basics, Coefficients, Controller, Hardware, Measurement, Move, NoFriction, Planner,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const PAPER: Basics = Basics {
    hardware: Hardware::edge_aligned(170_000_000, 20_000),
    count: 25e-9,
    mass: 4.05,
    // 6.59 mN·m/A at 2 mm a turn.
    force_per_ampere: 20.703_096,
    resistance: 3.41,
    supply: 6.0,
    current: 0.68,
    speed: 15e-3,
    travel: Some((-12.5e-3, 12.5e-3)),
};

#[test]
fn the_papers_axis_comes_out_within_a_factor_of_what_it_was_given() {
    let (made, own) = (PAPER.axis().expect("basics"), Axis::PAPER_AXIS);
    let ratio = |what: &str, made: f64, own: f64, most: f64| {
        let ratio = made / own;
        assert!(
            ratio <= most && ratio >= 1.0 / most,
            "{what}: {made:e}, not {own:e}"
        );
    };
    ratio(
        "force per volt",
        made.motor.force_per_volt(),
        own.motor.force_per_volt(),
        1.000_001,
    );
    ratio("K_p", made.gains.proportional, own.gains.proportional, 1.01);
    ratio("K_i", made.gains.integral, own.gains.integral, 1.1);
    ratio("K_d", made.gains.derivative, own.gains.derivative, 1.3);
    ratio("duty", made.duty_limit, own.duty_limit, 1.02);
    ratio(
        "acceleration",
        made.limits.acceleration,
        own.limits.acceleration,
        1.8,
    );
    // In proportion to the acceleration: the smoothing is as long.
    ratio(
        "smoothing",
        made.limits.acceleration / made.limits.jerk,
        own.limits.acceleration / own.limits.jerk,
        1.01,
    );
    ratio(
        "following error",
        made.watch.following_error,
        own.watch.following_error,
        1.1,
    );
    ratio(
        "current",
        made.watch.current_max,
        own.watch.current_max,
        1.03,
    );
    ratio(
        "frozen duty",
        made.watch.frozen_duty,
        own.watch.frozen_duty,
        2.4,
    );
    for (made, own) in [
        (made.encoder.window, own.encoder.window),
        (made.watch.top_speed, own.watch.top_speed),
        (made.watch.supply_min, own.watch.supply_min),
        (made.watch.supply_max, own.watch.supply_max),
        (made.watch.frozen_time, own.watch.frozen_time),
        (made.watch.supply_time, own.watch.supply_time),
        (made.gains.deadband, own.gains.deadband),
        (made.fade_time, own.fade_time),
    ] {
        assert!((made / own - 1.0).abs() < 1e-9, "{made:e}, not {own:e}");
    }
}

/// Moves a mass behind a motor without friction; the largest following error on the way and what is left behind it (counts).
fn moved(basics: &Basics, axis: &Axis) -> (f64, f64) {
    let coefficients = Coefficients::try_new(axis, NoFriction::<f32>::new(), Units::SI);
    let mut controller = Controller::new(coefficients.expect("an axis"), 0_u32);
    let mut planner = Planner::try_new(axis).expect("an axis");
    let tick = axis.sample_time();
    let (mut place, mut speed, mut code, mut largest) = (0.0, 0.0, 0, 0.0_f64);
    let mut step = |controller: &mut Controller<_, u32>| {
        for _ in 0..10 {
            let volts = f64::from(code) / f64::from(axis.hardware.steps) * basics.supply;
            let current = (volts - basics.force_per_ampere * speed) / basics.resistance;
            speed += 0.1 * tick * basics.force_per_ampere * current / basics.mass;
            place += 0.1 * tick * speed;
        }
        controller.heard();
        let command = controller.tick(Measurement {
            count: (place / basics.count).floor() as i32 as u32,
            supply: (basics.supply / axis.hardware.supply_code) as u16,
            current: 0,
            late: false,
        });
        assert_eq!(command.fault, None, "{basics:?}");
        code = command.code;
        let error = command.reference as f64 / 65536.0 - place / basics.count;
        largest = largest.max(error.abs());
        (largest, error.abs())
    };
    controller.enable().expect("nothing speaks against it");
    // Short moves round their acceleration up.
    let (fast, steep) = (axis.limits.speed, 0.8 * axis.limits.acceleration);
    let ramp = fast / steep;
    let far = fast * (2.0 * ramp + 1000.0 * tick);
    let there: Move = planner.by(far, fast, steep).expect("within the limits");
    controller.start(there).expect("it stands");
    let mut last = (0.0, 0.0);
    for _ in 0..(2.0 * ramp / tick) as usize + 16_000 {
        last = step(&mut controller);
    }
    last
}

#[test]
fn what_follows_from_any_basics_is_stable() {
    let mut rng = ChaCha8Rng::seed_from_u64(20_261_129);
    let mut any = |low: f64, high: f64| low * (high / low).powf(rng.random_range(0.0..1.0));
    let mut tried = 0;
    while tried < 200 {
        let rate = [1000, 5000, 20_000, 40_000][any(1.0, 4.999) as usize - 1];
        let mut basics = Basics {
            hardware: Hardware::edge_aligned(20_000_000, rate),
            count: 1.0,
            mass: any(0.01, 100.0),
            force_per_ampere: any(0.1, 100.0),
            resistance: any(0.3, 20.0),
            supply: any(5.0, 48.0),
            current: any(0.2, 1.9),
            speed: 1.0,
            travel: None,
        };
        let axis = basics.axis().expect("basics");
        // A fifth of what the motor reaches, and an encoder that shows a thousandth of the error that is a fault.
        basics.speed = 0.2 * axis.duty_limit * basics.supply / basics.force_per_ampere;
        basics.count = any(3e-4, 3e-3) * axis.watch.following_error;
        let per_tick = basics.speed / f64::from(rate) / basics.count;
        if !(0.01..2000.0).contains(&per_tick) {
            continue;
        }
        tried += 1;
        let axis = basics.axis().expect("basics");
        let (largest, left) = moved(&basics, &axis);
        let fault = axis.watch.following_error / basics.count;
        assert!(
            largest < 0.6 * fault,
            "{largest} of {fault} counts: {basics:?}"
        );
        assert!(left < 2.0, "{left} counts are left: {basics:?}");
    }
}

#[test]
fn every_value_that_is_wrong_is_told_by_its_name() {
    let wrong = Basics {
        hardware: Hardware {
            steps: 0,
            ..PAPER.hardware
        },
        count: 0.0,
        mass: -1.0,
        force_per_ampere: f64::NAN,
        resistance: 0.0,
        supply: f64::INFINITY,
        current: 0.0,
        speed: -0.0,
        travel: Some((1.0, 1.0)),
    };
    let error = wrong.axis().expect_err("nothing of it is right");
    assert_eq!(error.errors().count(), 9);
    assert_eq!(error.to_string().lines().count(), 9);
    for name in [
        "PWM steps",
        "count",
        "mass",
        "ampere",
        "resistance",
        "supply",
        "rated current",
        "speed",
        "travel",
    ] {
        assert!(error.to_string().contains(name), "{name}: {error}");
    }
    assert!(PAPER.axis().is_ok());
}
