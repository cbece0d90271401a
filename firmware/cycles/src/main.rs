//! Calls every kernel through one stub over one random motion, in QEMU, for `cargo xtask cycles` to record.
//!
//! A stub is a function named `cycles__KERNEL__N` that nothing is inlined into or out of; its instruction path is
//! what is measured. For each, one line says what the recorder cannot see:
//! `kernel NAME N calls COUNT model BYTES state BYTES error PERCENT checksum HEX`. At the end the kernels in whole numbers
//! run on unrecorded, over a million steps: `agreement NAME steps COUNT checksum HEX`.

#![no_std]
#![no_main]

mod alone;
mod checksum;
// A board's flash has no room for the application beside every kernel.
#[cfg(not(feature = "board"))]
mod closed_loop;
#[cfg(not(feature = "board"))]
mod control_task;
mod effects;
mod exported;
mod given;
mod kernels;
#[cfg(all(target_abi = "eabihf", not(feature = "board")))]
mod koopman;
#[cfg_attr(target_arch = "arm", path = "cortex_m.rs")]
#[cfg_attr(target_arch = "riscv32", path = "hazard3.rs")]
mod machine;
mod motion;
#[cfg(all(target_abi = "eabihf", not(feature = "board")))]
mod outer;
mod peers;
mod spent;
mod stub;
mod textbook;
mod tick;
mod truth;

use core::panic::PanicInfo;

/// Prints a line on the machine's console.
#[macro_export]
macro_rules! say {
    ($($what:tt)*) => { $crate::machine::print(format_args!("{}\n", format_args!($($what)*))) };
}

fn run() -> ! {
    if machine::MEASURES {
        if !machine::start_counter() {
            say!(
                "# The core's cycle counter does not count here, as in an emulator: the cycles below mean nothing"
            );
        }
        say!(
            "# Measured with the core's cycle counter, motion seed {:#x}",
            motion::SEED
        );
        say!(
            "kernel,n,instructions_mean,instructions_max,cycles_mean,cycles_worst,cycles_low,cycles_high,cycles_in_tick,\
             floor,flash_bytes,ram_bytes,paths,calls,error"
        );
    } else {
        say!("motion seed {:#x}", motion::SEED);
    }
    peers::run_empty_tick();
    if machine::is_brief() {
        kernels::in_whole_numbers();
        #[cfg(not(feature = "board"))]
        control_task::run();
        machine::exit(true)
    }
    kernels::run();
    effects::run();
    #[cfg(not(feature = "board"))]
    control_task::run();
    #[cfg(all(target_abi = "eabihf", not(feature = "board")))]
    outer::run();
    peers::run();
    if !machine::MEASURES {
        kernels::long_runs(|kernel, checksum| {
            say!(
                "agreement {} steps {} checksum {:016x}",
                kernel,
                kernels::LONG,
                checksum
            );
        });
    }
    machine::exit(true)
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    say!("{}", info);
    machine::exit(false)
}
