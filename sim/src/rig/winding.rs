//! A warm winding whose resistance the firmware follows: does it find it, by the same commands as the host's simulation?

use super::agreement::{Agreement, compare};
use super::run::{CALIBRATED, bridge};
use super::{Listener, RigError, Script, run};
use crate::stage::StageConfig;
use crate::stage::electrical::COPPER_PER_K;
use crate::tracking::{Step, electrical};
use preslide::control::Axis;
use preslide::{Friction, Units};
use std::path::Path;

/// By how much the winding is warmer than it was told (K).
const WARMER_K: f64 = 30.0;
/// How far the resistance may be followed (-).
const SPAN: f64 = 0.5;
/// Strokes as fast as the axis may: it learns from their ramps.
const STROKES: usize = 20;
const STROKE_M: f64 = 2e-3;

/// What became of a warm winding.
#[derive(Clone, Copy, Debug)]
pub struct Followed {
    /// The firmware's commands beside the host's.
    pub agreement: Agreement,
    /// The winding's resistance over the one told (-), and what the host found, which commands alike.
    pub share: [f64; 2],
}

/// Runs the firmware `elf` with `friction` compiled in.
///
/// # Errors
/// [`RigError`] where a run cannot be made.
pub fn followed<F: Friction>(elf: &Path, friction: F, units: Units) -> Result<Followed, RigError> {
    let mut axis = Axis::PAPER_AXIS;
    let mut stage = electrical(&mut axis, StageConfig::default());
    let mut settings = vec![("motor.resistance_span", SPAN)];
    if let Some(electrical) = &mut stage.electrical {
        electrical.ambient_c += WARMER_K;
        settings.extend(bridge(electrical));
    }
    // As it comes over the link.
    let narrow = |value: f64| f64::from(value as f32);
    axis.hardware.dead_time = narrow(axis.hardware.dead_time);
    axis.hardware.diode_drop = narrow(axis.hardware.diode_drop);
    axis.motor.resistance_span = SPAN;
    let limits = axis.limits;
    let stroke = |n: usize| Step::Move {
        distance_m: if n.is_multiple_of(2) {
            STROKE_M
        } else {
            -STROKE_M
        },
        speed_m_s: limits.speed,
        ramp_s: limits.speed / limits.acceleration,
    };
    let strokes: Vec<Step> = (0..STROKES).map(stroke).collect();
    let mut script = Script::told(CALIBRATED, &settings);
    (script.axis, script.stage) = (axis, stage);
    let script = script.queue(2 * CALIBRATED, &strokes)?;
    let record = run(elf, &script, Listener::File)?;
    let mut found = f64::NAN;
    let agreement = compare(&record, &script, &strokes, friction, units, |_, now, _| {
        found = f64::from(now.resistance_share()) / 65_536.0;
    })?;
    Ok(Followed {
        agreement,
        share: [1.0 + COPPER_PER_K * WARMER_K, found],
    })
}
