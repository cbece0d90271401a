//! The Cortex-M33: between what its documented differences from the Cortex-M4 could save at best, and the Cortex-M4's prices.
//!
//! It executes the Cortex-M4F's code, so that the paths are the same. Arm publishes no instruction timings for it, and LLVM schedules for
//! it with the Cortex-M4's model. Documented is what differs: it issues two 16-bit instructions at once, a branch among them; addresses are formed, and branches
//! resolved, a stage earlier (Arm's presentation of the core, in Elektronik 2016: elektroniknet.de, "Cortex-M23 und M33 sind erste
//! ARMv8-M-CPUs"; interrupt entry takes 12 cycles as the Cortex-M4's, 21 where the security state changes, which is not in these figures).
//!
//! The dear end *assumes* that no instruction takes longer than on the Cortex-M4, and takes the Cortex-M4's dear answers. The cheap end *assumes* that any two 16-bit
//! instructions in a row pair, that a load takes one cycle, a taken branch two wherever it leads, and a float's product with a sum one.

use super::Prices;
use super::instruction::{Class, Instruction};
use super::price::{self, Price};

pub const PRICES: Prices = Prices {
    table: "firmware/cycles/cortex-m33.csv",
    header: &[
        "A RANGE for one update on a Cortex-M33 without wait states, made by `cargo xtask cycles`: Arm publishes no instruction timings.",
        "The paths are those of cortex-m4.csv. cycles_high, and with it cycles_mean, cycles_worst and cycles_in_tick: the Cortex-M4's prices with",
        "the dear answers, ASSUMING that no instruction takes longer here. cycles_low: pairs of 16-bit instructions issued at once and loads",
        "of one cycle, as far as they could go (xtask/src/cycles/m33.rs says what is documented). Nothing confirms either end.",
    ],
    of_path,
    of_interrupt,
};

fn of_path(path: &[(u32, Instruction)]) -> Price {
    let high = price::of_path(path).high;
    Price {
        cycles: high,
        low: least(path),
        high,
    }
}

fn of_interrupt(path: &[(u32, Instruction)]) -> Price {
    let (own, exception) = (of_path(path), price::of_exception(path));
    Price {
        cycles: own.high + exception.high,
        low: own.low + exception.low,
        high: own.high + exception.high,
    }
}

/// What the path would take if everything documented went as well as it could.
fn least(path: &[(u32, Instruction)]) -> u32 {
    let mut cycles = 0;
    // The instruction before is 16 bits long and has not paired yet.
    let mut waits = false;
    for (index, (address, now)) in path.iter().enumerate() {
        let jumps = path
            .get(index + 1)
            .is_none_or(|(next, _)| *next != address + now.size);
        let pairs = waits && now.size == 2;
        cycles += alone(now, jumps) - u32::from(pairs);
        waits = now.size == 2 && !pairs && !jumps;
    }
    cycles
}

/// Without a partner; at least one cycle, which a partner takes off.
fn alone(now: &Instruction, jumps: bool) -> u32 {
    let taken = match now.class {
        Class::Float(cycles) if cycles > 3 => cycles,
        // Two words over one bus.
        Class::Fixed(3) => 2,
        Class::Multiple(words) => words,
        Class::Divide | Class::InstructionBarrier => 2,
        _ => 1,
    };
    // The refill.
    taken.max(1) + u32::from(jumps)
}

#[cfg(test)]
mod tests {
    use super::of_path;
    use crate::cycles::instruction::path;

    #[test]
    fn short_instructions_pair_and_the_dear_end_is_the_cortex_m4() {
        let path = path(
            0,
            &[
                (2, "ldr", "r0, [r1, #0]"),
                (2, "adds", "r0, r0, r2"),
                (2, "adds", "r0, r0, r3"),
                (4, "mul.w", "r0, r0, r2"),
                (2, "bx", "lr"),
            ],
        );
        let price = of_path(&path);
        assert_eq!((price.low, price.high), (1 + 1 + 1 + 2, 2 + 1 + 1 + 1 + 2));
        assert_eq!(price.cycles, price.high);
    }
}
