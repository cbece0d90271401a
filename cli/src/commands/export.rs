//! `preslide export`.

use super::{Failure, ReadingArgs, outputs, write_text};
use clap::Args;
use preslide_host::export::joint::{Format, Joint};
use preslide_host::export::{Options, reduced, rust_source, sha256};
use preslide_host::model::{Model, ModelError, read};
use preslide_host::recording::Needs;
use preslide_host::simulate::force_of_motion;
use std::path::{Path, PathBuf};

/// A model as Rust source for the firmware: constants, the composed type, and the function that builds it; or as a simulator's joint
#[derive(Args)]
#[command(
    after_help = "Example: preslide export model.toml --recording axis.csv -o src/stage_model.rs\n         preslide export model.toml --mjcf -o joint.xml"
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

    /// A joint of MuJoCo instead: frictionloss, damping, armature; what it cannot hold is said, and stands in comments
    #[arg(long, conflicts_with_all = ["limit", "urdf"])]
    mjcf: bool,

    /// A joint of URDF instead: the friction and damping of its dynamics
    #[arg(long, conflicts_with = "limit")]
    urdf: bool,

    /// Recording to name in the source by its hash, with the error of the exported model on it; may be repeated
    #[arg(long, value_name = "REC")]
    recording: Vec<PathBuf>,

    #[command(flatten)]
    reading: ReadingArgs,

    /// Write the source; without it, it goes to the terminal
    #[arg(short, long, value_name = "OUT")]
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

        let format = match (self.mjcf, self.urdf) {
            (true, _) => Some(Format::Mjcf),
            (_, true) => Some(Format::Urdf),
            _ => None,
        };
        let joint = format.map(|format| Joint::of(&model, format));
        let joint = joint.transpose().map_err(in_file)?;
        let how = match &joint {
            Some(_) => "Written by `preslide export`: a joint, for a body of yours.",
            None => {
                "Written by `preslide export`; do not edit, export again. As a module: `#[rustfmt::skip] mod …;`."
            }
        };
        let mut remarks = vec![
            how.to_owned(),
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
            let exported = joint.as_ref().map_or(&model, |joint| &joint.model);
            remarks.push(self.error_on(exported, path)?);
        }
        if let Some(joint) = joint {
            self.write(&joint.to_xml(&remarks))?;
            for clause in &joint.left_out {
                tell!("Not in the joint: {clause}.");
            }
            return Ok(());
        }
        let options = Options {
            remarks,
            limit: self.limit,
        };
        self.write(&rust_source(&model, &options).map_err(in_file)?)?;
        let place = self
            .output
            .as_deref()
            .map_or("a file of the firmware".into(), |p| p.display().to_string());
        tell!(
            "Declare {place} as a module and call model::<f32>(sample_time, Units::SI): its type, Model<f32>, is what the controller takes. This project's firmware is built with it where PRESLIDE_MODEL holds its full path."
        );
        Ok(())
    }

    /// To the file that was asked for, or the terminal.
    fn write(&self, text: &str) -> Result<(), Failure> {
        match &self.output {
            Some(path) => write_text(path, text),
            None => {
                say!("{}", text.trim_end());
                Ok(())
            }
        }
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
