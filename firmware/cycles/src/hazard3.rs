//! The machine under the kernels: Hazard3 in the testbench of `cycles/hazard3`, which runs the core's own RTL.

use core::arch::{asm, global_asm};
use core::fmt::{Arguments, Write};

use crate::spent::Taken;
use crate::stub::{ControlTick, Controller, Step};
use crate::tick::Inputs;

/// It measures itself: `mcycle` and `minstret` are the core's.
pub const MEASURES: bool = true;
/// The host compares the checksums that it prints beside the table's rows.
pub const TELLS: bool = true;

/// Registers of the testbench.
const CONSOLE: *mut u8 = 0xf000_0000 as *mut u8;
const END: *mut u32 = 0xf000_0004 as *mut u32;
const BRIEF: *const u32 = 0xf000_0008 as *const u32;

// The image is loaded whole, with zeros where they belong. Counters stand after reset. `tp` points to where C keeps its `errno`.
global_asm!(
    ".section .start, \"ax\"",
    ".globl _start",
    "_start:",
    "la sp, _stack",
    "la tp, _errno",
    "la t0, trapped",
    "csrw mtvec, t0",
    "csrw mcountinhibit, zero",
    "j started",
    ".balign 4",
    "trapped:",
    "li t0, 0xf0000004",
    "li t1, 3",
    "sw t1, 0(t0)",
    "j trapped",
);

// SAFETY: the symbol is this crate's own.
#[unsafe(no_mangle)]
extern "C" fn started() -> ! {
    crate::run()
}

struct Console;

impl Write for Console {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        for byte in text.bytes() {
            // SAFETY: the testbench's register; a byte stored there is printed.
            unsafe { CONSOLE.write_volatile(byte) };
        }
        Ok(())
    }
}

/// Whether only what costs least is to be measured: under memory with wait states.
pub fn is_brief() -> bool {
    // SAFETY: the testbench's register.
    unsafe { BRIEF.read_volatile() != 0 }
}

pub fn print(text: Arguments) {
    let _ = Console.write_fmt(text);
}

/// Whether it counts.
pub fn start_counter() -> bool {
    // SAFETY: a function without arguments, which does nothing.
    unsafe { counted(nothing as *const (), [0; 6]) }.1.cycles > 0
}

extern "C" fn nothing() {}

/// Calls a function with what stands in its argument registers, and counts from the call's first cycle to the end of the return.
///
/// # Safety
/// The function takes and returns what these registers hold.
unsafe fn counted(
    function: *const (),
    [a0, a1, a2, a3, a4, a5]: [usize; 6],
) -> ([usize; 2], Taken) {
    let (low, high): (usize, usize);
    let (cycle, instruction, last_cycle, last_instruction): (u32, u32, u32, u32);
    // SAFETY: the call keeps to the C convention, of which all that it may change is named; reading counters changes nothing.
    unsafe {
        asm!(
            "csrr s2, minstret",
            "csrr s3, mcycle",
            "jalr {function}",
            "csrr a2, mcycle",
            "csrr a3, minstret",
            function = in(reg) function,
            inout("a0") a0 => low,
            inout("a1") a1 => high,
            inout("a2") a2 => last_cycle,
            inout("a3") a3 => last_instruction,
            in("a4") a4,
            in("a5") a5,
            out("s2") instruction,
            out("s3") cycle,
            clobber_abi("C"),
        )
    };
    // Each reading takes a cycle. Of instructions one reading stays in the count (the table's header says so).
    let taken = Taken {
        cycles: last_cycle.wrapping_sub(cycle) - 1,
        instructions: Some(last_instruction.wrapping_sub(instruction) - 2),
    };
    ([low, high], taken)
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
    let (model, state) = (model as *const M as usize, state as *mut State as usize);
    let (d, v) = (words(displacement), words(velocity));
    let arguments = match size_of::<S>() {
        4 => [model, state, d[0], v[0], 0, 0],
        _ => [model, state, d[0], d[1], v[0], v[1]],
    };
    // SAFETY: `step` is a C function of two addresses and two numbers, of a register or a pair each.
    let (force, taken) = unsafe { counted(step as *const (), arguments) };
    (from_words(force), taken)
}

/// A control tick and what it took.
pub fn tick<M, State, S: Copy>(
    control: ControlTick<M, State, S>,
    model: &M,
    state: &mut State,
    controller: &mut Controller,
    inputs: &Inputs<S>,
) -> (S, Taken) {
    let arguments = [
        model as *const M as usize,
        state as *mut State as usize,
        controller as *mut Controller as usize,
        inputs as *const Inputs<S> as usize,
        0,
        0,
    ];
    // SAFETY: `control` is a C function of four addresses.
    let (force, taken) = unsafe { counted(control as *const (), arguments) };
    (from_words(force), taken)
}

/// A number as registers hold it.
fn words<S: Copy>(number: S) -> [usize; 2] {
    const { assert!(size_of::<S>() == 4 || size_of::<S>() == 8) };
    let mut words = [0; 2];
    // SAFETY: both are plain memory, and the words are as long as the number or longer.
    unsafe {
        core::ptr::copy_nonoverlapping(
            (&raw const number).cast::<u8>(),
            words.as_mut_ptr().cast(),
            size_of::<S>(),
        )
    };
    words
}

fn from_words<S: Copy>(words: [usize; 2]) -> S {
    // SAFETY: as above; every pattern of bits is a number.
    unsafe { words.as_ptr().cast::<S>().read_unaligned() }
}

pub fn exit(success: bool) -> ! {
    loop {
        // SAFETY: the testbench's register; it ends the run.
        unsafe { END.write_volatile(u32::from(!success)) };
    }
}
