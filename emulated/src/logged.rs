//! What the firmware logs by defmt, decoded by defmt's own program.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use anyhow::{Result, ensure};
use fs_err as fs;
use preslide_tools::need::defmt_print;
use preslide_tools::process::{output_of, run_for, with_folder};

/// A run of a second and a half.
const LIMIT: Duration = Duration::from_secs(120);

/// What is to be logged, in its order.
const LINES: [&str; 3] = [
    "ERROR fault: Some(EncoderJump)",
    "ERROR fault: None",
    "WARN request 12: refused: TooFast",
];

/// Lets the emulated board, built with its log, have a fault and refuse a move, and compares what is decoded.
pub fn decoded(rig: &Path, elf: &Path) -> Result<()> {
    let frames = with_folder("log", |folder| {
        let file = folder.join("frames");
        run_for(Command::new(rig).arg("logged").arg(elf).arg(&file), LIMIT)?;
        Ok(fs::read(&file)?)
    })?;
    let mut print = Command::new(defmt_print()?);
    print.args(["--log-format", "{L} {s}", "-e"]).arg(elf);
    let text = output_of(&mut print, &frames)?;
    let words = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
    let lines: Vec<String> = text.lines().map(words).collect();
    ensure!(
        lines == LINES,
        "the firmware logged\n{text}and not {LINES:#?}"
    );
    println!("log: {} frames decoded: {}", lines.len(), lines.join("; "));
    Ok(())
}
