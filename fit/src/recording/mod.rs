//! Recordings: a measured motion and the effort it took, checked and in SI units.
//!
//! [`load`] reads CSV, MATLAB and other files in the project's format, or other people's with a column mapping. What cannot be used is a [`RecordingError`] that names file, place,
//! reason and remedy; what can be used with care is a [`Warning`] with a fixed code. Nothing is
//! dropped or repaired without one of the two.

/// A [`Warning`] of that code, its message written as by `format!`.
macro_rules! warning {
    ($code:expr, $($message:tt)+) => {
        $crate::recording::Warning::new($code, format!($($message)+))
    };
}

mod alone;
mod balance;
mod checks;
mod clock;
mod columns;
mod copies;
mod decimate;
mod drive_off;
mod dropouts;
mod error;
mod even;
mod expression;
mod extra;
mod formats;
mod frame;
mod headless;
mod held;
mod join;
mod json;
mod known;
mod labelled;
mod labels;
mod layout;
mod load;
mod lost;
mod mat;
mod names;
mod places;
mod plausible;
mod propose;
mod qualified;
mod rate;
mod read;
mod repair;
mod rows;
mod samples;
mod segments;
mod simulated;
mod speeds;
mod stated;
mod summary;
mod table;
#[cfg(test)]
mod tests;
mod timing;
mod twin;
mod twincat;
mod units;
mod variables;
mod words;

use std::io::Read;
use std::ops::Range;
use std::path::Path;

pub use copies::COPIES;
pub use error::{Problem, RecordingError};
pub use extra::Extra;
use frame::Frame;
pub use join::{DROPPED, FLIPPED_ALIKE, RATES};
use known::Slot;
pub use simulated::Simulated;
pub use speeds::{Speeds, load_speeds};
use table::{Data, Table};

/// Motion along a line or about an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionKind {
    /// Position in m, effort in N.
    Linear,
    /// Position in rad, effort in N·m.
    Rotary,
}

impl MotionKind {
    /// Of an axis that turns, or not.
    pub fn turning(turns: bool) -> Self {
        match turns {
            true => MotionKind::Rotary,
            false => MotionKind::Linear,
        }
    }

    /// "linear" or "rotary", as in model files.
    pub fn name(self) -> &'static str {
        match self {
            MotionKind::Linear => "linear",
            MotionKind::Rotary => "rotary",
        }
    }

    /// The unit of its position: `m` or `rad`.
    pub fn unit(self) -> &'static str {
        match self {
            MotionKind::Linear => "m",
            MotionKind::Rotary => "rad",
        }
    }

    /// The column of its position.
    pub fn column(self) -> &'static str {
        match self {
            MotionKind::Linear => "x_m",
            MotionKind::Rotary => "q_rad",
        }
    }

    /// The column of its reference.
    pub fn reference_column(self) -> &'static str {
        match self {
            MotionKind::Linear => "x_ref_m",
            MotionKind::Rotary => "q_ref_rad",
        }
    }
}

/// What the effort column measures, which decides what the model must contain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EffortRole {
    /// `force_N`: the driving force; contains inertia.
    Force,
    /// `friction_N`: the friction alone, inertia already taken off or negligible.
    Friction,
    /// `torque_Nm`: the driving torque; contains inertia.
    Torque,
    /// `current_A`: the motor current, proportional to force or torque; contains inertia.
    Current,
    /// `voltage_V`: a voltage proportional to force or torque; contains inertia.
    Voltage,
    /// `effort_raw`: a number proportional to force or torque, of a unit that nobody said; contains inertia.
    Raw,
}

impl EffortRole {
    /// The quantity's name, as in messages.
    pub fn name(self) -> &'static str {
        match self {
            EffortRole::Force => "force",
            EffortRole::Friction => "friction",
            EffortRole::Torque => "torque",
            EffortRole::Current => "current",
            EffortRole::Voltage => "voltage",
            EffortRole::Raw => "raw effort",
        }
    }

    /// The column of the recording format.
    pub fn column(self) -> &'static str {
        match self {
            EffortRole::Force => "force_N",
            EffortRole::Friction => "friction_N",
            EffortRole::Torque => "torque_Nm",
            EffortRole::Current => "current_A",
            EffortRole::Voltage => "voltage_V",
            EffortRole::Raw => "effort_raw",
        }
    }

    /// The unit: `N`, `Nm`, `A`, `V` or `raw`.
    pub fn unit(self) -> &'static str {
        match self {
            EffortRole::Force | EffortRole::Friction => "N",
            EffortRole::Torque => "Nm",
            EffortRole::Current => "A",
            EffortRole::Voltage => "V",
            EffortRole::Raw => "raw",
        }
    }

    /// The unit where it is no force's or torque's.
    pub fn other_unit(self) -> Option<&'static str> {
        Some(self.unit()).filter(|unit| !matches!(*unit, "N" | "Nm"))
    }

    /// Whether accelerating the moving mass is part of the effort.
    pub fn contains_inertia(self) -> bool {
        self != EffortRole::Friction
    }
}

