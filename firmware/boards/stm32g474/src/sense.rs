//! Supply voltage and winding current, converted at the same phase of every PWM period.

use crate::BOARD;
use embassy_stm32::Peri;
use embassy_stm32::adc::{Adc, AdcConfig};
use embassy_stm32::pac;
use embassy_stm32::pac::adc::vals::{Exten, SampleTime};
use embassy_stm32::peripherals::{ADC1, PC0, PC1};
use preslide_app::{Scales, Sense};

/// ADC code of no current, the middle of the scale.
const MIDDLE: i32 = 2048;

const SCALES: Scales = BOARD.scales();

/// ADC1's channels of PC0 and PC1 (DS12288, pin definitions).
const SUPPLY: u8 = 6;
const CURRENT: u8 = 7;

/// The event that starts a conversion: TIM1_TRGO (RM0440, table of injected triggers).
const TIM1_TRGO: u8 = 0;

/// Current, then supply, converted when TIM1 says; the end of both is the interrupt of the control task.
pub struct Converter {
    _supply: Peri<'static, PC0>,
    _current: Peri<'static, PC1>,
}

impl Converter {
    /// Calibrates the converter and has it wait for the timer. Pins are analog after a reset.
    pub fn start(
        adc: Peri<'static, ADC1>,
        supply: Peri<'static, PC0>,
        current: Peri<'static, PC1>,
    ) -> Self {
        // It only calibrates here; the converter stays on when the driver goes, which has no `Drop`.
        let _calibrated = Adc::new(adc, AdcConfig::default());
        let adc = pac::ADC1;
        adc.cr().modify(|w| w.set_aden(true));
        while !adc.isr().read().adrdy() {}
        adc.smpr().modify(|w| {
            w.set_smp(SUPPLY.into(), SampleTime::CYCLES12_5);
            w.set_smp(CURRENT.into(), SampleTime::CYCLES12_5);
        });
        adc.jsqr().modify(|w| {
            w.set_jl(1);
            w.set_jsq(0, CURRENT);
            w.set_jsq(1, SUPPLY);
            w.set_jextsel(TIM1_TRGO);
            w.set_jexten(Exten::RISING_EDGE);
        });
        adc.ier().modify(|w| w.set_jeosie(true));
        adc.cr().modify(|w| w.set_jadstart(true));
        Self {
            _supply: supply,
            _current: current,
        }
    }
}

impl Sense for Converter {
    #[inline]
    fn acknowledge(&mut self) {
        pac::ADC1.isr().write(|w| w.set_jeos(true));
    }

    #[inline]
    fn read(&mut self) -> (u16, i16) {
        let current = i32::from(pac::ADC1.jdr(0).read().jdata());
        let supply = pac::ADC1.jdr(1).read().jdata();
        (SCALES.supply(supply), SCALES.current(current - MIDDLE))
    }

    #[inline]
    fn is_due(&mut self) -> bool {
        pac::ADC1.isr().read().jeos()
    }
}
