//! `preslide demo`.

use super::tune::{SHARE, plan};
use super::{Failure, OutputArgs, command_line, write_text};
use anyhow::anyhow;
use clap::Args;
use preslide_fit::identify::{Identification, Options, STEPS, identify};
use preslide_fit::model::Model;
use preslide_fit::progress::Progress;
use preslide_fit::recording::{self, LoadOptions, Recording};
use preslide_host::cost::DEFAULT;
use preslide_host::diagnose::{Diagnosis, diagnose};
use preslide_host::export::{self, refused, rust_source};
use preslide_host::tune::{Choice, Tuning, of_model};
use preslide_sim::chain::{Trial, follow, follow_by, known, record};
use preslide_sim::demo::Story;
use std::path::PathBuf;
use std::time::Instant;

/// Record, identify, diagnose and track a simulated stage that hides something; under a minute
#[derive(Args)]
#[command(
    after_help = "Example: preslide demo --out preslide-report\n\nIn the files positions are in m, forces in N, times in s; what is printed has its unit."
)]
pub struct Demo {
    /// Folder for the recording, the models, the source for the firmware and the report
    #[arg(long, value_name = "FOLDER", default_value = "preslide-report")]
    out: PathBuf,

    /// Seed of the stage's friction and of the effect that it hides
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

impl Demo {
    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        let start = Instant::now();
        std::fs::create_dir_all(&self.out)
            .map_err(|e| Failure::Input(format!("--out {}: {e}", self.out.display())))?;
        let trial = Trial::draw(self.seed, 1);
        let trial = trial.first().ok_or_else(|| anyhow!("there is one trial"))?;
        say!(
            "A simulated stage that hides something is recorded, identified, diagnosed and compensated. Some twenty seconds.\n"
        );
        let recording = self.record(trial)?;
        let found = self.identify(&recording)?;
        let before = &found.best().model;
        let (diagnosis, after) = self.diagnose(&recording, before)?;
        let exported = self.export(trial, &after, &recording)?;
        let truth = known(trial).map_err(|reason| anyhow!(reason))?;
        let run = |model| anyhow::Ok(follow(trial, model)?);
        let story = Story {
            trial,
            recording: &recording,
            found: &found,
            diagnosis: &diagnosis,
            exported: &exported,
            models: [&after, &truth],
            followed: [
                run(None)?,
                run(Some(before))?,
                run(Some(&after))?,
                follow_by(trial, &after, exported.kernel).map_err(anyhow::Error::from)?,
                run(Some(&truth))?,
            ],
        };
        self.tell(&story);
        self.report(&story, start.elapsed().as_secs_f64())
    }

    /// The result first, then how it came about.
    fn tell(&self, story: &Story) {
        explain!("{}\n", story.outcome());
        explain!("{}", story.table().to_text());
        explain!("{}", story.truth_table().to_text());
        say!(
            "How: 1. A simulated stage (seed {}: 3 kg and a rotor of 1 kg on a 2 mm screw) followed strokes of\n\
             150 to 8 µm, slow slides and passes over 4 mm under the firmware's control code; encoder count and\n\
             motor current were recorded. Its friction is a 64-element hysteresis that wanders by up to ±15 % and\n\
             is not a GMS model; and it hid something.\n",
            self.seed
        );
        let file = |name: &str| self.file(name).display().to_string();
        say!("2. preslide identify {}\n", file("recording.csv"));
        super::identify::print(story.found, story.recording);
        say!(
            "\n3. preslide diagnose {} --model {}\n",
            file("recording.csv"),
            file("model.toml")
        );
        explain!("{}\n", story.diagnosis.verdict_lines(story.recording));
        explain!("{}", story.diagnosis.budget_text(story.recording));
        explain!("{}", story.diagnosis.recommendation(story.recording));
        say!(
            "\n4. preslide export {} --recording {} --kernel auto --count {:e}\n",
            file("extended.toml"),
            file("recording.csv"),
            story.trial.axis.encoder.count
        );
        say!(
            "{} Source: {}.",
            story.exported.said(DEFAULT),
            file("stage_model.rs")
        );
        say!("\n5. Another motion, the same gains, the same stage: the errors above.\n");
    }

    fn file(&self, name: &str) -> PathBuf {
        self.out.join(name)
    }

    /// The simulated stage's recording, as the tool reads it back.
    fn record(&self, trial: &Trial) -> Result<Recording, Failure> {
        let text = record(trial)?;
        write_text(&self.file("recording.csv"), &text)?;
        Ok(recording::load(
            &self.file("recording.csv"),
            &LoadOptions::default(),
        )?)
    }

    fn identify(&self, recording: &Recording) -> Result<Identification, Failure> {
        let progress = Progress::new("identify", STEPS);
        let found = identify(recording, &Options::default(), &progress).map_err(Failure::Data)?;
        progress.finish();
        let model = super::identify::model_text(&found, recording);
        write_text(&self.file("model.toml"), &model)?;
        Ok(found)
    }

    /// The diagnosis, and the model with all of it that a controller can use.
    fn diagnose(
        &self,
        recording: &Recording,
        before: &Model,
    ) -> Result<(Diagnosis, Model), Failure> {
        let progress = Progress::new("diagnose, steps of the search", 0);
        let diagnosis = diagnose(recording, Some(before), None, &progress)?;
        progress.finish();
        let mut after = diagnosis.extended_model(recording).model.clone();
        let useless: Vec<&str> = refused(&after).iter().map(|(id, _)| *id).collect();
        after
            .effects
            .retain(|effect| !useless.contains(&effect.id()));
        let extended = after.to_toml(&[format!("diagnosed from {}", recording.name)]);
        write_text(&self.file("extended.toml"), &extended)?;
        Ok((diagnosis, after))
    }

    /// Source for the firmware, with the kernel that `preslide tune` recommends for the core that this project's boards have.
    fn export(
        &self,
        trial: &Trial,
        model: &Model,
        recording: &Recording,
    ) -> Result<Choice, Failure> {
        let rate = trial.axis.hardware.rate_hz.into();
        let (costs, budget) = plan(DEFAULT, None, rate, SHARE).map_err(|reason| anyhow!(reason))?;
        let tuning = of_model(model, trial.axis.encoder.count, &costs, budget);
        let choice = tuning.and_then(Tuning::chosen).map_err(Failure::Data)?;
        let options = export::Options {
            remarks: vec![choice.said(DEFAULT)],
            reached: export::reached(model, recording).map_err(|reason| anyhow!(reason))?,
            kernel: Some(choice.kernel),
            ..export::Options::default()
        };
        let source = rust_source(model, &options).map_err(|reason| anyhow!(reason))?;
        write_text(&self.file("stage_model.rs"), &source)?;
        Ok(choice)
    }

    /// The files for machines, and the page.
    fn report(&self, story: &Story, seconds: f64) -> Result<(), Failure> {
        let outputs = OutputArgs {
            json: Some(self.file("identification.json")),
            report: Some(self.file("report.html")),
        };
        outputs.write(&story.found.to_json(story.recording, seconds), || {
            story.page(command_line())
        })?;
        let outputs = OutputArgs {
            json: Some(self.file("diagnosis.json")),
            report: None,
        };
        outputs.write_json(&story.diagnosis.to_json(story.recording, seconds))?;
        say!(
            "Open {} in a browser. Then try a recording of your own: preslide identify REC.csv",
            self.file("report.html").display()
        );
        Ok(())
    }
}
