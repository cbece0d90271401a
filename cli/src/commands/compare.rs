//! `preslide compare`.

use super::{Failure, OutputArgs, RecordingArgs, SplitArgs, command_line, thin};
use clap::Args;
use preslide_host::compare::{compare, shortened, steps};
use preslide_host::identify::MANY;
use preslide_host::progress::Progress;
use preslide_host::recording::Recording;
use std::time::Instant;

/// Every friction model on the same recording: error in and out of sample, memory, cost
#[derive(Args)]
#[command(
    after_help = "Example: preslide compare axis.csv --train 100..145 --test 145..190 --report comparison.html"
)]
pub struct Compare {
    #[command(flatten)]
    recordings: RecordingArgs,

    #[command(flatten)]
    split: SplitArgs,

    #[command(flatten)]
    outputs: OutputArgs,
}

impl Compare {
    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        let start = Instant::now();
        self.recordings.check_outputs(None, &[], &self.outputs)?;
        let recording = self.recordings.load()?;
        let recording = self.shorten(thin(recording, MANY));
        let options = self.split.options(&recording)?;
        let progress = Progress::new("compare", steps());
        let found = compare(&recording, &options, &progress).map_err(Failure::Data)?;
        progress.finish();

        say!("{}", found.table(&recording).to_text());
        for model in &found.models {
            say!("{}: {}", model.name(), model.parameters_in_words());
        }
        say!("");
        for note in &found.notes {
            say!("Note: {note}.");
        }
        say!("{}", found.recommendation());
        let seconds = start.elapsed().as_secs_f64();
        self.outputs.write(&found.to_json(&recording, seconds), || {
            found.page(&recording, command_line())
        })
    }

    /// Stretches of a long recording, and a line that says so; all of it where windows of it are asked for.
    fn shorten(&self, recording: Recording) -> Recording {
        let Some(kept) = shortened(&recording).filter(|_| !self.split.has_windows()) else {
            return recording;
        };
        if let Some(warning) = kept.warnings.last() {
            eprintln!("{}: {}", kept.name, warning.message);
        }
        kept
    }
}
