//! TIM1 as two half bridges.

use crate::clock::dead_clocks;
use core::convert::Infallible;
use embassy_stm32::pac;
use embassy_stm32::pac::timer::vals::{Mms, Ocm, Ossi};
use embassy_stm32::peripherals::TIM1;
use embassy_stm32::timer::Channel as TimerChannel;
use embassy_stm32::timer::complementary_pwm::ComplementaryPwm;
use embedded_hal::{digital, pwm};
use preslide::control::Hardware;

/// The bridge: a lead at each of the first two channels.
pub type HalfBridges = preslide_app::HalfBridges<Channel<0>, Channel<1>, Outputs, Outputs>;

/// The duty of a channel and its complement, by its place. The timer takes it at its next update.
pub struct Channel<const AT: usize>;

impl<const AT: usize> pwm::ErrorType for Channel<AT> {
    type Error = Infallible;
}

impl<const AT: usize> pwm::SetDutyCycle for Channel<AT> {
    fn max_duty_cycle(&self) -> u16 {
        pac::TIM1.arr().read().arr()
    }

    #[inline]
    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        pac::TIM1.ccr(AT).write(|w| w.set_ccr(duty));
        Ok(())
    }
}

/// All outputs together: set high they follow their channels, and they read low where software or the break input has turned them off.
pub struct Outputs;

impl digital::ErrorType for Outputs {
    type Error = Infallible;
}

impl digital::OutputPin for Outputs {
    #[inline]
    fn set_low(&mut self) -> Result<(), Infallible> {
        off();
        Ok(())
    }

    #[inline]
    fn set_high(&mut self) -> Result<(), Infallible> {
        pac::TIM1.bdtr().modify(|w| w.set_moe(true));
        Ok(())
    }
}

impl digital::InputPin for Outputs {
    #[inline]
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(pac::TIM1.bdtr().read().moe())
    }

    #[inline]
    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(!pac::TIM1.bdtr().read().moe())
    }
}

/// Starts with the bridge open; `fails` where something is at the break input. The current is sampled at `phase` of a period (¼…½)
/// after the middle of the pulse. `None` where the timer does not make the steps.
pub fn run(
    mut pwm: ComplementaryPwm<'static, TIM1>,
    hardware: &Hardware,
    fails: bool,
    phase: f64,
) -> Option<HalfBridges> {
    off();
    // Whole clocks: it was rounded to them.
    pwm.set_dead_time(dead_clocks(hardware.dead_time));
    for channel in [TimerChannel::Ch1, TimerChannel::Ch2] {
        pwm.set_duty(channel, 0);
        pwm.enable(channel);
    }
    let tim = pac::TIM1;
    // Outputs that are off are driven to their idle level, low: with all four gates low the bridge is open. A low level at the
    // break input does the same without software, and lasts until software drives again.
    tim.bdtr().modify(|w| {
        w.set_ossi(Ossi::IDLE_LEVEL);
        w.set_bkp(0, pac::timer::vals::Bkp::ACTIVE_LOW);
        w.set_bke(0, fails);
        w.set_aoe(false);
    });
    tim.arr().write(|w| w.set_arr(hardware.steps));
    // Channel 4 rises on the counter's way up, which takes half a period from the middle of the pulse: there the current is sampled.
    let sampled = (2.0 * phase * f64::from(hardware.steps)) as u16;
    tim.ccr(3)
        .write(|w| w.set_ccr(sampled.min(hardware.steps - 1)));
    tim.ccmr_output(1).modify(|w| w.set_ocm(1, Ocm::PWM_MODE2));
    tim.cr2().modify(|w| w.set_mms(Mms::COMPARE_OC4));
    // It runs from here on; dropping the driver would stop it.
    core::mem::forget(pwm);
    HalfBridges::start(Channel::<0>, Channel::<1>, Outputs, Outputs, hardware.steps)
}

/// All four switches open, from wherever.
pub fn off() {
    pac::TIM1.bdtr().modify(|w| w.set_moe(false));
}
