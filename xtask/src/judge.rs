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

/// Answers that must not flip.
pub fn properties(arguments: &[String]) -> Result<(), String> {
    judge("properties", arguments)
}

/// Known effects added to real recordings.
pub fn inject(arguments: &[String]) -> Result<(), String> {
    judge("inject", arguments)
}

/// Experiments against passive recordings.
pub fn experiments(arguments: &[String]) -> Result<(), String> {
    judge("experiments", arguments)
}

/// Every source of recordings with a known truth, in one table.
pub fn sources(arguments: &[String]) -> Result<(), String> {
    judge("sources", arguments)
}

/// The confidence of names, fitted to judged ones.
pub fn calibrate(arguments: &[String]) -> Result<(), String> {
    judge("calibrate", arguments)
}

/// What is said of each file of `../shared/recordings`.
pub fn real(arguments: &[String]) -> Result<(), String> {
    judge("real", arguments)
}
