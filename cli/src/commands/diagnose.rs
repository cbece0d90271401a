//! `preslide diagnose`.

use super::outputs::is_stdout;
use super::{
    Failure, OutputArgs, RecordingArgs, command_line, in_words, thin, write_model, write_text,
};
use clap::Args;
use preslide_fit::model::Model;
use preslide_fit::progress::Progress;
use preslide_fit::recording::{Recording, Simulated};
use preslide_fit::report::figures::capital;
use preslide_fit::signal::beside_the_motion;
use preslide_host::diagnose::correction::Language;
use preslide_host::diagnose::experiment::{self, Experiment};
use preslide_host::diagnose::fit::Fit;
use preslide_host::diagnose::verdict::Verdict;
use preslide_host::diagnose::{Diagnosis, Refusal, diagnose, diagnose_simulation, effect};
use preslide_host::export::no_refused;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Name and size the physics that a model lacks, with proof on held-out data
#[derive(Args)]
#[command(after_help = not_tested())]
pub struct Diagnose {
    #[command(flatten)]
    recordings: RecordingArgs,

    /// The model to check; without it the fit of `preslide identify`
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,

    /// Judge your own simulation: the column with the force or torque that it needs for the recorded motion; or the position that it
    /// reaches under the recorded force or torque, or under its own, which is then a second column. Or its own file
    /// (simulation.csv, simulation.csv:force_N), at any rate and start
    #[arg(
        long,
        value_name = "COLUMN[,COLUMN]|FILE[:COLUMN]",
        value_delimiter = ',',
        conflicts_with = "model"
    )]
    simulated: Vec<String>,

    /// Write a motion (reference position, CSV) that would show what this recording cannot
    #[arg(long, value_name = "MOTION.csv")]
    experiment: Option<PathBuf>,

    /// With --experiment: write only what would decide the most costly doubt. Give the effects whose experiments were already played,
    /// or none. If nothing is in doubt, no file is written
    #[arg(
        long,
        value_name = "ID",
        value_delimiter = ',',
        requires = "experiment"
    )]
    asked: Option<Vec<String>>,

    /// Write the model, or the fit, with the confident effects added; with --simulated what the simulation lacks: a table of forces, term
    /// by term (.csv), or the code to add (.py, .c, .m), each kind once
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,

    /// Print every candidate with its share of the mismatch, standard errors and parameters
    #[arg(long)]
    table: bool,

    #[command(flatten)]
    outputs: OutputArgs,
}

fn not_tested() -> String {
    let tested: Vec<&str> = effect::ALL.iter().map(|e| e.id()).collect();
    format!(
        "Example: preslide diagnose recording.csv --model model.toml -o extended.toml --report diagnosis.html\n         preslide diagnose recording.csv --simulated force_sim_N\n         preslide diagnose recording.csv --simulated x_sim_m\n\nTested: {}, presliding_shape.\n\nlead_error, periodic_lead_error: if a further column measures the position too.",
        tested.join(", ")
    )
}

