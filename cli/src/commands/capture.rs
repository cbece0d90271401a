//! `preslide capture`.

use super::{AxisArgs, Failure, of_kind, outputs, parse_frequency, write_text};
use clap::Args;
use preslide_drive::quantity::{self, Quantity};
use preslide_fit::progress::Progress;
use preslide_fit::recording::MotionKind;
use preslide_fit::report::figures::quantity;
use preslide_host::capture::{CaptureError, End, Scale, Summary, capture, open};
use preslide_link::RangeCode;
use serde_json::json;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Record the telemetry of a running controller, by TCP or serial line
///
/// It ends after --seconds, when the line closes, or after 10 s of silence on TCP, and keeps the rows so far.
#[derive(Args)]
#[command(
    after_help = "Example: preslide capture tcp:127.0.0.1:7700 -o axis.csv --seconds 20\n\nScales come from the axis: give the --axis that the firmware was built with. Set a serial device's speed with stty first."
)]
pub struct Capture {
    /// tcp:HOST:PORT, or the path of a serial device, pipe or file
    #[arg(value_name = "SOURCE")]
    source: String,

    /// Write the recording
    #[arg(short, long, value_name = "REC.csv")]
    output: PathBuf,

    /// Replace the recording if it exists
    #[arg(long)]
    overwrite: bool,

    /// End after this many seconds of the controller's time
    #[arg(long, value_name = "S", value_parser = parse_positive)]
    seconds: Option<f64>,

    /// Leave out what comes before this controller time, such as homing, during which positions have another origin
    #[arg(long, value_name = "S", default_value_t = 0.0)]
    after: f64,

    /// Try to connect for this many seconds
    #[arg(long, value_name = "S", default_value = "0", value_parser = parse_wait)]
    wait: Duration,

    /// Ticks averaged into one row
    #[arg(long, value_name = "TICKS", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..))]
    every: u32,

    #[command(flatten)]
    axis: AxisArgs,

    /// The controller's rate [default: the axis's]
    #[arg(long, value_name = "HZ", value_parser = parse_frequency)]
    rate: Option<f64>,

    /// Length of an encoder count, such as 25nm or 2.5urad [default: the axis's]
    #[arg(long, value_name = "LENGTH", value_parser = quantity::positive_length)]
    count: Option<Quantity>,

    /// Force of the motor at the stage per ampere in N/A or N·m/A [default: the axis's torque constant × transmission]
    #[arg(long, value_name = "N_PER_A", value_parser = parse_positive)]
    effort_per_ampere: Option<f64>,

    /// The axis turns: counts are rad, the effort is N·m
    #[arg(long)]
    rotary: bool,

    /// Write what was captured and what is missing as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Refuses a file that exists, unless it may be replaced.
pub fn refuse_existing(path: &Path, overwrite: bool) -> Result<(), Failure> {
    if !overwrite && path.exists() {
        let path = path.display();
        return Err(Failure::Input(format!(
            "{path} exists; name another file, or give --overwrite"
        )));
    }
    Ok(())
}

/// A recording's file, made with its first byte: what is refused before leaves none, and takes nothing from an older one.
pub struct OnceWritten<'a> {
    path: &'a Path,
    overwrite: bool,
    file: Option<File>,
}

impl<'a> OnceWritten<'a> {
    /// An existing one is replaced only on request.
    pub fn new(path: &'a Path, overwrite: bool) -> Self {
        Self {
            path,
            overwrite,
            file: None,
        }
    }
}

impl Write for OnceWritten<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        if let Some(file) = &mut self.file {
            return file.write(bytes);
        }
        let mut options = OpenOptions::new();
        options.write(true).truncate(true).create(true);
        let file = options.create_new(!self.overwrite).open(self.path)?;
        self.file.insert(file).write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.as_mut().map_or(Ok(()), File::flush)
    }
}

fn parse_positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("give a number above zero".to_owned()),
    }
}

fn parse_wait(text: &str) -> Result<Duration, String> {
    let seconds = text.parse::<f64>().ok();
    let wait = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    wait.ok_or_else(|| "give a number of seconds, 0 or more".to_owned())
}

impl From<CaptureError> for Failure {
    fn from(error: CaptureError) -> Self {
        let text = error.to_string();
        match error {
            CaptureError::Connect { .. } | CaptureError::Open { .. } => Failure::Input(text),
            CaptureError::NoTelemetry { .. } => Failure::Data(text),
            CaptureError::Read(_) | CaptureError::Write(_) => Failure::Tool(text),
        }
    }
}

