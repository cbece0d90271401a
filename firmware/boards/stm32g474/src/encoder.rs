//! TIM2: the quadrature counter, and what it showed at the index pulse.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{AfType, Flex, Pull};
use embassy_stm32::pac;
use embassy_stm32::pac::timer::vals::{CcmrInputCcs, FilterValue};
use embassy_stm32::peripherals::{PA0, PA1, PB10, TIM2};
use embassy_stm32::timer::qei::{Config, Qei};
use preslide_app::CountEncoder;

/// TIM2_CH3 on PB10 (DS12288, table of alternate functions).
const INDEX_FUNCTION: u8 = 1;

/// Eight clocks of 170 MHz, 47 ns: shorter pulses are noise. 10 million counts a second still pass.
const FILTER: FilterValue = FilterValue::FCK_INT_N8;

/// The encoder.
pub struct Encoder {
    // Kept, so that its pins stay the timer's.
    _counter: Qei<'static, TIM2>,
}

impl Encoder {
    /// Counts edges of both phases, and captures the count where the index rises.
    pub fn start(
        timer: Peri<'static, TIM2>,
        a: Peri<'static, PA0>,
        b: Peri<'static, PA1>,
        index: Peri<'static, PB10>,
    ) -> Self {
        let mut index = Flex::new(index);
        index.set_as_af_unchecked(INDEX_FUNCTION, AfType::input(Pull::Down));
        core::mem::forget(index);
        let counter = Qei::new(timer, a, b, Config::default());
        let tim = pac::TIM2;
        // The driver counts 16 bits; the timer has 32.
        tim.arr().write_value(u32::MAX);
        tim.ccmr_input(0).modify(|w| {
            w.set_icf(0, FILTER);
            w.set_icf(1, FILTER);
        });
        tim.ccmr_input(1).modify(|w| {
            w.set_ccs(0, CcmrInputCcs::TI4);
            w.set_icf(0, FILTER);
        });
        tim.ccer().modify(|w| w.set_cce(2, true));
        Self { _counter: counter }
    }
}

impl CountEncoder for Encoder {
    #[inline]
    fn index(&mut self) -> Option<u32> {
        let pulse = pac::TIM2.sr().read().ccif(2);
        // Reading the captured count clears the flag.
        pulse.then(|| pac::TIM2.ccr(2).read())
    }

    #[inline]
    fn count(&mut self) -> u32 {
        pac::TIM2.cnt().read()
    }
}
