//! The firmware with an outer task: the same commands as the host's, and what becomes of them where the outer task is late.

use super::agreement::{Agreement, compare, samples};
use super::{Listener, Record, RigError, Script, motion, requests, run};
use crate::tracking::TrackingError;
use crate::tracking::koopman::{FirmwareSettings, FirmwareTask};
use preslide::control::NoFriction;
use preslide::control::koopman::{Desk, Guided};
use preslide::{ParamError, Units};
use preslide_link::{Reply, Report, Request};
use std::path::Path;

/// Ticks of a run, when it is asked how many orders were missed, and from when on the error is judged: the axis has set out by then.
const TICKS: u64 = 13_000;
const ASKED: u64 = 12_700;
const JUDGED: std::ops::Range<u64> = 2000..12_000;

/// What a run showed.
#[derive(Clone, Debug)]
pub struct Guidance {
    /// Its commands beside those of the host's simulation with the same orders.
    pub agreement: Agreement,
    /// RMS, mean and largest following error (m) by the encoder while it moved.
    pub errors_m: [f64; 3],
    /// Missed orders as the firmware counts them, and on the host.
    pub missed: [u32; 2],
    /// Samples in the safe state: there should be none.
    pub faults: usize,
}

/// Runs the firmware `elf`, built with these `settings`; `late` says in which ticks the next run of the outer task is made longer than its
/// sample.
///
/// # Errors
/// [`RigError`] where a run cannot be made.
pub fn guidance(
    elf: &Path,
    settings: &FirmwareSettings,
    late: impl Fn(u64) -> bool + Clone + 'static,
) -> Result<Guidance, RigError> {
    let parameter = |error: ParamError| RigError::Tracking(TrackingError::Parameter(error));
    let steps = motion();
    let mut script = Script::guided(TICKS)
        .send(20, &requests(&steps))
        .send(ASKED, &[Request::State]);
    let falsified = late.clone();
    script.falsify = Box::new(move |tick, reading| reading.outlast = falsified(tick));
    let record = run(elf, &script, Listener::File)?;
    let (ticks, force) = (settings.ticks, settings.cost.force);
    let friction = Guided::try_new(NoFriction::<f32>::new(), ticks, force, Units::SI);
    let friction = friction.map_err(parameter)?;
    let mut beside: Option<Beside> = None;
    let (asked, told) = told(&record)?;
    let mut missed = 0;
    let mut unusable = None;
    let agreement = compare(
        &record,
        &script,
        &steps,
        friction,
        Units::SI,
        |tick, controller, next| {
            let beside = beside.get_or_insert_with(|| {
                let desk = Desk::new(controller);
                let task = FirmwareTask::try_new(settings, &script.axis, &desk);
                Beside {
                    desk,
                    task: task.map_err(|error| unusable = Some(error)).ok(),
                    outlasts: false,
                    unanswered: None,
                }
            });
            beside.outlasts |= late(tick);
            let starts = beside.desk.attend(controller, || next);
            beside.go_on(starts);
            // The firmware tells what it had counted before that tick.
            if tick < asked {
                missed = controller.friction_state().missed();
            }
        },
    )?;
    match unusable {
        Some(error) => Err(parameter(error)),
        None => Ok(Guidance {
            agreement,
            errors_m: errors(&record, script.axis.encoder.count),
            missed: [told, missed],
            faults: samples(&record).filter(|s| s.fault.is_some()).count(),
        }),
    }
}

/// The outer task beside the host's controller.
struct Beside {
    desk: Desk,
    task: Option<FirmwareTask>,
    /// The next run is to take longer than its sample.
    outlasts: bool,
    /// The order of one that does.
    unanswered: Option<(u32, f32)>,
}

impl Beside {
    /// A tick: a late order comes just after its sample; one in time at once, which makes no difference.
    fn go_on(&mut self, starts: bool) {
        let over = |of: &mut (u32, f32)| of.0 != self.desk.sample();
        if let Some((of, force)) = self.unanswered.take_if(over) {
            self.desk.order(of, force);
        }
        let Some(task) = self.task.as_mut().filter(|_| starts) else {
            return;
        };
        if task.take(&mut self.desk) {
            let order = (task.sample(), task.solve());
            match std::mem::take(&mut self.outlasts) {
                true => self.unanswered = Some(order),
                false => self.desk.order(order.0, order.1),
            }
        }
    }
}

fn errors(record: &Record, count: f64) -> [f64; 3] {
    let judged = samples(record).filter(|s| JUDGED.contains(&u64::from(s.tick)));
    let errors: Vec<f64> = judged
        .map(|s| (s.reference as f64 / 65_536.0 - f64::from(s.position)) * count)
        .collect();
    let n = errors.len() as f64;
    let squares: f64 = errors.iter().map(|e| e * e).sum();
    let largest = errors.iter().fold(0.0, |most: f64, e| most.max(e.abs()));
    [
        (squares / n).sqrt(),
        errors.iter().sum::<f64>() / n,
        largest,
    ]
}

/// The tick in which the firmware told its state, and what it said of missed orders.
fn told(record: &Record) -> Result<(u64, u32), RigError> {
    let state = record
        .remains
        .reports
        .iter()
        .find_map(|report| match report {
            Report::Answer {
                reply: Reply::State(state),
                ..
            } => Some((state.tick.into(), state.missed.into())),
            _ => None,
        });
    state.ok_or(RigError::Answer("did not tell its state"))
}
