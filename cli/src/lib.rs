//! The `preslide` command: what the program runs, and what others run in their own process.

// They end the program where their stream is closed: `say!`, `tell!` and `ask` do not.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

#[macro_use]
mod heard;
mod commands;

use clap::{Parser, Subcommand};
use commands::Failure;
pub use heard::{Answer, Listener, call};
use std::process::ExitCode;

/// Measures the friction of a positioning axis from a drive recording, for a model in the motor-control interrupt.
///
/// Exit codes: 0 done; 1 the tool failed; 2 bad usage or input; 3 the data cannot answer the question.
#[derive(Parser)]
#[command(name = "preslide", version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Demo(commands::demo::Demo),
    Capture(commands::capture::Capture),
    Commission(commands::commission::Commission),
    Compare(commands::compare::Compare),
    Diagnose(commands::diagnose::Diagnose),
    Drive(commands::drive::Drive),
    Export(commands::export::Export),
    Fleet(commands::fleet::Fleet),
    Identify(commands::identify::Identify),
    Plan(commands::plan::Plan),
    Reproduce(commands::reproduce::Reproduce),
    Simulate(commands::simulate::Simulate),
    Tune(commands::tune::Tune),
}

impl Command {
    fn run(self) -> Result<(), Failure> {
        match self {
            Self::Demo(command) => command.run(),
            Self::Capture(command) => command.run(),
            Self::Commission(command) => command.run(),
            Self::Compare(command) => command.run(),
            Self::Diagnose(command) => command.run(),
            Self::Drive(command) => command.run(),
            Self::Export(command) => command.run(),
            Self::Fleet(command) => command.run(),
            Self::Identify(command) => command.run(),
            Self::Plan(command) => command.run(),
            Self::Reproduce(command) => command.run(),
            Self::Simulate(command) => command.run(),
            Self::Tune(command) => command.run(),
        }
    }
}

/// The program.
pub fn program() -> ExitCode {
    match Arguments::parse().command.run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            tell!("preslide: {}", failure.message());
            ExitCode::from(failure.exit_code())
        }
    }
}
