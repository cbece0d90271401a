//! Telemetry of a running controller into a recording.

use anyhow::{Context, bail};
use preslide::control::Settings;
use preslide_link::{Deframer, FaultCode, Report, Sample};
use std::io::{BufWriter, ErrorKind, Read, Write};
use std::net::TcpStream;

/// What turns raw telemetry into SI, and how much of it is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// `T_s` (s).
    pub sample_time_s: f64,
    /// One encoder count (m).
    pub count_m: f64,
    /// Motor force at the stage per ampere (N/A).
    pub force_n_per_a: f64,
    /// Ticks averaged into one row: force is the mean, position the last.
    pub every: u32,
}

impl Scale {
    /// The scale of a controller with these settings.
    pub fn of(settings: &Settings, every: u32) -> Self {
        Self {
            sample_time_s: settings.sample_time,
            count_m: settings.encoder.count,
            force_n_per_a: settings.motor.torque_constant * settings.motor.transmission(),
            every: every.max(1),
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
    /// Samples that the controller had to drop, because the line was too slow.
    pub dropped: u64,
    /// Samples that were lost on the line.
    pub lost: u64,
    /// Frames that could not be read.
    pub damaged: u64,
    /// The fault that the capture ended with or passed through.
    pub fault: Option<FaultCode>,
}

/// Opens `tcp:HOST:PORT`, or a file, pipe or serial device by its path (set a device's speed with `stty` first).
///
/// # Errors
/// Where it cannot be opened, with what to check.
pub fn open(source: &str) -> anyhow::Result<Box<dyn Read>> {
    if let Some(address) = source.strip_prefix("tcp:") {
        let stream = TcpStream::connect(address).with_context(|| {
            format!("cannot connect to {address}; is the controller, or `rig serve`, running and listening there?")
        })?;
        return Ok(Box::new(stream));
    }
    let file = std::fs::File::open(source).with_context(|| {
        format!("cannot open {source}; give tcp:HOST:PORT or the path of a device or file")
    })?;
    Ok(Box::new(file))
}

/// Reads telemetry until the source ends or `rows` are written, into a recording (CSV with `t_s`, `x_m`, `x_ref_m`,
/// `force_N`). `progress` is told the rows written so far.
///
/// Time is the tick's number, so lost samples show as a gap that every reader of recordings finds.
///
/// # Errors
/// Where reading or writing fails, or nothing that looks like telemetry came.
pub fn capture(
    mut source: impl Read,
    to: impl Write,
    scale: &Scale,
    rows: Option<u64>,
    mut progress: impl FnMut(u64),
) -> anyhow::Result<Summary> {
    let mut to = BufWriter::new(to);
    writeln!(to, "t_s,x_m,x_ref_m,force_N")?;
    let mut deframer = Deframer::new();
    let mut summary = Summary::default();
    let mut expected: Option<u32> = None;
    let (mut current, mut gathered) = (0.0, 0_u32);
    let mut buffer = [0; 4096];
    'reading: loop {
        let length = match source.read(&mut buffer) {
            Ok(0) => break,
            Ok(length) => length,
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            // A controller that is switched off is the usual end of a capture.
            Err(error) if error.kind() == ErrorKind::ConnectionReset => break,
            Err(error) => return Err(error).context("reading telemetry"),
        };
        for &byte in buffer.iter().take(length) {
            let sample = match deframer.push::<Report>(byte) {
                Some(Ok(Report::Sample(sample))) => sample,
                Some(Err(_)) => {
                    // The first frame is usually cut: the line was there before the listener.
                    summary.damaged += 1;
                    continue;
                }
                _ => continue,
            };
            summary.lost +=
                expected.map_or(0, |next| u64::from(sample.sequence.wrapping_sub(next)));
            expected = Some(sample.sequence.wrapping_add(1));
            summary.samples += 1;
            summary.dropped = sample.dropped.into();
            summary.fault = summary.fault.or(sample.fault);
            current += f64::from(sample.current) * 1e-4;
            gathered += 1;
            if gathered == scale.every {
                row(&mut to, scale, &sample, current / f64::from(gathered))?;
                (current, gathered) = (0.0, 0);
                summary.rows += 1;
                progress(summary.rows);
                if rows.is_some_and(|rows| summary.rows >= rows) {
                    break 'reading;
                }
            }
        }
    }
    to.flush().context("writing the recording")?;
    if summary.rows == 0 {
        bail!(
            "no telemetry came ({} damaged frames); check that this is a Preslide controller's link and, on a serial \
             line, its speed",
            summary.damaged
        );
    }
    Ok(summary)
}

fn row(to: &mut impl Write, scale: &Scale, sample: &Sample, current_a: f64) -> std::io::Result<()> {
    writeln!(
        to,
        "{:.6},{:.4e},{:.9e},{:.6e}",
        f64::from(sample.tick) * scale.sample_time_s,
        f64::from(sample.position) * scale.count_m,
        sample.reference as f64 / 65536.0 * scale.count_m,
        current_a * scale.force_n_per_a,
    )
}

#[cfg(test)]
mod tests {
    use super::{Scale, capture};
    use preslide::control::Settings;
    use preslide_link::{FaultCode, LARGEST_FRAME, Report, Sample, encode};

