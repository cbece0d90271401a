//! The chain without an emulator: the same control code on the host.

use super::any::AnyFriction;
use super::{Errors, JUDGED, RECORDED, Row, Tracked, Trial, judged, known, recorded};
use crate::rig::telemetry;
use crate::stage::Stage;
use crate::tracking::{Axis, Step, Tracking, TrackingError};
use anyhow::Context;
use preslide::control::{NoFriction, Settings};
use preslide::{Friction, Units};
use preslide_fit::friction::Visitor;
use preslide_fit::identify::{Options, STEPS, identify};
use preslide_fit::kernel::Kernel;
use preslide_fit::model::Model;
use preslide_fit::progress::Progress;
use preslide_fit::recording::{LoadOptions, load_csv};
use preslide_host::capture::{Scale, capture};
use preslide_host::diagnose::diagnose;

/// Ticks from one sample of telemetry to the next, as a serial line carries them.
const EVERY: u32 = 20;
/// Ticks of a row of the recording: 2 ms.
const ROW: u32 = 40;

/// The recording (CSV) of a controller without a friction model that follows the recorded motion: its telemetry, captured.
///
/// # Errors
/// Where the stage or the motion is refused, or the controller gave up.
pub fn record(trial: &Trial) -> anyhow::Result<String> {
    let settings = trial.axis;
    let friction = NoFriction::<f64>::new();
    let mut axis = Axis::on(&settings, friction, Units::SI, trial.stage(RECORDED)?)?;
    let steps = trial.from_start(RECORDED, recorded());
    let telemetry = telemetry(&mut axis, &settings, &steps, EVERY, |_, _| {})?;
    let mut csv = Vec::new();
    capture(
        &telemetry[..],
        &mut csv,
        &Scale::of(&settings, ROW),
        None,
        || {},
    )?;
    Ok(String::from_utf8(csv)?)
}

/// How the judged motion was followed.
#[derive(Clone, Debug, Default)]
pub struct Followed {
    /// Error of the true position.
    pub error: Tracking,
    /// Time (s) of every twentieth tick.
    pub t_s: Vec<f64>,
    /// Reference (m) there.
    pub reference_m: Vec<f64>,
    /// Reference less true position (m) there.
    pub error_m: Vec<f64>,
}

/// Follows the judged motion with a model fed forward, or none.
///
/// # Errors
/// [`TrackingError`] where the model cannot be used. A fault of the controller is no error: the answer says so.
pub fn follow(trial: &Trial, model: Option<&Model>) -> Result<Followed, TrackingError> {
    let closed = Closed::of(trial)?;
    match model {
        None => closed.visit(NoFriction::<f64>::new()),
        Some(model) => model
            .feed_forward(closed.settings.sample_time(), closed)
            .map_err(TrackingError::Identification)?,
    }
}

/// The same with the model's friction in a kernel's form, as `preslide export --kernel` writes it.
///
/// # Errors
/// As there.
pub fn follow_by(trial: &Trial, model: &Model, kernel: Kernel) -> Result<Followed, TrackingError> {
    let closed = Closed::of(trial)?;
    model
        .feed_forward_by(kernel, closed.settings.sample_time(), closed)
        .map_err(TrackingError::Identification)?
}

struct Closed {
    stage: Stage,
    settings: Settings,
    steps: Vec<Step>,
}

impl Closed {
    fn of(trial: &Trial) -> Result<Self, TrackingError> {
        Ok(Self {
            stage: trial.stage(JUDGED)?,
            settings: trial.axis,
            steps: trial.from_start(JUDGED, judged()),
        })
    }

    fn by(self, model: AnyFriction) -> Result<Followed, TrackingError> {
        let settings = self.settings;
        let mut axis = Axis::on(&settings, model, Units::SI, self.stage)?;
        let mut followed = Followed::default();
        let mut tick = 0;
        axis.follow(&Step::plan_all(&self.steps, &settings)?, |now| {
            tick += 1;
            followed.error.add_true(&now, settings.encoder.count);
            if tick % EVERY == 0 {
                let reference = now.command.reference as f64 / 65536.0 * settings.encoder.count;
                followed.t_s.push(f64::from(tick) * settings.sample_time());
                followed.reference_m.push(reference);
                followed.error_m.push(reference - now.true_m);
            }
        });
        Ok(followed)
    }
}

impl Visitor for Closed {
    type Outcome = Result<Followed, TrackingError>;

    fn visit<M: Friction<Scalar = f64> + 'static>(self, model: M) -> Self::Outcome {
        self.by(AnyFriction::of(model))
    }
}

/// The whole chain of a trial without an emulator, in one process; the diagnosis still gets recording and model alone.
///
/// # Errors
/// Whatever a step of it refuses.
pub fn rehearse(trial: &Trial) -> anyhow::Result<Row> {
    let csv = record(trial)?;
    let recording = load_csv(csv.as_bytes(), "recording.csv", &LoadOptions::default())?;
    let progress = Progress::new("identify", STEPS);
    let found = identify(&recording, &Options::default(), &progress).map_err(anyhow::Error::msg)?;
    let before = &found.best().model;
    let diagnosis = diagnose(&recording, Some(before), None, &progress)?;
    let after = diagnosis.extended_model(&recording).model.clone();
    let mut refit = after.clone();
    refit.effects.clear();
    let known = known(trial).map_err(anyhow::Error::msg)?;
    let error = |model| anyhow::Ok(Tracked::from(follow(trial, model)?.error.rms_m()));
    Ok(Row {
        concealed: trial.effect.id(),
        told: serde_json::from_value(diagnosis.to_json(&recording, 0.0))
            .context("the diagnosis in JSON")?,
        errors: Errors {
            none: error(None)?,
            before: error(Some(before))?,
            refit: error(Some(&refit))?,
            after: error(Some(&after))?,
            known: error(Some(&known))?,
        },
    })
}
