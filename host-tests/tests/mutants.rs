//! What no other test missed when `cargo mutants` changed it.

use preslide::Units;
use preslide::control::{
    Axis, Coefficients, Controller, Measurement, Motor, Move, NoFriction, Planner,
};

const RESTS: Measurement<u32> = Measurement {
    count: 0,
    supply: 6000,
    current: 0,
    late: false,
};

fn controller(axis: &Axis, first: u32) -> Controller<NoFriction<f32>, u32> {
    let friction = NoFriction::<f32>::new();
    let coefficients = Coefficients::try_new(axis, friction, Units::SI).expect("the paper's axis");
    Controller::new(coefficients, first)
}

#[test]
fn a_latched_reading_is_a_place_on_the_axis() {
    for (reversed, sign) in [(false, 1), (true, -1)] {
        let mut axis = Axis::PAPER_AXIS;
        axis.encoder.reversed = reversed;
        let first = u32::MAX - 10;
        let mut controller = controller(&axis, first);
        let count = first.wrapping_add(30);
        let _ = controller.tick(Measurement { count, ..RESTS });
        controller.set_position(controller.position(), 500);
        // Before and behind the counter's wrap, and where it is.
        for back in [0, 12, 25] {
            let place = controller.position_at(count.wrapping_sub(back));
            assert_eq!(place, 500 - sign * i64::from(back));
        }
    }
}

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
            ..RESTS
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
