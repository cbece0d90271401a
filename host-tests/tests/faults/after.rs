//! What a fault leaves behind: where the axis is, and how warm the winding.

use crate::measured::{calm, carrying, delayed, supplied};
use preslide::Units;
use preslide::control::{Axis, Coefficients, Controller, Fault, Measurement, NoFriction, Planner};
use preslide::effects::{PeriodicForce, With};

type Placed = Controller<With<NoFriction<f32>, (PeriodicForce<f32>,)>, u32>;

/// With a cogging of 0.5 N, which is at its greatest where the axis stands: a command of some 116 codes.
fn placed(axis: &Axis) -> Placed {
    let cogging = PeriodicForce::try_new(0.5, 1e-3, 0.0, Units::SI).expect("valid");
    let model = With::try_new(NoFriction::new(), (cogging,)).expect("valid");
    let mut controller = Controller::new(
        Coefficients::try_new(axis, model, Units::SI).expect("valid"),
        0,
    );
    controller.tick(calm(0));
    assert_eq!(controller.enable(), Ok(()));
    controller.set_position(0, 0);
    controller
}

/// What acts at the present place while the axis stands (codes).
fn acting(controller: &mut Placed, count: u32) -> i32 {
    let measured = Measurement { count, ..calm(0) };
    controller.tick(measured);
    controller.tick(measured).code
}

/// After every fault that the count may be the reason of, or the victim, the axis does not know where it is: places have no effect and
/// travel has no ends until the position is set again. After the others it knows.
#[test]
fn a_fault_that_doubts_the_count_loses_the_place_and_all_that_acts_by_it() {
    let mut axis = Axis::PAPER_AXIS;
    axis.watch.following_error = 20e-6;
    let jump = |_| calm(99_999);
    let slips = |tick: u32| calm(10 * tick);
    let sag = |_| supplied(4000);
    let late = |_| delayed();
    let large = |_| carrying(20_000);
    let warm = |_| carrying(9500);
    type Measure = fn(u32) -> Measurement<u32>;
    let cases: [(Fault, bool, Measure); 6] = [
        (Fault::EncoderJump, false, jump),
        (Fault::FollowingError, false, slips),
        (Fault::SupplyOutOfRange, false, sag),
        (Fault::Overrun, true, late),
        (Fault::OverCurrent, true, large),
        (Fault::Overload, true, warm),
    ];
    for (fault, stays, measure) in cases {
        assert_eq!(fault.doubts_count(), !stays, "{fault:?}");
        let mut controller = placed(&axis);
        let code = acting(&mut controller, 0);
        assert!((110..120).contains(&code), "{code}");
        let mut last = calm(0);
        let found = (1..400_000).find_map(|tick| {
            last = measure(tick);
            controller.tick(last).fault
        });
        assert_eq!(found, Some(fault));
        assert_eq!(controller.is_located(), stays, "{fault:?}");
        controller.acknowledge();
        // Until the velocity's estimate has come to rest.
        for _ in 0..12_000 {
            controller.tick(calm(last.count));
        }
        assert_eq!(controller.enable(), Ok(()), "{fault:?}");
        let (count, planner) = (last.count, Planner::try_new(&axis).expect("valid"));
        let far = planner
            .clone()
            .by(12.4e-3, 10e-3, 0.5)
            .expect("not located");
        let code = acting(&mut controller, count);
        if stays {
            assert!((110..120).contains(&code), "{fault:?}: {code}");
        } else {
            assert_eq!(code, 0, "{fault:?}");
            // Told anew, it acts again.
            controller.set_position(controller.position(), 0);
            assert!(
                (110..120).contains(&acting(&mut controller, count)),
                "{fault:?}"
            );
            assert_eq!(controller.start(far), Ok(()));
        }
    }
    // The frozen encoder, which has to be pushed against.
    let mut controller = placed(&axis);
    let mut planner = Planner::try_new(&axis).expect("valid");
    let next = planner.by(1e-3, 1e-3, 0.1).expect("within the limits");
    assert_eq!(controller.start(next), Ok(()));
    let found = (0..20_000).find_map(|_| controller.tick(calm(0)).fault);
    assert!(matches!(
        found,
        Some(Fault::EncoderFrozen | Fault::FollowingError)
    ));
    assert!(!controller.is_located());
}

/// Nothing watches a disabled axis, but a count that jumps is no count any more.
#[test]
fn a_jump_while_disabled_loses_the_place() {
    let mut controller = placed(&Axis::PAPER_AXIS);
    controller.disable();
    controller.tick(calm(30));
    assert!(controller.is_located());
    controller.tick(calm(5000));
    assert!(!controller.is_located());
    assert_eq!(controller.fault(), None);
}

/// A winding that rests while disabled has, after the time that cooling takes, the whole of its overload before it again; sooner, a part.
#[test]
fn a_winding_cools_while_disabled_by_the_time() {
    let mut axis = Axis::PAPER_AXIS;
    axis.watch.thermal_time = 0.1;
    let warm = carrying(9500);
    let mut controller = placed(&axis);
    let mut overload = |rest: u32| {
        controller.acknowledge();
        controller.disable();
        for _ in 0..rest {
            controller.tick(calm(0));
        }
        assert_eq!(controller.enable(), Ok(()));
        let ticks = (1..10_000).find(|_| controller.tick(warm).fault.is_some());
        assert_eq!(controller.fault(), Some(Fault::Overload));
        ticks.expect("a fault")
    };
    // From cold: i_r²·τ/(i² − i_r²) = 2000·0.68²/(0.95² − 0.68²).
    let [cold, at_once, half, cooled] = [0, 0, 1000, 4000].map(&mut overload);
    println!(
        "ticks to the overload: cold {cold}, at once {at_once}, half cooled {half}, cooled {cooled}"
    );
    assert!((2101..=2103).contains(&cold), "{cold}");
    assert!(at_once <= 2, "{at_once}");
    assert!((1050..=1053).contains(&half), "{half}");
    assert_eq!(cooled, cold);
}
