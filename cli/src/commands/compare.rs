//! `preslide compare`.

use super::{Failure, OutputArgs, RecordingArgs, SplitArgs, command_line, thin};
use clap::{Args, ValueEnum as _};
use preslide_fit::identify::MANY;
use preslide_fit::progress::Progress;
use preslide_host::compare::{compare, steps};
use std::time::Instant;

/// Fit every friction model to one recording: error fitted and held out, memory, cost
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
        let recording = thin(recording, MANY);
        let options = self.split.options(&recording)?;
        let progress = Progress::new("compare", steps());
        let found = compare(&recording, &options, &progress).map_err(Failure::Data)?;
        progress.finish();
        explain!("{}", found.table(&recording).to_text());
        if let Some(best) = found.models.get(found.recommended) {
            let parameters = best.parameters_in_words(recording.effort_unit());
            explain!("{}: {parameters}.", best.name());
            say!("The others' parameters are in --report and --json.\n");
        }
        for note in &found.notes {
            explain!("Note: {note}.");
        }
        explain!("{}", found.recommendation());
        let command = self.recordings.command("identify", None);
        say!("Next: {command} -o model.toml");
        if let Some(family) = found.cheapest.and_then(|i| found.models[i].family())
            && let Some(value) = family.to_possible_value()
        {
            let (name, value) = (family.name(), value.get_name());
            say!("Or, for {name}: {command} --friction {value} -o model.toml");
        }
        let seconds = start.elapsed().as_secs_f64();
        self.outputs.write(&found.to_json(&recording, seconds), || {
            found.page(&recording, command_line())
        })
    }
}
