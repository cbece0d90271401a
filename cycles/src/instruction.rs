//! One Thumb-2 instruction as objdump prints it, reduced to what its price depends on.

use anyhow::{Context as _, Result};
use preslide_tools::objdump::without_condition;

/// Registers as bits: r0 to pc in 0 to 15, s0 to s31 in 16 to 47.
pub type Registers = u64;

const SP: Registers = 1 << 13;
const PC: Registers = 1 << 15;

/// What an instruction costs, apart from what stands around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Always the same.
    Fixed(u32),
    /// Always the same, but a result that the next instruction uses comes a cycle late.
    Float(u32),
    /// LDR: one cycle less right behind another.
    Load,
    /// STR: a write buffer may hide a part.
    Store,
    /// LDM, STM, PUSH, POP and their float forms of so many words.
    Multiple(u32),
    /// SDIV, UDIV: ends early for small quotients.
    Divide,
    Branch,
    CompareAndBranch,
    TableBranch,
    /// IT, which folds into a 16-bit instruction before it.
    IfThen,
    /// MRS, MSR, CPS.
    Special,
    /// DMB, DSB: waits for stores under way.
    MemoryBarrier,
    /// ISB: refills the pipeline.
    InstructionBarrier,
}

/// What the price of a path needs to know of each instruction on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instruction {
    /// 2 or 4 bytes.
    pub size: u32,
    pub class: Class,
    /// Inside an IT block: it may pass without effect.
    pub conditional: bool,
    /// Registers that get a result.
    pub writes: Registers,
    /// Address registers that a load or store changes by the way.
    pub updates: Registers,
    pub reads_float: Registers,
    /// Registers that form an address.
    pub address: Registers,
    /// Accesses memory.
    pub memory: bool,
}

impl Instruction {
    pub fn uses_float(&self) -> bool {
        (self.writes | self.reads_float) >> 16 != 0
    }

    pub fn writes_pc(&self) -> bool {
        self.writes & PC != 0
    }

    pub fn loads_pc(&self) -> bool {
        self.memory && self.writes_pc()
    }

    /// Reads mnemonic and operands; `conditional` says that it stands in an IT block.
    pub fn parse(size: u32, mnemonic: &str, operands: &str, conditional: bool) -> Result<Self> {
        let (name, kind) = mnemonic.split_once('.').unwrap_or((mnemonic, ""));
        let name = if conditional {
            without_condition(name)
        } else {
            name
        };
        let class = class_of(name, operands).with_context(|| {
            format!("no price for `{mnemonic} {operands}`; add it to cycles/src/instruction.rs")
        })?;
        let words: Vec<Registers> = split_operands(operands).map(registers_in).collect();
        let word = |index: usize| words.get(index).copied().unwrap_or(0);
        let all = words.iter().fold(0, |sum, word| sum | word);

        let is_list = ["ldm", "stm", "vldm", "vstm"]
            .iter()
            .any(|start| name.starts_with(start));
        let is_stack = ["push", "pop", "vpush", "vpop"].contains(&name);
        let address = if is_stack {
            SP
        } else if is_list {
            word(0)
        } else {
            operands.split_once('[').map_or(0, |(_, rest)| {
                registers_in(rest.split(']').next().unwrap_or(""))
            }) & !PC
        };
        let memory = is_stack || is_list || operands.contains('[') && class != Class::TableBranch;
        let writes_back = is_stack || operands.contains('!') || operands.contains("],");
        let writes = match name {
            "pop" | "vpop" => all,
            _ if is_list && name.contains("ld") => all & !word(0),
            _ if memory && (name.contains("st") || name.contains("push")) => 0,
            "cmp" | "cmn" | "tst" | "teq" | "vcmp" | "vcmpe" | "nop" | "msr" | "cpsid"
            | "cpsie" | "dmb" | "dsb" | "isb" => 0,
            "umull" | "smull" | "umlal" | "smlal" | "umaal" | "smlald" | "ldrd" => {
                word(0) | word(1)
            }
            "vmov" if kind.is_empty() && words.len() == 3 && word(0) < 1 << 16 => word(0) | word(1),
            _ if matches!(
                class,
                Class::Branch | Class::CompareAndBranch | Class::TableBranch | Class::IfThen
            ) =>
            {
                0
            }
            _ => word(0),
        };
        // A multiply-accumulate, and what writes nothing, reads its first operand too.
        let accumulates = matches!(class, Class::Float(3));
        let sources = words.iter().skip(1).fold(0, |sum, word| sum | word);
        let reads = if accumulates || writes == 0 {
            all
        } else {
            sources
        };
        Ok(Self {
            size,
            class,
            conditional,
            writes,
            updates: if writes_back { address } else { 0 },
            reads_float: if memory && writes != 0 {
                0
            } else {
                reads >> 16 << 16
            },
            address,
            memory,
        })
    }
}

