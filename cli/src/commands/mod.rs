//! The commands: each reads its arguments, calls the library, and prints one recommendation.

pub mod capture;
pub mod commission;
pub mod compare;
pub mod demo;
pub mod diagnose;
pub mod drive;
pub mod export;
pub mod fleet;
pub mod identify;
pub mod outputs;
pub mod plan;
pub mod reproduce;
pub mod simulate;
pub mod tune;

use crate::heard::arguments;
use clap::Args;
pub use outputs::{write_model, write_text};
use preslide_axis::AxisFile;
use preslide_drive::quantity::{self, Quantity};
use preslide_fit::identify::Options;
use preslide_fit::model::{Model, ModelError};
use preslide_fit::recording::{
    self, LoadOptions, MotionKind, Needs, Recording, RecordingError, Speeds,
};
use preslide_fit::report::Page;
use preslide_fit::signal::{Window, check_windows, parse_window};
use preslide_host::diagnose::Refusal;
use std::path::{Path, PathBuf};

/// Why a command ended without its answer; decides the exit code.
#[derive(Debug)]
pub enum Failure {
    /// The tool failed: exit code 1.
    Tool(String),
    /// Bad usage or bad input: exit code 2.
    Input(String),
    /// The data cannot answer the question: exit code 3.
    Data(String),
}

impl Failure {
    /// Exit code as documented in `preslide --help`.
    pub fn exit_code(&self) -> u8 {
        match self {
            Failure::Tool(_) => 1,
            Failure::Input(_) => 2,
            Failure::Data(_) => 3,
        }
    }

    /// The message for the user.
    pub fn message(&self) -> &str {
        match self {
            Failure::Tool(message) | Failure::Input(message) | Failure::Data(message) => message,
        }
    }
}

impl From<RecordingError> for Failure {
    fn from(error: RecordingError) -> Self {
        Failure::Input(error.to_string())
    }
}

impl From<ModelError> for Failure {
    fn from(error: ModelError) -> Self {
        Failure::Input(error.to_string())
    }
}

impl From<Refusal> for Failure {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::Input(reason) => Failure::Input(reason),
            Refusal::Data(reason) => Failure::Data(reason),
        }
    }
}

impl From<anyhow::Error> for Failure {
    fn from(error: anyhow::Error) -> Self {
        Failure::Tool(format!("{error:#}"))
    }
}

/// Which axis.
#[derive(Args, Clone, Debug)]
pub struct AxisArgs {
    /// The description of the axis [default: what PRESLIDE_AXIS names, or else, but for a plan and an observer,
    /// the project's own axis.toml]
    #[arg(long, value_name = "AXIS.toml")]
    axis: Option<PathBuf>,
}

impl AxisArgs {
    /// Reads it.
    pub fn read(&self) -> Result<AxisFile, Failure> {
        AxisFile::chosen(self.axis.as_deref()).map_err(|error| Failure::Input(error.to_string()))
    }

    /// The file that was named, none or one.
    pub fn file(&self) -> Vec<&Path> {
        self.axis.iter().map(PathBuf::as_path).collect()
    }

    /// The file that somebody chose.
    pub fn chosen(&self) -> Option<PathBuf> {
        let of_variable = || std::env::var_os(preslide_axis::VARIABLE).map(PathBuf::from);
        self.axis.clone().or_else(of_variable)
    }
}

/// Recordings and how to read them.
#[derive(Args, Clone, Debug)]
pub struct RecordingArgs {
    /// Recordings: CSV, MATLAB .mat, NumPy .npz, and if built in Parquet, HDF5, MCAP, .db3; columns t_s, x_m or q_rad, and an effort
    /// such as force_N
    #[arg(required = true, value_name = "REC")]
    recordings: Vec<PathBuf>,

    #[command(flatten)]
    reading: ReadingArgs,
}

impl RecordingArgs {
    /// Columns that the command takes itself: nothing is said of them.
    pub fn take(&mut self, columns: &[String]) {
        self.reading.taken = columns.to_vec();
    }

    /// Another command on the same files, as [`ReadingArgs::command`].
    pub fn command(&self, name: &str, model: Option<&Path>) -> String {
        self.reading.command(name, &self.recordings, model)
    }

    /// The command that exports a model, as [`ReadingArgs::export`].
    pub fn export(&self, model: &Path, more: &[String]) -> String {
        self.reading.export(&self.recordings, model, more)
    }

