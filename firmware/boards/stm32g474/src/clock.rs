//! 170 MHz from the internal oscillator, and what follows from it.

use embassy_stm32::Config;
use embassy_stm32::rcc::{Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk, mux};
use preslide::control::Hardware;

/// The core's clock, and that of the timers (Hz).
const CLOCK_HZ: u32 = 16_000_000 / 4 * 85 / 2;

/// What axis.toml says of the bridge and the converters on this board (build.rs).
pub const BOARD: Board = include!(concat!(env!("OUT_DIR"), "/board.rs"));

/// Of the board's table in axis.toml.
pub struct Board {
    /// Dead time (s), and forward voltage of the diodes (V).
    pub dead_time: f64,
    pub diode_drop: f64,
    /// Supply at full scale (V), and current from end to end of the scale (A).
    pub supply_full: f64,
    pub current_span: f64,
}

/// Clocks in which neither gate of a half bridge is on, after each edge: to the nearest. Up to 127 the register takes them as they are.
pub const DEAD_TIME: u16 = {
    let clocks = BOARD.dead_time * CLOCK_HZ as f64 + 0.5;
    assert!(
        clocks < 128.0,
        "dead_time of the board in axis.toml: at most 0.75 µs"
    );
    clocks as u16
};

/// Rate, PWM steps and dead time: the timer counts up and down once a tick. Nothing else says any of them.
pub const HARDWARE: Hardware = Hardware::centre_aligned(CLOCK_HZ, 20_000)
    .with_dead_time(DEAD_TIME as f64 / CLOCK_HZ as f64, BOARD.diode_drop);

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
