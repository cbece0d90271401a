//! `preslide identify`.

use super::{
    Failure, OutputArgs, RecordingArgs, SplitArgs, command_line, quoted, thin, write_model,
};
use clap::Args;
use preslide_fit::identify::family::Family;
use preslide_fit::identify::{Identification, MANY, Options, STEPS, identify, motion, speed_table};
use preslide_fit::progress::Progress;
use preslide_fit::recording::{Recording, Speeds};
use preslide_fit::report::figures::left;
use preslide_fit::simulate::closed::Controller;
use preslide_host::predict::{self, predict};
use std::path::PathBuf;
use std::time::Instant;

/// Fit a rigid body and a friction model to recordings
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

    /// Minimise the error of the force, or of the motion that a simulation computes from the force (with --controller,
    /// from the reference). `motion` has Coulomb friction, and whatever physics helps in windows that were left out
    #[arg(long, value_enum, default_value_t = Criterion::Force, conflicts_with_all = ["blocks", "friction", "test"])]
    criterion: Criterion,

    /// Gains of the controller that drove the axis, for --criterion motion in closed loop; as for `simulate --controller`
    #[arg(long, value_name = "GAINS.toml")]
    controller: Option<PathBuf>,

    /// Instead of fitting a model, report how far a linear predictor on lifted states (EDMD with control) sees beside GMS and LuGre:
    /// fitted to the first 60 %, chosen on the next 20 %, judged on the last 20 %
    #[arg(long, value_enum, conflicts_with_all = ["blocks", "friction", "criterion", "controller", "train", "test", "output"])]
    predictor: Option<Lifted>,

    /// Write the model
    #[arg(short, long, value_name = "MODEL.toml")]
    output: Option<PathBuf>,

    #[command(flatten)]
    outputs: OutputArgs,
}

/// What a fit makes small.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Criterion {
    Force,
    Motion,
}

/// A predictor for controllers that look ahead.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Lifted {
    Koopman,
}

