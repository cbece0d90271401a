//! What `objdump -d` prints of a program, Arm's or RISC-V's: its functions, their code and where it leads.

use std::collections::{BTreeMap, BTreeSet};

/// A line of it.
pub enum Line<'a> {
    /// `000174b8 <name>:`, where a function begins.
    Label {
        /// Its first instruction's.
        address: u32,
        /// As the program has it, mangled or not.
        name: &'a str,
    },
    /// `   174b8:⇥BYTES⇥OPERATION⇥OPERANDS`, an instruction or a literal.
    Code {
        /// Where it stands.
        address: u32,
        /// How long it is.
        bytes: u32,
        /// The mnemonic.
        operation: &'a str,
        /// Registers, numbers and targets.
        operands: &'a str,
    },
}

/// Its lines but for headings and blanks.
pub fn lines(listing: &str) -> impl Iterator<Item = Line<'_>> {
    listing
        .lines()
        .filter_map(|line| label(line).or_else(|| code(line)))
}

fn label(line: &str) -> Option<Line<'_>> {
    let (address, name) = line.strip_suffix(">:")?.split_once(" <")?;
    let address = u32::from_str_radix(address, 16).ok()?;
    // gcc's `.L12` begins no function.
    (!name.starts_with('.')).then_some(Line::Label { address, name })
}

fn code(line: &str) -> Option<Line<'_>> {
    let mut columns = line.split('\t').map(str::trim);
    let address = columns.next()?.strip_suffix(':')?;
    let digits = columns.next()?.bytes().filter(u8::is_ascii_hexdigit);
    Some(Line::Code {
        address: u32::from_str_radix(address, 16).ok()?,
        bytes: digits.count() as u32 / 2,
        operation: columns.next()?,
        operands: columns.next().unwrap_or(""),
    })
}

/// The address in `393e <name+0x12>`, `a0,20000de0 <name>` or `22(ra) # 200a5072 <name>`.
fn target(operands: &str) -> Option<u32> {
    let (before, _) = operands.split_once(" <")?;
    let address = before.rsplit([',', ' ']).next()?;
    u32::from_str_radix(address, 16).ok()
}

/// An operation of Arm without its condition.
pub fn without_condition(name: &str) -> &str {
    const CONDITIONS: [&str; 16] = [
        "eq", "ne", "cs", "cc", "mi", "pl", "vs", "vc", "hi", "ls", "ge", "lt", "gt", "le", "hs",
        "lo",
    ];
    CONDITIONS
        .iter()
        .find_map(|condition| name.strip_suffix(condition))
        .unwrap_or(name)
}

/// A function.
pub struct Function {
    /// As the program has it, mangled or not.
    pub name: String,
    /// Of its code, literals included.
    pub bytes: u32,
    /// Where it jumps to.
    targets: BTreeSet<u32>,
    /// It calls what a register holds, which nobody can follow.
    pub calls_a_register: bool,
}

/// The functions of a program, by where they begin.
pub struct Functions(BTreeMap<u32, Function>);

impl Functions {
    /// `jumps` says of an operation whether it goes to its operand.
    pub fn of(listing: &str, jumps: impl Fn(&str) -> bool) -> Self {
        let mut functions = BTreeMap::new();
        for line in lines(listing) {
            match line {
                Line::Label { address, name } => {
                    let function = Function {
                        name: name.to_owned(),
                        bytes: 0,
                        targets: BTreeSet::new(),
                        calls_a_register: false,
                    };
                    functions.insert(address, function);
                }
                Line::Code {
                    bytes,
                    operation,
                    operands,
                    ..
                } => {
                    let Some(mut last) = functions.last_entry() else {
                        continue;
                    };
                    let (function, target) = (last.get_mut(), target(operands));
                    function.bytes += bytes;
                    function.calls_a_register |= operation.starts_with("blx") && target.is_none();
                    function.targets.extend(target.filter(|_| jumps(operation)));
                }
            }
        }
        Self(functions)
    }

    /// Where a function begins.
    pub fn address(&self, name: &str) -> Option<u32> {
        let found = self.0.iter().find(|(_, function)| function.name == name);
        found.map(|(address, _)| *address)
    }

    /// Those that the function at `start` can reach, itself included; those that begin in `beyond` are not followed.
    pub fn reached(&self, start: u32, beyond: &[u32]) -> BTreeMap<u32, &Function> {
        let (mut seen, mut open) = (BTreeMap::new(), vec![start]);
        while let Some(address) = open.pop() {
            if let Some((address, function)) = self.0.range(..=address).next_back()
                && !beyond.contains(address)
                && seen.insert(*address, function).is_none()
            {
                open.extend(&function.targets);
            }
        }
        seen
    }
}
