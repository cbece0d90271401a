//! What a capture says of the stage's friction, by how the stage's current is made and sampled; without an emulator.

use super::{TrueCurve, frame, presliding};
use crate::stage::{Sampling, Stage, StageConfig};
use crate::tracking::{Axis, Step, TrackingError, electrical};
use anyhow::Context;
use preslide::control::{NoFriction, Settings};
use preslide::{Friction, Units};
use preslide_fit::identify::{Options, STEPS, identify};
use preslide_fit::progress::Progress;
use preslide_fit::recording::{LoadOptions, load_csv};
use preslide_host::capture::{Scale, capture};
use preslide_link::{Report, Sample};
use rayon::prelude::*;

/// Ticks from one sample of telemetry to the next, and of a row of the recording.
const EVERY: u32 = 5;
const ROW: u32 = 20;
/// Between two looks at the stage's friction.
const LOOK_TICKS: u32 = 2000;
/// The stage's seed, as `cargo xtask qemu` has it.
const SEED: u64 = 7;

/// The telemetry of an axis that follows `steps`, as it goes over the line; `look` sees the stage after every tick.
///
/// # Errors
/// [`TrackingError`] where a step cannot be planned, or the controller gave up.
pub fn telemetry<F: Friction>(
    axis: &mut Axis<F>,
    settings: &Settings,
    steps: &[Step],
    every: u32,
    mut look: impl FnMut(u32, &Stage),
) -> Result<Vec<u8>, TrackingError> {
    let mut bytes = Vec::new();
    let mut tick = 0;
    for step in steps {
        axis.start(step.plan(settings)?);
        while !axis.is_idle() {
            let (command, .., current_a) = axis.tick();
            tick += 1;
            if let Some(fault) = command.fault {
                return Err(TrackingError::Stopped(fault));
            }
            look(tick, axis.stage());
            if tick % every == 0 {
                bytes.extend(frame(&Report::Sample(Sample {
                    sequence: tick / every,
                    dropped: 0,
                    tick,
                    position: command.position as i32,
                    reference: command.reference,
                    code: command.code as i16,
                    current: (current_a / settings.hardware.current_code).round() as i16,
                    supply: (settings.motor.supply / settings.hardware.supply_code) as u16,
                    fault: None,
                    range: None,
                    level: 0,
                })));
            }
        }
    }
    Ok(bytes)
}

/// A way to make and to sample the current, and what came of it.
#[derive(Clone, Debug)]
pub struct Row {
    /// How.
    pub name: &'static str,
    /// Identified breakaway force (N), its 95 % interval, and the truth.
    pub breakaway_n: (f64, [f64; 2], f64),
    /// RMS deviation of the virgin curve from the truth over its RMS (-).
    pub deviation: f64,
    /// Points of the curve whose interval holds the truth, and points.
    pub inside: (usize, usize),
}

/// Records, captures and identifies with each.
///
/// # Errors
/// Whatever a step of it refuses.
pub fn study() -> anyhow::Result<Vec<Row>> {
    let ways = [
        ("ideal", None),
        ("electrical, where the current is its mean", Some(None)),
        (
            "electrical, centre of the low side",
            Some(Some(Sampling::Synchronous(0.5))),
        ),
        (
            "electrical, 16 samples a period",
            Some(Some(Sampling::Oversampled(16))),
        ),
        (
            "electrical, unsynchronised",
            Some(Some(Sampling::Unsynchronised)),
        ),
    ];
    let row = |&(name, way)| row(name, way).context(name);
    ways.par_iter().map(row).collect()
}

fn row(name: &'static str, way: Option<Option<Sampling>>) -> anyhow::Result<Row> {
    let mut settings = Settings::PAPER_AXIS;
    let mut stage = StageConfig {
        seed: SEED,
        ..StageConfig::default()
    };
    if let Some(sampling) = way {
        stage = electrical(&mut settings, stage);
        if let (Some(electrical), Some(sampling)) = (&mut stage.electrical, sampling) {
            electrical.sense.sampling = sampling;
        }
    }
    let friction = NoFriction::<f64>::new();
    let mut axis = Axis::try_new(&settings, friction, Units::SI, stage)?;
    let mut curve = TrueCurve::default();
    let bytes = telemetry(&mut axis, &settings, &presliding(), EVERY, |tick, stage| {
        if tick % LOOK_TICKS == 0 {
            curve.look(stage, stage.truth().velocity_m_s);
        }
    })?;
    let mut csv = Vec::new();
    capture(
        &bytes[..],
        &mut csv,
        &Scale::of(&settings, ROW),
        None,
        || {},
    )?;
    let recording = load_csv(&csv[..], "recording.csv", &LoadOptions::default())?;
    let progress = Progress::new("identify", STEPS);
    let found = identify(&recording, &Options::default(), &progress).map_err(anyhow::Error::msg)?;
    progress.finish();
    let comparison = curve.compare(found.best());
    let (_, truth, last) = comparison.points.last().context("the curve has points")?;
    Ok(Row {
        name,
        breakaway_n: (last.value, last.ci95.unwrap_or([f64::NAN; 2]), *truth),
        deviation: comparison.relative_rms(),
        inside: (comparison.inside(), comparison.points.len()),
    })
}

/// The rows for people.
pub fn print(rows: &[Row]) -> String {
    let mut text = format!(
        "{:<42} {:>28} {:>9} {:>16} {:>14}\n",
        "current", "breakaway found, 95 % (N)", "true (N)", "curve RMS off", "inside 95 %"
    );
    for row in rows {
        let (value, [low, high], truth) = row.breakaway_n;
        let (inside, points) = row.inside;
        text += &format!(
            "{:<42} {:>28} {truth:>9.4} {:>14.2} % {:>14}\n",
            row.name,
            format!("{value:.4}, {low:.4} … {high:.4}"),
            100.0 * row.deviation,
            format!("{inside} of {points}"),
        );
    }
    text
}