/// Something about a recording that its user should know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// A fixed name, such as `gap`, for machines and for looking up.
    pub code: &'static str,
    /// What was found, with figures and the place in the file.
    pub message: String,
    /// The options of the command that would put it right, where one would.
    pub maps: Vec<String>,
}

impl Warning {
    pub(crate) fn new(code: &'static str, message: impl Into<String>) -> Self {
        Warning {
            code,
            message: message.into(),
            maps: Vec::new(),
        }
    }

    /// That a file of several is left out, and why.
    pub fn left_out(error: &RecordingError) -> Self {
        Self::new(
            "left-out",
            format!("{error}; the other files are used without it"),
        )
    }
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.code, self.message)
    }
}

/// A motion and the effort it took. All columns have the same length, but for those that [`Needs`] lets be absent;
/// samples are in file order.
#[derive(Clone, Debug)]
pub struct Recording {
    /// File name, for messages.
    pub name: String,
    /// Linear or rotary.
    pub kind: MotionKind,
    /// Time stamps (s); they increase within each of [`pieces`](Self::pieces).
    pub t_s: Vec<f64>,
    /// Position (m or rad), measured or, with [`position_integrated`](Self::position_integrated),
    /// integrated from the velocity.
    pub position: Vec<f64>,
    /// Commanded position (m or rad), where recorded.
    pub reference: Option<Vec<f64>>,
    /// Velocity (m/s or rad/s), where recorded.
    pub velocity: Option<Vec<f64>>,
    /// Effort in [`effort_unit`](Self::effort_unit), positive where it drives motion in +x.
    pub effort: Vec<f64>,
    /// What the effort measures.
    pub role: EffortRole,
    /// Temperature (°C), where recorded.
    pub temperature_c: Option<Vec<f64>>,
    /// Load (N or N·m), where recorded: a normal force, or one along the axis.
    pub load_n: Option<Vec<f64>>,
    /// Pressure (Pa), where recorded.
    pub pressure_pa: Option<Vec<f64>>,
    /// Every further numeric column that varies, as written: what else the effort may follow.
    pub extra: Vec<Extra>,
    /// Number of the part of the motion that each sample belongs to; one stroke between reversals
    /// where no column gives it.
    pub segment: Vec<u32>,
    /// Number of the repetition of the motion, one fold of cross-validation each.
    pub repeat: Vec<u32>,
    /// The segments are strokes found here, not a column of the file.
    pub segments_found: bool,
    /// The repeats are cycles found here. False also where the motion has no period and every
    /// sample is in repeat 0.
    pub repeats_found: bool,
    /// There was no position column.
    pub position_integrated: bool,
    /// Contiguous samples, split at gaps and where the clock starts again: no filter and no model
    /// may run from one into the next. They cover all samples, in order; one may be a single sample.
    pub pieces: Vec<Range<usize>>,
    /// The samples of each recording that was joined, in order; one range where only one was loaded.
    pub joined: Vec<Range<usize>>,
    /// What the user should know.
    pub warnings: Vec<Warning>,
    /// Further columns that stay at one value, by name: in a joined recording they may be part of one that varies.
    constant_extra: extra::Constant,
    /// How many times the load was taken off the effort, where the drive holds it.
    load_held: Option<f64>,
    sample_time_s: f64,
    /// What the position goes in steps of (m or rad), where it does.
    pub count: Option<f64>,
}

impl Recording {
    /// Lowest and highest position (m or rad).
    pub fn ends(&self) -> (f64, f64) {
        crate::statistics::bounds(&self.position)
    }

    /// Number of samples, at least 2.
    pub fn len(&self) -> usize {
        self.t_s.len()
    }

    /// Never true of a recording that was loaded.
    pub fn is_empty(&self) -> bool {
        self.t_s.is_empty()
    }

    /// Median time step within the pieces (s).
    pub fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    /// `m` or `rad`.
    pub fn position_unit(&self) -> &'static str {
        self.kind.unit()
    }

    /// `N`, `Nm`, `A`, `V` or `raw`.
    pub fn effort_unit(&self) -> &'static str {
        self.role.unit()
    }

    /// What the results mean where the effort is no force or torque; `None` where it is one.
    pub fn per_unit(&self) -> Option<String> {
        let (force, mass, target) = match self.kind {
            MotionKind::Linear => ("N", "kg", "force_N"),
            MotionKind::Rotary => ("Nm", "kg_m2", "torque_Nm"),
        };
        self.role.other_unit().map(|unit| {
            format!(
                "the effort is in {unit}: where a key or a unit says {force}, read {unit}, and where it says {mass}, read {mass} per {force}/{unit}; the drive's constant K in {force}/{unit} multiplies them all, and --map {target}=K*COLUMN brings it in"
            )
        })
    }
}

