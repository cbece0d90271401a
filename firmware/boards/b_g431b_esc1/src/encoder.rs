//! TIM4: the quadrature counter, and what it showed at the index pulse. It has 16 bits; the rest is counted here.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{AfType, Flex, Pull};
use embassy_stm32::pac;
use embassy_stm32::pac::timer::vals::{CcmrInputCcs, FilterValue};
use embassy_stm32::peripherals::{PB6, PB7, PB8, TIM4};
use embassy_stm32::timer::qei::{Config, Qei};

/// TIM4_CH3 on PB8 (DS12589, table of alternate functions).
const INDEX_FUNCTION: u8 = 2;

/// Eight clocks of 170 MHz, 47 ns: shorter pulses are noise. The board has a capacitor at each of these pins too.
const FILTER: FilterValue = FilterValue::FCK_INT_N8;

/// The encoder.
pub struct Encoder {
    // Kept, so that its pins stay the timer's.
    _counter: Qei<'static, TIM4>,
    last: u16,
    count: u32,
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
        let last = tim.cnt().read().cnt();
        Self {
            _counter: counter,
            last,
            count: last.into(),
        }
    }

    /// The count; to be read every tick, in which it comes on by less than half the timer's range.
    #[inline]
    pub fn count(&mut self) -> u32 {
        let now = pac::TIM4.cnt().read().cnt();
        self.count = self.at(now);
        self.last = now;
        self.count
    }

    /// The count where the timer showed `reading`.
    #[inline]
    fn at(&self, reading: u16) -> u32 {
        let since = reading.wrapping_sub(self.last).cast_signed();
        self.count.wrapping_add_signed(since.into())
    }

    /// What it was at the index pulse, once for each pulse.
    #[inline]
    pub fn index(&self) -> Option<u32> {
        let pulse = pac::TIM4.sr().read().ccif(2);
        // Reading the captured count clears the flag.
        pulse.then(|| self.at(pac::TIM4.ccr(2).read().ccr()))
    }
}
