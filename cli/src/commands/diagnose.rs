//! `preslide diagnose`.

use super::{Failure, OutputArgs, RecordingArgs, command_line, thin, write_text};
use clap::Args;
use preslide_host::diagnose::fit::Fit;
use preslide_host::diagnose::verdict::Verdict;
use preslide_host::diagnose::{Refusal, diagnose, diagnose_simulation, effect, experiment};
use preslide_host::model::Model;
use preslide_host::progress::Progress;
use preslide_host::recording::{Recording, Simulated};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// Where recording and model differ, what physics is missing, and the proof
#[derive(Args)]
#[command(after_help = not_tested())]
pub struct Diagnose {
    #[command(flatten)]
    recordings: RecordingArgs,

    /// The model to check; without it the fit of `preslide identify`
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,

    /// Judge a simulation of your own: the column with the force or torque that it needs for the recorded motion; or with the
    /// position that it comes to under the recorded force or torque, or under its own, which is then a second column
    #[arg(
        long,
        value_name = "COLUMN[,COLUMN]",
        value_delimiter = ',',
        conflicts_with = "model"
    )]
    simulated: Vec<String>,

    /// Write a motion that would show what this recording cannot (a reference position, CSV)
    #[arg(long, value_name = "MOTION.csv")]
    experiment: Option<PathBuf>,

    /// Write the model, or the fit, extended by what was found with confidence
    #[arg(short, long, value_name = "EXTENDED.toml")]
    output: Option<PathBuf>,

    /// Print every candidate that was judged with its share of the mismatch, its standard errors and its parameters
    #[arg(long)]
    table: bool,

    #[command(flatten)]
    outputs: OutputArgs,
}

fn not_tested() -> String {
    let tested: Vec<&str> = effect::ALL.iter().map(|e| e.id()).collect();
    format!(
        "Example: preslide diagnose recording.csv --model model.toml -o extended.toml --report diagnosis.html\n         preslide diagnose recording.csv --simulated force_sim_N\n         preslide diagnose recording.csv --simulated x_sim_m\n\nTested: {}, presliding_shape.\n\nlead_error, periodic_lead_error: told where a further column measures the position, too.",
        tested.join(", ")
    )
}

impl Diagnose {
    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        let start = Instant::now();
        let own = [
            ("-o", self.output.as_ref()),
            ("--experiment", self.experiment.as_ref()),
        ];
        self.recordings
            .check_outputs(self.model.as_ref(), &own, &self.outputs)?;
        let model = self.model.as_deref().map(Model::load).transpose()?;
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
                    "schema": "preslide.diagnosis/1", "recording": recording.name, "verdict": "insufficient-data",
                    "fit": fit.as_ref().map(|fit| fit.to_json(&recording)), "reason": message, "effects": [], "unknown": null, "seconds": start.elapsed().as_secs_f64(),
                });
                self.outputs.write_json(&answer)?;
                // Why there is none is said once.
                if let Some(fit) = fit.filter(|fit| fit.is_found()) {
                    say!("Note: {}.", fit.words(&recording));
                }
                return Err(Failure::Data(format!("insufficient-data: {message}")));
            }
            Err(refusal) => return Err(refusal.into()),
        };
        progress.finish();
        say!("{}\n", found.verdict_words(&recording));
        if let Some(fit) = &found.fit {
            say!("Note: {}.\n", fit.words(&recording));
        }
        for left_out in found.left_out_words() {
            say!("Note: {left_out}.\n");
        }
        if let Some(given) = found.given_words() {
            say!("Note: {given}.\n");
        }
        if let Some(table) = found.given_table() {
            say!("{}", table.to_text());
        }
        if let Some(reproduced) = &found.reproduced {
            say!("Note: {}.\n", reproduced.words(&recording));
        }
        if let Some(per) = recording.per_unit() {
            say!("Note: {per}.\n");
        }
        say!("{}", found.budget_text(&recording));
        let besides = [
            found.in_fit_words(&recording),
            found.possible_words(&recording),
        ];
        for words in besides.into_iter().flatten() {
            say!("{words}.\n");
        }
        if self.table && !found.effects.is_empty() {
            say!("{}", found.table(&recording).to_text());
        }
        for second in &found.second_positions {
            say!("Second position: {}.", second.words(&recording));
        }
        for lack in &found.lacks {
            say!("Cannot show {}: {}.", lack.hides.join(", "), lack.missing);
        }
        say!("{}", found.recommendation());
        if let Some(path) = &self.output {
            let extended = found.extended_model(&recording, model.as_ref());
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
            let mut remarks = vec![
                format!("diagnosed from {}", recording.name),
                found.verdict_words(&recording),
            ];
            remarks.extend(recording.per_unit());
            if !self.simulated.is_empty() {
                remarks.push(format!("the effects are what {} lacks; inertia and friction are the recording's own, which their levels refer to", self.simulated.join(",")));
            }
            write_text(path, &extended.model.to_toml(&remarks))?;
        }
        if let Some(path) = &self.experiment {
            let (motion, words) = experiment::profile(&recording, &found);
            write_text(path, &motion)?;
            say!("{}: {words}.", path.display());
        }
        let seconds = start.elapsed().as_secs_f64();
        self.outputs
            .write(&found.to_json(&recording, seconds), || {
                found.page(&recording, command_line())
            })?;
        if found.verdict == Verdict::InsufficientData {
            return Err(Failure::Data(found.verdict_words(&recording)));
        }
        Ok(())
    }

    /// The simulation's columns, with what is to be said of them.
    fn take_simulated(&self, recording: &mut Recording) -> Result<Option<Simulated>, Failure> {
        if self.simulated.is_empty() {
            return Ok(None);
        }
        let known = recording.warnings.len();
        let values = recording
            .take_simulated(&self.simulated)
            .map_err(Failure::Input)?;
        for warning in &recording.warnings[known..] {
            eprintln!("{}: warning: {warning}", recording.name);
        }
        Ok(Some(values))
    }
}
