//! Supply voltage and winding current, converted at the same phase of every PWM period.
//!
//! The half bridge that rests has its low side on throughout, so the current of the winding flows through its shunt: that of V where
//! U drives, and that of U, downward as well, where V drives.

use crate::BOARD;
use embassy_stm32::Peri;
use embassy_stm32::adc::{Adc, AdcConfig};
use embassy_stm32::opamp::{OpAmp, OpAmpGain, OpAmpSpeed};
use embassy_stm32::pac;
use embassy_stm32::pac::adc::vals::{Exten, SampleTime};
use embassy_stm32::peripherals::{ADC1, ADC2, OPAMP1, OPAMP2, PA0, PA1, PA2, PA3, PA5, PA6, PA7};
use preslide_app::{Scales, Sense};

/// ADC codes at the 3.3 V reference.
const FULL: i32 = 4096;

const SCALES: Scales = BOARD.scales();

/// Channels of PA2 and PA6, the amplifiers' outputs, on their converters, and of PA0 (DS12589, pin definitions).
const AMPLIFIER: u8 = 3;
const SUPPLY: u8 = 1;

/// The event that starts a conversion: TIM1_TRGO (RM0440, table of injected triggers).
const TIM1_TRGO: u8 = 0;

/// An amplifier that reads less or more than this with the bridge open is broken.
const OFFSETS: core::ops::Range<i32> = FULL / 8..FULL / 8 * 7;

/// The pins of the two amplifiers: input, bias, output.
pub struct Pins {
    /// Of half bridge U.
    pub u: (Peri<'static, PA1>, Peri<'static, PA3>, Peri<'static, PA2>),
    /// Of half bridge V.
    pub v: (Peri<'static, PA7>, Peri<'static, PA5>, Peri<'static, PA6>),
    /// The divided supply.
    pub supply: Peri<'static, PA0>,
}

/// Both currents and the supply, converted when TIM1 says; the end of the first converter's two is the interrupt of the control task.
pub struct Converters {
    /// What the amplifiers of U and V read with the bridge open, times 256.
    offsets: [i32; 2],
    _supply: Peri<'static, PA0>,
}

impl Converters {
    /// Calibrates the converters and has them wait for the timer.
    pub fn start(
        converters: (Peri<'static, ADC1>, Peri<'static, ADC2>),
        amplifiers: (Peri<'static, OPAMP1>, Peri<'static, OPAMP2>),
        pins: Pins,
    ) -> Self {
        // The board's resistors are made for a gain of 16 with the bias at VINM0. They stay on when their drivers go.
        let (u, v) = (pins.u, pins.v);
        let mut first = OpAmp::new(amplifiers.0, OpAmpSpeed::HighSpeed);
        core::mem::forget(first.pga_biased_ext(u.0, u.1, u.2, OpAmpGain::Mul16));
        let mut second = OpAmp::new(amplifiers.1, OpAmpSpeed::HighSpeed);
        core::mem::forget(second.pga_biased_ext(v.0, v.1, v.2, OpAmpGain::Mul16));
        // They only calibrate here; the converters stay on when the drivers go, which have no `Drop`.
        let _calibrated = Adc::new(converters.0, AdcConfig::default());
        let _calibrated = Adc::new(converters.1, AdcConfig::default());
        for adc in [pac::ADC1, pac::ADC2] {
            adc.cr().modify(|w| w.set_aden(true));
            while !adc.isr().read().adrdy() {}
            adc.smpr().modify(|w| {
                w.set_smp(SUPPLY.into(), SampleTime::CYCLES12_5);
                w.set_smp(AMPLIFIER.into(), SampleTime::CYCLES12_5);
            });
        }
        pac::ADC1.jsqr().modify(|w| {
            w.set_jl(1);
            w.set_jsq(0, AMPLIFIER);
            w.set_jsq(1, SUPPLY);
            w.set_jextsel(TIM1_TRGO);
            w.set_jexten(Exten::RISING_EDGE);
        });
        pac::ADC2.jsqr().modify(|w| {
            w.set_jl(0);
            w.set_jsq(0, AMPLIFIER);
            w.set_jextsel(TIM1_TRGO);
            w.set_jexten(Exten::RISING_EDGE);
        });
        pac::ADC1.ier().modify(|w| w.set_jeosie(true));
        // The one whose end is waited for last: it takes longer, by a conversion.
        pac::ADC2.cr().modify(|w| w.set_jadstart(true));
        pac::ADC1.cr().modify(|w| w.set_jadstart(true));
        Self {
            offsets: [FULL / 2 * 256; 2],
            _supply: pins.supply,
        }
    }
}

impl Sense for Converters {
    #[inline]
    fn acknowledge(&mut self) {
        pac::ADC1.isr().write(|w| w.set_jeos(true));
    }

    /// The current ends at ±3.2767 A.
    #[inline]
    fn read(&mut self) -> (u16, i16) {
        let read = [pac::ADC1, pac::ADC2].map(|adc| i32::from(adc.jdr(0).read().jdata()));
        let supply = SCALES.supply(pac::ADC1.jdr(1).read().jdata());
        if !pac::TIM1.bdtr().read().moe() {
            for (offset, read) in self.offsets.iter_mut().zip(read) {
                *offset += read - (*offset >> 8);
            }
            let broken = self.offsets.iter().any(|o| !OFFSETS.contains(&(o >> 8)));
            // As large a current as there is: enabling finds it.
            return (supply, if broken { i16::MAX } else { 0 });
        }
        let [u, v] = [0, 1].map(|of: usize| read[of] - (self.offsets[of] >> 8));
        let v_drives = pac::TIM1.ccr(1).read().ccr() > 0;
        (supply, SCALES.current(if v_drives { -u } else { v }))
    }

    #[inline]
    fn is_due(&mut self) -> bool {
        pac::ADC1.isr().read().jeos()
    }
}
