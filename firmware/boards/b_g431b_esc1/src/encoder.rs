//! TIM4: the quadrature counter, and what it showed at the index pulse. It has 16 bits; the rest is counted here.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{AfType, Flex, Pull};
use embassy_stm32::pac;
use embassy_stm32::pac::timer::vals::{CcmrInputCcs, FilterValue};
use embassy_stm32::peripherals::{PB6, PB7, PB8, TIM4};
use embassy_stm32::timer::qei::{Config, Qei};
use preslide_app::{CountEncoder, Widened};

/// TIM4_CH3 on PB8 (DS12589, table of alternate functions).
const INDEX_FUNCTION: u8 = 2;

/// Eight clocks of 170 MHz, 47 ns: shorter pulses are noise. The board has a capacitor at each of these pins too.
const FILTER: FilterValue = FilterValue::FCK_INT_N8;

/// The encoder.
pub struct Encoder {
    // Kept, so that its pins stay the timer's.
    _counter: Qei<'static, TIM4>,
    count: Widened,
}

impl Encoder {
    /// Counts edges of both phases, and captures the count where the index rises.
    pub fn start(
        timer: Peri<'static, TIM4>,
        a: Peri<'static, PB6>,
        b: Peri<'static, PB7>,
        index: Peri<'static, PB8>,
    ) -> Self {
        let mut index = Flex::new(index);
        index.set_as_af_unchecked(INDEX_FUNCTION, AfType::input(Pull::Down));
        core::mem::forget(index);
        let counter = Qei::new(timer, a, b, Config::default());
        let tim = pac::TIM4;
        tim.ccmr_input(0).modify(|w| {
            w.set_icf(0, FILTER);
            w.set_icf(1, FILTER);
        });
        tim.ccmr_input(1).modify(|w| {
            w.set_ccs(0, CcmrInputCcs::TI4);
            w.set_icf(0, FILTER);
        });
        tim.ccer().modify(|w| w.set_cce(2, true));
        Self {
            _counter: counter,
            count: Widened::new(tim.cnt().read().cnt()),
        }
    }
}

impl CountEncoder for Encoder {
    #[inline]
    fn index(&mut self) -> Option<u32> {
        let pulse = pac::TIM4.sr().read().ccif(2);
        // Reading the captured count clears the flag.
        pulse.then(|| self.count.at(pac::TIM4.ccr(2).read().ccr()))
    }

    #[inline]
    fn count(&mut self) -> u32 {
        self.count.go_on(pac::TIM4.cnt().read().cnt())
    }
}
