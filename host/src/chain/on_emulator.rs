//! The chain with the firmware in QEMU.

use super::{Trial, judged, recorded};
use crate::rig::{Listener, RigError, Script, run, samples};
use crate::tracking::{Step, TrackingError};
use preslide::control::Settings;
use preslide_link::{MOST_BLOCKS, ModelSettings, Refusal, Reply, Report, Request};
use std::cell::RefCell;
use std::path::Path;

/// Ticks from one sample of telemetry to the next: 1 kHz, as a slow serial line carries.
const EVERY: u16 = 20;

/// When the first move is sent: the request before it has been read by then.
const FIRST: u64 = 40;

fn script<'a>(trial: &Trial, steps: &[Step]) -> Result<Script<'a>, TrackingError> {
    let mut script = Script::quiet(0);
    script.stage = trial.config.clone();
    script.concealed = Some(trial.effect);
    // The exchange of the initialisation, tick 0, carries no byte.
    let telemetry = Request::Telemetry { every: EVERY };
    script.send(1, &[telemetry]).follow(FIRST, steps)
}

/// Moves the stage through the recorded motion and hands the firmware's telemetry to the first client of the port; what the
/// firmware logged.
///
/// # Errors
/// [`RigError`] where the run cannot be made.
pub fn serve(trial: &Trial, elf: &Path, port: u16) -> Result<String, RigError> {
    let script = script(trial, &recorded())?;
    Ok(run(elf, &script, Listener::Tcp(port))?.remains.log)
}

/// RMS error (m) of the stage's true position over the judged motion, by a firmware whose model was compiled in; `None` where
/// it gave up.
///
/// # Errors
/// [`RigError`] where the run cannot be made.
pub fn track(trial: &Trial, elf: &Path) -> Result<Option<f64>, RigError> {
    // Before each tick: where the stage was at the end of the one before it.
    let positions = RefCell::new(Vec::new());
    let mut script = script(trial, &judged())?;
    script.disturb = Box::new(|_, stage| positions.borrow_mut().push(stage.truth().position_m));
    let set = Request::Model(ModelSettings {
        breakaway_n: 0.9,
        blocks: [(1e5, 0.25); MOST_BLOCKS],
    });
    let record = run(elf, &script.send(FIRST, &[set]), Listener::File)?;
    let is_refusal = |report: &Report| {
        let compiled_in = Reply::Refused(Refusal::CompiledIn);
        matches!(report, Report::Answer { reply, .. } if *reply == compiled_in)
    };
    if !record.remains.reports.iter().any(is_refusal) {
        return Err(RigError::Answer(
            "took a model over the link in place of the one that was compiled in",
        ));
    }
    let positions = positions.borrow();
    let count = Settings::PAPER_AXIS.encoder.count;
    let (mut squares, mut number) = (0.0, 0);
    for sample in samples(&record).filter(|sample| u64::from(sample.tick) > FIRST) {
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
