//! Telemetry of a running controller into a recording.

mod source;
#[cfg(test)]
mod tests;

pub use source::open;

use preslide::control::Settings;
use preslide_fit::recording::MotionKind;
use preslide_link::{Deframer, FaultCode, RangeCode, Report, Sample};
use std::io::{BufWriter, ErrorKind, Read, Write};

/// What turns raw telemetry into SI, and how much of it is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Linear or rotary: metres and newtons, or radians and newton metres.
    pub motion: MotionKind,
    /// `T_s` (s).
    pub sample_time_s: f64,
    /// One encoder count (m or rad).
    pub count: f64,
    /// Motor force at the stage per ampere (N/A or N·m/A).
    pub effort_per_a: f64,
    /// Ticks averaged into one row; of a controller that sends fewer, the samples among them.
    pub every: u32,
    /// What comes before this time of the controller's (s) is left out.
    pub after_s: f64,
}

impl Scale {
    /// The scale of a linear controller with these settings.
    pub fn of(settings: &Settings, every: u32) -> Self {
        Self {
            motion: MotionKind::Linear,
            sample_time_s: settings.sample_time(),
            count: settings.encoder.count,
            effort_per_a: settings.motor.torque_constant * settings.motor.transmission(),
            every: every.max(1),
            after_s: 0.0,
        }
    }

    fn header(&self) -> &'static str {
        match self.motion {
            MotionKind::Linear => "t_s,x_m,x_ref_m,force_N",
            MotionKind::Rotary => "t_s,q_rad,q_ref_rad,torque_Nm",
        }
    }
}

/// How a capture went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// Samples read.
    pub samples: u64,
    /// Rows written.
    pub rows: u64,
    /// Places where samples are missing; no row reaches across one.
    pub gaps: u64,
    /// Samples that are missing there.
    pub missing: u64,
    /// Of these, samples that the controller had to drop because the line was too slow.
    pub dropped: u64,
    /// Frames that could not be read.
    pub damaged: u64,
    /// The first fault, and when (s).
    pub fault: Option<(FaultCode, f64)>,
    /// The first time that what the drive spent on friction left its normal range, to which side, and when (s).
    pub left_range: Option<(RangeCode, f64)>,
    /// Why the capture ended.
    pub end: End,
}

/// Why a capture ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum End {
    /// As many rows as were asked for.
    Complete,
    /// The source closed, as when a controller is switched off.
    #[default]
    Closed,
    /// Nothing came any more.
    Silent,
    /// The controller began to count its ticks anew, as after a reset.
    Restarted,
}

/// Why there is no recording.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    /// No connection.
    #[error(
        "cannot connect to {address}: {error}; give tcp:HOST:PORT of a controller's telemetry (`cargo xtask stage` serves \
         an emulated one), or --wait for one that is still starting"
    )]
    Connect {
        /// `HOST:PORT`.
        address: String,
        /// What the system said.
        error: std::io::Error,
    },
    /// No such file or device.
    #[error(
        "cannot open {path}: {error}; give tcp:HOST:PORT or the path of a device, pipe or file"
    )]
    Open {
        /// Its path.
        path: String,
        /// What the system said.
        error: std::io::Error,
    },
    /// The source broke.
    #[error("reading telemetry: {0}")]
    Read(std::io::Error),
    /// The recording could not be written.
    #[error("writing the recording: {0}")]
    Write(std::io::Error),
    /// Nothing that fills a row.
    #[error(
        "no telemetry came ({bytes} bytes, {damaged} damaged frames, {samples} of the {every} samples that a row takes); check \
         that this is a Preslide controller's link and, on a serial line, its speed"
    )]
    NoTelemetry {
        /// Bytes read.
        bytes: u64,
        /// Frames that could not be read.
        damaged: u64,
        /// Samples read.
        samples: u64,
        /// Ticks in a row.
        every: u32,
    },
}

/// Reads telemetry until the source ends, falls silent or restarts, or `rows` are written, into a recording (CSV).
/// `progress` hears of every row.
///
/// # Errors
/// [`CaptureError::Read`], [`CaptureError::Write`] or [`CaptureError::NoTelemetry`].
pub fn capture(
    mut source: impl Read,
    to: impl Write,
    scale: &Scale,
    rows: Option<u64>,
    mut progress: impl FnMut(),
) -> Result<Summary, CaptureError> {
    let mut recorder = Recorder::new(to, scale, rows);
    let mut deframer = Deframer::new();
    let mut bytes = 0;
    let mut buffer = [0; 4096];
    'reading: loop {
        let length = match source.read(&mut buffer) {
            Ok(0) => break,
            Ok(length) => length,
            Err(error) => match error.kind() {
                ErrorKind::Interrupted => continue,
                ErrorKind::ConnectionReset => break,
                ErrorKind::WouldBlock | ErrorKind::TimedOut => {
                    recorder.summary.end = End::Silent;
                    break;
                }
                _ => return Err(CaptureError::Read(error)),
            },
        };
        bytes += length as u64;
        for &byte in buffer.iter().take(length) {
            let before = recorder.summary.rows;
            match deframer.push::<Report>(byte) {
                Some(Ok(Report::Sample(sample))) if recorder.take(&sample)? => break 'reading,
                // The first frame is usually cut: the line was there before the listener.
                Some(Err(_)) => recorder.summary.damaged += 1,
                _ => {}
            }
            if recorder.summary.rows > before {
                progress();
            }
        }
    }
    recorder.end(bytes)
}