impl Diagnose {
    /// Runs the command.
    pub fn run(mut self) -> Result<(), Failure> {
        let start = Instant::now();
        self.check_kinds()?;
        self.check_asked()?;
        let outputs = self.output.iter().map(|path| ("-o", Some(path)));
        let own: Vec<_> = outputs
            .chain([("--experiment", self.experiment.as_ref())])
            .collect();
        self.recordings
            .check_outputs(self.model.as_ref(), &own, &self.outputs)?;
        let model = self.model.as_deref().map(Model::load).transpose()?;
        self.recordings.take(&self.simulated);
        // However many samples there are: what is said must not turn on the length of the recording.
        let loaded = self.recordings.load()?;
        let fit = self
            .simulated
            .is_empty()
            .then(|| Arc::new(Fit::of(&loaded)));
        let mut recording = thin(loaded, 0);
        let simulated = self.take_simulated(&mut recording)?;
        let progress = Progress::new("diagnose, steps of the search", 0);
        let found = match simulated {
            Some(simulated) => diagnose_simulation(&recording, simulated, &progress),
            None => diagnose(&recording, model.as_ref(), fit.clone(), &progress),
        };
        let found = match found {
            Ok(found) => found,
            Err(Refusal::Data(message)) => {
                let answer = serde_json::json!({
                    "schema": "preslide.diagnosis/1", "recording": recording.name, "effort_unit": recording.effort_unit(), "verdict": "insufficient-data",
                    "fit": fit.as_ref().map(|fit| fit.to_json(&recording)), "reason": message, "effects": [], "unknown": null, "seconds": start.elapsed().as_secs_f64(),
                });
                self.outputs.write_json(&answer)?;
                // Say once why there is none.
                if let Some(fit) = fit.filter(|fit| fit.is_found()) {
                    explain!("Note: {}.", fit.words(&recording));
                }
                return Err(Failure::Data(format!("insufficient data: {message}")));
            }
            Err(refusal) => return Err(refusal.into()),
        };
        progress.finish();
        explain!("{}\n", found.verdict_lines(&recording));
        if let Some(fit) = found.fit_words(&recording) {
            explain!("Note: {fit}.\n");
        }
        for left_out in found.left_out_words() {
            explain!("Note: {left_out}.\n");
        }
        if let Some(given) = found.given_words(&recording) {
            explain!("Note: {given}.\n");
        }
        if let Some(table) = found.given_table(&recording) {
            explain!("{}", table.to_text());
        }
        if let Some(late) = found.simulated_late {
            say!(
                "Note: the simulation is {:.3} ms later than the recording; that is taken off.\n",
                1e3 * late
            );
        }
        if let Some(reproduced) = &found.reproduced {
            explain!("Note: {}.\n", reproduced.words(&recording));
        }
        if let Some(per) = recording.per_unit() {
            explain!("Note: {per}.\n");
        }
        explain!("{}", found.budget_text(&recording));
        let besides = [
            found.in_fit_words(&recording),
            found.possible_words(&recording),
        ];
        for words in besides.into_iter().flatten() {
            explain!("{words}.\n");
        }
        if self.table && !found.effects.is_empty() {
            explain!("{}", found.table(&recording).to_text());
        }
        for second in &found.second_positions {
            explain!("Second position: {}.", second.words(&recording));
        }
        for lack in &found.lacks {
            explain!("{}", lack.words());
        }
        explain!("{}", found.recommendation(&recording));
        let mut next = self.next(found.verdict);
        if self.simulated.is_empty() {
            for path in &self.output {
                next = write_extended(path, &found, &recording, &self.recordings)?;
            }
        } else {
            self.write_correction(&found, &recording)?;
        }
        let mut experiment = serde_json::Value::Null;
        if let Some(path) = &self.experiment {
            let next = match &self.asked {
                Some(asked) => Experiment::next(&found, asked),
                None => Some(Experiment::for_all(&found)),
            };
            let column = recording.kind.reference_column();
            match next {
                Some(next) => {
                    write_text(path, &next.csv(column))?;
                    experiment =
                        serde_json::json!({ "about": next.about, "seconds": next.seconds() });
                    explain!("{}: {}.", path.display(), next.words());
                    let play = ["preslide", "drive", "PORT", "play"].map(str::to_owned);
                    let to = ["-o", "axis2.csv"].map(str::to_owned);
                    let file = [path.display().to_string()];
                    let play = in_words(play.into_iter().chain(file).chain(to));
                    say!("Next, on the axis: {play}");
                }
                None => say!(
                    "Nothing is in doubt that an experiment could decide: {} is not written.",
                    path.display()
                ),
            }
        }
        if self.simulated.is_empty() && found.verdict != Verdict::InsufficientData {
            say!("Next: {next}");
        }
        let seconds = start.elapsed().as_secs_f64();
        let mut answer = found.to_json(&recording, seconds);
        answer["experiment"] = experiment;
        self.outputs
            .write(&answer, || found.page(&recording, command_line()))?;
        if found.verdict == Verdict::InsufficientData {
            return Err(Failure::Data(found.verdict_words(&recording)));
        }
        Ok(())
    }

    /// The command that follows where no model was written.
    fn next(&self, verdict: Verdict) -> String {
        let again = self.recordings.command("diagnose", self.model.as_deref());
        match (verdict, &self.model) {
            (Verdict::MissingPhysics | Verdict::ParametersDiffer, _) => {
                format!("{again} -o extended.toml")
            }
            (Verdict::Consistent, Some(model)) => self.recordings.export(model, &[]),
            (Verdict::Consistent, None) => {
                let identify = self.recordings.command("identify", None);
                format!("{identify} -o model.toml")
            }
            _ => format!("{again} --report diagnosis.html"),
        }
    }

