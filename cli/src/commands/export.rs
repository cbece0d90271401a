//! `preslide export`.

use super::tune::{SHARE, count_of, plan};
use super::{Failure, ReadingArgs, of_axis, outputs, parse_frequency, write_text};
use clap::{Args, ValueEnum};
use preslide_drive::quantity::{self, Quantity};
use preslide_fit::kernel::{Arithmetic, Kernel};
use preslide_fit::model::{Model, ModelError, read};
use preslide_fit::recording::Needs;
use preslide_fit::report::figures::quantity;
use preslide_fit::simulate::force_of_motion;
use preslide_host::cost::DEFAULT;
use preslide_host::export::joint::{Format, Joint};
use preslide_host::export::{
    Bound, Options, Reached, bounds, c_source, reached, reduced, rust_source, sha256,
};
use preslide_host::tune::{TOO_COARSE, counting, counting_note, of_model, too_coarse};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Write a model as source for the firmware, in Rust or C, or as a simulator's joint (MuJoCo, URDF, OpenUSD)
#[derive(Args)]
#[command(
    after_help = "Example: preslide export model.toml --recording axis.csv -o src/stage_model.rs\n         preslide export model.toml --lang c --rate 20kHz -o stage_model.c\n         preslide export model.toml --lang c --kernel slip_reserve_i16f16 --count 25e-9 -o stage_model.c\n         preslide export model.toml --mjcf -o joint.xml\n         preslide export model.toml --usd -o joint.usda"
)]
pub struct Export {
    /// Model file, as `identify` and `diagnose` write it
    #[arg(value_name = "MODEL.toml")]
    model: PathBuf,

    /// Leave out the effect with this id; may be repeated
    #[arg(long, value_name = "ID")]
    without: Vec<String>,

    /// Bound on each force that grows with speed or position, in N or N·m [default: ten times the
    /// breakaway force, or twice the largest on --recording, whichever is more]
    #[arg(long, value_name = "FORCE")]
    limit: Option<f64>,

    /// Language of the source; C99 is NAME.c with NAME.h beside it, in single precision or, by --kernel, in whole numbers
    #[arg(long, value_enum, default_value_t = Lang::Rust, conflicts_with_all = ["mjcf", "urdf", "usd"])]
    lang: Lang,

    /// Ticks per second (Hz), for C code of models that depend on time, and for --kernel [default there: 20 kHz]
    #[arg(long, value_name = "HZ", value_parser = parse_frequency)]
    rate: Option<f64>,

    /// Form of a Maxwell-slip model's law: a kernel's name, or auto for the one that `preslide tune` recommends; in C those of i16f16
    /// compute in encoder counts, without floats, and take no effect but viscous friction and a constant force
    #[arg(long, value_name = "NAME or auto", conflicts_with_all = ["mjcf", "urdf", "usd"])]
    kernel: Option<String>,

    /// Core for --kernel auto, as for `preslide tune`
    #[arg(long, default_value = DEFAULT, value_name = "CORE or FILE.csv")]
    cpu: String,

    /// Length of an encoder count for --kernel auto and for C in whole numbers (m or rad); without it, encoder_count_m of the model's [mechanics]
    #[arg(long, value_name = "LENGTH", value_parser = quantity::positive_length)]
    count: Option<Quantity>,

    /// Write a MuJoCo joint instead: frictionloss, damping, armature; comments list what it cannot hold
    #[arg(long, conflicts_with_all = ["limit", "urdf", "usd"])]
    mjcf: bool,

    /// Write a URDF joint instead: the friction and damping of its dynamics
    #[arg(long, conflicts_with_all = ["limit", "usd"])]
    urdf: bool,

    /// Write an OpenUSD joint instead, as text (.usda) with PhysX's schema, which Isaac Sim reads: armature, static, dynamic and viscous friction
    #[arg(long, conflicts_with = "limit")]
    usd: bool,

    /// Recording to name in the source by its hash, with the error of the exported model on it, and to take bounds from; may be repeated
    #[arg(long, value_name = "REC")]
    recording: Vec<PathBuf>,

    #[command(flatten)]
    reading: ReadingArgs,

    /// Write the source here instead of to the terminal
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,

    /// Write what was exported, and from what, as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Ticks per second of a kernel, where nothing is said.
const RATE_HZ: f64 = 20e3;

/// What firmware is written in.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Lang {
    /// With this project's library.
    Rust,
    /// C99, with nothing but `math.h`.
    C,
}

