//! `preslide identify`.

use super::{Failure, OutputArgs, RecordingArgs, SplitArgs, command_line, thin, write_text};
use clap::Args;
use preslide_host::identify::family::Family;
use preslide_host::identify::{Identification, MANY, STEPS, identify, speed_table};
use preslide_host::progress::Progress;
use preslide_host::recording::{Recording, Speeds};
use std::path::PathBuf;
use std::time::Instant;

/// Rigid body and friction model from recordings
#[derive(Args)]
#[command(
    after_help = "Example: preslide identify axis.csv --map force_N=35.15*voltage_V -o model.toml --report report.html"
)]
pub struct Identify {
    #[command(flatten)]
    recordings: RecordingArgs,

    #[command(flatten)]
    split: SplitArgs,

    /// Write GMS with this many blocks instead of the recommended model (0: Coulomb + viscous)
    #[arg(long, value_name = "N")]
    blocks: Option<usize>,

    /// Fit this model of the family and write it instead of the recommended one
    #[arg(long, value_name = "KIND", conflicts_with = "blocks")]
    friction: Option<Family>,

    /// Write the model
    #[arg(short, long, value_name = "MODEL.toml")]
    output: Option<PathBuf>,

    #[command(flatten)]
    outputs: OutputArgs,
}

impl Identify {
    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        let start = Instant::now();
        self.recordings
            .check_outputs(None, &[("-o", self.output.as_ref())], &self.outputs)?;
        if let Some(table) = self.recordings.load_speeds()? {
            return self.of_speeds(table, start);
        }
        let recording = self.recordings.load()?;
        let recording = thin(recording, MANY);
        let options = self.split.options(&recording)?;
        let more = if self.friction.is_some() { 2 } else { 0 };
        let progress = Progress::new("identify", STEPS + more);
        let mut found = identify(&recording, &options, &progress).map_err(Failure::Data)?;
        if let Some(blocks) = self.blocks {
            found.choose(blocks).map_err(Failure::Input)?;
        }
        if let Some(family) = self.friction {
            found
                .choose_family(&recording, family, &progress)
                .map_err(Failure::Data)?;
        }
        progress.finish();

        print(&found, &recording);

        let refused = found.refused();
        if let Some(path) = self.output.as_ref().filter(|_| refused.is_none()) {
            write_text(path, &model_text(&found, &recording))?;
        }
        let seconds = start.elapsed().as_secs_f64();
        self.outputs
            .write(&found.to_json(&recording, seconds), || {
                found.page(&recording, command_line())
            })?;
        if let Some(reason) = refused {
            return Err(Failure::Data(format!(
                "{}: {reason}, so no model is written",
                recording.name
            )));
        }
        Ok(())
    }
}

impl Identify {
    /// What a table of speed and effort without time tells.
    fn of_speeds(self, table: Speeds, start: Instant) -> Result<(), Failure> {
        if self.split.is_given() || self.friction.is_some() || self.blocks.is_some_and(|n| n > 0) {
            return Err(Failure::Input(format!(
                "{} is a table of speed and effort without time: --train, --test, --friction and --blocks need a recording with time (`t_s`, or the step `dt_s`)",
                table.name
            )));
        }
        let found = speed_table::fit(table, self.recordings.may_turn()).map_err(Failure::Data)?;
        eprintln!("{}", found.in_one_line());
        for warning in found.warnings() {
            eprintln!("warning: {warning}");
        }
        say!("{}", found.table().to_text());
        for note in found.notes() {
            say!("Note: {note}.");
        }
        say!("{}", found.recommendation());
        if let Some(path) = &self.output {
            let model = found.model().map_err(Failure::Data)?;
            write_text(path, &model.to_toml(&found.remarks()))?;
        }
        let seconds = start.elapsed().as_secs_f64();
        let page = || found.page(command_line());
        self.outputs.write(&found.to_json(seconds), page)
    }
}

/// The tables, the notes and the recommendation.
pub fn print(found: &Identification, recording: &Recording) {
    say!("{}", found.rigid_body_table(recording).to_text());
    say!("{}", found.size_table().to_text());
    let tables = [found.parameter_table(), found.block_table(recording)];
    for table in tables.into_iter().flatten() {
        say!("{}", table.to_text());
    }
    for note in found.notes(recording) {
        say!("Note: {note}.");
    }
    say!("{}", found.recommendation);
}

/// The recommended model's file, with where it comes from at its head.
pub fn model_text(found: &Identification, recording: &Recording) -> String {
    let best = found.best();
    let mut remarks = vec![
        format!("identified from {}", recording.name),
        format!(
            "NMSE {:.4} % fitted, {:.4} % held out",
            best.nmse_train, best.nmse_test
        ),
    ];
    remarks.extend(recording.per_unit());
    best.model.to_toml(&remarks)
}
