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

/// A small fixed set of every source gates CI: none of its figures may fall behind the committed ones by more than chance.
pub fn gate() -> Result<(), String> {
    crate::judge::sources(&["--ci".to_owned()])
}