    /// Makes sure that the outputs can be written and overwrite neither a recording nor the model.
    pub fn check_outputs(
        &self,
        model: Option<&PathBuf>,
        own: &[outputs::Output],
        others: &OutputArgs,
    ) -> Result<(), Failure> {
        let inputs = self.recordings.iter().chain(model);
        let inputs: Vec<_> = inputs.map(PathBuf::as_path).collect();
        outputs::check(&inputs, own, Some(others))
    }

    /// The files as one table of speed and effort without time; `None` if one of them is not such a table.
    pub fn load_speeds(&self) -> Result<Option<Speeds>, Failure> {
        let options = self.reading.options(Needs::Speeds);
        let mut tables = Vec::new();
        for path in &self.recordings {
            match recording::load_speeds(path, &options)? {
                Some(table) => tables.push(table),
                None => return Ok(None),
            }
        }
        Speeds::join(tables).map(Some).map_err(Failure::Input)
    }

    /// Whether the sign of the effort may be turned.
    pub fn may_turn(&self) -> bool {
        self.reading.sign.is_none()
    }

    /// Loads every recording and joins them into one.
    pub fn load(&self) -> Result<Recording, Failure> {
        self.reading.load(&self.recordings, Needs::Both)
    }
}

/// How to read recordings.
#[derive(Args, Clone, Debug)]
pub struct ReadingArgs {
    /// Read a column, or a sum of products of numbers and columns, under the tool's name: force_N=35.15*vir, 'force_N=100*pA-80*pB'.
    /// The factor of a pressure is per unit of the file (bar), that of another quantity per SI unit (A, even if the column is in mA)
    #[arg(long, value_name = "NAME=COLUMN", value_parser = recording::parse_map)]
    map: Vec<(String, String)>,

    /// Sign of the effort, 1 or -1 [default: found; an opposed one is flipped with a warning]
    #[arg(long, value_name = "SIGN", allow_negative_numbers = true)]
    sign: Option<f64>,

    /// Ignore this column; may be repeated
    #[arg(long, value_name = "COLUMN")]
    ignore: Vec<String>,

    /// Columns that the command takes itself.
    #[arg(skip)]
    taken: Vec<String>,
}

impl ReadingArgs {
    fn options(&self, needs: Needs) -> LoadOptions {
        LoadOptions {
            needs,
            map: self.map.clone(),
            sign: self.sign,
            ignore: self.ignore.clone(),
            taken: self.taken.clone(),
            ..LoadOptions::default()
        }
    }

    /// Loads one of several files. Columns to ignore that this file lacks go to `not_there`; another file may have them.
    fn load_one(
        &self,
        path: &Path,
        needs: Needs,
        not_there: &mut Vec<String>,
    ) -> Result<Recording, RecordingError> {
        let mut options = self.options(needs);
        loop {
            let error = match recording::load(path, &options) {
                Ok(recording) => return Ok(recording),
                Err(error) => error,
            };
            let Some(name) = error.problem.not_there() else {
                return Err(error);
            };
            not_there.push(name.to_owned());
            options.ignore.retain(|own| own != name);
        }
    }

    /// Another command on recordings, read alike, and on a model, as a shell wants it.
    pub fn command(&self, name: &str, recordings: &[PathBuf], model: Option<&Path>) -> String {
        let command = ["preslide", name].map(str::to_owned).into_iter();
        let files = recordings.iter().map(|file| file.display().to_string());
        let model = model.iter();
        let model = model.flat_map(|path| ["--model".to_owned(), path.display().to_string()]);
        in_words(command.chain(files).chain(self.arguments()).chain(model))
    }

    /// The command that exports a model with what these recordings say of it, `more` behind the model's file.
    pub fn export(&self, recordings: &[PathBuf], model: &Path, more: &[String]) -> String {
        let start = [
            "preslide".to_owned(),
            "export".to_owned(),
            model.display().to_string(),
        ];
        let files = recordings.iter();
        let files = files.flat_map(|file| ["--recording".to_owned(), file.display().to_string()]);
        let output = ["-o".to_owned(), "stage_model.rs".to_owned()];
        in_words(
            (start.into_iter().chain(more.iter().cloned()))
                .chain(files)
                .chain(self.arguments())
                .chain(output),
        )
    }

