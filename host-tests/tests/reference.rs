//! The reference reaches what is planned, and exceeds no limit whatever is requested, and whenever.

use crate::measured::calm;
use preslide::control::{
    Axis, Coefficients, Controller, MOST_SMOOTHED, Move, NoFriction, Pace, Planner, Reference,
    Refused,
};
use preslide::{ParamError, Units};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// 2⁻³² of a count.
const ONE: f64 = 4_294_967_296.0;

fn pace(axis: &Axis) -> Pace {
    let friction = NoFriction::<f32>::new();
    let coefficients = Coefficients::try_new(axis, friction, Units::SI).expect("a valid axis");
    *Controller::new(coefficients, 0_u32).pace()
}

/// The largest of what was seen, each as a share of its limit.
#[derive(Debug, Default)]
struct Extremes {
    beyond_m: f64,
    speed: f64,
    acceleration: f64,
    jerk: f64,
}

/// Differentiates the reference's position as it comes out, in SI.
struct Judge<'a> {
    axis: &'a Axis,
    position: i64,
    speed: i64,
    acceleration: i64,
    seen: Extremes,
}

impl Judge<'_> {
    fn take(&mut self, position: i64) {
        let grid = self.axis.grid();
        let (count, t) = (grid.count / ONE, grid.sample_time);
        let speed = position.wrapping_sub(self.position);
        let acceleration = speed - self.speed;
        let jerk = acceleration - self.acceleration;
        let limits = &self.axis.limits;
        let share = |value: i64, per: f64, limit: f64| (value as f64).abs() * count / per / limit;
        let seen = &mut self.seen;
        seen.speed = seen.speed.max(share(speed, t, limits.speed));
        seen.acceleration = seen
            .acceleration
            .max(share(acceleration, t * t, limits.acceleration));
        seen.jerk = seen.jerk.max(share(jerk, t * t * t, limits.jerk));
        if let Some((low, high)) = limits.travel {
            let at = position as f64 * count;
            seen.beyond_m = seen.beyond_m.max(at - high).max(low - at);
        }
        (self.position, self.speed, self.acceleration) = (position, speed, acceleration);
    }

    /// What rounding to 2⁻³² counts may add: the position's last bit, differentiated.
    fn judge(&self) {
        let grid = self.axis.grid();
        let limits = &self.axis.limits;
        let bit = |order: i32, limit: f64| {
            1.0 + f64::from(1 << order) * 2.0 * grid.count
                / ONE
                / grid.sample_time.powi(order)
                / limit
        };
        let seen = &self.seen;
        assert!(seen.beyond_m <= 0.0, "{seen:?}");
        assert!(seen.speed <= bit(1, limits.speed), "{seen:?}");
        assert!(seen.acceleration <= bit(2, limits.acceleration), "{seen:?}");
        assert!(seen.jerk <= bit(3, limits.jerk), "{seen:?}");
    }
}

/// An axis whose plans are changed at random, under a judge's eyes.
struct Restless<'a> {
    rng: ChaCha8Rng,
    axis: &'a Axis,
    pace: Pace,
    planner: Planner,
    reference: Reference,
    judge: Judge<'a>,
}

/// What became of an order: refused by the reference, or already when it was planned.
type Answer = Result<Result<(), Refused>, ParamError>;

impl<'a> Restless<'a> {
    fn new(axis: &'a Axis, seed: u64) -> Self {
        let pace = pace(axis);
        let mut reference = Reference::at(0, &pace);
        reference.locate(true);
        Self {
            rng: ChaCha8Rng::seed_from_u64(seed),
            axis,
            pace,
            planner: Planner::try_new(axis).expect("a valid axis"),
            reference,
            judge: Judge {
                axis,
                position: 0,
                speed: 0,
                acceleration: 0,
                seen: Extremes::default(),
            },
        }
    }

    /// Of eight orders four are moves; one each a jog, a stop, a dwell and a stream.
    fn order(&mut self) -> Answer {
        match self.rng.next_u32() % 8 {
            0..4 => self.move_by_some(),
            4 => {
                let limit = self.axis.limits.speed;
                let jog = self.planner.jog(limit * self.rng.random_range(-1.0..1.0));
                jog.map(|jog| {
                    self.reference.jog(jog, &self.pace);
                    Ok(())
                })
            }
            5 => {
                self.reference.stop();
                Ok(Ok(()))
            }
            6 => Move::dwell(
                self.rng.random_range(1e-4..5e-3),
                self.axis.grid().sample_time,
            )
            .map(|next| self.reference.start(next, &self.pace)),
            _ => self.stream(),
        }
    }

