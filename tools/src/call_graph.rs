//! Which functions a task of an Arm program can reach, read from its disassembly.

use std::collections::BTreeMap;

use anyhow::{Context as _, Result, bail};

use crate::objdump::{Functions, without_condition};

/// The functions reached from `start` by direct branches and calls, itself included, by where they begin; those in `beyond` are not followed.
///
/// # Errors
/// Where `start` is not in the disassembly, or calls through a register (which this cannot follow).
pub fn reached(disassembly: &str, start: &str, beyond: &[&str]) -> Result<BTreeMap<u32, String>> {
    let functions = Functions::of(disassembly, branches);
    let address = |name: &str| {
        let address = functions.address(name);
        address.with_context(|| format!("the image has no function {name}; was it inlined?"))
    };
    let beyond: Result<Vec<u32>> = beyond.iter().map(|name| address(name)).collect();
    let reached = functions.reached(address(start)?, &beyond?);
    if let Some(function) = reached.values().find(|f| f.calls_a_register) {
        let name = &function.name;
        bail!("{name}, reached from {start}, calls through a register");
    }
    let named = reached.into_iter();
    Ok(named.map(|(at, f)| (at, f.name.clone())).collect())
}

/// `b`, `bl`, their conditional and wide forms, and `cbz`; not `bic`, `bfi`, `bkpt`.
fn branches(operation: &str) -> bool {
    let stem = operation.split('.').next().unwrap_or_default();
    stem.starts_with("cb") || ["b", "bl"].contains(&without_condition(stem))
}

#[cfg(test)]
mod tests {
    use super::reached;

    const IMAGE: &str = "
00000010 <tick>:
      10:\tb580\tpush\t{r7, lr}
      12:\tf000 f805\tbl\t20 <core::<impl f32>::max>
      16:\td1fb\tbne.n\t10 <tick>
      18:\tf000 b80c\tb.w\t30 <far+0x4>

00000020 <core::<impl f32>::max>:
      20:\tf020 0001\tbic.w\tr0, r0, #1

00000030 <far>:
      30:\tb130\tcbz\tr0, 40 <core::panicking::panic>

00000040 <core::panicking::panic>:
      40:\tdefe\tudf\t#254

00000050 <other>:
      50:\t4798\tblx\tr3
";

    #[test]
    fn follows_calls_tail_calls_and_short_branches() {
        let names = reached(IMAGE, "tick", &[]).expect("no call through a register");
        let names: Vec<(u32, &str)> = names.iter().map(|(at, n)| (*at, n.as_str())).collect();
        assert_eq!(
            names,
            [
                (0x10, "tick"),
                (0x20, "core::<impl f32>::max"),
                (0x30, "far"),
                (0x40, "core::panicking::panic"),
            ]
        );
    }

    #[test]
    fn says_what_it_cannot_follow() {
        let fails = |start, beyond: &[&str], word| {
            reached(IMAGE, start, beyond).is_err_and(|error| error.to_string().contains(word))
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
