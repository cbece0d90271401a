//! TIM1: two half bridges, each with its complement and dead time.

use crate::clock::{RATE, STEPS};
use core::convert::Infallible;
use embassy_stm32::Peri;
use embassy_stm32::gpio::OutputType;
use embassy_stm32::pac;
use embassy_stm32::peripherals::{PA8, PA9, PB13, PB14, TIM1};
use embassy_stm32::timer::Channel as TimerChannel;
use embassy_stm32::timer::complementary_pwm::{ComplementaryPwm, ComplementaryPwmPin};
use embassy_stm32::timer::low_level::CountingMode;
use embassy_stm32::timer::simple_pwm::PwmPin;
use embedded_hal::pwm::{ErrorType, SetDutyCycle};

/// 100 ns at 170 MHz: assumption, enough for the usual small gate drivers.
const DEAD_TIME: u16 = 17;

/// A half bridge.
pub struct Channel(usize);

/// Starts both half bridges at duty 0, which brakes.
pub fn start(
    timer: Peri<'static, TIM1>,
    high_a: Peri<'static, PA8>,
    low_a: Peri<'static, PB13>,
    high_b: Peri<'static, PA9>,
    low_b: Peri<'static, PB14>,
) -> (Channel, Channel) {
    let mut pwm = ComplementaryPwm::new(
        timer,
        Some(PwmPin::new(high_a, OutputType::PushPull)),
        Some(ComplementaryPwmPin::new(low_a, OutputType::PushPull)),
        Some(PwmPin::new(high_b, OutputType::PushPull)),
        Some(ComplementaryPwmPin::new(low_b, OutputType::PushPull)),
        None,
        None,
        None,
        None,
        RATE,
        CountingMode::EdgeAlignedUp,
    );
    pwm.set_dead_time(DEAD_TIME);
    for channel in [TimerChannel::Ch1, TimerChannel::Ch2] {
        pwm.set_duty(channel, 0);
        pwm.enable(channel);
    }
    // It runs from here on; dropping the driver would stop it.
    core::mem::forget(pwm);
    (Channel(0), Channel(1))
}

/// All four switches open, from wherever.
pub fn off() {
    pac::TIM1.bdtr().modify(|w| w.set_moe(false));
}

impl ErrorType for Channel {
    type Error = Infallible;
}

impl SetDutyCycle for Channel {
    fn max_duty_cycle(&self) -> u16 {
        STEPS
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        pac::TIM1.ccr(self.0).write(|w| w.set_ccr(duty));
        Ok(())
    }
}
