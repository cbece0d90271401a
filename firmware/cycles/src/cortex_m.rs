//! The machine under the kernels: a Cortex-M with semihosting for a console. QEMU's counts no cycles, a board's does.

use core::fmt::Arguments;
use core::sync::atomic::{Ordering, compiler_fence};
#[cfg(feature = "board")]
use cortex_m::{Peripherals, peripheral::DWT};
use cortex_m_semihosting::{debug, hprint};

use crate::spent::Taken;
use crate::stub::{ControlTick, Controller, Step};
use crate::tick::Inputs;

/// It measures itself; otherwise a recorder does from outside.
pub const MEASURES: bool = cfg!(feature = "board");
/// Somebody compares what it prints beside the table's rows.
pub const TELLS: bool = !MEASURES;

#[cortex_m_rt::entry]
fn main() -> ! {
    crate::run()
}

/// Whether only what costs least is to be measured.
pub const fn is_brief() -> bool {
    false
}

pub fn print(text: Arguments) {
    hprint!("{}", text);
}

/// Switches the counter on, and interrupts off for good: nothing else is to be counted. Whether it counts.
pub fn start_counter() -> bool {
    cortex_m::interrupt::disable();
    #[cfg(feature = "board")]
    if let Some(mut core) = Peripherals::take() {
        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();
    }
    cycles_of(|| cortex_m::asm::delay(10)).1 > 0
}

/// A Cortex-M0+ has no counter.
#[inline(always)]
fn cycle_count() -> u32 {
    #[cfg(feature = "board")]
    return DWT::cycle_count();
    #[cfg(not(feature = "board"))]
    return 0;
}

/// Between two readings with `work` between them, less what reading takes.
#[inline(always)]
fn between<R>(work: impl FnOnce() -> R) -> (R, Taken) {
    let ((), reading) = cycles_of(|| ());
    let (result, cycles) = cycles_of(work);
    let taken = Taken {
        cycles: cycles.saturating_sub(reading),
        instructions: None,
    };
    (result, taken)
}

#[inline(always)]
fn cycles_of<R>(work: impl FnOnce() -> R) -> (R, u32) {
    let start = cycle_count();
    compiler_fence(Ordering::SeqCst);
    let result = work();
    compiler_fence(Ordering::SeqCst);
    (result, cycle_count().wrapping_sub(start))
}

/// A kernel's update and what it took.
///
/// # Safety
/// `step` takes these types.
pub unsafe fn update<M, State, S: Copy>(
    step: Step<M, State, S>,
    model: &M,
    state: &mut State,
    [displacement, velocity]: [S; 2],
) -> (S, Taken) {
    // SAFETY: the caller's.
    between(|| unsafe { step(model, state, displacement, velocity) })
}

/// A control tick and what it took.
pub fn tick<M, State, S: Copy>(
    control: ControlTick<M, State, S>,
    model: &M,
    state: &mut State,
    controller: &mut Controller,
    inputs: &Inputs<S>,
) -> (S, Taken) {
    between(|| control(model, state, controller, inputs))
}

pub fn exit(success: bool) -> ! {
    debug::exit(if success {
        debug::EXIT_SUCCESS
    } else {
        debug::EXIT_FAILURE
    });
    loop {
        cortex_m::asm::wfi();
    }
}