    /// A model goes in one file, a correction of a simulation in a table or code.
    fn check_kinds(&self) -> Result<(), Failure> {
        if self.simulated.is_empty() {
            let several = self.output.len() > 1;
            return match several {
                true => Err(Failure::Input(
                    "-o: there is one extended model; name one file".to_owned(),
                )),
                false => Ok(()),
            };
        }
        let is_known = |path: &&PathBuf| is_table(path) || Language::of(path).is_some();
        match self.output.iter().find(|path| !is_known(path)) {
            Some(path) => Err(Failure::Input(format!(
                "-o {}: with --simulated it writes a correction, not a model: name a file .csv (the force of each term at every sample), .py, .c, .h or .m (code to add to the simulation)",
                path.display()
            ))),
            None => Ok(()),
        }
    }

    /// Effects for which an experiment was played go by their ids.
    fn check_asked(&self) -> Result<(), Failure> {
        let asked = self.asked.iter().flatten().map(String::as_str);
        let is_unknown = |id: &&str| *id != "none" && !experiment::may_be_for(id);
        let unknown: Vec<&str> = asked.filter(is_unknown).collect();
        match unknown.is_empty() {
            true => Ok(()),
            false => Err(Failure::Input(format!(
                "--asked {}: not in the catalogue; the ids are at the end of `preslide diagnose --help`, and `none` is for the first experiment",
                unknown.join(",")
            ))),
        }
    }

    /// What the simulation lacks, and what it leaves with that.
    fn write_correction(&self, found: &Diagnosis, recording: &Recording) -> Result<(), Failure> {
        let Some(correction) = &found.correction else {
            if !self.output.is_empty() {
                say!(
                    "Nothing found makes the simulation better at the samples: no correction is written."
                );
            }
            return Ok(());
        };
        let words = capital(&correction.words(&found.null.rows, recording));
        explain!("{words}.");
        let remarks = [
            format!(
                "What {} lacks compared with {}. {words}.",
                self.simulated.join(","),
                recording.name
            ),
            found.verdict_words(recording),
        ];
        for path in &self.output {
            let text = match Language::of(path) {
                Some(language) => correction.code(language, &remarks),
                None => correction.csv(recording),
            };
            write_text(path, &text)?;
        }
        if self.output.is_empty() {
            say!("Next: the same with -o correction.csv -o correction.py (or .c, .m)");
        }
        Ok(())
    }

    /// The simulation's columns, with what is to be said of them.
    fn take_simulated(&self, recording: &mut Recording) -> Result<Option<Simulated>, Failure> {
        if self.simulated.is_empty() {
            return Ok(None);
        }
        let known = recording.warnings.len();
        let of_file = match self.simulated.as_slice() {
            [one] => recording
                .load_simulated(one, beside_the_motion)
                .map_err(Failure::Input)?,
            _ => None,
        };
        let values = match of_file {
            Some(values) => values,
            None => recording
                .take_simulated(&self.simulated)
                .map_err(Failure::Input)?,
        };
        for warning in &recording.warnings[known..] {
            tell!("{}: warning: {warning}", recording.name);
        }
        Ok(Some(values))
    }
}

/// Whether a file is a table by its name.
fn is_table(path: &Path) -> bool {
    is_stdout(path) || path.extension().is_some_and(|ending| ending == "csv")
}

/// The user's model or the fit with what was found with confidence; the command that compiles it in.
fn write_extended(
    path: &Path,
    found: &Diagnosis,
    recording: &Recording,
    files: &RecordingArgs,
) -> Result<String, Failure> {
    let extended = found.extended_model(recording);
    // What is said of a file is a line each, by which the Python package leaves out what is said of its own.
    if !extended.replaces.is_empty() {
        say!(
            "{} replaces {}.",
            path.display(),
            extended.replaces.join(", ")
        );
    }
    for reason in &extended.refused {
        say!("Not in {}: {reason}.", path.display());
    }
    if let Err(reason) = no_refused(&extended.model) {
        say!("{} for `preslide export`: {reason}.", path.display());
    }
    let mut remarks = vec![
        format!("diagnosed from {}", recording.name),
        found.verdict_words(recording),
    ];
    remarks.extend(recording.per_unit());
    write_model(path, &extended.model.to_toml(&remarks))?;
    let useless = preslide_host::export::refused(&extended.model);
    let without = useless.iter();
    let without = without.flat_map(|(id, _)| ["--without".to_owned(), (*id).to_owned()]);
    Ok(files.export(path, &without.collect::<Vec<_>>()))
}