/// The cycle table of the Arm Cortex-M4 Technical Reference Manual (r0p1, sections 3.3 and 7.2.3).
fn class_of(name: &str, operands: &str) -> Option<Class> {
    let count = || {
        let list = operands.split_once('{').map_or("", |(_, rest)| rest);
        registers_in(list).count_ones()
    };
    Some(match name {
        "it" | "itt" | "ite" | "ittt" | "itte" | "itet" | "itee" | "itttt" | "ittte" | "ittet"
        | "ittee" | "itett" | "itete" | "iteet" | "iteee" => Class::IfThen,
        "cbz" | "cbnz" => Class::CompareAndBranch,
        "tbb" | "tbh" => Class::TableBranch,
        "b" | "bl" | "bx" | "blx" => Class::Branch,
        "mov" if operands.starts_with("pc,") => Class::Branch,
        "sdiv" | "udiv" => Class::Divide,
        "ldrd" | "strd" => Class::Fixed(3),
        _ if name.starts_with("ldm") || name.starts_with("stm") => Class::Multiple(count()),
        _ if name.starts_with("vldm") || name.starts_with("vstm") => Class::Multiple(count()),
        "push" | "pop" | "vpush" | "vpop" => Class::Multiple(count()),
        "ldr" | "ldrb" | "ldrh" | "ldrsb" | "ldrsh" | "ldrex" => Class::Load,
        "str" | "strb" | "strh" | "strex" => Class::Store,
        "vldr" | "vstr" if operands.starts_with('d') => Class::Fixed(3),
        "vldr" | "vstr" => Class::Fixed(2),
        "vadd" | "vsub" | "vmul" | "vnmul" | "vcvt" | "vcvtr" => Class::Float(1),
        "vmla" | "vmls" | "vnmla" | "vnmls" | "vfma" | "vfms" | "vfnma" | "vfnms" => {
            Class::Float(3)
        }
        "vdiv" | "vsqrt" => Class::Float(14),
        "vmov" if split_operands(operands).count() == 3 => Class::Fixed(2),
        "vmov" | "vneg" | "vabs" | "vcmp" | "vcmpe" | "vmrs" | "vmsr" => Class::Fixed(1),
        "mrs" | "msr" | "cpsid" | "cpsie" => Class::Special,
        "dmb" | "dsb" => Class::MemoryBarrier,
        "isb" => Class::InstructionBarrier,
        _ if is_condition_branch(name) => Class::Branch,
        _ if is_single_cycle(name) => Class::Fixed(1),
        _ => return None,
    })
}

pub fn is_condition_branch(name: &str) -> bool {
    name.len() == 3 && name.starts_with('b') && without_condition(name) == "b"
}

fn is_single_cycle(name: &str) -> bool {
    const DSP: &[&str] = &[
        "smul", "smla", "smls", "smml", "smmu", "smuad", "smusd", "umull", "umlal", "umaal",
    ];
    const PARALLEL: &[&str] = &["q", "s", "u", "sh", "uh", "uq"];
    const PARALLEL_OPERATIONS: &[&str] = &["add16", "sub16", "add8", "sub8", "asx", "sax"];
    const PLAIN: &[&str] = &[
        "mov", "movw", "movt", "mvn", "add", "addw", "adc", "sub", "subw", "sbc", "rsb", "neg",
        "and", "orr", "orn", "eor", "bic", "lsl", "lsr", "asr", "ror", "rrx", "mul", "mla", "mls",
    ];
    const OTHER: &[&str] = &[
        "cmp", "cmn", "tst", "teq", "nop", "adr", "clz", "rbit", "rev", "rev16", "revsh", "bfi",
        "bfc", "ubfx", "sbfx", "uxtb", "uxth", "uxtb16", "uxtab", "uxtah", "uxtab16", "sxtb",
        "sxth", "sxtb16", "sxtab", "sxtah", "sxtab16", "ssat", "usat", "ssat16", "usat16", "qadd",
        "qsub", "qdadd", "qdsub", "pkhbt", "pkhtb", "sel", "usad8", "usada8",
    ];
    let parallel = || {
        PARALLEL_OPERATIONS.iter().any(|end| {
            name.strip_suffix(end)
                .is_some_and(|start| PARALLEL.contains(&start))
        })
    };
    OTHER.contains(&name)
        || PLAIN.contains(&name)
        || name
            .strip_suffix('s')
            .is_some_and(|name| PLAIN.contains(&name))
        || DSP.iter().any(|start| name.starts_with(start))
        || parallel()
}

/// Splits at the commas outside brackets and braces.
fn split_operands(operands: &str) -> impl Iterator<Item = &str> {
    let mut depth = 0;
    operands
        .split(move |letter: char| {
            match letter {
                '[' | '{' => depth += 1,
                ']' | '}' => depth -= 1,
                _ => {}
            }
            letter == ',' && depth == 0
        })
        .map(str::trim)
        .filter(|operand| !operand.is_empty())
}

/// Every register named in the text, ranges like `s16-s19` included.
fn registers_in(text: &str) -> Registers {
    let words = text.split(|letter: char| !letter.is_ascii_alphanumeric() && letter != '-');
    words.fold(0, |sum, word| sum | range(word))
}

