//! A stage that begins to wear half way: does the firmware notice, after that and not before, as the host's simulation does?

use super::agreement::{Agreement, compare, samples};
use super::{Listener, RigError, Script, run};
use crate::tracking::Step;
use preslide::control::NormalRange;
use preslide::{Friction, Units};
use preslide_link::RangeCode;
use std::path::Path;

/// Strokes back and forth (m) and their speed (m/s): a window of the watch in 0.1 s.
const STROKE_M: f64 = 1e-3;
const SPEED_M_S: f64 = 4e-3;
const RAMP_S: f64 = 0.02;
/// Tick from which the first is sent.
const FIRST_MOVE: u64 = 2000;

/// What happens to the stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wear {
    /// Strokes in all; the stage is as ever over the first half.
    pub strokes: usize,
    /// Growth of the friction level per stroke afterwards [–].
    pub per_stroke: f64,
}

/// What the firmware said, and whether the host says the same.
#[derive(Clone, Debug)]
pub struct Notice {
    /// Commands compared.
    pub agreement: Agreement,
    /// Tick in which commissioning was over, in the emulator and on the host.
    pub learned: [Option<u64>; 2],
    /// Tick in which the wear began.
    pub worn_from: u64,
    /// Tick in which the flag was raised, to which side, in the emulator and on the host.
    pub raised: [Option<(u64, RangeCode)>; 2],
    /// Friction level of the stage then, or at the end [–].
    pub level: f64,
    /// Friction level that the adaptation had found at the end [–]; 1 without one.
    pub adapted: f64,
    /// Samples in the safe state: there should be none.
    pub faults: usize,
    /// What the firmware logged.
    pub log: String,
}

/// Runs the firmware `elf`, which watches with `friction`'s settings, on a stage that wears.
///
/// # Errors
/// [`RigError`] where a run cannot be made.
pub fn notice<F: Friction>(
    elf: &Path,
    friction: F,
    units: Units,
    wear: &Wear,
) -> Result<Notice, RigError> {
    let steps: Vec<Step> = (0..wear.strokes)
        .map(|i| Step::Move {
            distance_m: if i % 2 == 0 { STROKE_M } else { -STROKE_M },
            speed_m_s: SPEED_M_S,
            ramp_s: RAMP_S,
        })
        .collect();
    // Enabling keeps the background busy for longer than the telemetry's queue lasts; the first move's start must not be lost.
    let mut script = Script::quiet(0).queue(FIRST_MOVE, &steps)?;
    let tick = script.ticks;
    let worn_from = tick / 2;
    let per_tick = wear.per_stroke * wear.strokes as f64 / tick as f64;
    let level_at = move |tick: u64| 1.0 + per_tick * tick.saturating_sub(worn_from) as f64;
    script.disturb = Box::new(move |tick, stage| {
        if tick > worn_from {
            // A level above 1 is one that any stage takes.
            let _ = stage.set_friction_level(level_at(tick));
        }
    });
    let record = run(elf, &script, Listener::File)?;
    let (mut learned, mut raised) = (None, None);
    let agreement = compare(
        &record,
        &script,
        &steps,
        friction,
        units,
        |tick, controller, _| match controller.condition().range {
            Some(NormalRange::Inside) => learned = learned.or(Some(tick)),
            Some(NormalRange::Above) => raised = raised.or(Some((tick, RangeCode::Above))),
            Some(NormalRange::Below) => raised = raised.or(Some((tick, RangeCode::Below))),
            Some(NormalRange::Learning) | None => {}
        },
    )?;
    let inside = samples(&record).find(|sample| sample.range == Some(RangeCode::Inside));
    let out = samples(&record).find_map(|sample| match sample.range {
        Some(range @ (RangeCode::Above | RangeCode::Below)) => Some((sample.tick.into(), range)),
        _ => None,
    });
    let end = out.map_or(script.ticks, |(tick, _)| tick);
    Ok(Notice {
        agreement,
        learned: [inside.map(|sample| sample.tick.into()), learned],
        worn_from,
        raised: [out, raised],
        level: level_at(end),
        adapted: samples(&record)
            .last()
            .map_or(1.0, |last| 1.0 + f64::from(last.level) * 1e-4),
        faults: samples(&record)
            .filter(|sample| sample.fault.is_some())
            .count(),
        log: record.remains.log(),
    })
}
