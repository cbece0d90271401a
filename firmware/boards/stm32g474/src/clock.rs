//! 170 MHz from the internal oscillator, and what follows from it.

use embassy_stm32::Config;
use embassy_stm32::rcc::{Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk, mux};
use preslide::control::Hardware;

/// The core's clock, and that of the timers (Hz).
const CLOCK_HZ: u32 = 16_000_000 / 4 * 85 / 2;

/// Rate and PWM steps: the timer counts up and down once a tick. Nothing else says either.
pub const HARDWARE: Hardware = Hardware::centre_aligned(CLOCK_HZ, 20_000);

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