impl Export {
    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        let mut inputs = vec![self.model.as_path()];
        inputs.extend(self.recording.iter().map(PathBuf::as_path));
        let header = self.header()?;
        let written = [
            ("-o", self.output.as_ref()),
            ("the header of -o", header.as_ref()),
            ("--json", self.json.as_ref()),
        ];
        outputs::check(&inputs, &written, None)?;
        let file = self.model.display().to_string();
        let text = read(&self.model).map_err(|source| ModelError::Unreadable {
            file: file.clone(),
            source,
        })?;
        let in_file = |reason: String| Failure::Input(format!("{file}: {reason}"));
        let whole = Model::parse(&text).map_err(in_file)?;
        of_axis(&whole, &self.model, &[("--count", self.count.as_ref())])?;
        let model = reduced(&whole, &self.without).map_err(in_file)?;

        let joint = self.format().map(|format| Joint::of(&model, format));
        let joint = joint.transpose().map_err(in_file)?;
        let how = match (&joint, self.lang) {
            (Some(_), _) => "Written by `preslide export`: a joint for one of your bodies.",
            (None, Lang::C) => "Written by `preslide export`; do not edit, export again.",
            (None, Lang::Rust) => {
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
        let mut seen = Vec::new();
        for path in &self.recording {
            let exported = joint.as_ref().map_or(&model, |joint| &joint.model);
            remarks.push(self.error_on(exported, path, &mut seen)?);
        }
        if let Some(joint) = joint {
            self.write(&joint.to_text(&remarks))?;
            for clause in &joint.left_out {
                tell!("Not in the joint: {clause}.");
            }
            return self.write_json(remarks, None, &joint.left_out, &[]);
        }
        let kernel = self.kernel(&model, &mut remarks)?;
        let in_counts = |kernel: Kernel| kernel.arithmetic() == Arithmetic::I16F16;
        let needs_count = self.lang == Lang::C && kernel.is_some_and(in_counts);
        let count = needs_count.then(|| count_of(self.count.as_ref(), &model, &self.model));
        let count = count.transpose()?;
        if let Some(count) = count {
            check_counts(&model, count, &mut remarks)?;
        }
        let options = Options {
            remarks,
            limit: self.limit,
            reached: seen,
            rate: self.rate.or(kernel.is_some().then_some(RATE_HZ)),
            count,
            kernel,
        };
        let bounds = bounds(&model, &options).map_err(in_file)?;
        if let Some((source, header)) = self.output.as_ref().zip(header) {
            let name = source.file_stem().unwrap_or_default().to_string_lossy();
            let c = c_source(&model, &options, &name).map_err(in_file)?;
            write_text(source, &c.source)?;
            write_text(&header, &c.header)?;
            self.write_json(options.remarks, kernel, &[], &bounds)?;
            if let Some(rate) = c.rate.filter(|_| self.rate.is_none()) {
                tell!(
                    "{name}_step is for {} kHz; --rate gives another.",
                    1e-3 * rate
                );
            }
            tell!(
                "Compile {} with the firmware; {name}_rest once, then {name}_step each tick, as its header says.",
                source.display()
            );
            return Ok(());
        }
        self.write(&rust_source(&model, &options).map_err(in_file)?)?;
        self.write_json(options.remarks, kernel, &[], &bounds)?;
        let place = self
            .output
            .as_deref()
            .filter(|path| !outputs::is_stdout(path))
            .map_or("a file of the firmware".into(), |p| p.display().to_string());
        tell!(
            "Declare {place} as a module and call model(sample_time, units): its type, Model, computes in {} and goes to the controller. PRESLIDE_MODEL=/full/path compiles it into this project's firmware.",
            kernel.map_or("f32", |kernel| kernel.arithmetic().name())
        );
        Ok(())
    }

    /// The requested kernel, and a remark on what it takes.
    fn kernel(&self, model: &Model, remarks: &mut Vec<String>) -> Result<Option<Kernel>, Failure> {
        let kernel = match self.kernel.as_deref() {
            None => return Ok(None),
            Some("auto") => {
                let count = count_of(self.count.as_ref(), model, &self.model)?;
                let (costs, budget) = plan(&self.cpu, None, self.rate.unwrap_or(RATE_HZ), SHARE)
                    .map_err(Failure::Input)?;
                check_counts(model, count, &mut Vec::new())?;
                let tuning = of_model(model, count, &costs, budget).map_err(Failure::Input)?;
                let choice = tuning.chosen().map_err(|reason| {
                    Failure::Data(format!(
                        "--kernel auto: {reason}; --budget is an option of `preslide tune`: give the kernel that it names"
                    ))
                })?;
                let mut said = choice.said(&self.cpu);
                if self.lang == Lang::C {
                    said += " That is the kernel in Rust.";
                }
                tell!("{said}");
                remarks.push(said);
                choice.kernel
            }
            Some(name) => Kernel::named(name)
                .map_err(|reason| Failure::Input(format!("--kernel: {reason}")))?,
        };
        Ok(Some(kernel))
    }

    /// The header of C source, which has two files.
    fn header(&self) -> Result<Option<PathBuf>, Failure> {
        if self.lang == Lang::Rust {
            return match self.rate {
                _ if self.kernel.as_deref() == Some("auto") => Ok(None),
                Some(_) => Err(Failure::Input("--rate is for --lang c: the function that builds a Rust model takes the sample time".to_owned())),
                None => Ok(None),
            };
        }
        let source = self
            .output
            .as_ref()
            .filter(|path| path.extension().is_some_and(|e| e == "c"));
        let source = source.ok_or_else(|| {
            Failure::Input("--lang c writes two files: name the source, and the header goes beside it: -o stage_model.c".to_owned())
        })?;
        Ok(Some(source.with_extension("h")))
    }

    /// That of a joint, where one is asked for.
    fn format(&self) -> Option<Format> {
        let formats = [
            (self.mjcf, Format::Mjcf),
            (self.urdf, Format::Urdf),
            (self.usd, Format::Usd),
        ];
        let asked = formats.into_iter().find(|(is_asked, _)| *is_asked);
        asked.map(|(_, format)| format)
    }

    /// Where bounds cut, and what was exported, where that is asked for: the remarks of the source, its kernel, what a joint cannot hold.
    fn write_json(
        &self,
        remarks: Vec<String>,
        kernel: Option<Kernel>,
        not_held: &[String],
        bounds: &[Bound],
    ) -> Result<(), Failure> {
        for bound in bounds {
            tell!("{}.", bound.said_with_remedy());
        }
        let Some(path) = &self.json else {
            return Ok(());
        };
        let language = if self.lang == Lang::C { "c" } else { "rust" };
        let answer = json!({
            "schema": "preslide.export/1", "model": name(&self.model), "format": self.format().map_or(language, Format::name),
            "output": self.output, "kernel": kernel.map(Kernel::name), "without": self.without, "not_held": not_held, "remarks": remarks,
            "bounds": bounds.iter().map(Bound::to_json).collect::<Vec<_>>(),
        });
        outputs::write_json(path, &answer)
    }

    /// To the requested file, or the terminal.
    fn write(&self, text: &str) -> Result<(), Failure> {
        match &self.output {
            Some(path) => write_text(path, text),
            None => {
                say!("{}", text.trim_end());
                Ok(())
            }
        }
    }

    /// What a recording says of the model, as a sentence; what its bounded terms reach there goes to `seen`.
    fn error_on(
        &self,
        model: &Model,
        path: &Path,
        seen: &mut Vec<Reached>,
    ) -> Result<String, Failure> {
        let bytes =
            std::fs::read(path).map_err(|e| Failure::Input(format!("{}: {e}", path.display())))?;
        let recording = self.reading.load(&[path.to_owned()], Needs::Motion)?;
        let found = force_of_motion(model, &recording).map_err(Failure::Input)?;
        seen.extend(reached(model, &recording).map_err(Failure::Input)?);
        let error = match found.agreement {
            Some(agreement) => format!(
                "NMSE {:.4} %, RMS error {}",
                agreement.nmse,
                quantity(agreement.rms, recording.effort_unit())
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

/// Says what counts (m or rad) take from the model, on the terminal and among the remarks.
///
/// # Errors
/// Counts so coarse that its friction is not seen.
fn check_counts(model: &Model, count: f64, remarks: &mut Vec<String>) -> Result<(), Failure> {
    let (lost, unit) = (counting(&model.friction, count), model.motion.unit());
    if lost > TOO_COARSE {
        return Err(Failure::Data(too_coarse(lost, count, unit)));
    }
    if let Some(note) = counting_note(lost, count, unit) {
        tell!("Note: {note}.");
        remarks.push(format!("Note: {note}."));
    }
    Ok(())
}

/// The file's name without its folder, which is of no use elsewhere.
fn name(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}
