//! The `preslide` command.

mod commands;

use clap::{Parser, Subcommand};
use commands::Failure;
use std::process::ExitCode;

/// Friction in the last micrometre: from a recording to the parameters of a real-time model.
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
    Compare(commands::compare::Compare),
    Diagnose(commands::diagnose::Diagnose),
    Drive(commands::drive::Drive),
    Export(commands::export::Export),
    Identify(commands::identify::Identify),
    Plan(commands::plan::Plan),
    Reproduce(commands::reproduce::Reproduce),
    Simulate(commands::simulate::Simulate),
    Tune(commands::tune::Tune),
}

fn main() -> ExitCode {
    let done = match Arguments::parse().command {
        Command::Demo(command) => command.run(),
        Command::Capture(command) => command.run(),
        Command::Compare(command) => command.run(),
        Command::Diagnose(command) => command.run(),
        Command::Drive(command) => command.run(),
        Command::Export(command) => command.run(),
        Command::Identify(command) => command.run(),
        Command::Plan(command) => command.run(),
        Command::Reproduce(command) => command.run(),
        Command::Simulate(command) => command.run(),
        Command::Tune(command) => command.run(),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            let failure: Failure = failure;
            eprintln!("preslide: {}", failure.message());
            ExitCode::from(failure.exit_code())
        }
    }
}
