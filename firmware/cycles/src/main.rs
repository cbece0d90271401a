//! Calls every kernel through one stub over one random motion, in QEMU, for `cargo xtask cycles` to record.
//!
//! A stub is a function named `cycles__KERNEL__N` that nothing is inlined into or out of; its instruction path is
//! what is measured. For each, one line says what the recorder cannot see:
//! `kernel NAME N calls COUNT model BYTES state BYTES force_rms NEWTONS checksum HEX`. At the end the kernels in whole numbers
//! run on unrecorded, over a million steps: `agreement NAME steps COUNT checksum HEX`.

#![no_std]
#![no_main]

mod checksum;
mod effects;
mod kernels;
mod motion;
mod peers;
mod spent;
mod stub;
mod tick;

use core::panic::PanicInfo;
use cortex_m::asm::wfi;
use cortex_m_semihosting::{debug, hprintln};

#[cortex_m_rt::entry]
fn main() -> ! {
    if cfg!(feature = "board") {
        if !spent::start_counter() {
            hprintln!(
                "# DWT.CYCCNT does not count here, as in an emulator: the cycles below mean nothing"
            );
        }
        hprintln!(
            "# Measured with DWT.CYCCNT, motion seed {:#x}",
            motion::SEED
        );
        hprintln!(
            "kernel,n,instructions_mean,instructions_max,cycles_mean,cycles_worst,cycles_low,cycles_high,cycles_in_tick,\
             floor,m7_estimate,flash_bytes,ram_bytes,paths,calls"
        );
    } else {
        hprintln!("motion seed {:#x}", motion::SEED);
    }
    peers::run_empty_tick();
    kernels::run();
    effects::run();
    peers::run();
    if !cfg!(feature = "board") {
        kernels::long_runs(|kernel, checksum| {
            hprintln!(
                "agreement {} steps {} checksum {:016x}",
                kernel,
                kernels::LONG,
                checksum
            );
        });
    }
    debug::exit(debug::EXIT_SUCCESS);
    loop {
        wfi();
    }
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    hprintln!("{}", info);
    debug::exit(debug::EXIT_FAILURE);
    loop {
        wfi();
    }
}
