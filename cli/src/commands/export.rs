//! `preslide export`.

use super::{Failure, ReadingArgs, outputs, write_text};
use clap::Args;
use preslide_host::export::{Options, reduced, rust_source, sha256};
use preslide_host::model::{Model, ModelError, read};
use preslide_host::recording::Needs;
use preslide_host::simulate::force_of_motion;
use std::path::{Path, PathBuf};

/// A model as Rust source for the firmware: constants, the composed type, and the function that builds it
#[derive(Args)]
#[command(
    after_help = "Example: preslide export model.toml --recording axis.csv -o src/stage_model.rs"
)]
pub struct Export {
    /// Model file, as `identify` and `diagnose` write it
    #[arg(value_name = "MODEL.toml")]
    model: PathBuf,

    /// Leave out an effect that no controller can use, or that this one should not: its id; may be repeated
    #[arg(long, value_name = "ID")]
    without: Vec<String>,

    /// Bound on each force that grows with speed or position, in N or N·m; ten times the breakaway force without it
    #[arg(long, value_name = "FORCE")]
    limit: Option<f64>,

    /// Recording to name in the source by its hash, with the error of the exported model on it; may be repeated
    #[arg(long, value_name = "REC")]
    recording: Vec<PathBuf>,

    #[command(flatten)]
    reading: ReadingArgs,

    /// Write the source; without it, it goes to the terminal
    #[arg(short, long, value_name = "OUT.rs")]
    output: Option<PathBuf>,
}

impl Export {
    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        let mut inputs = vec![self.model.as_path()];
        inputs.extend(self.recording.iter().map(PathBuf::as_path));
        outputs::check(&inputs, &[("-o", self.output.as_ref())], None)?;
        let file = self.model.display().to_string();
        let text = read(&self.model).map_err(|source| ModelError::Unreadable {
            file: file.clone(),
            source,
        })?;
        let in_file = |reason: String| Failure::Input(format!("{file}: {reason}"));
        let whole = Model::parse(&text).map_err(in_file)?;
        let model = reduced(&whole, &self.without).map_err(in_file)?;

        let mut remarks = vec![
            "Written by `preslide export`; do not edit, export again. As a module: `#[rustfmt::skip] mod …;`.".to_owned(),
            format!(
                "Model {}, SHA-256 {}.",
                name(&self.model),
                sha256(text.as_bytes())
            ),
        ];
        let head = text.lines().map_while(|line| line.strip_prefix('#'));
        remarks.extend(head.map(|line| format!("Model: {}.", line.trim().trim_end_matches('.'))));
        for id in &self.without {
            remarks.push(format!("Left out by request: {id}."));
        }
        for path in &self.recording {
            remarks.push(self.error_on(&model, path)?);
        }
        let options = Options {
            remarks,
            limit: self.limit,
        };
        let source = rust_source(&model, &options).map_err(in_file)?;

        match &self.output {
            Some(path) => write_text(path, &source)?,
            None => say!("{}", source.trim_end()),
        }
        let place = self
            .output
            .as_deref()
            .map_or("a file of the firmware".into(), |p| p.display().to_string());
        tell!(
            "Declare {place} as a module and call model::<f32>(sample_time, Units::SI): its type, Model<f32>, is what the controller takes. This project's firmware is built with it where PRESLIDE_MODEL holds its full path."
        );
        Ok(())
    }

    /// What a recording says of the model, as a sentence.
    fn error_on(&self, model: &Model, path: &Path) -> Result<String, Failure> {
        let bytes =
            std::fs::read(path).map_err(|e| Failure::Input(format!("{}: {e}", path.display())))?;
        let recording = self.reading.load(&[path.to_owned()], Needs::Motion)?;
        let found = force_of_motion(model, &recording).map_err(Failure::Input)?;
        let error = match found.agreement {
            Some(agreement) => format!(
                "NMSE {:.4} %, RMS error {:.4e} {}",
                agreement.nmse,
                agreement.rms,
                recording.effort_unit()
            ),
            None => "no force to compare with".to_owned(),
        };
        Ok(format!(
            "Recording {}, SHA-256 {}: {error}.",
            name(path),
            sha256(&bytes)
        ))
    }
}

/// The file's name without its folder, which is of no use elsewhere.
fn name(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}
