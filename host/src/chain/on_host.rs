//! The chain without an emulator: the same control code on the host.

use super::{Errors, Row, Trial, judged, known, recorded};
use crate::capture::{Scale, capture};
use crate::diagnose::{Refusal, diagnose};
use crate::friction::Visitor;
use crate::identify::{Options, STEPS, identify};
use crate::model::Model;
use crate::progress::Progress;
use crate::recording::{LoadOptions, load_csv};
use crate::rig::frame;
use crate::stage::Stage;
use crate::tracking::{Axis, Step, Tracking, TrackingError};
use anyhow::Context;
use preslide::control::{Move, NoFriction, Settings};
use preslide::{Friction, Units};
use preslide_link::{Report, Sample};

/// Ticks from one sample of telemetry to the next, as a serial line carries them.
const EVERY: u64 = 20;

/// The bytes of telemetry that a controller without a friction model sends while it follows the recorded motion.
///
/// # Errors
/// [`TrackingError`] where the motion cannot be planned.
pub fn record(stage: Stage) -> Result<Vec<u8>, TrackingError> {
    let settings = Settings::PAPER_AXIS;
    let mut axis = Axis::on(&settings, NoFriction::<f64>::new(), Units::SI, stage)?;
    let moves = plan(&recorded(), &settings)?;
    let mut bytes = Vec::new();
    let (mut tick, mut sequence) = (0_u32, 0);
    axis.follow(&moves, |now| {
        tick += 1;
        if u64::from(tick).is_multiple_of(EVERY) {
            bytes.extend(frame(&Report::Sample(Sample {
                sequence,
                dropped: 0,
                tick,
                position: now.command.position as i32,
                reference: now.command.reference,
                code: now.command.code as i16,
                current: (now.current_a * 1e4).round() as i16,
                supply: 6000,
                fault: None,
            })));
            sequence += 1;
        }
    });
    Ok(bytes)
}

fn plan(steps: &[Step], settings: &Settings) -> Result<Vec<Move<f64>>, TrackingError> {
    let plan = |step: &Step| step.plan(settings, Units::SI);
    Ok(steps.iter().map(plan).collect::<Result<Vec<_>, _>>()?)
}

/// Follows the judged motion with a model fed forward, or none; the true position's error.
///
/// # Errors
/// [`TrackingError`] where the model cannot be used or the axis faults.
pub fn follow(stage: Stage, model: Option<&Model>) -> Result<Tracking, TrackingError> {
    let closed = Closed { stage };
    match model {
        None => closed.visit(NoFriction::<f64>::new()),
        Some(model) => model
            .feed_forward(Settings::PAPER_AXIS.sample_time, closed)
            .map_err(TrackingError::Identification)?,
    }
}

struct Closed {
    stage: Stage,
}

impl Visitor for Closed {
    type Outcome = Result<Tracking, TrackingError>;

    fn visit<M: Friction<Scalar = f64>>(self, model: M) -> Self::Outcome {
        let settings = Settings::PAPER_AXIS;
        let mut axis = Axis::on(&settings, model, Units::SI, self.stage)?;
        let moves = plan(&judged(), &settings)?;
        let mut tracking = Tracking::default();
        axis.follow(&moves, |now| {
            tracking.add_true(&now, settings.encoder.count)
        });
        Ok(tracking)
    }
}

/// Ticks of a row of the recording: 2 ms.
const ROW: u32 = 40;

/// The whole chain of a trial without an emulator, in one process; the diagnosis still gets recording and model alone.
///
/// # Errors
/// Whatever a step of it refuses.
pub fn rehearse(trial: &Trial) -> anyhow::Result<Row> {
    let mut csv = Vec::new();
    let scale = Scale::of(&Settings::PAPER_AXIS, ROW);
    capture(&record(trial.stage()?)?[..], &mut csv, &scale, None, || {})?;
    let recording = load_csv(&csv[..], "recording.csv", &LoadOptions::default())?;
    let progress = Progress::new("identify", STEPS);
    let found = identify(&recording, &Options::default(), &progress).map_err(anyhow::Error::msg)?;
    let before = &found.best().model;
    let (study, diagnosis) =
        diagnose(&recording, Some(before), &progress).map_err(|refusal| match refusal {
            Refusal::Input(reason) | Refusal::Data(reason) => anyhow::Error::msg(reason),
        })?;
    let (after, _) = diagnosis.extended_model(&study, &recording, Some(before));
    let known = known(trial).map_err(anyhow::Error::msg)?;
    let error = |model| anyhow::Ok(follow(trial.stage()?, model)?.rms_m());
    Ok(Row {
        concealed: trial.effect.id(),
        told: serde_json::from_value(diagnosis.to_json(&recording, 0.0))
            .context("the diagnosis in JSON")?,
        errors: Errors {
            none: error(None)?,
            before: error(Some(before))?,
            after: error(Some(&after))?,
            known: error(Some(&known))?,
        },
    })
}
