//! `preslide demo`.

use super::{Failure, OutputArgs, command_line, write_text};
use anyhow::anyhow;
use clap::Args;
use preslide_host::diagnose::diagnose;
use preslide_host::export::{self, refused, rust_source};
use preslide_host::identify::{Options, STEPS, identify};
use preslide_host::progress::Progress;
use preslide_host::recording::{self, LoadOptions};
use preslide_sim::chain::{Trial, follow, known, record};
use preslide_sim::demo::Story;
use std::path::PathBuf;
use std::time::Instant;

/// The whole story on data the tool makes itself, offline, in under a minute
#[derive(Args)]
#[command(
    after_help = "Example: preslide demo --out preslide-report\n\nPositions are in m, forces in N, times in s. Other seeds hide other effects."
)]
pub struct Demo {
    /// Folder for the recording, the models, the source for the firmware and the report
    #[arg(long, value_name = "FOLDER", default_value = "preslide-report")]
    out: PathBuf,

    /// Seed of the effect that the simulated stage hides, and of its friction
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

impl Demo {
    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        let start = Instant::now();
        std::fs::create_dir_all(&self.out)
            .map_err(|e| Failure::Input(format!("--out {}: {e}", self.out.display())))?;
        let file = |name: &str| self.out.join(name);
        let trial = Trial::draw(self.seed, 1);
        let trial = trial.first().ok_or_else(|| anyhow!("there is one trial"))?;

        say!(
            "1. A simulated stage (seed {}: 3 kg on a 2 mm screw) follows strokes of 150 to 8 µm, slow slides and passes over\n   \
             4 mm under the firmware's control code; encoder count and motor current are recorded. Its friction is a\n   \
             64-element hysteresis that wanders by up to ±15 % and is no GMS; besides, it hides something.\n",
            self.seed
        );
        let text = record(trial)?;
        write_text(&file("recording.csv"), &text)?;

        say!(
            "\n2. How many blocks: preslide identify {}\n",
            file("recording.csv").display()
        );
        let recording = recording::load(&file("recording.csv"), &LoadOptions::default())?;
        let progress = Progress::new("identify", STEPS);
        let found = identify(&recording, &Options::default(), &progress).map_err(Failure::Data)?;
        progress.finish();
        super::identify::print(&found, &recording);
        let model = super::identify::model_text(&found, &recording);
        write_text(&file("model.toml"), &model)?;

        say!("\n3. What is missing: preslide diagnose, from that recording and that model alone\n");
        let before = &found.best().model;
        let progress = Progress::new("diagnose, steps of the search", 0);
        let diagnosis = diagnose(&recording, Some(before), &progress)?;
        progress.finish();
        say!("{}\n", diagnosis.verdict_words(&recording));
        say!("{}", diagnosis.table(&recording).to_text());
        say!("{}", diagnosis.recommendation());
        let (mut after, _) = diagnosis.extended_model(&recording, Some(before));
        let useless: Vec<&str> = refused(&after).iter().map(|(id, _)| *id).collect();
        after.effects.retain(|effect| !useless.contains(&effect.id));
        let extended = after.to_toml(&[format!("diagnosed from {}", recording.name)]);
        write_text(&file("extended.toml"), &extended)?;
        let source =
            rust_source(&after, &export::Options::default()).map_err(|reason| anyhow!(reason))?;
        write_text(&file("stage_model.rs"), &source)?;

        say!("\n4. How much better it tracks: another motion, the same gains, the same stage\n");
        let truth = known(trial).map_err(|reason| anyhow!(reason))?;
        let run = |model| anyhow::Ok(follow(trial, model)?);
        let story = Story {
            trial,
            recording: &recording,
            found: &found,
            diagnosis: &diagnosis,
            followed: [
                run(None)?,
                run(Some(before))?,
                run(Some(&after))?,
                run(Some(&truth))?,
            ],
        };
        say!("{}", story.table().to_text());
        say!("{}", story.outcome());
        say!("What it was: {}.\n", trial.effect.words());

        let seconds = start.elapsed().as_secs_f64();
        let outputs = OutputArgs {
            json: Some(file("identification.json")),
            report: Some(file("report.html")),
        };
        outputs.write(&found.to_json(&recording, seconds), || {
            story.page(command_line())
        })?;
        let outputs = OutputArgs {
            json: Some(file("diagnosis.json")),
            report: None,
        };
        outputs.write_json(&diagnosis.to_json(&recording, seconds))?;
        say!(
            "Open {} in a browser. Then try a recording of your own: preslide identify REC.csv",
            file("report.html").display()
        );
        Ok(())
    }
}
