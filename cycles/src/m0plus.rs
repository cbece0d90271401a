//! `cargo xtask cycles --m0plus`: the Cortex-M0+ of the RP2040, by the table of the core's manual.
//!
//! An Armv6-M program is an Armv7-M program too: it runs on the same emulated machine as the Cortex-M4's and takes the same path there as on
//! the Cortex-M0+. The manual gives every instruction one price, so that the cycles are exact but for MRS, MSR and CPS, which
//! no kernel holds, and for what stands outside the core: flash behind a cache, and a second master at the same bank of memory.

use anyhow::Result;
use preslide_tools::thumb::has_target;

use super::instruction::{Class, Instruction};
use super::price::Price;
use super::{Core, Prices, check as check_core};

pub const CORE: Core = Core {
    target: "thumbv6m-none-eabi",
    command: "cargo xtask cycles --m0plus",
    prices: Prices {
        table: "firmware/cycles/cortex-m0plus.csv",
        header: &[
            "Cost of one update on a Cortex-M0+ with the single-cycle multiplier, as in the RP2040, made by `cargo xtask cycles --m0plus`.",
            "QEMU gives the exact instruction paths, and the core's manual has one price for each instruction. Without wait states: code in",
            "flash behind a cache that misses, or two masters at one bank of memory, takes longer. No board has confirmed these figures.",
            "A row's cycles include call and return (`empty_call`). No float unit, no DSP instructions: f32 is software.",
            "cycles_in_tick: by how much a control tick (PID in f32, sensors in memory) grows with the kernel inlined.",
            "calls: the first of the motion of cortex-m4.csv. The C peers are gcc's for this core. Empty columns are not measured.",
        ],
        of_path,
        // No interrupt is recorded on it.
        of_interrupt: of_path,
    },
    is_m4f: false,
};

/// Compares with the committed table where the target is installed.
pub fn check() -> Result<bool> {
    if !has_target(CORE.target) {
        println!(
            "\nSKIPPED: {} was not checked: no Rust target {target}; rustup target add {target}",
            CORE.prices.table,
            target = CORE.target
        );
        return Ok(false);
    }
    check_core(&CORE)
}

/// The price of a path from its first instruction to its return (Cortex-M0+ Technical Reference Manual r0p1, table 3-1).
fn of_path(path: &[(u32, Instruction)]) -> Price {
    let step = |index: usize| {
        let (address, now) = path[index];
        let next = path.get(index + 1).map(|(next, _)| *next);
        of_step(&now, next != Some(address + now.size))
    };
    (0..path.len()).map(step).sum()
}

/// What POP costs more where it loads the program counter.
const POP_TO_PC: u32 = 2;

fn of_step(now: &Instruction, jumps: bool) -> Price {
    let cycles = match now.class {
        Class::Fixed(_) if now.writes_pc() => 2,
        Class::Load | Class::Store => 2,
        Class::Multiple(words) if now.loads_pc() => 1 + words + POP_TO_PC,
        Class::Multiple(words) => 1 + words,
        // BL is the one branch of 32 bits.
        Class::Branch if now.size == 4 => 3,
        Class::Branch if jumps => 2,
        Class::Special | Class::MemoryBarrier | Class::InstructionBarrier => 3,
        _ => 1,
    };
    let is_special = now.class == Class::Special;
    Price::between(if is_special { 1 } else { cycles }, cycles, cycles)
}

#[cfg(test)]
mod tests {
    use super::of_path;
    use crate::instruction::path;

    #[test]
    fn a_path_costs_what_the_manual_says() {
        let path = path(
            0,
            &[
                (2, "push", "{r4, r5, lr}"),
                (2, "ldr", "r0, [r1, #0]"),
                (2, "muls", "r0, r2"),
                (2, "bne.n", "20"),
                (4, "bl", "40"),
                (2, "str", "r0, [r1, #4]"),
                (2, "pop", "{r4, r5, pc}"),
            ],
        );
        let price = of_path(&path);
        assert_eq!(
            (price.cycles, price.low),
            (4 + 2 + 1 + 1 + 3 + 2 + 6, price.cycles)
        );
        let taken = [path[3], (20, path[1].1), path[6]];
        assert_eq!(of_path(&taken).cycles, 2 + 2 + 6);
    }
}
