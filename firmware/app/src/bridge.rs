//! The H bridge: a signed code on two PWM channels.

use core::convert::Infallible;
use embedded_hal::pwm::SetDutyCycle;

/// One channel drives forward, the other backward; the one that does not drive is at 0.
pub struct Bridge<A, B> {
    forward: A,
    backward: B,
}

impl<A, B> Bridge<A, B>
where
    A: SetDutyCycle<Error = Infallible>,
    B: SetDutyCycle<Error = Infallible>,
{
    /// Both channels off. `None` where a channel's full duty is not `steps` codes, which would scale every command.
    pub fn new(forward: A, backward: B, steps: u16) -> Option<Self> {
        let fits = forward.max_duty_cycle() == steps && backward.max_duty_cycle() == steps;
        let mut bridge = Self { forward, backward };
        bridge.set(0);
        fits.then_some(bridge)
    }

    /// Applies a code. The channel that stops is set first, so both never drive at once.
    #[inline]
    pub fn set(&mut self, code: i32) {
        let duty = u16::try_from(code.unsigned_abs()).unwrap_or(u16::MAX);
        let (Ok(()), Ok(())) = if code >= 0 {
            (
                self.backward.set_duty_cycle(0),
                self.forward.set_duty_cycle(duty),
            )
        } else {
            (
                self.forward.set_duty_cycle(0),
                self.backward.set_duty_cycle(duty),
            )
        };
    }
}
