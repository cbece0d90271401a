//! The `preslide` command.

fn main() -> std::process::ExitCode {
    preslide_cli::program()
}
