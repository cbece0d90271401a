//! Friction feed-forward on a RISC-V core without a float unit, 20 000 times a second by the core's own time: all is whole numbers, in counts and
//! millinewtons.
//!
//! It is written for QEMU's `virt`, where CI runs it; run on no board. There is no axis: a motion with reversals inside reversals takes its
//! place, and the force is printed. On a chip, an ESP32-C3 or the RISC-V half of an RP2350, [`commanded`] reads what is asked for and [`spend`]
//! sets a PWM or a converter; clock and pins are its HAL's.
//!
//! `rustup target add riscv32imac-unknown-none-elf`, then, in `examples`,
//! `cargo build --release -p riscv-virt --target riscv32imac-unknown-none-elf` and
//! `qemu-system-riscv32 -M virt -nographic -bios none -semihosting-config enable=on,target=native -kernel target/riscv32imac-unknown-none-elf/release/riscv-virt`
#![no_std]
#![no_main]

use panic_halt as _;
use preslide::fixed::types::I16F16;
use preslide::{Friction, Motion, Units};
use riscv::register::time;
use semihosting::{println, process};

// What `preslide export model.toml --kernel … -o stage_model.rs` wrote; yours stands beside this file.
#[rustfmt::skip]
#[path = "../../../cli/tests/exported/packed_i16f16.rs"]
mod stage_model;

/// A displacement of 1 is a count of 25 nm, a force of 1 a millinewton.
const UNITS: Units = Units {
    length: 25e-9,
    force: 1e-3,
    velocity: 1e-3,
};
/// Ticks per second, and the clocks of the core's time per tick: `virt` counts 10 MHz.
const RATE: usize = 20_000;
const CLOCKS: usize = 10_000_000 / RATE;
/// Where the motion turns (counts), at a count per tick; and from one line to the next (ticks).
const TURNS: [i32; 5] = [2000, -1000, 500, -200, 2500];
const EVERY: u32 = 50;

#[riscv_rt::entry]
fn main() -> ! {
    let model: Result<stage_model::Model, _> = stage_model::model(1.0 / RATE as f64, UNITS);
    let Ok(model) = model else {
        println!("the model does not fit these units");
        process::exit(1)
    };
    let mut friction = model.at_rest();
    let (mut place, mut tick, mut due) = (0, 0_u32, time::read());
    while let Some(next) = commanded(tick) {
        due = due.wrapping_add(CLOCKS);
        while due.wrapping_sub(time::read()) <= CLOCKS {}
        let motion = Motion::quasi_static(I16F16::from_num(next - place));
        place = next;
        tick += 1;
        spend(tick, place, model.step(&mut friction, motion));
    }
    process::exit(0)
}

/// The place that is asked for (counts); `None` behind the last turn.
fn commanded(tick: u32) -> Option<i32> {
    let (mut from, mut left) = (0, tick.cast_signed() + 1);
    for to in TURNS {
        let way: i32 = to - from;
        if left <= way.abs() {
            return Some(from + left * way.signum());
        }
        (from, left) = (to, left - way.abs());
    }
    None
}

/// The force (mN) that the motor is to have beside its loop's.
fn spend(tick: u32, place: i32, force: I16F16) {
    if tick.is_multiple_of(EVERY) {
        println!("tick {}: at {} counts {:.3} mN", tick, place, force);
    }
}
