//! What is promised of an outer task beside the controller: it knows the reference ahead as it will be, what comes late is thrown away, and
//! what runs below it goes on.

use crate::measured::calm;
use preslide::Units;
use preslide::control::koopman::{
    Desk, Guided, KoopmanModel, KoopmanSettings, Outer, OuterSettings,
};
use preslide::control::{Axis, Coefficients, Controller, Move, NoFriction};
use preslide_host_tests::deviation::Deviation;

const TICKS: u32 = 20;
/// Samples ahead.
const AHEAD: u32 = 16;
/// The tick behind which the first move is asked for.
const BEGIN: usize = 500;
/// In mid-motion.
const STOPPED: usize = 1000;
/// By a newton (m).
const MOVES_M: f64 = 1e-6;

type GuidedController = Controller<Guided<NoFriction<f32>>, u32>;
type Ahead = Outer<4, 1, 1, 1>;

/// A loop whose next error is what the reference moves less what the force does: the best force tells the mean displacement ahead.
fn settings() -> OuterSettings<4, 1, 1> {
    let mut force = [0.0; 4];
    force[0] = -MOVES_M;
    OuterSettings {
        ticks: TICKS,
        yields: [1e-6],
        compensated: false,
        gain: 0.0,
        model: KoopmanModel {
            map: [[0.0; 4]; 4],
            force,
            reference: [1.0, 0.0, 0.0, 0.0],
        },
        cost: KoopmanSettings {
            lengths: [AHEAD],
            effort: 1e-24,
            change: 0.0,
            force: 100.0,
            slew: 100.0,
            travel: 0.0,
            iterations: 20,
        },
    }
}

fn controller(axis: &Axis) -> GuidedController {
    let none = NoFriction::new();
    let guided = Guided::try_new(none, TICKS, 100.0, Units::SI).expect("valid");
    let coefficients = Coefficients::try_new(axis, guided, Units::SI).expect("valid");
    let mut controller = Controller::new(coefficients, 0);
    controller.enable().expect("no fault");
    controller
}

/// A tick of an axis that is where the reference was.
fn tick(controller: &mut GuidedController) {
    let count = (controller.reference() >> 16) as u32;
    tick_at(controller, count);
}

/// A tick of an axis at the count.
fn tick_at(controller: &mut GuidedController, count: u32) {
    let command = controller.tick(calm(count));
    assert_eq!(command.fault, None);
}

/// Through corners, smoothing, reversals, rests, the change from one move to the next, and behind a stop on the way.
#[test]
fn the_reference_is_known_ahead_as_it_will_be() {
    let axis = Axis::PAPER_AXIS;
    let mut controller = controller(&axis);
    let mut desk = Desk::new(&controller);
    let mut outer = Ahead::try_new(&settings(), &axis, &desk).expect("valid");
    let go = |m, speed| Move::plan(m, speed, 0.5, axis.grid()).expect("planned");
    let mut moves = vec![
        go(300e-6, 5e-3),
        go(-200e-6, 2e-3),
        Move::dwell(0.03, axis.sample_time()).expect("planned"),
        go(50e-6, 1e-3),
        go(-150e-6, 8e-3),
    ]
    .into_iter();
    let (mut places, mut foreseen) = (Vec::new(), Vec::new());
    for now in 0..12_000 {
        if now > BEGIN
            && controller.is_idle()
            && let Some(next) = moves.next()
        {
            controller.start(next).expect("within the limits");
        }
        if now == STOPPED {
            controller.stop();
        }
        tick(&mut controller);
        places.push(controller.reference() as f64 / 65_536.0 * axis.encoder.count);
        let next = moves.as_slice().first().filter(|_| now >= BEGIN);
        if desk.attend(&mut controller, || next.copied()) {
            assert!(outer.take(&mut desk));
            foreseen.push((now, f64::from(outer.solve()) * MOVES_M));
            desk.order(outer.sample(), 0.0);
        }
    }
    assert!(moves.len() == 0 && controller.is_standing());
    assert!(foreseen.len() > 590);
    let mut apart = Deviation::default();
    for (now, displacement) in foreseen {
        let then_ticks = (AHEAD * TICKS) as usize;
        let Some(then) = places.get(now + then_ticks) else {
            continue;
        };
        // Nobody knows when the first one will be asked for, nor the stop.
        if [BEGIN, STOPPED].map(|then| (then.saturating_sub(then_ticks)..=then).contains(&now))
            != [false; 2]
        {
            continue;
        }
        apart.add(displacement, (then - places[now]) / f64::from(AHEAD));
    }
    // Single precision of 7 µm a sample, and 2⁻¹⁶ of a count.
    apart.assert_within("the reference ahead", 1e-11, 3e-12, 1e-12);
}

