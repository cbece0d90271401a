//! Supply voltage and winding current.

use embassy_stm32::Peri;
use embassy_stm32::adc::{Adc, AdcConfig, SampleTime};
use embassy_stm32::peripherals::{ADC1, PA2, PA3};

/// ADC codes at the 3.3 V reference.
const FULL: u32 = 4096;

/// Supply (mV) at full scale: 3.3 V behind a divider by 11. Assumption: replace with the bridge's own.
const SUPPLY_FULL: u32 = 36_300;

/// Winding current (0.1 mA) from end to end of the scale, zero in the middle: ±3.2 A. Assumption, as above.
const CURRENT_SPAN: i32 = 64_000;

/// Two conversions a tick, about 0.5 µs each.
pub struct Sense {
    adc: Adc<'static, ADC1>,
    supply: Peri<'static, PA2>,
    current: Peri<'static, PA3>,
}

impl Sense {
    /// Calibrates the converter.
    pub fn new(
        adc: Peri<'static, ADC1>,
        supply: Peri<'static, PA2>,
        current: Peri<'static, PA3>,
    ) -> Self {
        Self {
            adc: Adc::new(adc, AdcConfig::default()),
            supply,
            current,
        }
    }

    /// Supply (mV) and winding current (0.1 mA).
    #[inline]
    pub fn read(&mut self) -> (u16, i16) {
        let supply = u32::from(
            self.adc
                .blocking_read(&mut self.supply, SampleTime::CYCLES12_5),
        );
        let current = i32::from(
            self.adc
                .blocking_read(&mut self.current, SampleTime::CYCLES12_5),
        );
        let current = (current - FULL as i32 / 2) * CURRENT_SPAN / FULL as i32;
        ((supply * SUPPLY_FULL / FULL) as u16, current as i16)
    }
}
