//! Which functions can be reached from one, read from a disassembly.

use std::collections::{BTreeMap, BTreeSet};

/// The functions reached from `start` by direct branches and calls, itself included; those in `beyond` are not followed.
///
/// # Errors
/// Where `start` is not in the disassembly, or calls through a register (which this cannot follow).
pub fn reached(
    disassembly: &str,
    start: &str,
    beyond: &[&str],
) -> Result<BTreeSet<String>, String> {
    let mut calls: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    let mut indirect = BTreeSet::new();
    let mut current = "";
    for line in disassembly.lines() {
        if let Some(name) = header(line) {
            current = name;
            calls.entry(current).or_default();
        } else if let Some((operation, operands)) = instruction(line) {
            if operation.starts_with("blx") && !operands.contains('<') {
                indirect.insert(current);
            } else if let Some(target) = target(operands).filter(|_| branches(operation)) {
                calls.entry(current).or_default().insert(target);
            }
        }
    }
    for name in beyond.iter().chain([&start]) {
        if !calls.contains_key(name) {
            return Err(format!("the image has no function {name}; was it inlined?"));
        }
    }
    let mut seen = BTreeSet::new();
    let mut open = vec![start];
    while let Some(name) = open.pop() {
        if !beyond.contains(&name) && seen.insert(name.to_owned()) {
            if indirect.contains(name) {
                return Err(format!(
                    "{name}, reached from {start}, calls through a register"
                ));
            }
            open.extend(calls.get(name).into_iter().flatten());
        }
    }
    Ok(seen)
}

/// Where every function begins.
pub fn addresses(disassembly: &str) -> BTreeMap<&str, u32> {
    let parse = |line| {
        let (address, _) = str::split_once(line, " <")?;
        Some((header(line)?, u32::from_str_radix(address, 16).ok()?))
    };
    disassembly.lines().filter_map(parse).collect()
}

/// `000003f0 <name>:`
fn header(line: &str) -> Option<&str> {
    let (address, name) = line.split_once(" <")?;
    let hex = !address.is_empty() && address.bytes().all(|b| b.is_ascii_hexdigit());
    name.strip_suffix(">:").filter(|_| hex)
}

/// `     894:  bl  393e <name>`
fn instruction(line: &str) -> Option<(&str, &str)> {
    let (_, text) = line.split_once(":\t")?;
    let text = text.trim_start();
    Some(text.split_once(char::is_whitespace).unwrap_or((text, "")))
}

/// `b`, `bl`, their conditional and wide forms, and `cbz`; not `bic`, `bfi`, `bkpt`.
fn branches(operation: &str) -> bool {
    let stem = operation.split('.').next().unwrap_or_default();
    let condition = |rest: &str| {
        [
            "", "eq", "ne", "cs", "cc", "mi", "pl", "vs", "vc", "hi", "ls", "ge", "lt", "gt", "le",
        ]
        .contains(&rest)
    };
    stem.starts_with("cb")
        || stem.strip_prefix("bl").is_some_and(condition)
        || stem.strip_prefix('b').is_some_and(condition)
}

/// The function in `393e <name+0x12>`.
fn target(operands: &str) -> Option<&str> {
    let (_, name) = operands.split_once('<')?;
    let name = name.strip_suffix('>')?;
    Some(name.rsplit_once("+0x").map_or(name, |(name, _)| name))
}

#[cfg(test)]
mod tests {
    use super::{addresses, reached};

    const IMAGE: &str = "
00000010 <tick>:
      10:\tpush\t{r7, lr}
      12:\tbl\t20 <core::<impl f32>::max>
      16:\tbne.n\t10 <tick>
      18:\tb.w\t30 <far+0x4>

00000020 <core::<impl f32>::max>:
      20:\tbic.w\tr0, r0, #1

00000030 <far>:
      30:\tcbz\tr0, 40 <core::panicking::panic>

00000040 <core::panicking::panic>:
      40:\tudf\t#254

00000050 <other>:
      50:\tblx\tr3
";

    #[test]
    fn follows_calls_tail_calls_and_short_branches() {
        let names = reached(IMAGE, "tick", &[]).expect("no call through a register");
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        assert_eq!(
            names,
            [
                "core::<impl f32>::max",
                "core::panicking::panic",
                "far",
                "tick"
            ]
        );
    }

    #[test]
    fn knows_where_functions_begin() {
        let places = addresses(IMAGE);
        assert_eq!(places.len(), 5);
        assert_eq!(places.get("far"), Some(&0x30));
    }

    #[test]
    fn says_what_it_cannot_follow() {
        let fails = |start, beyond: &[&str], word| {
            reached(IMAGE, start, beyond).is_err_and(|error| error.contains(word))
        };
        assert!(fails("other", &[], "register"));
        assert!(fails("gone", &[], "inlined"));
        assert!(fails("tick", &["gone"], "inlined"));
    }

    #[test]
    fn does_not_follow_what_is_beyond() {
        let names = reached(IMAGE, "tick", &["far"]).expect("no call through a register");
        assert_eq!(names.len(), 2, "{names:?}");
    }
}
