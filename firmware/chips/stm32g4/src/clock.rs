//! 170 MHz from the internal oscillator, and what follows from it.

use embassy_stm32::Config;
use embassy_stm32::rcc::{Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk, mux};
use preslide::control::Hardware;
use preslide_app::Board;

/// The core's clock, and that of the timers (Hz).
const CLOCK_HZ: u32 = 16_000_000 / 4 * 85 / 2;

/// Clocks in which neither gate of a half bridge is on, after each edge: to the nearest. Up to 127 the register takes them as they are.
pub(crate) const fn dead_clocks(dead_time: f64) -> u16 {
    let clocks = dead_time * CLOCK_HZ as f64 + 0.5;
    assert!(
        clocks < 128.0,
        "dead_time of the board in axis.toml: at most 0.75 µs"
    );
    clocks as u16
}

/// Rate, PWM steps and dead time: the timer counts up and down once a tick. Nothing else says any of them.
///
/// # Panics
/// Where the dead time is longer than the register takes: in a constant, that is a compile error.
pub const fn hardware(board: &Board) -> Hardware {
    let dead_time = dead_clocks(board.dead_time) as f64 / CLOCK_HZ as f64;
    Hardware::centre_aligned(CLOCK_HZ, 20_000).with_dead_time(dead_time, board.diode_drop)
}

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