    /// How recordings are read, as arguments.
    fn arguments(&self) -> impl Iterator<Item = String> {
        let maps = self.map.iter();
        let maps = maps.flat_map(|(to, from)| ["--map".to_owned(), format!("{to}={from}")]);
        let sign = self.sign.iter();
        let sign = sign.flat_map(|sign| ["--sign".to_owned(), sign.to_string()]);
        let ignored = self.ignore.iter();
        let ignored = ignored.flat_map(|column| ["--ignore".to_owned(), column.clone()]);
        maps.chain(sign).chain(ignored)
    }

    /// Loads one recording of many, without a word.
    pub fn load_quietly(&self, path: &Path) -> Result<Recording, RecordingError> {
        self.load_one(path, Needs::Both, &mut Vec::new())
    }

    /// How recordings are read, to compare with an earlier run.
    pub fn in_words(&self) -> String {
        format!("{:?} {:?} {:?}", self.map, self.sign, self.ignore)
    }

    /// Loads recordings and joins them into one, and prints what the loader noticed.
    pub fn load(&self, paths: &[PathBuf], needs: Needs) -> Result<Recording, Failure> {
        let (mut recordings, mut wrong) = (Vec::new(), Vec::new());
        let mut nowhere = self.ignore.clone();
        for path in paths {
            let mut not_there = Vec::new();
            let loaded = self.load_one(path, needs, &mut not_there);
            nowhere.retain(|name| not_there.contains(name));
            match loaded {
                Ok(recording) => recordings.push(recording),
                Err(error) => wrong.push(error),
            }
        }
        if let Some(path) = paths.first().filter(|_| !nowhere.is_empty()) {
            recording::load(path, &self.options(needs))?;
        }
        let is_mistyped = |error: &RecordingError| error.problem.is_of_the_system();
        if recordings.is_empty() || wrong.iter().any(is_mistyped) {
            return Err(Failure::Input(all_wrong(&wrong)));
        }
        for recording in &recordings {
            tell!("{}", recording.in_one_line());
            for warning in &recording.warnings {
                tell!("{}: warning: {warning}", recording.name);
                if !warning.maps.is_empty() {
                    tell!("Try: {}", command_line_with(&warning.maps));
                }
            }
        }
        let mut whole = Recording::join(recordings).map_err(Failure::Input)?;
        for error in wrong {
            let warning = recording::Warning::left_out(&error);
            tell!("warning: {warning}");
            whole.warnings.push(warning);
        }
        let of_joining = [
            recording::COPIES,
            recording::DROPPED,
            recording::RATES,
            recording::FLIPPED_ALIKE,
        ];
        for warning in whole
            .warnings
            .iter()
            .filter(|w| of_joining.contains(&w.code))
        {
            tell!("{}: warning: {warning}", whole.name);
        }
        Ok(whole)
    }
}

/// The recording, from so many samples on, with as many as its band needs, and a line that says so.
pub fn thin(recording: Recording, from: usize) -> Recording {
    let Some(thinned) = preslide_fit::identify::thinned(&recording, from) else {
        return recording;
    };
    if let Some(warning) = thinned.warnings.last() {
        tell!("{}: {}", thinned.name, warning.message);
    }
    thinned
}

/// Every file's error, and the command that would read them where their names let it be guessed.
fn all_wrong(errors: &[RecordingError]) -> String {
    let mut lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
    let maps = errors.iter().map(|e| e.problem.maps());
    let maps = maps
        .map(|maps| maps.join(" "))
        .find(|maps| !maps.is_empty());
    lines.extend(maps.map(|maps| format!("Try: {} {maps}", command_line())));
    lines.join("\n")
}

/// What to fit and what to hold out.
#[derive(Args, Clone, Copy, Debug)]
pub struct SplitArgs {
    /// Fit only this window of time, in seconds: 100..145
    #[arg(long, value_name = "FROM..TO", value_parser = parse_window)]
    train: Option<Window>,

    /// Judge on this window, which is never fitted; without it repeats or strokes take turns
    #[arg(long, value_name = "FROM..TO", value_parser = parse_window)]
    test: Option<Window>,
}

impl SplitArgs {
    /// A window was given.
    pub fn is_given(self) -> bool {
        self.train.is_some() || self.test.is_some()
    }

