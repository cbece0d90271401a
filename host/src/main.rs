//! The `preslide` command.
fn main() {}
