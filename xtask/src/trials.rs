//! `cargo xtask trials`: what `preslide diagnose` is worth on recordings whose truth it does not see.

use crate::judge::judge;

/// Runs the trials with the arguments of the program behind it (`--help` lists them).
pub fn run_command(arguments: &[String]) -> Result<(), String> {
    judge("trials", arguments)
}
