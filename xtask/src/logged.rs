//! What the firmware logs by defmt, decoded by defmt's own program.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use crate::process::{output_of, run_for};
use crate::tools::defmt_print;

/// A run of a second and a half.
const LIMIT: Duration = Duration::from_secs(120);

/// What is to be logged, in its order.
const LINES: [&str; 3] = [
    "ERROR fault: Some(EncoderJump)",
    "ERROR fault: None",
    "WARN request 12: refused: TooFast",
];

/// Lets the emulated board, built with its log, have a fault and refuse a move, and compares what is decoded.
pub fn decoded(rig: &Path, elf: &Path) -> Result<(), String> {
    let file = std::env::temp_dir().join(format!("preslide-log-{}", std::process::id()));
    run_for(Command::new(rig).arg("logged").arg(elf).arg(&file), LIMIT)?;
    let mut print = Command::new(defmt_print()?);
    let told = |error| format!("{}: {error}", file.display());
    let frames = std::fs::read(&file).map_err(told)?;
    print.args(["--log-format", "{L} {s}", "-e"]).arg(elf);
    let text = output_of(&mut print, &frames)?;
    let _ = std::fs::remove_file(&file);
    let words = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
    let lines: Vec<String> = text.lines().map(words).collect();
    if lines == LINES {
        println!("log: {} frames decoded: {}", lines.len(), lines.join("; "));
        Ok(())
    } else {
        Err(format!("the firmware logged\n{text}and not {LINES:#?}"))
    }
}
