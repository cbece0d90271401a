//! 170 MHz from the internal oscillator, and what follows from it.

use embassy_stm32::Config;
use embassy_stm32::rcc::{Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk, mux};
use embassy_stm32::time::Hertz;

/// The control rate and the PWM's.
pub const RATE: Hertz = Hertz(20_000);

/// PWM codes at full duty: timer clocks in a PWM period.
pub const STEPS: u16 = 8500;

/// 16 MHz / 4 · 85 / 2, with the core's boost, which is needed above 150 MHz (RM0440).
pub fn config() -> Config {
    let mut config = Config::default();
    config.rcc.pll = Some(Pll {
        source: PllSource::HSI,
        prediv: PllPreDiv::DIV4,
        mul: PllMul::MUL85,
        divp: None,
        divq: None,
        divr: Some(PllRDiv::DIV2),
    });
    config.rcc.mux.adc12sel = mux::Adcsel::SYS;
    config.rcc.sys = Sysclk::PLL1_R;
    config.rcc.boost = true;
    config
}
