//! `cargo xtask trials`: what `preslide diagnose` is worth on recordings whose truth it does not see.

use crate::judge::{self, judge};

/// Runs the trials with the arguments of the program behind it (`--help` lists them).
pub fn run_command(arguments: &[String]) -> Result<(), String> {
    judge("trials", arguments)
}

/// A small fixed set of every source gates CI: none of its figures may fall behind the committed ones by more than chance.
pub fn gate() -> Result<(), String> {
    judge::sources(&["--ci".to_owned()])
}