/// What a file must hold to be of use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Needs {
    /// Motion and effort: a recording.
    #[default]
    Both,
    /// A motion; where no column gives the effort, [`Recording::effort`] is empty.
    Motion,
    /// An effort that is a force or a torque; where no column gives the motion, [`Recording::position`] is empty.
    /// Nothing is said about the motion and no sign is looked for.
    Effort,
    /// Velocity and effort, without time.
    Speeds,
}

/// How to read a file.
#[derive(Clone, Debug)]
pub struct LoadOptions {
    /// What the file must hold.
    pub needs: Needs,
    /// `--map`: name in the format, and the file's column or product such as `35.1507*vir`.
    pub map: Vec<(String, String)>,
    /// `--sign`: 1 or -1, multiplies the effort; without it an opposed sign is found and flipped.
    pub sign: Option<f64>,
    /// `--ignore`: columns that are taken as if they were not there.
    pub ignore: Vec<String>,
    /// `--simulated`: further columns that the caller takes, of which nothing is said.
    pub taken: Vec<String>,
    /// Largest file that is opened (bytes); all but text, which is a stream, half of it.
    pub max_bytes: u64,
    /// Most samples that are kept: with 8 columns of 8 bytes, 640 MB.
    pub max_samples: usize,
}

impl LoadOptions {
    /// The sign that was asked for.
    fn sign(&self) -> Result<Option<f64>, Problem> {
        match self.sign.filter(|s| s.abs() != 1.0) {
            Some(sign) => Err(Problem::Other(format!(
                "--sign {sign} is neither 1 nor -1; give `--sign -1` where the effort opposes the model's convention (positive against motion in +x)"
            ))),
            None => Ok(self.sign),
        }
    }
}

impl Default for LoadOptions {
    fn default() -> Self {
        LoadOptions {
            needs: Needs::Both,
            map: Vec::new(),
            sign: None,
            ignore: Vec::new(),
            taken: Vec::new(),
            max_bytes: 1 << 30,
            max_samples: 10_000_000,
        }
    }
}

/// Splits a `--map` argument such as `force_N=35.1507*vir`.
///
/// # Errors
/// A message for the user where there is no `=` or nothing on one side of it.
pub fn parse_map(argument: &str) -> Result<(String, String), String> {
    match argument.split_once('=').map(|(a, b)| (a.trim(), b.trim())) {
        Some((target, source)) if !target.is_empty() && !source.is_empty() => {
            Ok((target.into(), source.into()))
        }
        _ => Err(format!(
            "`{argument}` is not a mapping; write NAME=COLUMN, such as force_N=load_cell or x_m=0.001*x_mm"
        )),
    }
}

/// Loads a recording: CSV and other separated text, MATLAB, NPZ, Parquet, HDF5, and joint states of ROS 2 in MCAP and `.db3`, known
/// by their first bytes; `.mat` by its extension too. Cargo features decide which of them this build reads.
///
/// # Errors
/// [`RecordingError`] names the file as given, the place, the reason and the remedy.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Recording, RecordingError> {
    let name = path.display().to_string();
    recording(read::file(path, options), &name, options)
}

/// Reads CSV from any stream; `name` stands in messages.
///
/// # Errors
/// As [`load`].
pub fn load_csv(
    input: impl Read,
    name: &str,
    options: &LoadOptions,
) -> Result<Recording, RecordingError> {
    recording(read::text(input, options), name, options)
}

/// The recording of a table, which may not have been read.
fn recording(
    table: Result<Table, Problem>,
    name: &str,
    options: &LoadOptions,
) -> Result<Recording, RecordingError> {
    let recording = table.and_then(|table| assemble(table, name, options));
    recording.map_err(|problem| RecordingError {
        file: name.into(),
        problem,
    })
}

