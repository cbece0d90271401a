//! How long the code of a RISC-V program's functions is, with all that they can call.
//!
//! The testbench records no paths, so that what is counted is what a function can reach: cold branches and what they call as well.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use crate::process::output;

struct Function {
    name: String,
    bytes: u32,
    /// Addresses that it jumps to.
    targets: BTreeSet<u32>,
}

/// By start address.
pub struct Sizes(BTreeMap<u32, Function>);

impl Sizes {
    pub fn of(program: &Path) -> Result<Self, String> {
        let mut objdump = Command::new("riscv64-unknown-elf-objdump");
        Ok(Self::parse(&output(objdump.arg("-d").arg(program))?))
    }

    fn parse(listing: &str) -> Self {
        let mut functions: BTreeMap<u32, Function> = BTreeMap::new();
        for line in listing.lines() {
            if let Some((address, name)) = label(line) {
                let function = Function {
                    name: name.to_string(),
                    bytes: 0,
                    targets: BTreeSet::new(),
                };
                functions.insert(address, function);
                continue;
            }
            // `20000060:⇥016080e7          ⇥jalr⇥22(ra) # 200a5072 <name>`
            let columns: Vec<&str> = line.split('\t').map(str::trim).collect();
            if let ([_, code, operation, operands @ ..], Some(mut last)) =
                (&columns[..], functions.last_entry())
            {
                let function = last.get_mut();
                function.bytes += code.len() as u32 / 2;
                if operation.starts_with(['j', 'b']) {
                    function
                        .targets
                        .extend(operands.iter().filter_map(|operands| target(operands)));
                }
            }
        }
        Self(functions)
    }

    /// Bytes of a function and of all that it can reach.
    pub fn reached_from(&self, name: &str) -> Result<u32, String> {
        let start = self.0.iter().find(|(_, function)| function.name == name);
        let (start, _) = start.ok_or_else(|| format!("the program has no function {name}"))?;
        let mut seen = BTreeSet::new();
        let mut open = vec![*start];
        let mut bytes = 0;
        while let Some(address) = open.pop() {
            if let Some((start, function)) = self.0.range(..=address).next_back()
                && seen.insert(*start)
            {
                bytes += function.bytes;
                open.extend(&function.targets);
            }
        }
        Ok(bytes)
    }
}

/// `20000de0 <name>:`; gcc's `.L12` begins no function.
fn label(line: &str) -> Option<(u32, &str)> {
    let (address, name) = line.strip_suffix(">:")?.split_once(" <")?;
    let address = u32::from_str_radix(address, 16).ok()?;
    (!name.starts_with('.')).then_some((address, name))
}

/// The address in `a0,20000de0 <name+0x12>`.
fn target(operands: &str) -> Option<u32> {
    let (before, _) = operands.split_once(" <")?;
    let address = before.rsplit([',', ' ']).next()?;
    u32::from_str_radix(address, 16).ok()
}

#[cfg(test)]
mod tests {
    use super::Sizes;

    #[test]
    fn a_function_counts_with_what_it_can_reach_once() {
        let listing = "\n20000000 <a>:\n20000000:\t00000097          \tauipc\tra,0x0\n20000004:\t008080e7          \tjalr\t8(ra) # 20000008 <b>\n\
                       \n20000008 <b>:\n\n20000008 <.L1>:\n20000008:\tdd7d                \tbeqz\ta0,20000000 <a+0x4>\n2000000a:\t8082                \tret\n\
                       \n2000000c <c>:\n2000000c:\t8082                \tret\n";
        let sizes = Sizes::parse(listing);
        assert_eq!(sizes.reached_from("a"), Ok(12));
        assert_eq!(sizes.reached_from("c"), Ok(2));
        assert!(sizes.reached_from("d").is_err());
    }
}
