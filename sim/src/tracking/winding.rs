//! What a warm winding costs, and what following its resistance wins back.
//!
//! The friction fed forward is the stage's own ([`Perfect`]), and the moves are fast: what the feed-forward lacks is force at a given duty.

use super::{Axis, FIXED_UNITS, Perfect, Step, Tracking, TrackingError, electrical};
use crate::stage::StageConfig;
use crate::stage::electrical::COPPER_PER_K;
use fixed::types::I16F16;
use preslide::control::Settings;
use preslide::{Scalar, Units};
use preslide_fit::report::Table;
use rayon::prelude::*;

/// Temperatures around the motor (°C): at its configured resistance, 30 K warmer, 30 K colder.
const AMBIENT_C: [f64; 3] = [20.0, 50.0, -10.0];

/// How far the resistance may be followed (-).
const SPAN: f64 = 0.4;

/// Strokes to learn from, and those that are judged.
const LEARNT: usize = 40;
const JUDGED: usize = 12;

/// A temperature, followed or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Around the motor (°C).
    pub ambient_c: f64,
    /// The resistance is followed.
    pub follows: bool,
    /// The winding's resistance around the motor's temperature, over the configured one (-), and what was found in `f32` and in fixed point.
    pub share: f64,
    /// See above.
    pub found: [f64; 2],
    /// RMS error of the judged strokes (m), in `f32` and in fixed point; NaN where a run ended in a fault.
    pub rms_m: [f64; 2],
}

/// All of them, on a stage of each seed; what is found is of the last.
///
/// # Errors
/// [`TrackingError`] where a controller or a stage cannot be built.
pub fn study(settings: &Settings, seeds: &[u64]) -> Result<Vec<Row>, TrackingError> {
    let tasks: Vec<_> = (AMBIENT_C.iter())
        .flat_map(|&ambient_c| [(ambient_c, false), (ambient_c, true)])
        .collect();
    (tasks.par_iter())
        .map(|&(ambient_c, follows)| {
            let float = strokes::<f32>(settings, ambient_c, follows, Units::SI, seeds)?;
            let fixed = strokes::<I16F16>(settings, ambient_c, follows, FIXED_UNITS, seeds)?;
            Ok(Row {
                ambient_c,
                follows,
                share: 1.0 + COPPER_PER_K * (ambient_c - AMBIENT_C[0]),
                found: [float.0, fixed.0],
                rms_m: [float.1, fixed.1],
            })
        })
        .collect()
}

fn strokes<S: Scalar>(
    settings: &Settings,
    ambient_c: f64,
    follows: bool,
    units: Units,
    seeds: &[u64],
) -> Result<(f64, f64), TrackingError> {
    let mut settings = *settings;
    let mut stage = electrical(&mut settings, StageConfig::default());
    if let Some(electrical) = &mut stage.electrical {
        electrical.ambient_c = ambient_c;
    }
    settings.motor.resistance_span = if follows { SPAN } else { 0.0 };
    let limits = settings.limits;
    let stroke = |n: usize| Step::Move {
        distance_m: if n.is_multiple_of(2) { 2e-3 } else { -2e-3 },
        speed_m_s: limits.speed,
        ramp_s: limits.speed / limits.acceleration,
    };
    let strokes: Vec<Step> = (0..LEARNT + JUDGED).map(stroke).collect();
    let moves = Step::plan_all(&strokes, &settings)?;
    let (mut tracking, mut found) = (Tracking::default(), f64::NAN);
    for &seed in seeds {
        let stage = StageConfig {
            seed,
            ..stage.clone()
        };
        let friction = Perfect::<S>::try_new(&stage, units)?;
        let mut axis = Axis::try_new(&settings, friction, units, stage)?;
        axis.follow(&moves, |now| {
            if now.step >= LEARNT {
                tracking.add(&now, settings.encoder.count);
            }
        });
        found = axis.resistance_share();
    }
    Ok((found, tracking.rms_m().unwrap_or(f64::NAN)))
}

/// The rows for people.
pub fn print(rows: &[Row]) -> String {
    let how = |row: &Row| {
        if row.follows {
            "followed"
        } else {
            "not followed"
        }
    };
    Table::of(
        "RMS error (nm) of fast moves with the stage's own friction fed forward",
        rows,
    )
    .column("around (C)", |row| format!("{:.0}", row.ambient_c))
    .column("R", |row| how(row).to_owned())
    .column("R over configured", |row| format!("{:.3}", row.share))
    .column("found, f32", |row| format!("{:.3}", row.found[0]))
    .column("found, fixed", |row| format!("{:.3}", row.found[1]))
    .column("f32", |row| format!("{:.0}", 1e9 * row.rms_m[0]))
    .column("fixed", |row| format!("{:.0}", 1e9 * row.rms_m[1]))
    .table()
    .to_text()
}