fn range(word: &str) -> Registers {
    match word.split_once('-') {
        None => register(word),
        Some((first, last)) => {
            let (first, last) = (register(first), register(last));
            if first == 0 || last < first {
                return 0;
            }
            // All bits from the lowest of `first` to the highest of `last`.
            let top = 64 - last.leading_zeros();
            (u64::MAX >> (64 - top)) & (u64::MAX << first.trailing_zeros())
        }
    }
}

fn register(word: &str) -> Registers {
    match word {
        "sb" => return 1 << 9,
        "sl" => return 1 << 10,
        "fp" => return 1 << 11,
        "ip" => return 1 << 12,
        "sp" => return SP,
        "lr" => return 1 << 14,
        "pc" => return PC,
        _ => {}
    }
    let Some((bank, number)) = word.split_at_checked(1) else {
        return 0;
    };
    match (bank, number.parse::<u32>()) {
        ("r", Ok(n)) if n < 16 => 1 << n,
        ("s", Ok(n)) if n < 32 => 1 << (16 + n),
        ("d", Ok(n)) if n < 16 => 0b11 << (16 + 2 * n),
        _ => 0,
    }
}

/// Instructions as (size, mnemonic, operands), one behind the other from `start`.
#[cfg(test)]
pub fn path(start: u32, lines: &[(u32, &str, &str)]) -> Vec<(u32, Instruction)> {
    let mut next = start;
    let step = |&(size, mnemonic, operands): &(u32, &str, &str)| {
        let instruction = Instruction::parse(size, mnemonic, operands, false).unwrap();
        next += size;
        (next - size, instruction)
    };
    lines.iter().map(step).collect()
}

#[cfg(test)]
mod tests {
    use super::{Class, Instruction, PC, SP};

    fn parsed(mnemonic: &str, operands: &str) -> Instruction {
        Instruction::parse(4, mnemonic, operands, false).unwrap()
    }

    #[test]
    fn reads_registers_of_loads_and_stores() {
        let load = parsed("ldr.w", "r1, [r0, r2, lsl #2]");
        assert_eq!((load.writes, load.address, load.updates), (0b010, 0b101, 0));
        let updating = parsed("vldmia", "r3!, {s15}");
        assert_eq!(
            (updating.writes, updating.updates, updating.class),
            (1 << 31, 0b1000, Class::Multiple(1))
        );
        let pop = parsed("pop", "{r4, r5, pc}");
        assert_eq!((pop.class, pop.updates), (Class::Multiple(3), SP));
        assert!(pop.loads_pc());
        let push = parsed("vpush", "{d8-d9}");
        assert_eq!(
            (push.class, push.writes, push.reads_float),
            (Class::Multiple(4), 0, 0b1111 << 32)
        );
        let literal = parsed("vldr", "s0, [pc, #20]");
        assert_eq!(
            (literal.writes & PC, literal.address, literal.reads_float),
            (0, 0, 0)
        );
    }

    #[test]
    fn a_multiply_accumulate_reads_its_destination_and_an_addition_does_not() {
        assert_eq!(
            parsed("vmla.f32", "s0, s2, s6").reads_float,
            0b100_0101 << 16
        );
        assert_eq!(
            parsed("vadd.f32", "s0, s2, s6").reads_float,
            0b100_0100 << 16
        );
        assert_eq!(
            parsed("vadd.f32", "s0, s0, s6").reads_float,
            0b100_0001 << 16
        );
        assert_eq!(parsed("vmov", "r2, r3, d0").writes, 0b1100);
    }

    #[test]
    fn conditions_are_stripped_only_inside_it_blocks() {
        let skipped = Instruction::parse(2, "movls", "r0, #1", true).unwrap();
        assert_eq!(
            (skipped.class, skipped.conditional),
            (Class::Fixed(1), true)
        );
        assert_eq!(parsed("muls", "r0, r1").class, Class::Fixed(1));
        assert_eq!(parsed("bls.n", "27912").class, Class::Branch);
        assert_eq!(parsed("bl", "265cc").class, Class::Branch);
    }

    #[test]
    fn what_interrupt_handlers_use_has_a_class() {
        assert_eq!(parsed("msr", "BASEPRI, r0").class, Class::Special);
        assert_eq!(parsed("cpsid", "i").class, Class::Special);
        assert_eq!(parsed("isb", "sy").class, Class::InstructionBarrier);
        let skipped = Instruction::parse(4, "dmbne", "sy", true).unwrap();
        assert_eq!(skipped.class, Class::MemoryBarrier);
        assert!(parsed("vmov", "s0, r0").uses_float() && parsed("vstr", "s0, [r1]").uses_float());
        assert!(!parsed("ldr", "r0, [r1, #4]").uses_float());
    }

    #[test]
    fn an_unknown_instruction_is_an_error() {
        assert!(
            Instruction::parse(4, "wibble", "r0", false)
                .unwrap_err()
                .to_string()
                .contains("no price for `wibble r0`")
        );
    }
}