impl Identify {
    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        let start = Instant::now();
        self.recordings.check_outputs(
            self.controller.as_ref(),
            &[("-o", self.output.as_ref())],
            &self.outputs,
        )?;
        if let Some(table) = self.recordings.load_speeds()? {
            return self.of_speeds(table, start);
        }
        if self.predictor.is_some() {
            return self.of_predictors(start);
        }
        if self.controller.is_some() && self.criterion == Criterion::Force {
            return Err(Failure::Input(
                "--controller needs --criterion motion: add that, or leave --controller out"
                    .to_owned(),
            ));
        }
        let recording = self.recordings.load()?;
        let recording = thin(recording, MANY);
        if self.criterion == Criterion::Motion {
            return self.of_motion(recording, start);
        }
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
            write_model(path, &model_text(&found, &recording))?;
        }
        let seconds = start.elapsed().as_secs_f64();
        self.outputs
            .write(&found.to_json(&recording, seconds), || {
                found.page(&recording, command_line())
            })?;
        let model = self.output.as_deref().filter(|_| refused.is_none());
        // Without a model `diagnose` makes the fit that is recommended, of all samples.
        let is_another = self.blocks.is_some() || self.friction.is_some() || self.split.is_given();
        match model.is_none() && refused.is_none() && is_another {
            true => self.say_to_write(),
            false => say!(
                "Next, to see whether the {} left is noise or missing physics:\n  {}",
                left(found.best().nmse_test),
                self.recordings.command("diagnose", model)
            ),
        }
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
    /// Parameters from the motion, beginning with those from the force.
    fn of_motion(self, recording: Recording, start: Instant) -> Result<(), Failure> {
        let controller = self.controller.as_deref().map(Controller::load);
        let controller = controller.transpose().map_err(Failure::Input)?;
        let recording = match self.split.options(&recording)?.train {
            Some((from, to)) => recording.slice_time(from, to)?,
            None => recording,
        };
        let progress = Progress::new("identify", STEPS + motion::STEPS);
        let force = identify(&recording, &Options::default(), &progress).map_err(Failure::Data)?;
        let found = motion::fit(&recording, &force, controller.as_ref(), &progress);
        let found = found.map_err(Failure::Data)?;
        progress.finish();
        explain!("{}", found.error_table(&recording).to_text());
        explain!("{}", found.table(&recording).to_text());
        for note in found.notes(&recording) {
            explain!("Note: {note}.");
        }
        explain!("{}", found.conclusion(&recording));
        if let Some(path) = &self.output {
            let mut remarks = vec![format!("identified from the motion of {}", recording.name)];
            remarks.push(found.conclusion(&recording));
            remarks.extend(recording.per_unit());
            write_model(path, &found.model.to_toml(&remarks))?;
        }
        let seconds = start.elapsed().as_secs_f64();
        let page = || found.page(&recording, command_line());
        self.outputs
            .write(&found.to_json(&recording, seconds), page)?;
        match self.output.as_deref() {
            Some(model) => say!("Next: {}", self.recordings.command("diagnose", Some(model))),
            None => self.say_to_write(),
        }
        Ok(())
    }

    /// The same once more, for the model.
    fn say_to_write(&self) {
        say!("Next: {} -o model.toml", command_line());
    }

    /// What is said of the next second.
    fn of_predictors(self, start: Instant) -> Result<(), Failure> {
        let recording = thin(self.recordings.load()?, MANY);
        let progress = Progress::new("predict", predict::STEPS);
        let found = predict(&recording, &progress).map_err(Failure::Data)?;
        progress.finish();
        explain!("{}", found.table(&recording).to_text());
        for note in &found.notes {
            explain!("Note: {note}.");
        }
        explain!("{}", found.recommendation());
        let seconds = start.elapsed().as_secs_f64();
        let page = || found.page(&recording, command_line());
        self.outputs
            .write(&found.to_json(&recording, seconds), page)?;
        say!(
            "Next: {} -o model.toml",
            self.recordings.command("identify", None)
        );
        Ok(())
    }

    /// The answer from a table of speed and effort without time.
    fn of_speeds(self, table: Speeds, start: Instant) -> Result<(), Failure> {
        if self.predictor.is_some()
            || self.split.is_given()
            || self.friction.is_some()
            || self.blocks.is_some_and(|n| n > 0)
        {
            return Err(Failure::Input(format!(
                "{} is a table of speed and effort without time: --train, --test, --friction, --predictor and --blocks need a recording with time (`t_s`, or the step `dt_s`)",
                table.name
            )));
        }
        let found = speed_table::fit(table, self.recordings.may_turn()).map_err(Failure::Data)?;
        tell!("{}", found.in_one_line());
        for warning in found.warnings() {
            tell!("warning: {warning}");
        }
        explain!("{}", found.table().to_text());
        for note in found.notes() {
            explain!("Note: {note}.");
        }
        explain!("{}", found.recommendation());
        if let Some(path) = &self.output {
            let model = found.model().map_err(Failure::Data)?;
            write_model(path, &model.to_toml(&found.remarks()))?;
        }
        let seconds = start.elapsed().as_secs_f64();
        let page = || found.page(command_line());
        self.outputs.write(&found.to_json(seconds), page)?;
        match self.output.as_deref() {
            Some(model) => say!(
                "Next: preslide export {} -o stage_model.rs",
                quoted(model.display().to_string())
            ),
            None if found.model().is_ok() => self.say_to_write(),
            None => {}
        }
        Ok(())
    }
}

/// The tables, the notes and the recommendation.
pub fn print(found: &Identification, recording: &Recording) {
    explain!("{}", found.rigid_body_table(recording).to_text());
    explain!("{}", found.size_table().to_text());
    let tables = [
        found.parameter_table(recording),
        found.block_table(recording),
    ];
    for table in tables.into_iter().flatten() {
        explain!("{}", table.to_text());
    }
    let notes = found.notes(recording).into_iter();
    for note in notes.chain(found.why_not_the_papers(recording)) {
        explain!("Note: {note}.");
    }
    explain!("{}", found.recommendation);
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
    if best.rigid_body.iter().any(|p| p.0 == "coulomb_and_offset") {
        remarks.push(
            "the motion goes one way: constant_force is Coulomb friction and a constant load in one; record reversals to part them"
                .to_owned(),
        );
    }
    let Some(count) = recording.count else {
        return best.model.to_toml(&remarks);
    };
    remarks.push(
        "the encoder's count is the step of the recorded position: correct it if the file was rounded"
            .to_owned(),
    );
    best.model.clone().with_count(count).to_toml(&remarks)
}
