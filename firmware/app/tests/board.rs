//! What a board's parts are put together by, on parts that remember what they were told.

use embedded_hal::digital::{self, InputPin, OutputPin};
use embedded_hal::pwm::{self, SetDutyCycle};
use preslide_app::{Bridge, Guarded, HalfBridges, Limits, Widened};
use std::cell::RefCell;
use std::rc::Rc;

/// What the parts were told, in its order; and what they are to do.
#[derive(Default)]
struct Told {
    said: Vec<(&'static str, u16)>,
    refuses: Option<&'static str>,
    faulty: bool,
}

#[derive(Clone)]
struct Part(&'static str, Rc<RefCell<Told>>);

#[derive(Debug)]
struct Refused;

impl pwm::Error for Refused {
    fn kind(&self) -> pwm::ErrorKind {
        pwm::ErrorKind::Other
    }
}

impl digital::Error for Refused {
    fn kind(&self) -> digital::ErrorKind {
        digital::ErrorKind::Other
    }
}

impl pwm::ErrorType for Part {
    type Error = Refused;
}

impl digital::ErrorType for Part {
    type Error = Refused;
}

impl Part {
    fn told(&self, value: u16) -> Result<(), Refused> {
        let mut told = self.1.borrow_mut();
        if told.refuses == Some(self.0) {
            return Err(Refused);
        }
        told.said.push((self.0, value));
        Ok(())
    }
}

impl SetDutyCycle for Part {
    fn max_duty_cycle(&self) -> u16 {
        1000
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Refused> {
        self.told(duty)
    }
}

impl OutputPin for Part {
    fn set_low(&mut self) -> Result<(), Refused> {
        self.told(0)
    }

    fn set_high(&mut self) -> Result<(), Refused> {
        self.told(1)
    }
}

impl InputPin for Part {
    fn is_high(&mut self) -> Result<bool, Refused> {
        Ok(!self.1.borrow().faulty)
    }

    fn is_low(&mut self) -> Result<bool, Refused> {
        Ok(self.1.borrow().faulty)
    }
}

fn bridge(
    steps: u16,
) -> (
    Option<HalfBridges<Part, Part, Part, Part>>,
    Rc<RefCell<Told>>,
) {
    let told = Rc::<RefCell<Told>>::default();
    let part = |name| Part(name, told.clone());
    let started = HalfBridges::start(part("a"), part("b"), part("enable"), part("fault"), steps);
    (started, told)
}

#[test]
fn the_half_bridge_that_stops_is_set_first_and_the_bridge_closes_last() {
    let (bridge, told) = bridge(1000);
    let mut bridge = bridge.expect("the timer makes the steps");
    assert_eq!(told.take().said, [("enable", 0), ("a", 0), ("b", 0)]);
    bridge.drive(300);
    assert_eq!(told.take().said, [("b", 0), ("a", 300), ("enable", 1)]);
    bridge.drive(-200);
    assert_eq!(told.take().said, [("a", 0), ("b", 200)]);
    bridge.open();
    assert_eq!(told.take().said, [("enable", 0)]);
    bridge.drive(0);
    assert_eq!(told.take().said, [("b", 0), ("a", 0), ("enable", 1)]);
}

#[test]
fn a_timer_of_other_steps_is_refused() {
    assert!(bridge(999).0.is_none());
}

#[test]
fn a_fault_tells_only_of_a_bridge_that_is_closed() {
    let (bridge, told) = bridge(1000);
    let mut bridge = bridge.expect("the timer makes the steps");
    told.borrow_mut().faulty = true;
    assert!(!bridge.is_broken());
    bridge.drive(1);
    assert!(bridge.is_broken());
    bridge.open();
    assert!(!bridge.is_broken());
}

#[test]
fn a_part_that_does_not_do_as_told_breaks_the_bridge_and_opens_it_somehow() {
    for refuses in ["a", "b", "enable"] {
        let (bridge, told) = bridge(1000);
        let mut bridge = bridge.expect("the timer makes the steps");
        told.borrow_mut().refuses = Some(refuses);
        bridge.drive(500);
        assert!(bridge.is_broken(), "{refuses}");
        told.take();
        told.borrow_mut().refuses = Some(refuses);
        bridge.open();
        let said: &[_] = match refuses {
            "enable" => &[("a", 0), ("b", 0)],
            _ => &[("enable", 0)],
        };
        assert_eq!(told.take().said, said);
        bridge.drive(500);
        assert!(!bridge.is_broken(), "{refuses}");
    }
}

/// Pulled up, an open switch and a broken wire read high; a pin that cannot be read is taken for one.
#[test]
fn a_guarded_bridge_has_switches_and_a_brake_beside_it() {
    struct Level(Result<bool, ()>);
    impl digital::ErrorType for Level {
        type Error = Refused;
    }
    impl InputPin for Level {
        fn is_high(&mut self) -> Result<bool, Refused> {
            self.0.map_err(|()| Refused)
        }
        fn is_low(&mut self) -> Result<bool, Refused> {
            self.is_high().map(|high| !high)
        }
    }
    for (low, high, read) in [
        (Ok(false), Ok(false), [false, false]),
        (Ok(true), Ok(false), [true, false]),
        (Ok(false), Ok(true), [false, true]),
        (Err(()), Ok(false), [true, false]),
    ] {
        let (inner, told) = bridge(1000);
        let inner = inner.expect("the timer makes the steps");
        let brake = Part("brake", told.clone());
        let mut guarded = Guarded::new(inner, (Level(low), Level(high)), brake, [800, 1200]);
        let [low, high] = read;
        assert_eq!(guarded.limits(), Limits { low, high });
        assert_eq!(guarded.brake_delays(), [800, 1200]);
        told.take();
        guarded.drive(300);
        guarded.release_brake(true);
        guarded.open();
        guarded.release_brake(false);
        let through = [
            ("b", 0),
            ("a", 300),
            ("enable", 1),
            ("brake", 1),
            ("enable", 0),
            ("brake", 0),
        ];
        assert_eq!(told.take().said, through);
        // The fault pin of the bridge itself goes through, too.
        guarded.drive(1);
        told.borrow_mut().faulty = true;
        assert!(guarded.is_broken());
    }
}

#[test]
fn a_counter_of_16_bits_is_counted_on_past_both_ends() {
    let mut count = Widened::new(65_530);
    assert_eq!(count.go_on(4), 65_540);
    // Where it was when the index came, before and after the last reading.
    assert_eq!([count.at(65_535), count.at(10)], [65_535, 65_546]);
    assert_eq!(count.go_on(65_000), 65_000);
    assert_eq!(count.go_on(40_000), 40_000);
    assert_eq!(count.go_on(10_000), 10_000);
    assert_eq!(count.go_on(60_000), 0_u32.wrapping_sub(5_536));
}
