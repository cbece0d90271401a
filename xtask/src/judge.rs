//! `cargo xtask properties`, `experiments`, `inject`, `sources`, `calibrate`, `real`: judges of `preslide diagnose` that know it by its command line and its JSON only.

use std::process::Command;

use anyhow::Result;
use preslide_tools::process::{build_as_tests, released, root, run};

/// Builds the tool, unless another is named with `--preslide`, and runs a judge with its arguments.
pub fn judge(name: &str, arguments: &[String]) -> Result<()> {
    let named = |argument: &String| argument.starts_with("--preslide") || argument == "--help";
    let tool = if arguments.iter().any(named) {
        ""
    } else {
        "--bin preslide"
    };
    build_as_tests(&format!("--bin judge {tool}"))?;
    let mut judge = Command::new(released("judge"));
    run(judge.arg(name).args(arguments).current_dir(root()))
}
