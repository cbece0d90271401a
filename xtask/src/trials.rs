//! `cargo xtask trials`: what `preslide diagnose` is worth on recordings whose truth it does not see.

use crate::process::{cargo, run};

/// Runs the trials with the arguments of the program behind it (`--help` lists them).
pub fn run_command(arguments: &[String]) -> Result<(), String> {
    run(&mut cargo(&[
        "build",
        "--release",
        "--package",
        "preslide-cli",
        "--bins",
    ]))?;
    let mut command = cargo(&["run", "--release", "--package", "preslide-host-tests"]);
    run(command.args(["--bin", "trials", "--"]).args(arguments))
}

/// A small fixed set that gates CI: no false alarm, and no fewer effects named than when it was set.
pub fn gate() -> Result<(), String> {
    let arguments = ["--count", "20", "--quiet", "--gate"].map(String::from);
    run_command(&arguments)
}
