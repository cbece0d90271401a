//! When a push that does not move the axis is a frozen encoder, and when it holds a load: by the push beyond what is held, in codes.

use crate::measured::calm;
use preslide::control::{Axis, Coefficients, Controller, Fault, Planner};
use preslide::{Friction, Motion, Units};

/// Pushes with what its memory says (N).
#[derive(Clone, Debug, PartialEq)]
struct Pushed;

impl Friction for Pushed {
    type Scalar = f64;
    type State = f64;

    fn at_rest(&self) -> f64 {
        0.0
    }

    fn step(&self, force: &mut f64, _: Motion<f64>) -> f64 {
        *force
    }

    fn limit(&self) -> Option<f64> {
        None
    }
}

/// An axis that nothing but the push drives, and that is asked to move slowly or to stand.
struct Rig {
    controller: Controller<Pushed, u32>,
    per_code: f64,
    /// The code above which is a push, and the ticks after which it is a fault.
    least: i32,
    timeout: u32,
    count: u32,
    way: i32,
}

impl Rig {
    fn new(way: i32, moves: bool) -> Self {
        let mut axis = Axis::PAPER_AXIS;
        axis.gains.proportional = 1.0;
        axis.gains.integral = 0.0;
        axis.gains.derivative = 0.0;
        axis.feed_forward.mass = 0.0;
        axis.feed_forward.limit = 100.0;
        axis.feed_forward.share = 1.0;
        axis.watch.following_error = 0.5e-3;
        axis.watch.frozen_duty = 0.05;
        axis.watch.thermal_time = 1e3;
        let coefficients = Coefficients::try_new(&axis, Pushed, Units::SI).expect("valid");
        let mut controller = Controller::new(coefficients, 0_u32);
        controller.enable().expect("nothing speaks against it");
        if moves {
            let planner = Planner::try_new(&axis).expect("the paper's axis");
            // Half a code of back-EMF.
            let jog = planner
                .jog(2e-5 * f64::from(way))
                .expect("within the limits");
            controller.jog(jog).expect("it is enabled");
        }
        let steps = f64::from(axis.hardware.steps);
        Self {
            controller,
            per_code: axis.motor.supply / steps * axis.motor.force_per_volt(),
            least: (axis.watch.frozen_duty * steps) as i32,
            timeout: (axis.watch.frozen_time / axis.sample_time()) as u32,
            count: 0,
            way,
        }
    }

    /// Pushes with so many codes along the way, while the count goes on by one every so many ticks (none for 0); the tick of the fault.
    fn push(&mut self, code: i32, every: u32, ticks: u32) -> Option<u32> {
        for tick in 1..=ticks {
            if every > 0 && tick.is_multiple_of(every) {
                self.count = self.count.wrapping_add_signed(self.way);
            }
            *self.controller.friction_state() = f64::from(self.way * code) * self.per_code;
            self.controller.heard();
            let measured = calm(self.count);
            if let Some(fault) = self.controller.tick(measured).fault {
                assert_eq!(fault, Fault::EncoderFrozen);
                return Some(tick);
            }
        }
        None
    }

    fn is_found(&mut self, code: i32) {
        let found = self.push(code, 0, self.timeout + 10);
        // The tick after the command is the first to look at it.
        let late = found.map(|tick| tick - self.timeout);
        assert!(
            late.is_some_and(|late| late <= 4),
            "{found:?}, {code} codes"
        );
    }
}

#[test]
fn a_frozen_count_is_found_in_time_and_a_moving_one_passes() {
    for way in [1, -1] {
        let mut rig = Rig::new(way, true);
        let (least, timeout) = (rig.least, rig.timeout);
        rig.is_found(least + 300);
        let mut rig = Rig::new(way, true);
        assert_eq!(rig.push(least - 3, 0, 10 * timeout), None);
        // To and fro.
        for _ in 0..5 {
            assert_eq!(rig.push(least + 300, 0, timeout / 2), None);
            assert_eq!(rig.push(-least - 300, 0, timeout / 2), None);
        }
        // It comes on: there is a load of at least the push less what friction may take, and a push beyond that is found.
        let mut rig = Rig::new(way, true);
        assert_eq!(rig.push(least + 300, timeout / 3, 10 * timeout), None);
        rig.is_found(least + 350);
    }
}

#[test]
fn what_holds_a_load_at_rest_is_no_fault_until_it_pushes_as_much_more() {
    for way in [1, -1] {
        let mut rig = Rig::new(way, false);
        let (least, timeout) = (rig.least, rig.timeout);
        assert_eq!(rig.push(2 * least, 0, 5 * timeout), None);
        assert_eq!(rig.push(3 * least - 5, 0, 5 * timeout), None);
        // It gives way by a count under a larger one: that is what it holds now.
        assert_eq!(rig.push(3 * least + 20, timeout / 2, timeout / 2), None);
        assert_eq!(rig.push(3 * least + 20, 0, 5 * timeout), None);
        rig.is_found(4 * least + 40);
    }
}
