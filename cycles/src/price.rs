//! What a path costs on a Cortex-M4 without wait states, by the table of its manual.
//!
//! Where the manual leaves the cost open, the price has a range:
//!
//! - a store with no other memory access beside it: 1, or 2 if the write buffer does not hide it;
//! - a division: 2 to 12; taken as 12;
//! - an instruction in an IT block: 1 if its condition fails, which the path does not show; taken as carried out;
//! - an address that the load or store just before has stepped on: pipelined, not pipelined (taken), or late;
//! - MRS, MSR and CPS: 1 or 2 (taken);
//! - DMB and DSB: 1 and what the stores under way still need, which the manual gives no bound for; 1, or up to 4;
//! - ISB: 1 and a refill of the pipeline: 2, or up to 4;
//! - the refill after the return from an interrupt: taken as an instruction's own, or contained in the return's 12.

use std::iter::Sum;
use std::ops::Add;

use super::instruction::{Class, Instruction};

/// Cycles: what the rules say, and the least and the most that they leave open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Price {
    pub cycles: u32,
    pub low: u32,
    pub high: u32,
}

impl Price {
    fn exactly(cycles: u32) -> Self {
        Self::between(cycles, cycles, cycles)
    }

    pub fn between(low: u32, cycles: u32, high: u32) -> Self {
        Self { cycles, low, high }
    }
}

impl Add for Price {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::between(
            self.low + other.low,
            self.cycles + other.cycles,
            self.high + other.high,
        )
    }
}

impl Sum for Price {
    fn sum<I: Iterator<Item = Self>>(prices: I) -> Self {
        prices.fold(Self::default(), Self::add)
    }
}

/// Interrupt entry and return, each: eight registers saved or restored while the handler or the interrupted code is fetched.
const EXCEPTION: u32 = 12;

/// Saving or restoring s0 to s15 and FPSCR, a cycle a word (Arm application note 298). The saving waits for the handler's
/// first float instruction; a handler without one pays for neither.
const FLOAT_FRAME: u32 = 17;

/// The price of an interrupt handler's path, from the interrupted instruction back to it. Tail-chained handlers share an
/// entry and a return and cost less.
pub fn of_interrupt(path: &[(u32, Instruction)]) -> Price {
    of_path(path) + of_exception(path)
}

/// What entry and return add to such a path.
pub fn of_exception(path: &[(u32, Instruction)]) -> Price {
    let mut price = Price::exactly(2 * EXCEPTION);
    if path.last().is_some_and(|(_, last)| last.loads_pc()) {
        price.low -= POP_TO_PC;
    }
    if path.iter().any(|(_, instruction)| instruction.uses_float()) {
        // Nothing if the interrupted task has never used a float.
        price.cycles += 2 * FLOAT_FRAME;
        price.high += 2 * FLOAT_FRAME;
    }
    price
}

/// What a POP or LDR costs more where it loads the program counter.
const POP_TO_PC: u32 = 3;

/// The price of a path from its first instruction to its return.
pub fn of_path(path: &[(u32, Instruction)]) -> Price {
    of_steps(path).sum()
}

/// The price of each instruction on a path.
pub fn of_steps(path: &[(u32, Instruction)]) -> impl Iterator<Item = Price> {
    let step = |index: usize| {
        let before = index.checked_sub(1).map(|before| &path[before].1);
        of_step(before, path[index], path.get(index + 1))
    };
    (0..path.len()).map(step)
}

fn of_step(
    before: Option<&Instruction>,
    (address, now): (u32, Instruction),
    after: Option<&(u32, Instruction)>,
) -> Price {
    // The last instruction of a path returns.
    let jumps = after.is_none_or(|(next, _)| *next != address + now.size);
    // A 32-bit instruction that straddles two words takes two fetches.
    let refill = after.map_or(0, |(next, target)| {
        u32::from(target.size == 4 && next % 4 != 0)
    });
    let mut price = match now.class {
        Class::Fixed(cycles) | Class::Float(cycles) => Price::exactly(cycles),
        Class::Load => load(before, &now),
        Class::Store => {
            let hidden = [before, after.map(|(_, after)| after)]
                .into_iter()
                .flatten()
                .any(|beside| beside.memory);
            Price::between(1, 1, if hidden { 1 } else { 2 })
        }
        Class::Multiple(words) => Price::exactly(1 + words),
        Class::Divide => Price::between(2, 12, 12),
        Class::Branch => Price::exactly(if jumps { 2 + refill } else { 1 }),
        Class::CompareAndBranch => Price::exactly(if jumps { 3 + refill } else { 1 }),
        Class::TableBranch => Price::exactly(4),
        Class::Special => Price::between(1, 2, 2),
        Class::MemoryBarrier => Price::between(1, 1, 4),
        Class::InstructionBarrier => Price::between(2, 2, 4),
        Class::IfThen => Price::exactly(u32::from(before.is_none_or(|before| before.size != 2))),
    };
    if now.loads_pc() && jumps {
        price = price + Price::exactly(POP_TO_PC);
    }
    if let Some(before) = before {
        if now.memory && before.writes & now.address != 0 {
            price = price + Price::exactly(1);
        } else if now.memory && before.updates & now.address != 0 {
            price.high += 1;
        }
        if matches!(before.class, Class::Float(_)) && before.writes & now.reads_float != 0 {
            price = price + Price::exactly(1);
        }
    }
    if now.conditional && !jumps {
        price.low = 1;
    }
    price
}

