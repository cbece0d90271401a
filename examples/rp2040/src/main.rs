//! Friction feed-forward for a drive that is commanded by a voltage, on a Raspberry Pi Pico: the commanded velocity on GPIO 26 in, a PWM on
//! GPIO 15 out, 20 000 times a second. The PWM, filtered, is the torque offset that many servo amplifiers take: half of it is none.
//!
//! A Cortex-M0+ has no float unit: all is whole numbers, in counts and millinewtons. Built in CI, run on no board.
//! `cargo build --release -p rp2040 --target thumbv6m-none-eabi`
#![no_std]
#![no_main]

use embedded_hal::pwm::SetDutyCycle;
use hal::fugit::ExtU32;
use panic_halt as _;
use preslide::fixed::types::I16F16;
use preslide::{Friction, Motion, Units};
use rp2040_hal as hal;

// What `preslide export model.toml --kernel … -o stage_model.rs` wrote; yours stands beside this file.
#[rustfmt::skip]
#[path = "../../../cli/tests/exported/packed_i16f16.rs"]
mod stage_model;

#[unsafe(link_section = ".boot2")]
#[used]
static BOOT2: [u8; 256] = rp2040_boot2::BOOT_LOADER_GENERIC_03H;

/// Commanded velocity at either end of the converter (counts of 25 nm per tick of 50 µs: 10 mm/s), with none in the middle.
const FASTEST: I16F16 = I16F16::lit("20");
const UNITS: Units = Units {
    length: 25e-9,
    force: 1e-3,
    velocity: 1e-3,
};
/// The whole PWM, from end to end (mN at the stage), and its steps at 125 MHz.
const FORCE_SPAN: I16F16 = I16F16::lit("10000");
const STEPS: u16 = 6250;

#[hal::entry]
fn main() -> ! {
    let mut p = hal::pac::Peripherals::take().unwrap();
    let mut watchdog = hal::Watchdog::new(p.WATCHDOG);
    let clocks = hal::clocks::init_clocks_and_plls(
        12_000_000,
        p.XOSC,
        p.CLOCKS,
        p.PLL_SYS,
        p.PLL_USB,
        &mut p.RESETS,
        &mut watchdog,
    );
    let Ok(clocks) = clocks else {
        panic!("the crystal does not start")
    };
    let sio = hal::Sio::new(p.SIO);
    let pins = hal::gpio::Pins::new(p.IO_BANK0, p.PADS_BANK0, sio.gpio_bank0, &mut p.RESETS);
    let mut pwm = hal::pwm::Slices::new(p.PWM, &mut p.RESETS).pwm7;
    pwm.set_top(STEPS - 1);
    pwm.channel_b.output_to(pins.gpio15);
    let _ = pwm.channel_b.set_duty_cycle(STEPS / 2);
    pwm.enable();
    let mut adc = hal::Adc::new(p.ADC, &mut p.RESETS);
    let mut command = hal::adc::AdcPin::new(pins.gpio26.into_floating_input()).unwrap();
    let timer = hal::Timer::new(p.TIMER, &mut p.RESETS, &clocks);

    let model: stage_model::Model = stage_model::model(50e-6, UNITS).expect("it fits these units");
    let mut friction = model.at_rest();
    let mut due = timer.get_counter();
    loop {
        due += 50.micros::<1, 1_000_000>();
        while timer.get_counter() < due {}
        let code: u16 = adc.read(&mut command).unwrap_or(2048);
        let part = I16F16::from_bits((i32::from(code) - 2048) << 5); // −1…1
        let force = model.step(&mut friction, Motion::quasi_static(part * FASTEST));
        let duty = I16F16::from_num(0.5) + force / FORCE_SPAN;
        let duty = duty.clamp(I16F16::ZERO, I16F16::ONE) * I16F16::from_num(STEPS);
        let _ = pwm.channel_b.set_duty_cycle(duty.to_num());
    }
}
