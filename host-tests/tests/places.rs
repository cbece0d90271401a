//! Where an axis is, where its travel ends, and where its motion does.

use crate::measured::calm;
use preslide::control::{
    Axis, Coefficients, Controller, Measurement, NoFriction, Planner, Reference, VelocitySource,
};
use preslide::{Bound, Friction, Motion, Units};

/// Of an axis without friction fed forward.
pub fn controller(axis: &Axis, first: u32) -> Controller<NoFriction<f32>, u32> {
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
        let _ = controller.tick(Measurement { count, ..calm(0) });
        controller.set_position(controller.position(), 500);
        // Before and behind the counter's wrap, and where it is.
        for back in [0, 12, 25] {
            let place = controller.position_at(count.wrapping_sub(back));
            assert_eq!(place, 500 - sign * i64::from(back));
        }
    }
}

/// A jog goes to the end of travel, not beyond, and not much less far: the two counts that rounding is given, a tick, and half a tick's way.
#[test]
fn a_jog_uses_the_whole_travel() {
    let axis = Axis::PAPER_AXIS;
    let (low, high) = axis.limits.travel.expect("it has ends");
    let pace = *controller(&axis, 0).pace();
    let planner = Planner::try_new(&axis).expect("the paper's axis");
    let mut reference = Reference::at(0, &pace);
    reference.locate(true);
    let mut position = 0;
    for (speed, end) in [(15e-3, high), (-15e-3, low), (4e-3, high), (-0.3e-3, low)] {
        reference.jog(planner.jog(speed).expect("within the limits"), &pace);
        for _ in 0..2_000_000 {
            position = reference.step(&pace).position;
            if reference.is_standing() {
                break;
            }
        }
        let at = position as f64 / 4_294_967_296.0 * axis.encoder.count;
        let short = (end - at) * speed.signum();
        assert!(
            (0.0..6.0 * axis.encoder.count + 1.5 * speed.abs() * 50e-6).contains(&short),
            "{short} m short of {end} at {speed} m/s"
        );
    }
}

/// A friction model that gets its position and keeps it.
#[derive(Clone, Debug, PartialEq)]
struct Placed;

impl Friction for Placed {
    type Scalar = f64;
    type State = Option<f64>;

    fn at_rest(&self) -> Option<f64> {
        None
    }

    fn set_position(&self, place: &mut Option<f64>, position: f64) {
        *place = Some(position);
    }

    fn step(&self, _: &mut Option<f64>, _: Motion<f64>) -> f64 {
        0.0
    }

    fn limit(&self) -> Option<f64> {
        Some(0.0)
    }
}

/// What acts by place is told where in its turn an endless axis is, however far it turned; and the position of any other.
#[test]
fn an_endless_axis_is_placed_within_its_turn() {
    for turn in [0, 1000_u32] {
        let mut axis = Axis::PAPER_AXIS;
        axis.encoder.turn = turn;
        axis.limits.travel = None;
        axis.feed_forward.drive = VelocitySource::Measured;
        // It is pushed back by its controller.
        axis.watch.following_error = 4e-4;
        axis.watch.frozen_time = 10.0;
        let coefficients = Coefficients::try_new(&axis, Placed, Units::SI).expect("valid");
        let mut controller = Controller::new(coefficients, 0_u32);
        controller.enable().expect("nothing speaks against it");
        let _ = controller.tick(calm(0));
        assert_eq!(
            *controller.friction_state(),
            None,
            "it does not know its place"
        );
        controller.set_position(0, 250);
        for step in (1..=300).chain((-400..300).rev()) {
            let count = (step * 15_i32) as u32;
            let command = controller.tick(Measurement { count, ..calm(0) });
            assert_eq!(command.fault, None);
            let position = 250 + 15 * step;
            let place = match turn {
                0 => position,
                turn => position.rem_euclid(turn as i32),
            };
            let told = controller.friction_state().expect("a place") / axis.encoder.count;
            assert!(
                (told - f64::from(place)).abs() < 1e-6,
                "{told}, not {place}"
            );
        }
    }
    let mut axis = Axis::PAPER_AXIS;
    axis.encoder.turn = 1;
    let error = Coefficients::try_new(&axis, Placed, Units::SI).expect_err("refused");
    assert_eq!(
        (error.parameter, error.bound),
        ("counts of a turn", Bound::AtLeast(2.0))
    );
}

/// The ends of travel are places: who does not know where it is has none.
#[test]
fn an_axis_that_is_not_located_has_no_ends() {
    let mut planner = Planner::try_new(&Axis::PAPER_AXIS).expect("the paper's axis");
    for located in [false, true] {
        planner.stands(0, located);
        assert_eq!(planner.clone().by(20e-3, 5e-3, 0.5).is_err(), located);
    }
}

/// A stream comes to rest at its last point, and may begin again there with another time between its points; on its way it may not.
#[test]
fn a_stream_ends_at_its_last_point() {
    let axis = Axis::PAPER_AXIS;
    let pace = *controller(&axis, 0).pace();
    let mut planner = Planner::try_new(&axis).expect("the paper's axis");
    planner.stands(0, true);
    let mut reference = Reference::at(0, &pace);
    for (ticks, from, last) in [(160, 0.0, 3e-4), (333, 3e-4, -1e-4)] {
        let shares = [0.02, 0.08, 0.2, 0.35, 0.5, 0.65, 0.85, 0.97, 1.0, 1.0];
        for (n, share) in shares.into_iter().enumerate() {
            let at = from + share * (last - from);
            if n > 0 {
                let error = planner.point(at, ticks + 1).expect_err("another time");
                assert_eq!(error.parameter, "ticks of a point in a stream");
            }
            let point = planner.point(at, ticks).expect("within the limits");
            // Half way from the point before it.
            let before = if n > 0 { shares[n - 1] } else { 0.0 };
            let half = from + 0.5 * (before + share) * (last - from);
            assert!((planner.end() - half).abs() < 0.01 * (share - before).abs().max(0.03) * 3e-4);
            assert_eq!(reference.start(point, &pace), Ok(()));
            while !reference.is_idle() {
                let _ = reference.step(&pace);
            }
        }
        let mut position = 0;
        while !reference.is_standing() {
            position = reference.step(&pace).position;
        }
        let end = position as f64 / 4_294_967_296.0 * axis.encoder.count;
        assert!(
            (end - last).abs() < 1e-11 && (planner.end() - last).abs() < 1e-11,
            "{end}"
        );
    }
}
