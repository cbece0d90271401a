//! The chain with the firmware in QEMU.

use super::{JUDGED, RECORDED, Trial, judged, recorded};
use crate::rig::{CALIBRATED, Listener, RigError, Script, run, samples};
use crate::tracking::{Step, TrackingError};
use preslide_host::drive::starting;
use preslide_link::{ModelPart, PART, Refusal, Reply, Report, Request};
use std::cell::RefCell;
use std::path::Path;

/// Ticks from one sample of telemetry to the next: 1 kHz, as a slow serial line carries.
const EVERY: u16 = 20;

/// When the first move is sent, in ticks after the axis is enabled: the requests before it have been carried out by then. For a parameter
/// that is set the firmware builds its model anew, about 120 ticks for a Stribeck curve of an exponent that is no whole number.
const FIRST: u64 = 400;

fn first(trial: &Trial) -> u64 {
    match trial.config.electrical {
        Some(_) => CALIBRATED + FIRST,
        None => FIRST,
    }
}

fn script<'a>(trial: &Trial, run: u64, steps: Vec<Step>) -> Result<Script<'a>, TrackingError> {
    let mut script = match &trial.config.electrical {
        Some(electrical) => Script::electrical(electrical),
        None => Script::quiet(0),
    };
    script.axis = trial.axis;
    script.stage = trial.switched_on(run);
    // In single precision, which is nearer than half a count.
    let zero = Request::Zero {
        position_m: script.stage.start_m as f32,
    };
    script.concealed = Some(trial.effect);
    // The exchange of the initialisation, tick 0, carries no byte.
    let telemetry = Request::Telemetry { every: EVERY };
    let script = script.send(1, &[zero, telemetry]);
    script.follow(first(trial), &trial.from_start(run, steps))
}

/// Moves the stage through the recorded motion and hands the firmware's telemetry to the first client of the port; what the
/// firmware logged.
///
/// # Errors
/// [`RigError`] where the run cannot be made.
pub fn serve(trial: &Trial, elf: &Path, port: u16) -> Result<String, RigError> {
    let script = script(trial, RECORDED, recorded())?;
    Ok(run(elf, &script, Listener::Tcp(port))?.remains.log())
}

/// RMS error (m) of the stage's true position over the judged motion, by a firmware whose model was compiled in; `None` where
/// it gave up.
///
/// # Errors
/// [`RigError`] where the run cannot be made.
pub fn track(trial: &Trial, elf: &Path) -> Result<Option<f64>, RigError> {
    // Before each tick: where the stage was at the end of the one before it.
    let positions = RefCell::new(Vec::new());
    let mut script = script(trial, JUDGED, judged())?;
    script.disturb = Box::new(|_, stage| positions.borrow_mut().push(stage.truth().position_m));
    let set = Request::Model(ModelPart {
        layout: starting(),
        first: 0,
        values: [0.25; PART],
    });
    let record = run(elf, &script.send(FIRST, &[set]), Listener::File)?;
    let is_refusal = |report: &Report| {
        let other = Reply::Refused(Refusal::OtherModel);
        matches!(report, Report::Answer { reply, .. } if *reply == other)
    };
    if !record.remains.reports.iter().any(is_refusal) {
        return Err(RigError::Answer(
            "took a model of other parts than the one that was compiled in",
        ));
    }
    let positions = positions.borrow();
    let count = trial.axis.encoder.count;
    let (mut squares, mut number) = (0.0, 0);
    // A sample before that may still count positions from where the axis was switched on.
    let told = first(trial) + u64::from(EVERY);
    for sample in samples(&record).filter(|sample| u64::from(sample.tick) > told) {
        if sample.fault.is_some() {
            return Ok(None);
        }
        let Some(position) = positions.get(sample.tick as usize + 1) else {
            continue;
        };
        squares += (sample.reference as f64 / 65536.0 * count - position).powi(2);
        number += 1;
    }
    let whole = !record.broke_off && number > 0;
    Ok(whole.then(|| (squares / f64::from(number)).sqrt()))
}
