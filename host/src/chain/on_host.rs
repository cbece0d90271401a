//! The chain without an emulator: the same control code on the host.

use super::{judged, recorded};
use crate::friction::Visitor;
use crate::model::Model;
use crate::rig::frame;
use crate::stage::Stage;
use crate::tracking::{Axis, Step, Tracking, TrackingError};
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
