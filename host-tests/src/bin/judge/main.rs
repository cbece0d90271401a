//! Judges of `preslide diagnose`, which know it by its command line and its JSON only: one program, which is linked once.

mod calibrate;
mod experiments;
mod inject;
mod properties;
mod real;
mod sources;

use std::process::ExitCode;

use clap::Parser;

#[derive(Parser)]
#[command(bin_name = "cargo xtask")]
enum Judge {
    Calibrate(calibrate::Options),
    Experiments(experiments::Options),
    Inject(inject::Options),
    Properties(properties::Options),
    Real(real::Options),
    Sources(sources::Options),
}

fn main() -> ExitCode {
    let judged = match Judge::parse() {
        Judge::Calibrate(options) => calibrate::run(&options),
        Judge::Experiments(options) => experiments::run(&options),
        Judge::Inject(options) => inject::run(&options),
        Judge::Properties(options) => properties::run(&options),
        Judge::Real(options) => real::run(&options),
        Judge::Sources(options) => sources::run(&options),
    };
    match judged {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("{reason}");
            ExitCode::FAILURE
        }
    }
}