    /// The windows, once they are known to hold samples of `recording`.
    pub fn options(self, recording: &Recording) -> Result<Options, Failure> {
        let Self { train, test } = self;
        check_windows(recording, train, test).map_err(Failure::Input)?;
        Ok(Options { train, test })
    }
}

/// Where to put what a command found, besides the terminal.
#[derive(Args, Clone, Debug)]
pub struct OutputArgs {
    /// Write the result for machines
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// Write one self-contained page with interactive plots
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

impl OutputArgs {
    /// Writes the requested outputs. `page` is built only if one is.
    pub fn write(
        &self,
        json: &serde_json::Value,
        page: impl FnOnce() -> Page,
    ) -> Result<(), Failure> {
        self.write_json(json)?;
        match &self.report {
            None => Ok(()),
            Some(path) if outputs::is_stdout(path) => write_text(path, &page().to_html()),
            Some(path) => outputs::write_with(path, |path| page().write_html(path)),
        }
    }

    /// Writes the result for machines, if requested.
    pub fn write_json(&self, json: &serde_json::Value) -> Result<(), Failure> {
        let path = self.json.as_deref();
        path.map_or(Ok(()), |path| outputs::write_json(path, json))
    }
}

/// Options of a command with --rotary, whose units are to be of such an axis.
fn of_kind(rotary: bool, given: &[(&str, Option<&Quantity>)]) -> Result<(), Failure> {
    let axis = match rotary {
        true => "with --rotary the axis turns",
        false => "without --rotary the axis is linear",
    };
    quantity::check(rotary, axis, given).map_err(Failure::Input)
}

/// Options of a command on a model, whose units are to be of its axis.
fn of_axis(model: &Model, file: &Path, given: &[(&str, Option<&Quantity>)]) -> Result<(), Failure> {
    let axis = format!(
        "{} is the model of a {} axis",
        file.display(),
        model.motion.name()
    );
    quantity::check(model.motion == MotionKind::Rotary, &axis, given).map_err(Failure::Input)
}

/// `170MHz`; a clock without a unit was meant in MHz as often as in Hz.
pub fn parse_clock(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(_) => Err(format!(
            "`{text}` has no unit; give --clock {text}MHz, or --clock {text}Hz"
        )),
        Err(_) => parse_frequency(text),
    }
}

/// `170MHz`, `20kHz`, `8000` in Hz.
pub fn parse_frequency(text: &str) -> Result<f64, String> {
    let scales = [("MHz", 1e6), ("kHz", 1e3), ("Hz", 1.0), ("", 1.0)];
    let read = |(unit, scale): (&str, f64)| {
        let number: f64 = text.strip_suffix(unit)?.trim().parse().ok()?;
        (number.is_finite() && number > 0.0).then_some(number * scale)
    };
    let found = scales.into_iter().find_map(read);
    found.ok_or_else(|| "give a frequency above zero, such as 170MHz, 20kHz or 8000".to_owned())
}

/// An argument as a shell wants it.
fn quoted(argument: String) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./,:=+%@".contains(c);
    match argument.chars().all(plain) && !argument.is_empty() {
        true => argument,
        false => format!("'{}'", argument.replace('\'', "'\\''")),
    }
}

/// The command line with these maps in place of those of the same columns.
fn command_line_with(maps: &[String]) -> String {
    let target = |map: &str| map.split_once('=').map(|m| m.0.trim().to_owned());
    let replaced = |map: &str| maps.iter().any(|m| target(m) == target(map));
    let mut kept: Vec<String> = Vec::new();
    for argument in arguments() {
        let joined = argument.strip_prefix("--map=").is_some_and(replaced);
        if kept.last().is_some_and(|last| last == "--map") && replaced(&argument) {
            kept.pop();
        } else if !joined {
            kept.push(argument);
        }
    }
    let maps = maps
        .iter()
        .flat_map(|map| ["--map".to_owned(), map.clone()]);
    in_words(kept.into_iter().chain(maps))
}

/// The command line, for the foot of a report and for what would work.
pub fn command_line() -> String {
    in_words(arguments().into_iter())
}

fn in_words(arguments: impl Iterator<Item = String>) -> String {
    arguments
        .enumerate()
        .map(|(i, argument)| {
            if i == 0 {
                "preslide".to_owned()
            } else {
                quoted(argument)
            }
        })
        .collect::<Vec<_>>()
        .join(" ")
}