    fn move_by_some(&mut self) -> Answer {
        let part = |rng: &mut ChaCha8Rng| 10_f64.powf(rng.random_range(-3.0..0.0));
        let limits = &self.axis.limits;
        let distance = self.rng.random_range(-1.0..1.0_f64).powi(3) * 3e-3;
        let speed = limits.speed * part(&mut self.rng);
        let ramp = limits.acceleration * part(&mut self.rng);
        Move::plan(distance, speed, ramp, self.axis.grid())
            .map(|next| self.reference.start(next, &self.pace))
    }

    /// Three points that may join what went before, or not, and run dry.
    fn stream(&mut self) -> Answer {
        let count = (self.judge.position >> 32) + self.rng.random_range(-1..2);
        self.planner.stands(count, true);
        let at = self.planner.end();
        let points = (1..4)
            .map(|i| self.planner.point(at + f64::from(i * i) * 1e-7, 40))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(points.into_iter().try_for_each(|point| {
            while !self.reference.is_idle() {
                self.tick();
            }
            self.reference.start(point, &self.pace)
        }))
    }

    /// Mostly too short for the order to be carried out.
    fn wait(&mut self) {
        let long = if self.rng.next_u32().is_multiple_of(10) {
            600
        } else {
            60
        };
        for _ in 0..self.rng.next_u32() % long {
            self.tick();
        }
    }

    fn tick(&mut self) {
        self.judge.take(self.reference.step(&self.pace).position);
    }
}

/// Moves, jogs, stops, streams and dwells at random times, most of them before what went before has ended.
fn replan(axis: &Axis, replans: u32, seed: u64) -> Extremes {
    let mut restless = Restless::new(axis, seed);
    let (mut started, mut refused) = (0, 0);
    for _ in 0..replans {
        match restless.order() {
            Ok(Ok(())) => started += 1,
            Ok(Err(_)) | Err(_) => refused += 1,
        }
        restless.wait();
    }
    let judge = restless.judge;
    println!(
        "seed {seed}: {started} started, {refused} refused; largest speed, acceleration, jerk of their limits {:.6} {:.6} {:.6}, \
         {:.2} nm from the end of travel",
        judge.seen.speed,
        judge.seen.acceleration,
        judge.seen.jerk,
        -judge.seen.beyond_m * 1e9
    );
    judge.judge();
    assert!(started > replans / 2, "it must have moved: {started}");
    judge.seen
}

