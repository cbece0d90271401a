//! The program as `arm-none-eabi-objdump -d` prints it: functions and their instructions.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use anyhow::{Context as _, Result, anyhow};
use preslide_tools::objdump::{self, Line};
use preslide_tools::process::{command, output};

use super::instruction::Instruction;
use super::recorder::TakenPath;

#[derive(Default)]
pub struct Disassembly {
    /// By address. What has no price is an error only once a path runs over it.
    instructions: HashMap<u32, Result<Instruction>>,
    /// Mnemonic and operands, as objdump prints them.
    texts: HashMap<u32, String>,
    /// Name and length in bytes, literals included, by start address.
    functions: BTreeMap<u32, (String, u32)>,
}

impl Disassembly {
    pub fn of(program: &Path) -> Result<Self> {
        let listing = output(command("arm-none-eabi-objdump -d").arg(program))?;
        Ok(Self::parse(&listing))
    }

    fn parse(listing: &str) -> Self {
        let mut disassembly = Self::default();
        let mut start = 0;
        let mut conditional = 0;
        for line in objdump::lines(listing) {
            let (address, size, mnemonic, operands) = match line {
                Line::Label { address, name } => {
                    start = address;
                    conditional = 0;
                    disassembly.functions.insert(start, (name.to_string(), 0));
                    continue;
                }
                Line::Code {
                    address,
                    bytes,
                    operation,
                    operands,
                } => (address, bytes, operation, operands),
            };
            if let Some((_, length)) = disassembly.functions.get_mut(&start) {
                *length = address + size - start;
            }
            if mnemonic.starts_with('.') {
                continue; // a literal
            }
            let instruction = Instruction::parse(size, mnemonic, operands, conditional > 0);
            disassembly.instructions.insert(address, instruction);
            let text = format!("{mnemonic}\t{operands}");
            disassembly.texts.insert(address, text);
            // `itte` makes the next three conditional: one for each letter after the i.
            let is_it = mnemonic.starts_with("it");
            conditional = if is_it {
                mnemonic.len() - 1
            } else {
                conditional.saturating_sub(1)
            };
        }
        disassembly
    }

    pub fn instruction(&self, address: u32) -> Result<&Instruction> {
        let found = self.instructions.get(&address).with_context(|| {
            format!("the path runs over {address:#x}, which objdump shows no instruction for")
        })?;
        found.as_ref().map_err(|reason| anyhow!("{reason}"))
    }

    /// The instructions of a path, with their addresses.
    pub fn steps(&self, path: &TakenPath) -> Result<Vec<(u32, Instruction)>> {
        let mut steps = Vec::new();
        for &(first, last) in &path.stretches {
            let mut address = first;
            while address <= last {
                let instruction = self.instruction(address)?;
                steps.push((address, *instruction));
                address += instruction.size;
            }
        }
        Ok(steps)
    }

    pub fn text(&self, address: u32) -> Option<&str> {
        self.texts.get(&address).map(String::as_str)
    }

    /// Start address of each function whose name begins with `prefix`, and the rest of its name.
    pub fn functions_named<'a>(&'a self, prefix: &'a str) -> impl Iterator<Item = (u32, &'a str)> {
        self.functions
            .iter()
            .filter_map(move |(start, (name, _))| Some((*start, name.strip_prefix(prefix)?)))
    }

    /// Start and length of the function that holds the address.
    pub fn function_at(&self, address: u32) -> Option<(u32, u32)> {
        self.functions
            .range(..=address)
            .next_back()
            .map(|(start, (_, length))| (*start, *length))
    }
}

#[cfg(test)]
mod tests {
    use super::Disassembly;

    #[test]
    fn reads_functions_and_it_blocks() {
        let listing = "\n00000100 <cycles__kernel__6>:\n     100:\tbf4c      \tite\tmi\n     102:\t2301      \tmovmi\tr3, #1\n     \
                       104:\t2300      \tmovpl\tr3, #0\n     106:\ted91 1a00 \tvldr\ts2, [r1]\n     10a:\t4770      \t\
                       bx\tlr\n     10c:\t00000000 \t.word\t0x00000000\n";
        let disassembly = Disassembly::parse(listing);
        let named: Vec<_> = disassembly.functions_named("cycles__").collect();
        assert_eq!(named, [(0x100, "kernel__6")]);
        assert_eq!(disassembly.function_at(0x10a), Some((0x100, 0x10)));
        let conditional = |address| disassembly.instruction(address).unwrap().conditional;
        assert_eq!(
            [0x102, 0x104, 0x106, 0x10a].map(conditional),
            [true, true, false, false]
        );
        assert!(disassembly.instruction(0x10c).is_err());
    }
}
