//! TIM1 as two half bridges: both boards' (`../../stm32g474/src/half_bridges.rs`).

use crate::clock::{DEAD_TIME, HARDWARE};
use embassy_stm32::pac;
use embassy_stm32::pac::timer::vals::{Mms, Ocm, Ossi};
use embassy_stm32::peripherals::TIM1;
use embassy_stm32::timer::Channel as TimerChannel;
use embassy_stm32::timer::complementary_pwm::ComplementaryPwm;
use preslide_app::Bridge;

/// Both half bridges.
pub struct HalfBridges {
    /// Driven since it was last opened by software.
    closed: bool,
}

/// Starts with the bridge open; `fails` where something is at the break input. The current is sampled at `phase` of a period (¼…½)
/// after the middle of the pulse.
pub fn run(mut pwm: ComplementaryPwm<'static, TIM1>, fails: bool, phase: f64) -> HalfBridges {
    off();
    pwm.set_dead_time(DEAD_TIME);
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
    tim.arr().write(|w| w.set_arr(HARDWARE.steps));
    // Channel 4 rises on the counter's way up, which takes half a period from the middle of the pulse: there the current is sampled.
    let sampled = (2.0 * phase * f64::from(HARDWARE.steps)) as u16;
    tim.ccr(3)
        .write(|w| w.set_ccr(sampled.min(HARDWARE.steps - 1)));
    tim.ccmr_output(1).modify(|w| w.set_ocm(1, Ocm::PWM_MODE2));
    tim.cr2().modify(|w| w.set_mms(Mms::COMPARE_OC4));
    // It runs from here on; dropping the driver would stop it.
    core::mem::forget(pwm);
    HalfBridges { closed: false }
}

/// All four switches open, from wherever.
pub fn off() {
    pac::TIM1.bdtr().modify(|w| w.set_moe(false));
}

impl Bridge for HalfBridges {
    /// The half bridge that stops is set first, so both never drive at once; the timer takes both at its next update.
    #[inline]
    fn drive(&mut self, code: i32) {
        let duty = u16::try_from(code.unsigned_abs()).unwrap_or(HARDWARE.steps);
        let (drives, rests) = if code >= 0 { (0, 1) } else { (1, 0) };
        let tim = pac::TIM1;
        tim.ccr(rests).write(|w| w.set_ccr(0));
        tim.ccr(drives).write(|w| w.set_ccr(duty));
        if !self.closed {
            self.closed = true;
            tim.bdtr().modify(|w| w.set_moe(true));
        }
    }

    #[inline]
    fn open(&mut self) {
        self.closed = false;
        off();
    }

    #[inline]
    fn is_broken(&self) -> bool {
        self.closed && !pac::TIM1.bdtr().read().moe()
    }
}