impl Capture {
    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        of_kind(self.rotary, &[("--count", self.count.as_ref())])?;
        let path = self.output.display();
        refuse_existing(&self.output, self.overwrite)?;
        let scale = Scale::of(&self.axis.read()?.axis(), self.every);
        let scale = Scale {
            sample_time_s: self.rate.map_or(scale.sample_time_s, |rate| 1.0 / rate),
            count: self.count.as_ref().map_or(scale.count, |count| count.value),
            motion: MotionKind::turning(self.rotary),
            effort_per_a: self.effort_per_ampere.unwrap_or(scale.effort_per_a),
            after_s: self.after,
            ..scale
        };
        let row_s = f64::from(scale.every) * scale.sample_time_s;
        // Saturating: a capture of ages is one without an end.
        let rows = self
            .seconds
            .map(|seconds| ((seconds / row_s).round() as u64).max(1));

        let own = [("-o", Some(&self.output)), ("--json", self.json.as_ref())];
        outputs::check(&[], &own, None)?;
        let source = open(&self.source, self.wait)?;
        let file = OnceWritten::new(&self.output, self.overwrite);
        let progress = Progress::new("capture, rows", rows.unwrap_or(0));
        let captured = capture(source, file, &scale, rows, || progress.inc(1));
        progress.finish();
        let summary = captured?;
        tell!("wrote {path}");
        if let Some(json) = &self.json {
            write_text(json, &format!("{:#}\n", machine(&summary)))?;
        }
        self.tell(&summary, &scale, row_s);
        Ok(())
    }

    fn tell(&self, summary: &Summary, scale: &Scale, row_s: f64) {
        let path = self.output.display();
        let (length, effort) = match scale.motion {
            MotionKind::Linear => ("m", "N"),
            MotionKind::Rotary => ("rad", "N·m"),
        };
        say!(
            "{} samples in {} rows, one every {:.3} ms, {:.3} s; a count is {}, an ampere {:.4} {effort}.",
            summary.samples,
            summary.rows,
            row_s * 1e3,
            summary.rows as f64 * row_s,
            quantity(scale.count, length),
            scale.effort_per_a,
        );
        if summary.gaps > 0 {
            say!(
                "Note: {} samples are missing in {} gap{}; the controller dropped {} because the line was too slow.",
                summary.missing,
                summary.gaps,
                if summary.gaps == 1 { "" } else { "s" },
                summary.dropped,
            );
        }
        if summary.damaged > 0 {
            say!(
                "Note: {} frames could not be read (one, at the start, is usual).",
                summary.damaged
            );
        }
        if let Some((fault, time)) = summary.fault {
            say!(
                "Note: the controller stopped at {time:.4} s ({fault:?}); identify only what came before: --train 0..{time:.4}."
            );
        }
        if let Some((range, time)) = summary.left_range {
            let (more, causes) = match range {
                RangeCode::Below => ("less", "a lighter load, running-in, a warmer stage"),
                _ => ("more", "wear, dirt, a new spot"),
            };
            say!(
                "Note: at {time:.4} s the controller reports that its drive spends {more} on friction than is normal ({causes}); \
                 identify anew, or diagnose against the present model."
            );
        }
        match summary.end {
            End::Silent => explain!("Note: the line fell silent for 10 s."),
            End::Restarted => {
                explain!("Note: the controller restarted; what follows is another recording.")
            }
            End::Complete | End::Closed => {}
        }
        say!("Next: preslide identify {path} -o model.toml");
    }
}

/// The summary for machines.
pub(super) fn machine(summary: &Summary) -> serde_json::Value {
    json!({
        "schema": "preslide.capture/1",
        "samples": summary.samples,
        "rows": summary.rows,
        "gaps": summary.gaps,
        "missing": summary.missing,
        "dropped": summary.dropped,
        "damaged": summary.damaged,
        "fault": summary.fault.map(|(fault, time)| json!({ "kind": format!("{fault:?}"), "t_s": time })),
        "left_range": summary.left_range.map(|(range, time)| json!({ "side": format!("{range:?}"), "t_s": time })),
        "end": format!("{:?}", summary.end).to_lowercase(),
    })
}
