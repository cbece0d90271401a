//! `preslide identify`.

use super::{Failure, OutputArgs, RecordingArgs, command_line, write_text};
use clap::Args;
use preslide_host::identify::split::{Window, parse_window};
use preslide_host::identify::{Options, identify};
use preslide_host::progress::Progress;
use std::path::PathBuf;
use std::time::Instant;

/// Rigid body and friction model from recordings
#[derive(Args)]
pub struct Identify {
    #[command(flatten)]
    recordings: RecordingArgs,

    /// Fit only this window of time, in seconds: 100..145
    #[arg(long, value_name = "FROM..TO", value_parser = parse_window)]
    train: Option<Window>,

    /// Judge on this window, which is never fitted; without it repeats or strokes take turns
    #[arg(long, value_name = "FROM..TO", value_parser = parse_window)]
    test: Option<Window>,

    /// Write the recommended model
    #[arg(short, long, value_name = "MODEL.toml")]
    output: Option<PathBuf>,

    #[command(flatten)]
    outputs: OutputArgs,
}

impl Identify {
    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        let start = Instant::now();
        let recording = self.recordings.load()?;
        let options = Options {
            train: self.train,
            test: self.test,
        };
        let progress = Progress::new("identify", 20);
        let found = identify(&recording, &options, &progress).map_err(Failure::Data)?;
        progress.finish();
        let _ = (
            found,
            start,
            write_text,
            command_line(),
            &self.output,
            &self.outputs,
        );
        Ok(())
    }
}
