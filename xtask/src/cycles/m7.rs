//! An estimate for the Cortex-M7, from `llvm-mca`'s model of its pipeline where that is installed.
//!
//! The M7 issues two instructions at once, so the M4's table says nothing about it. llvm-mca knows the pipeline but not
//! memory, caches or branch prediction: take its figures as ±40 %.

use std::process::Command;

use super::disassembly::Disassembly;
use super::instruction::{is_condition_branch, without_condition};
use super::recorder::TakenPath;
use crate::process::{find, output};

/// Enough for the pipeline's filling and draining to fade.
const ITERATIONS: u32 = 100;

/// Cycles of the most frequent path, or `None` where llvm-mca is not installed or cannot read the path.
pub fn estimate(disassembly: &Disassembly, paths: &[TakenPath]) -> Option<f64> {
    find("llvm-mca")?;
    let path = paths.iter().max_by_key(|path| path.calls)?;
    let mut text = String::from(".syntax unified\n.thumb\n");
    for &(first, last) in &path.stretches {
        let mut address = first;
        while address <= last {
            let instruction = disassembly.instruction(address).ok()?;
            text += &straight(disassembly.text(address)?, instruction.conditional);
            address += instruction.size;
        }
    }
    let file = std::env::temp_dir().join(format!("preslide-m7-{}.s", std::process::id()));
    std::fs::write(&file, text).ok()?;
    let printed = output(
        Command::new("llvm-mca")
            .args(["-mtriple=thumbv7em-none-eabihf", "-mcpu=cortex-m7"])
            .arg(format!("-iterations={ITERATIONS}"))
            .arg(&file),
    );
    let _ = std::fs::remove_file(&file);
    let cycles = printed.ok()?.lines().find_map(|line| {
        let total = line.strip_prefix("Total Cycles:")?;
        total.trim().parse::<f64>().ok()
    })?;
    Some(cycles / f64::from(ITERATIONS))
}

/// Assembly again, of a path that no branch leaves: branches lead to where they stand, conditions and their IT go, and so
/// do objdump's comments. LLVM 14 stumbles over accesses that update their address, whose update becomes an addition, and over
/// comparisons with a literal zero.
fn straight(text: &str, conditional: bool) -> String {
    let code = text.split(['@', ';', '<']).next().unwrap_or("").trim();
    let (mnemonic, operands) = code.split_once('\t').unwrap_or((code, ""));
    let (name, kind) = mnemonic.split_once('.').unwrap_or((mnemonic, ""));
    let name = if conditional {
        without_condition(name)
    } else {
        name
    };
    let dot = if kind.is_empty() { "" } else { "." };
    let whole = |operands: &str| format!("{name}{dot}{kind} {operands}\n");
    match name {
        _ if name.starts_with("it") => String::new(),
        "cbz" | "cbnz" => {
            let register = operands.split(',').next().unwrap_or("");
            whole(&format!("{register}, ."))
        }
        "b" | "bl" => whole("."),
        _ if is_condition_branch(name) => whole("."),
        "ldr" | "str" | "strb" | "strh" | "strd"
            if operands.contains("],") || operands.ends_with('!') =>
        {
            let (kept, _) = operands.split_once(']').unwrap_or((operands, ""));
            let base = kept.rsplit('[').next().unwrap_or("");
            let base = base.split(',').next().unwrap_or("");
            whole(&format!("{kept}]")) + &format!("add.w {base}, {base}, #4\n")
        }
        "vcmp" | "vcmpe" => whole(&operands.replace("#0.0", "s0")),
        _ => whole(operands.trim()),
    }
}

#[cfg(test)]
mod tests {
    use super::straight;

    #[test]
    fn what_llvm_mca_cannot_read_is_rewritten_and_nothing_else_changes() {
        let plain = |text| straight(text, false);
        assert_eq!(plain("bgt.n\t3b45a <f+0xba>"), "bgt.n .\n");
        assert_eq!(plain("cbz\tr3, 3b45a <f+0xba>"), "cbz r3, .\n");
        assert_eq!(
            plain("bic.w\tr3, r3, r3, asr #31"),
            "bic.w r3, r3, r3, asr #31\n"
        );
        assert_eq!(plain("bx\tlr"), "bx lr\n");
        assert_eq!(
            plain("vldr\ts2, [pc, #680]\t@ 3a7c0 <f>"),
            "vldr s2, [pc, #680]\n"
        );
        assert_eq!(
            plain("str.w\tr2, [lr], #4"),
            "str.w r2, [lr]\nadd.w lr, lr, #4\n"
        );
        assert_eq!(plain("vcmp.f32\ts4, #0.0"), "vcmp.f32 s4, s0\n");
        assert_eq!(plain("ite\tmi"), "");
        assert_eq!(straight("vmovne.f32\ts0, s6", true), "vmov.f32 s0, s6\n");
    }
}
