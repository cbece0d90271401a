//! What a notch at the drive's first mode buys: how far the feedback's gains may grow before the axis rings, and what error is left with
//! half of that.

use super::observer::mode_hz;
use super::{Axis, Perfect, Step, Tracking, TrackingError, motions};
use crate::stage::{Stage, StageConfig};
use preslide::control::{NoFriction, Notch, Settings};
use preslide::{Scalar, Units};
use preslide_fit::report::Table;
use rayon::prelude::*;

/// The drive's stiffness, of the stage's own (-): its mode at half, one and two times the frequency.
pub const DRIVES: [f64; 3] = [0.25, 1.0, 4.0];

/// Where the notch is, of the mode's frequency (-); 0 for no notch. Who hits an axis and counts is a tenth off.
pub const NOTCHES: [f64; 4] = [0.0, 1.0, 0.9, 1.1];

/// Gains between which the axis begins to ring, of the axis's own (-), and how near the search comes.
const LOWEST: f64 = 0.1;
const HIGHEST: f64 = 30.0;
const NEAR: f64 = 1.01;

/// Of the ticks so many may be cut (-): an axis that rings is cut in every swing.
const CUT: f64 = 0.02;

/// RMS errors (m); NaN where a run ended in a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Nested triangles by feedback alone.
    pub alone_m: f64,
    /// With the stage's own friction fed forward.
    pub fed_m: f64,
}

/// A drive with a notch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// The drive's first mode (Hz).
    pub mode_hz: f64,
    /// The notch's frequency over that (-); 0 for none.
    pub at: f64,
    /// Factor by which all gains may grow before any stage rings (-): the gain margin.
    pub margin: f64,
    /// With half of that.
    pub half: Errors,
}

/// Every drive with every notch, in the arithmetic `S`, on a stage of each seed.
///
/// # Errors
/// [`TrackingError`] where a controller or a stage cannot be built.
pub fn study<S: Scalar + Send + Sync>(
    settings: &Settings,
    stage: &StageConfig,
    units: Units,
    [drives, notches]: [&[f64]; 2],
    seeds: &[u64],
) -> Result<Vec<Row>, TrackingError> {
    let tasks: Vec<_> = (drives.iter())
        .flat_map(|&drive| notches.iter().map(move |&at| (drive, at)))
        .collect();
    (tasks.par_iter())
        .map(|&(drive, at)| {
            let mut stage = stage.clone();
            stage.drive.stiffness_n_per_m *= drive;
            let mode_hz = mode_hz(&stage, Stage::try_new(stage.clone())?.reflected_rotor_kg());
            let notch = Notch {
                frequency: at * mode_hz,
                ..Notch::NONE
            };
            let settings = Settings { notch, ..*settings };
            let stages: Vec<_> = (seeds.iter())
                .map(|&seed| StageConfig {
                    seed,
                    ..stage.clone()
                })
                .collect();
            let margin = margin::<S>(&settings, &stages, units)?;
            Ok(Row {
                mode_hz,
                at,
                margin,
                half: errors::<S>(&scaled(&settings, 0.5 * margin), &stages, units)?,
            })
        })
        .collect()
}

fn margin<S: Scalar>(
    settings: &Settings,
    stages: &[StageConfig],
    units: Units,
) -> Result<f64, TrackingError> {
    let (mut stable, mut ringing) = (LOWEST, HIGHEST);
    while ringing > NEAR * stable {
        let middle = (stable * ringing).sqrt();
        let settings = scaled(settings, middle);
        let mut any = false;
        for stage in stages {
            any = any || rings::<S>(&settings, stage, units)?;
        }
        if any {
            ringing = middle;
        } else {
            stable = middle;
        }
    }
    Ok(stable)
}

fn errors<S: Scalar>(
    settings: &Settings,
    stages: &[StageConfig],
    units: Units,
) -> Result<Errors, TrackingError> {
    let moves = Step::plan_all(&motions::nested_triangles(), settings)?;
    let [mut alone, mut fed] = [Tracking::default(), Tracking::default()];
    for stage in stages {
        let count = settings.encoder.count;
        let mut axis = Axis::try_new(settings, NoFriction::<S>::new(), units, stage.clone())?;
        axis.follow(&moves, |now| alone.add(&now, count));
        let friction = Perfect::<S>::try_new(stage, units)?;
        let mut axis = Axis::try_new(settings, friction, units, stage.clone())?;
        axis.follow(&moves, |now| fed.add(&now, count));
    }
    Ok(Errors {
        alone_m: alone.rms_m().unwrap_or(f64::NAN),
        fed_m: fed.rms_m().unwrap_or(f64::NAN),
    })
}

fn scaled(settings: &Settings, by: f64) -> Settings {
    let mut scaled = *settings;
    scaled.gains.proportional *= by;
    scaled.gains.integral *= by;
    scaled.gains.derivative *= by;
    scaled
}

/// In a slide, where no contact damps, and in the rest after it.
fn rings<S: Scalar>(
    settings: &Settings,
    stage: &StageConfig,
    units: Units,
) -> Result<bool, TrackingError> {
    let mut steps = motions::slide();
    steps.push(Step::Dwell(0.3));
    let moves = Step::plan_all(&steps, settings)?;
    let mut axis = Axis::try_new(settings, NoFriction::<S>::new(), units, stage.clone())?;
    let limit = (settings.duty_limit * f64::from(settings.hardware.steps)) as i32;
    let (mut ticks, mut cut, mut fault) = (0_u32, 0_u32, false);
    axis.follow(&moves, |now| {
        ticks += 1;
        cut += u32::from(now.command.code.abs() == limit);
        fault |= now.command.fault.is_some();
    });
    Ok(fault || f64::from(cut) > CUT * f64::from(ticks))
}

/// The rows for people.
pub fn print(rows: &[Row]) -> String {
    let Notch { width, depth, .. } = Notch::NONE;
    let nm = |error: f64| format!("{:.1}", 1e9 * error);
    Table::of(
        format!("A notch of width {width} and depth {depth}; RMS error (nm) in nested triangles with half of the gains that ring"),
        rows,
    )
    .column("mode (Hz)", |row| format!("{:.0}", row.mode_hz))
    .column("notch", |row| match row.at {
        0.0 => "none".to_owned(),
        1.0 => "at the mode".to_owned(),
        at => format!("{:+.0} %", 100.0 * (at - 1.0)),
    })
    .column("gains may grow", |row| format!("{:.2} ×", row.margin))
    .column("dB", |row| format!("{:.1}", 20.0 * row.margin.log10()))
    .column("feedback alone", |row| nm(row.half.alone_m))
    .column("friction fed", |row| nm(row.half.fed_m))
    .table()
    .to_text()
}