/// An order that comes when its sample is over is discarded; after two late runs in a row the outer task gives way for a sample.
#[test]
fn discards_late_orders_and_yields() {
    let axis = Axis::PAPER_AXIS;
    let mut controller = controller(&axis);
    let mut desk = Desk::new(&controller);
    let mut sample = |orders: &[(u32, f32)]| {
        let starts = loop {
            tick(&mut controller);
            let starts = desk.attend(&mut controller, || None);
            if controller.friction_state().is_due() {
                break starts;
            }
        };
        // As soon as it has begun: to the sample so many before.
        for (before, force) in orders {
            desk.order(desk.sample() - before, *force);
        }
        let state = controller.friction_state();
        (starts, state.force(), state.missed())
    };
    assert_eq!(sample(&[(0, 0.25)]), (true, 0.0, 0));
    assert_eq!(sample(&[(0, 0.5)]), (true, 0.25, 0));
    // Not answered yet.
    assert_eq!(sample(&[]), (true, 0.5, 0));
    let (starts, force, missed) = sample(&[(1, 0.75)]);
    assert!(starts && missed == 1 && force < 0.5, "{force}");
    // Nor is that one: twice in a row.
    let (starts, fades, missed) = sample(&[(1, 0.75)]);
    assert!(
        !starts && missed == 2 && fades < 0.5 * force,
        "{fades} N after {force} N"
    );
    // The next one is started again, and answers.
    let (starts, _, missed) = sample(&[(0, -0.25)]);
    assert!(starts && missed == 3);
    assert_eq!(sample(&[(0, 0.0)]), (true, -0.25, 3));
}

/// The best force against an axis that stands ahead of its reference, with an error that stays: over n samples `Σk/Σk²` of it. Where that would
/// end beyond the travel it is less.
#[test]
fn an_error_is_worked_off_and_an_end_of_travel_presses() {
    const AHEAD_COUNTS: i64 = 40;
    let mut settings = settings();
    settings.model.map[0][0] = 1.0;
    settings.cost.travel = 50.0;
    let force = |place: Option<f64>, ahead: i64| {
        let axis = Axis::PAPER_AXIS;
        let mut controller = controller(&axis);
        if let Some(place) = place {
            let counts = (place / axis.encoder.count).round() as i64;
            controller.set_position(0, counts);
        }
        let mut desk = Desk::new(&controller);
        let mut outer = Ahead::try_new(&settings, &axis, &desk).expect("valid");
        let mut force = 0.0;
        for _ in 0..20 * TICKS {
            tick_at(&mut controller, ahead as u32);
            if desk.attend(&mut controller, || None) && outer.take(&mut desk) {
                force = f64::from(outer.solve());
                desk.order(outer.sample(), 0.0);
            }
        }
        force
    };
    let error = AHEAD_COUNTS as f64 * 25e-9;
    let sums = (1..=i32::from(AHEAD as u16))
        .map(f64::from)
        .fold([0.0, 0.0], |[one, two], k| [one + k, two + k * k]);
    let wanted = -error / MOVES_M * sums[0] / sums[1];
    for sign in [1, -1] {
        let ahead = sign * AHEAD_COUNTS;
        let free = force(None, ahead) * sign as f64;
        assert!((free / wanted - 1.0).abs() < 0.01, "{free} N, not {wanted}");
        let end = 12.5e-3 * sign as f64;
        let inside = force(Some(0.9 * end), ahead) * sign as f64;
        assert!((inside / free - 1.0).abs() < 0.01, "{inside} N, not {free}");
        // An eighth of the error before an end: that force overshoots by nearly half of the error within the plan, beyond the other end.
        let near = |end: f64| force(Some(end - end.signum() * error / 8.0), ahead) * sign as f64;
        let (own, other) = (near(end), near(-end));
        assert!((own / free - 1.0).abs() < 0.01, "{own} N, not {free}");
        assert!(other / free < 0.95, "{other} N, {free} without an end");
    }
}