/// Telemetry into a recording (CSV).
///
/// A row is the mean over [`Scale::every`] ticks, for time, position, reference and force alike, so that none lags behind
/// another. Time is the tick's number, so what is missing shows as a gap that every reader of recordings finds.
pub struct Recorder<W: Write> {
    to: BufWriter<W>,
    scale: Scale,
    rows: Option<u64>,
    summary: Summary,
    /// Tick, sequence and drops of the last sample.
    last: Option<(u32, u32, u32)>,
    row: Mean,
}

impl<W: Write> Recorder<W> {
    /// Complete after so many rows. Nothing is written before the first.
    pub fn new(to: W, scale: &Scale, rows: Option<u64>) -> Self {
        Self {
            to: BufWriter::new(to),
            scale: *scale,
            rows,
            summary: Summary::default(),
            last: None,
            row: Mean::default(),
        }
    }

    /// Takes a sample; whether the recording has ended: complete, or the controller restarted.
    ///
    /// # Errors
    /// [`CaptureError::Write`].
    pub fn take(&mut self, sample: &Sample) -> Result<bool, CaptureError> {
        let (scale, summary) = (&self.scale, &mut self.summary);
        let time = f64::from(sample.tick) * scale.sample_time_s;
        if time < scale.after_s {
            return Ok(false);
        }
        // A slow line carries every n-th tick only; what is missing shows in the numbers of the samples.
        let mut missing = 0;
        if let Some((tick, sequence, dropped)) = self.last {
            if sample.tick <= tick {
                summary.end = End::Restarted;
                return Ok(true);
            }
            let lost = sample.sequence.wrapping_sub(sequence).wrapping_sub(1);
            missing = u64::from(lost) + u64::from(sample.dropped.wrapping_sub(dropped));
            summary.gaps += u64::from(missing > 0);
            summary.missing += missing;
        }
        let begin = self.last.is_none() || missing > 0;
        self.last = Some((sample.tick, sample.sequence, sample.dropped));
        summary.samples += 1;
        summary.dropped = sample.dropped.into();
        summary.fault = summary.fault.or(sample.fault.map(|fault| (fault, time)));
        let left = sample
            .range
            .filter(|range| matches!(range, RangeCode::Above | RangeCode::Below));
        summary.left_range = summary.left_range.or(left.map(|range| (range, time)));
        if begin {
            // Rows are counted from behind this sample.
            self.row = Mean::behind(sample);
            return Ok(false);
        }
        self.row.add(sample);
        if sample.tick - self.row.after >= scale.every {
            if summary.rows == 0 {
                writeln!(self.to, "{}", scale.header()).map_err(CaptureError::Write)?;
            }
            self.row
                .write(&mut self.to, scale)
                .map_err(CaptureError::Write)?;
            self.row = Mean::behind(sample);
            summary.rows += 1;
            if self.rows.is_some_and(|rows| summary.rows >= rows) {
                summary.end = End::Complete;
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Ends it; `bytes` were read for it.
    ///
    /// # Errors
    /// [`CaptureError::Write`] or [`CaptureError::NoTelemetry`].
    pub fn end(mut self, bytes: u64) -> Result<Summary, CaptureError> {
        self.to.flush().map_err(CaptureError::Write)?;
        let summary = self.summary;
        if summary.rows == 0 {
            return Err(CaptureError::NoTelemetry {
                bytes,
                damaged: summary.damaged,
                samples: summary.samples,
                every: self.scale.every,
            });
        }
        Ok(summary)
    }
}

/// The samples of a row, summed.
#[derive(Default)]
struct Mean {
    /// The last tick before the row.
    after: u32,
    samples: u32,
    tick: f64,
    position: f64,
    reference: f64,
    current: f64,
}

impl Mean {
    fn behind(sample: &Sample) -> Self {
        Self {
            after: sample.tick,
            ..Self::default()
        }
    }

    fn add(&mut self, sample: &Sample) {
        self.samples += 1;
        self.tick += f64::from(sample.tick);
        self.position += f64::from(sample.position);
        self.reference += sample.reference as f64 / 65536.0;
        self.current += f64::from(sample.current) * 1e-4;
    }

    fn write(&self, to: &mut impl Write, scale: &Scale) -> std::io::Result<()> {
        let mean = |sum: f64, unit: f64| sum / f64::from(self.samples) * unit;
        writeln!(
            to,
            "{:.7},{:.9e},{:.9e},{:.6e}",
            mean(self.tick, scale.sample_time_s),
            mean(self.position, scale.count),
            mean(self.reference, scale.count),
            mean(self.current, scale.effort_per_a),
        )
    }
}