#[test]
fn random_replans_exceed_no_limit() {
    replans_exceed_no_limit(30_000);
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn a_million_random_replans_exceed_no_limit() {
    replans_exceed_no_limit(1_000_000);
}

/// On two axes nothing exceeds position, speed, acceleration or jerk.
fn replans_exceed_no_limit(replans: u32) {
    let paper = Axis::PAPER_AXIS;
    let mut seen = replan(&paper, replans / 5 * 3, 1);
    // A coarse, fast axis with the longest smoothing, in a short travel.
    let mut coarse = paper;
    coarse.encoder.count = 1e-6;
    coarse.limits = preslide::control::Limits {
        speed: 0.5,
        acceleration: 20.0,
        jerk: 2.0 * 20.0 / (f64::from(MOST_SMOOTHED) * 50e-6),
        travel: Some((-2e-3, 5e-3)),
    };
    coarse.watch.top_speed = 0.6;
    let other = replan(&coarse, replans / 5 * 2, 2);
    // The limits are met, not avoided.
    for seen in [&mut seen.acceleration, &mut seen.jerk] {
        assert!(*seen > 0.9, "{seen}");
    }
    assert!(other.speed > 0.3 && other.acceleration > 0.9, "{other:?}");
}

#[test]
fn moves_end_where_they_should_to_the_last_bit() {
    let axis = Axis::PAPER_AXIS;
    let pace = pace(&axis);
    for (distance, speed, acceleration) in [
        (100e-9, 20e-6, 0.04),
        (-37e-9, 5e-9, 1e-6),
        (1e-3, 1e-3, 0.05),
        (-0.3e-6, 1e-2, 1.0),
        (2.5e-9, 1e-6, 1e-4),
        (12e-3, 15e-3, 1.0),
        (25e-9, 1e-3, 1e-7),
    ] {
        let mut reference = Reference::at(-7, &pace);
        let start = reference.step(&pace).position;
        let planned = Move::plan(distance, speed, acceleration, axis.grid()).expect("a valid move");
        assert_eq!(reference.start(planned, &pace), Ok(()), "{distance}");
        let (mut last, mut ticks) = (start, 0);
        while !reference.is_standing() {
            let now = reference.step(&pace).position;
            assert!(
                (now - last) as f64 * distance.signum() >= 0.0,
                "it must not turn back"
            );
            (last, ticks) = (now, ticks + 1);
        }
        assert!(ticks <= planned.ticks() + pace.smoothing(), "{ticks}");
        let wanted = (distance / axis.encoder.count * ONE).round() as i64;
        assert_eq!(last - start, wanted, "{distance}");
    }
}

#[test]
fn a_stop_takes_no_longer_than_braking_and_smoothing() {
    let axis = Axis::PAPER_AXIS;
    let pace = pace(&axis);
    let mut reference = Reference::at(0, &pace);
    let fast = Move::plan(10e-3, 15e-3, 1.0, axis.grid()).expect("a valid move");
    assert_eq!(reference.start(fast, &pace), Ok(()));
    for _ in 0..2000 {
        reference.step(&pace);
    }
    reference.stop();
    let begin = reference.step(&pace).position;
    let (mut ticks, mut end) = (1, begin);
    while !reference.is_standing() {
        end = reference.step(&pace).position;
        ticks += 1;
    }
    // v/a = 15 ms are 300 ticks; v²/(2·a) = 112.5 µm are 4500 counts, and half of the smoothing's 64 ticks at 30 counts.
    assert!(ticks <= 300 + 64 + 2, "{ticks}");
    let travelled = (end - begin) as f64 / ONE;
    assert!((5300.0..5520.0).contains(&travelled), "{travelled}");
}

#[test]
fn moves_are_checked_when_they_are_planned_and_when_they_start() {
    let axis = Axis::PAPER_AXIS;
    let mut planner = Planner::try_new(&axis).expect("a valid axis");
    planner.stands(0, true);
    let named = |result: Result<Move, preslide::ParamError>| result.expect_err("refused").parameter;
    assert_eq!(named(planner.by(1e-3, 16e-3, 0.5)), "speed of a move");
    assert_eq!(named(planner.by(1e-3, 1e-3, 1.5)), "acceleration of a move");
    assert_eq!(named(planner.to(-13e-3, 1e-3, 0.5)), "end of a move");
    assert_eq!(named(planner.by(f64::NAN, 1e-3, 0.5)), "end of a move");
    assert_eq!(named(planner.point(13e-3, 20)), "point of a stream");
    assert_eq!(named(planner.point(1e-3, 20)), "speed of a stream");
    assert_eq!(
        named(planner.point(1.5e-6 / 2.0, 10)),
        "acceleration of a stream"
    );
    assert!(planner.jog(f64::NAN).is_err() && planner.jog(-16e-3).is_err());
    // What another planned, for another axis, is refused at the start.
    let pace = pace(&axis);
    let mut reference = Reference::at(0, &pace);
    reference.locate(true);
    let plan = |distance, speed, acceleration| {
        Move::plan(distance, speed, acceleration, axis.grid()).expect("a move")
    };
    let refused = [
        (plan(1e-3, 16e-3, 0.5), Refused::TooFast),
        (plan(1e-3, 1e-3, 1.5), Refused::TooSteep),
        (plan(13e-3, 1e-3, 0.5), Refused::BeyondTravel),
    ];
    for (next, reason) in refused {
        assert_eq!(reference.start(next, &pace), Err(reason));
    }
}

/// A sine sent as points every millisecond: followed, within the limits, and at rest in the end.
#[test]
fn a_stream_of_points_is_followed_smoothly() {
    let axis = Axis::PAPER_AXIS;
    let pace = pace(&axis);
    let mut planner = Planner::try_new(&axis).expect("a valid axis");
    planner.stands(0, true);
    let mut reference = Reference::at(0, &pace);
    let mut judge = Judge {
        axis: &axis,
        position: 0,
        speed: 0,
        acceleration: 0,
        seen: Extremes::default(),
    };
    let at = |i: i32| {
        let phase = std::f64::consts::TAU * f64::from(i) / 500.0;
        2e-4 * (1.0 - phase.cos())
    };
    let mut worst: f64 = 0.0;
    for i in (0..=1000).chain([1000, 1000]) {
        let point = planner.point(at(i), 20).expect("within the limits");
        assert_eq!(reference.start(point, &pace), Ok(()));
        while !reference.is_idle() {
            judge.take(reference.step(&pace).position);
        }
        // Half a point and half of the smoothing behind, half a tick ahead since speed is held through a tick.
        let lag = 10.0 - 0.5 + 31.5;
        let wanted =
            2e-4 * (1.0 - (std::f64::consts::TAU * (f64::from(i) - lag / 20.0) / 500.0).cos());
        if (10..1000).contains(&i) {
            worst = worst.max((wanted - judge.position as f64 / ONE * axis.encoder.count).abs());
        }
    }
    while !reference.is_standing() {
        judge.take(reference.step(&pace).position);
    }
    judge.judge();
    println!("stream: {:.1} nm off the sine at most", worst * 1e9);
    assert!(worst < 100e-9, "{worst}");
    let end = judge.position as f64 / ONE * axis.encoder.count;
    assert!((end - at(1000)).abs() < 1e-12, "{end}");
}

#[test]
fn a_silent_host_stops_the_axis_and_a_heard_one_does_not() {
    let axis = Axis::PAPER_AXIS;
    let run = |every: u64| {
        let friction = NoFriction::<f32>::new();
        let coefficients = Coefficients::try_new(&axis, friction, Units::SI).expect("valid");
        let mut controller = Controller::new(coefficients, 0_u32);
        assert_eq!(controller.enable(), Ok(()));
        let planner = Planner::try_new(&axis).expect("valid");
        let jog = planner.jog(1e-3).expect("within the limits");
        assert_eq!(controller.jog(jog), Ok(()));
        let mut count = 0;
        let mut ticks = 0_u64;
        while !controller.is_standing() && ticks < 200_000 {
            let command = controller.tick(calm(count));
            assert_eq!(command.fault, None);
            count = (command.reference >> 16) as u32;
            ticks += 1;
            if ticks.is_multiple_of(every) {
                controller.heard();
            }
        }
        (ticks, controller.jog(jog))
    };
    // 2 s are 40000 ticks; braking from 1 mm/s takes 20, the smoothing 64.
    let (ticks, answer) = run(u64::MAX);
    assert!((40_000..40_100).contains(&ticks), "{ticks}");
    assert_eq!(answer, Err(Refused::Silence));
    assert_eq!(run(30_000), (200_000, Ok(())));
}

#[test]
fn zeroing_in_motion_renames_the_place_and_bumps_nothing() {
    let axis = Axis::PAPER_AXIS;
    let run = |zero: bool| {
        let friction = NoFriction::<f32>::new();
        let coefficients = Coefficients::try_new(&axis, friction, Units::SI).expect("valid");
        let mut controller = Controller::new(coefficients, 500_u32);
        assert_eq!(controller.enable(), Ok(()));
        let next = Move::plan(1e-3, 1e-3, 0.1, axis.grid()).expect("a move");
        assert_eq!(controller.start(next), Ok(()));
        let mut count = 500;
        let mut codes = Vec::new();
        let mut by = 0;
        for tick in 0..5000 {
            if zero && tick == 1000 {
                // The index pulse was 300 counts ago.
                let index = controller.position_at(count - 300);
                controller.set_position(index, 0);
                by = -index;
            }
            let command = controller.tick(calm(count));
            codes.push((
                command.code,
                command.position - by,
                command.reference - (by << 16),
            ));
            count = 500 + ((command.reference >> 16) - by - 2).max(0) as u32;
        }
        assert_eq!(controller.is_located(), zero);
        codes
    };
    assert_eq!(run(true), run(false));
}
