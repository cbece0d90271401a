//! `preslide demo`.

use super::{Failure, OutputArgs, command_line, write_text};
use clap::Args;
use preslide_host::demo;
use preslide_host::identify::{Options, STEPS, identify};
use preslide_host::progress::Progress;
use preslide_host::recording::{self, LoadOptions};
use std::path::PathBuf;
use std::time::Instant;

/// The whole story on data the tool makes itself, offline, in under a minute
#[derive(Args)]
#[command(
    after_help = "Example: preslide demo --out preslide-report\n\nPositions are in m, forces in N, times in s."
)]
pub struct Demo {
    /// Folder for the recording, the model, the report and its picture
    #[arg(long, value_name = "FOLDER", default_value = "preslide-report")]
    out: PathBuf,

    /// Seed of everything random in the simulated stage
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

        say!(
            "1. A stage moves back and forth by 150, 60, 20 and 8 µm, six times, at 40 µm/s, under a plain position\n   \
             controller. Encoder count and motor current are recorded. The stage is simulated (seed {}): 3 kg on a 2 mm\n   \
             screw; its friction is a 64-element hysteresis that yields smoothly, wanders by up to ±15 % and is no GMS.\n",
            self.seed
        );
        let progress = Progress::new("stage", 100);
        let samples = demo::record(self.seed, &progress)?;
        progress.finish();
        write_text(&file("recording.csv"), &samples.to_csv())?;

        say!(
            "\n2. `preslide identify {}`\n",
            file("recording.csv").display()
        );
        let recording = recording::load(&file("recording.csv"), &LoadOptions::default())?;
        let progress = Progress::new("identify", STEPS);
        let found = identify(&recording, &Options::default(), &progress).map_err(Failure::Data)?;
        progress.finish();
        super::identify::print(&found, &recording);

        say!("\n3. What to do with it\n");
        write_text(
            &file("model.toml"),
            &super::identify::model_text(&found, &recording),
        )?;
        let seconds = start.elapsed().as_secs_f64();
        let outputs = OutputArgs {
            json: Some(file("identification.json")),
            report: Some(file("identification.html")),
        };
        outputs.write(&found.to_json(&recording, seconds), || {
            found.page(&recording, command_line())
        })?;
        say!(
            "Open {} in a browser. Then try a recording of your own: preslide identify REC.csv",
            file("identification.html").display()
        );
        Ok(())
    }
}
