//! `cargo xtask properties`, `experiments`, `inject`, `sources`, `calibrate`, `real`: judges of `preslide diagnose` that know it by its command line and its JSON only.

use crate::process::{build_as_tests, released, root, run};
use std::process::Command;

/// Builds the tool, unless another is named with `--preslide`, and runs a judge with its arguments.
pub fn judge(name: &str, arguments: &[String]) -> Result<(), String> {
    let named = |argument: &String| argument.starts_with("--preslide") || argument == "--help";
    let mut programs = vec!["--bin", "judge"];
    if !arguments.iter().any(named) {
        programs.extend(["--bin", "preslide"]);
    }
    build_as_tests(&programs)?;
    let mut judge = Command::new(released("judge"));
    run(judge.arg(name).args(arguments).current_dir(root()))
}