/// Turns a table into a recording: time, repairs, even samples, parts of the motion, sign, warnings.
fn assemble(mut table: Table, path: &str, options: &LoadOptions) -> Result<Recording, Problem> {
    let asked_sign = options.sign()?;
    let mut warnings = std::mem::take(&mut table.plan.warnings);
    let (mut frame, mut constant_extra) = frame_of(&mut table, &options.taken, &mut warnings)?;
    let (kind, role) = (table.plan.kind, table.plan.role);
    held::keep_readings(&mut frame, &mut table.place, &mut warnings);
    repair::repair(&mut frame, (kind, role), &table, &mut warnings);
    let count = frame.column(Slot::Position).and_then(|x| summary::count(x));
    extra::move_constant((&mut frame.extra, &mut constant_extra));
    even::resample(&mut frame, &mut warnings);
    let samples = frame.t_s.len();
    if samples < 2 {
        return Err(Problem::too_short(samples));
    }

    let velocity = frame.take(Slot::Velocity);
    let measured = frame.take(Slot::Position);
    let position_integrated = measured.is_none();
    let position = match measured {
        Some(position) => position,
        None if options.needs == Needs::Effort && velocity.is_none() => Vec::new(),
        None => timing::integrate(
            &frame.t_s,
            velocity.as_deref().unwrap_or_default(),
            &frame.pieces,
            &mut warnings,
        ),
    };
    let mut effort = frame.take(Slot::Effort).unwrap_or_default();
    let runs: Vec<_> = frame
        .runs
        .iter()
        .map(|run| segments::strokes(&position, run.clone()))
        .collect();
    if options.needs == Needs::Effort {
        let sign = asked_sign.unwrap_or(1.0);
        effort.iter_mut().for_each(|f| *f *= sign);
    } else {
        checks::motion(&runs, samples, kind.unit(), &mut warnings);
    }
    if options.needs == Needs::Both || (options.needs == Needs::Motion && !effort.is_empty()) {
        checks::clipping(&effort, role.unit(), &mut warnings);
        checks::sign(
            &position,
            &mut effort,
            &runs,
            role,
            asked_sign,
            &mut warnings,
        );
    }

    let (given_segment, given_repeat) = (frame.part(Slot::Segment), frame.part(Slot::Repeat));
    let segments_found = given_segment.is_none();
    let segment =
        given_segment.unwrap_or_else(|| segments::segments(&runs, &frame.pieces, samples));
    let (repeat, repeats_found) = match given_repeat {
        Some(repeat) => (repeat, false),
        None if options.needs == Needs::Effort => (vec![0; samples], false),
        None => segments::repeats(&position, &frame.t_s, &runs, samples, &mut warnings),
    };
    let name = Path::new(path)
        .file_name()
        .map_or_else(|| path.to_string(), |n| n.to_string_lossy().into_owned());
    let mut recording = Recording {
        name,
        kind,
        position,
        reference: frame.take(Slot::Reference),
        velocity,
        effort,
        role,
        temperature_c: frame.take(Slot::Temperature),
        load_n: frame.take(Slot::Load),
        load_held: None,
        pressure_pa: frame.take(Slot::Pressure),
        segment,
        repeat,
        segments_found,
        repeats_found,
        position_integrated,
        joined: std::iter::once(0..samples).collect(),
        warnings,
        constant_extra,
        sample_time_s: timing::sample_time(&frame.t_s, &frame.pieces),
        count,
        extra: frame.extra,
        pieces: frame.pieces,
        t_s: frame.t_s,
    };
    let asked = recording.implausible(&table.plan);
    recording.warnings.extend(asked);
    recording.take_load_off();
    Ok(recording)
}

/// The columns of a table, its times checked; and the further columns that stay at one value.
fn frame_of(
    table: &mut Table,
    taken: &[String],
    warnings: &mut Vec<Warning>,
) -> Result<(Frame, extra::Constant), Problem> {
    let mut frame = Frame::default();
    let data = std::mem::take(&mut table.data);
    for (source, data) in table.plan.sources.iter().zip(data) {
        let slot = source.known.slot;
        match data {
            Data::Numbers(values) => frame.numbers.push((slot, values)),
            Data::Labels(labels) => {
                let numbers = labels.finish(source, warnings).map_err(|(at, what)| {
                    Problem::cell(table.place.of(at), source.known.name, what)
                })?;
                frame.parts.push((slot, numbers));
            }
        }
    }
    let mut t_s = match frame.take(Slot::Step) {
        Some(steps) => timing::of_steps(steps, warnings),
        None => frame.take(Slot::Time).unwrap_or_default(),
    };
    let samples = t_s.len();
    let further = std::mem::take(&mut table.extra);
    let (extra, constant) = extra::sort(further, taken, warnings);
    if samples < 2 {
        return Err(Problem::too_short(samples));
    }
    timing::unwrap(&mut t_s, table, warnings);
    even::regularise(&mut t_s, warnings);
    let number = |i: usize, slot: Slot| {
        let column = frame.parts.iter().find(|c| c.0 == slot);
        column.and_then(|c| c.1.get(i).copied()).unwrap_or(0)
    };
    let part = |i| (number(i, Slot::Segment), number(i, Slot::Repeat));
    (frame.runs, frame.pieces) = timing::check(&t_s, part, table, warnings)?;
    (frame.t_s, frame.extra) = (t_s, extra);
    Ok((frame, constant))
}
