//! Supply voltage and winding current, converted at the same phase of every PWM period.

use crate::{BOARD, HARDWARE};
use preslide_app::{Scales, Sense};
use rp235x_hal::Adc;
use rp235x_hal::adc::AdcPin;
use rp235x_hal::gpio::bank0::{Gpio26, Gpio27};
use rp235x_hal::gpio::{FunctionNull, Pin, PullNone};
use rp235x_hal::pwm::{FreeRunning, Pwm1, Slice};

/// Code of no current, the middle of the scale.
const MIDDLE: i32 = 2048;

const SCALES: Scales = BOARD.scales();

type Input<I> = AdcPin<Pin<I, FunctionNull, PullNone>>;

/// The converter, and the timer that says when.
pub struct Converter {
    pub adc: Adc,
    pub supply: Input<Gpio26>,
    pub current: Input<Gpio27>,
    pub timer: Slice<Pwm1, FreeRunning>,
}

/// Has a timer without pins wrap at `phase` of a period after the middle of the pulse, where the bridge's wraps. Both are to be started
/// together.
pub fn schedule(timer: &mut Slice<Pwm1, FreeRunning>, phase: f64) {
    // The bridge's counts up and down, this one up only.
    let period = 2 * HARDWARE.steps;
    timer.set_top(period - 1);
    timer.set_counter(period - (phase * f64::from(period)) as u16);
    timer.enable_interrupt0();
}

impl Sense for Converter {
    #[inline]
    fn acknowledge(&mut self) {
        self.timer.clear_interrupt();
    }

    /// Waits for both conversions, 4 µs. One that fails reads as the largest current, which is a fault, and no supply.
    #[inline]
    fn read(&mut self) -> (u16, i16) {
        let current = self.adc.read(&mut self.current);
        let supply: Result<u16, _> = self.adc.read(&mut self.supply);
        let current = current.map_or(i16::MAX, |code: u16| {
            SCALES.current(i32::from(code) - MIDDLE)
        });
        (supply.map_or(0, |code| SCALES.supply(code)), current)
    }

    #[inline]
    fn is_due(&mut self) -> bool {
        self.timer.has_overflown()
    }
}