    fn telemetry(sequences: impl Iterator<Item = u32>) -> Vec<u8> {
        let mut line = Vec::new();
        for sequence in sequences {
            let sample = Sample {
                sequence,
                dropped: 0,
                tick: sequence + 1,
                position: 3 * sequence.cast_signed(),
                reference: i64::from(sequence) << 16,
                code: 0,
                current: 1000,
                supply: 6000,
                fault: (sequence == 8).then_some(FaultCode::Overrun),
            };
            let mut frame = [0; LARGEST_FRAME];
            let length = encode(&Report::Sample(sample), &mut frame).expect("it fits");
            line.extend_from_slice(&frame[..length]);
        }
        line
    }

    #[test]
    fn telemetry_becomes_a_recording_in_si() {
        let mut csv = Vec::new();
        let scale = Scale::of(&Settings::PAPER_AXIS, 2);
        let summary =
            capture(&telemetry(0..10)[..], &mut csv, &scale, None, |_| {}).expect("telemetry");
        let text = String::from_utf8(csv).expect("text");
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "t_s,x_m,x_ref_m,force_N");
        // Tick 2, count 3 of 25 nm, reference 1 count, 0.1 A of 20.7 N/A.
        assert_eq!(lines[1], "0.000100,7.5000e-8,2.500000000e-8,2.070310e0");
        assert_eq!((summary.samples, summary.rows, lines.len()), (10, 5, 6));
        assert_eq!(
            (summary.lost, summary.damaged, summary.fault),
            (0, 0, Some(FaultCode::Overrun))
        );
    }

    #[test]
    fn what_is_lost_or_damaged_is_counted() {
        let mut line = telemetry((0..10).filter(|i| *i != 4));
        // Cut into the first frame, as a listener that comes late does.
        line.drain(..5);
        let scale = Scale::of(&Settings::PAPER_AXIS, 1);
        let summary = capture(&line[..], Vec::new(), &scale, None, |_| {}).expect("telemetry");
        assert_eq!((summary.samples, summary.lost, summary.damaged), (8, 1, 1));
    }

    #[test]
    fn silence_and_noise_are_errors() {
        let scale = Scale::of(&Settings::PAPER_AXIS, 1);
        for line in [&[][..], &[0x55; 500], &[1, 2, 3, 0, 9, 9, 0]] {
            let error = capture(line, Vec::new(), &scale, None, |_| {}).expect_err("no telemetry");
            assert!(error.to_string().contains("no telemetry"), "{error}");
        }
    }
}
