//! The pins of TIM1: two half bridges, each with its complement, and the break input.

use crate::HARDWARE;
use embassy_stm32::Peri;
use embassy_stm32::gpio::{AfType, Flex, OutputType, Pull};
use embassy_stm32::peripherals::{PA8, PA9, PB12, PB13, PB14, TIM1};
use embassy_stm32::time::Hertz;
use embassy_stm32::timer::complementary_pwm::{ComplementaryPwm, ComplementaryPwmPin};
use embassy_stm32::timer::low_level::CountingMode;
use embassy_stm32::timer::simple_pwm::PwmPin;
use preslide_stm32g4::tim1::{self, HalfBridges};

/// TIM1_BKIN on PB12 (DS12288, table of alternate functions).
const BREAK_FUNCTION: u8 = 6;

/// The pins of the bridge.
pub struct Pins {
    /// Half bridge A, high and low side.
    pub a: (Peri<'static, PA8>, Peri<'static, PB13>),
    /// Half bridge B, high and low side.
    pub b: (Peri<'static, PA9>, Peri<'static, PB14>),
    /// The gate driver's fault output, low in a fault.
    pub fault: Peri<'static, PB12>,
}

/// Starts the timer with the bridge open ([`tim1::run`]).
pub fn start(timer: Peri<'static, TIM1>, pins: Pins, phase: f64) -> Option<HalfBridges> {
    let mut fault = Flex::new(pins.fault);
    fault.set_as_af_unchecked(BREAK_FUNCTION, AfType::input(Pull::Up));
    core::mem::forget(fault);
    let pwm = ComplementaryPwm::new(
        timer,
        Some(PwmPin::new(pins.a.0, OutputType::PushPull)),
        Some(ComplementaryPwmPin::new(pins.a.1, OutputType::PushPull)),
        Some(PwmPin::new(pins.b.0, OutputType::PushPull)),
        Some(ComplementaryPwmPin::new(pins.b.1, OutputType::PushPull)),
        None,
        None,
        None,
        None,
        Hertz(HARDWARE.rate_hz),
        CountingMode::CenterAlignedBothInterrupts,
    );
    tim1::run(pwm, &HARDWARE, true, phase)
}
