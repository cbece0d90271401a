//! The stage link: counter, ADC and PWM as registers that a simulator on the host keeps.

use crate::registers::HostFile;
use core::convert::Infallible;
use core::sync::atomic::{AtomicU16, Ordering};
use embedded_hal::pwm::{ErrorType, SetDutyCycle};
use preslide_link::{Exchange, Order, Reading};

static FORWARD: AtomicU16 = AtomicU16::new(0);
static BACKWARD: AtomicU16 = AtomicU16::new(0);

/// A PWM channel: what it holds is sent with the next exchange.
pub struct Channel {
    duty: &'static AtomicU16,
    steps: u16,
}

impl Channel {
    /// Both channels of the bridge.
    pub fn pair(steps: u16) -> (Self, Self) {
        (
            Self {
                duty: &FORWARD,
                steps,
            },
            Self {
                duty: &BACKWARD,
                steps,
            },
        )
    }
}

impl ErrorType for Channel {
    type Error = Infallible;
}

impl SetDutyCycle for Channel {
    fn max_duty_cycle(&self) -> u16 {
        self.steps
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        self.duty.store(duty, Ordering::Relaxed);
        Ok(())
    }
}

/// Turns the PWM off, from wherever.
pub fn off() {
    FORWARD.store(0, Ordering::Relaxed);
    BACKWARD.store(0, Ordering::Relaxed);
}

/// Sends what the bridge holds and waits for what the registers show after the stage has moved on by a tick.
///
/// The emulator stands still meanwhile: neither the controller's time nor the watchdog sees how long the simulator takes.
pub fn exchange() -> Reading {
    let code =
        i32::from(FORWARD.load(Ordering::Relaxed)) - i32::from(BACKWARD.load(Ordering::Relaxed));
    HostFile::OUTPUT.write(&Order { code: code as i16 }.to_bytes());
    let mut bytes = [0; 10];
    if HostFile::INPUT.read(&mut bytes) {
        Reading::from_bytes(bytes)
    } else {
        // The simulator is gone.
        Reading {
            quit: true,
            ..Reading::default()
        }
    }
}
