//! An H bridge of what embedded-hal knows: two PWM channels and two pins.

use crate::Bridge;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::pwm::SetDutyCycle;

/// Two half bridges. No duty holds a lead at the supply's low side; `enable` low opens all switches, whatever the channels do.
pub struct HalfBridges<A, B, Enable, Fault> {
    a: A,
    b: B,
    enable: Enable,
    /// Low where the bridge has opened itself.
    fault: Fault,
    steps: u16,
    /// Driven since it was last opened by software.
    closed: bool,
    /// A channel or a pin did not do as told.
    failed: bool,
}

impl<A: SetDutyCycle, B: SetDutyCycle, Enable: OutputPin, Fault: InputPin>
    HalfBridges<A, B, Enable, Fault>
{
    /// Open. `None` where a channel's full duty is not `steps` ([`preslide::control::Hardware::steps`]), or a channel or a pin does not do
    /// as told.
    pub fn start(mut a: A, mut b: B, mut enable: Enable, fault: Fault, steps: u16) -> Option<Self> {
        enable.set_low().ok()?;
        a.set_duty_cycle(0).ok()?;
        b.set_duty_cycle(0).ok()?;
        let fits = a.max_duty_cycle() == steps && b.max_duty_cycle() == steps;
        fits.then_some(Self {
            a,
            b,
            enable,
            fault,
            steps,
            closed: false,
            failed: false,
        })
    }
}

impl<A: SetDutyCycle, B: SetDutyCycle, Enable: OutputPin, Fault: InputPin> Bridge
    for HalfBridges<A, B, Enable, Fault>
{
    /// The half bridge that stops is set first, so both never drive at once; a timer takes both at its next update.
    #[inline]
    fn drive(&mut self, code: i32) {
        let duty = u16::try_from(code.unsigned_abs()).unwrap_or(self.steps);
        let set = if code >= 0 {
            self.b.set_duty_cycle(0).is_ok() && self.a.set_duty_cycle(duty).is_ok()
        } else {
            self.a.set_duty_cycle(0).is_ok() && self.b.set_duty_cycle(duty).is_ok()
        };
        if !self.closed {
            self.closed = self.enable.set_high().is_ok();
        }
        self.failed = !set || !self.closed;
    }

    #[inline]
    fn open(&mut self) {
        // A pin that fails here leaves nothing else to try than both low sides.
        if self.enable.set_low().is_err() {
            let _ = self.a.set_duty_cycle(0);
            let _ = self.b.set_duty_cycle(0);
        }
        self.closed = false;
    }

    #[inline]
    fn is_broken(&mut self) -> bool {
        self.failed || self.closed && self.fault.is_low().unwrap_or(true)
    }
}

/// Wakes a gate driver that sleeps: its pin high, then a wait of so many µs. Before a bridge is first closed, never in a tick. Whether the
/// pin did as told.
pub fn wake(sleep: &mut impl OutputPin, delay: &mut impl DelayNs, wait_us: u32) -> bool {
    let done = sleep.set_high().is_ok();
    delay.delay_us(wait_us);
    done
}