fn load(before: Option<&Instruction>, now: &Instruction) -> Price {
    match before.filter(|before| before.class == Class::Load) {
        Some(before) if before.writes & now.address != 0 => Price::exactly(2),
        Some(before) if before.updates & now.address != 0 => Price::between(1, 2, 2),
        Some(_) => Price::exactly(1),
        None => Price::exactly(2),
    }
}

#[cfg(test)]
mod tests {
    use super::{Price, of_interrupt, of_path};
    use crate::instruction::{Instruction, path};

    fn price(start: u32, lines: &[(u32, &str, &str)]) -> Price {
        of_path(&path(start, lines))
    }

    const RETURN: (u32, &str, &str) = (2, "bx", "lr");

    #[test]
    fn loads_pipeline_unless_the_address_depends_on_them() {
        let independent = [
            (2, "ldr", "r0, [r2, #0]"),
            (2, "ldr", "r1, [r2, #4]"),
            RETURN,
        ];
        assert_eq!(price(0, &independent).cycles, 2 + 1 + 2);
        let dependent = [
            (2, "ldr", "r0, [r2, #0]"),
            (2, "ldr", "r1, [r0, #4]"),
            RETURN,
        ];
        assert_eq!(price(0, &dependent).cycles, 2 + 3 + 2);
        let computed = [(2, "adds", "r2, #4"), (2, "ldr", "r1, [r2, #4]"), RETURN];
        assert_eq!(price(0, &computed).cycles, 1 + 3 + 2);
    }

    #[test]
    fn a_float_result_is_late_for_the_next_instruction_only() {
        let used = [
            (4, "vmul.f32", "s0, s1, s2"),
            (4, "vadd.f32", "s3, s0, s4"),
            RETURN,
        ];
        assert_eq!(price(0, &used).cycles, 1 + 2 + 2);
        let apart = [
            (4, "vmul.f32", "s0, s1, s2"),
            (2, "nop", ""),
            (4, "vadd.f32", "s3, s0, s4"),
            RETURN,
        ];
        assert_eq!(price(0, &apart).cycles, 1 + 1 + 1 + 2);
    }

    #[test]
    fn an_isolated_store_has_a_range() {
        let isolated = [(2, "movs", "r0, #1"), (2, "str", "r0, [r1, #0]"), RETURN];
        assert_eq!(price(0, &isolated), Price::between(4, 4, 5));
        let hidden = [
            (2, "ldr", "r0, [r1, #0]"),
            (2, "str", "r2, [r1, #4]"),
            RETURN,
        ];
        assert_eq!(price(0, &hidden), Price::between(5, 5, 5));
    }

    #[test]
    fn branches_cost_by_outcome_and_target() {
        let not_taken = [(2, "beq.n", "10"), (2, "nop", ""), RETURN];
        assert_eq!(price(0, &not_taken).cycles, 1 + 1 + 2);
        let wide = Instruction::parse(4, "vadd.f32", "s0, s1, s2", false).unwrap();
        let branch = Instruction::parse(2, "b.n", "10", false).unwrap();
        let back = Instruction::parse(2, "bx", "lr", false).unwrap();
        assert_eq!(
            of_path(&[(0, branch), (8, wide), (12, back)]).cycles,
            2 + 1 + 2
        );
        assert_eq!(
            of_path(&[(0, branch), (10, wide), (14, back)]).cycles,
            3 + 1 + 2
        );
    }

    #[test]
    fn a_frame_costs_what_the_manual_says() {
        let frame = [
            (2, "push", "{r7, lr}"),
            (2, "mov", "r7, sp"),
            (2, "pop", "{r7, pc}"),
        ];
        assert_eq!(price(0, &frame).cycles, 3 + 1 + (3 + 3));
    }

    #[test]
    fn it_folds_into_a_short_instruction() {
        let folded = [(2, "cmp", "r0, #0"), (2, "it", "eq"), RETURN];
        assert_eq!(price(0, &folded).cycles, 1 + 2);
        let alone = [(4, "cmp.w", "r0, #0"), (2, "it", "eq"), RETURN];
        assert_eq!(price(0, &alone).cycles, 1 + 1 + 2);
    }

    #[test]
    fn an_interrupt_costs_its_entry_and_return_and_float_registers_where_it_uses_them() {
        let handler = |middle: (&str, &str)| {
            [
                (2, "push", "{r7, lr}"),
                (4, middle.0, middle.1),
                (2, "pop", "{r7, pc}"),
            ]
            .map(|(size, name, operands)| {
                (0, Instruction::parse(size, name, operands, false).unwrap())
            })
        };
        let plain = of_interrupt(&handler(("nop", "")));
        assert_eq!((plain.low, plain.cycles, plain.high), (31, 34, 34));
        let float = of_interrupt(&handler(("vadd.f32", "s0, s1, s2")));
        assert_eq!((float.low, float.cycles, float.high), (31, 68, 68));
    }
}
