//! The same motion in the emulator and in the host's simulation: the same commands?

use super::run::{Record, Script, registers, requests, run};
use super::{Listener, RigError};
use crate::stage::Stage;
use crate::tracking::{Step, TrackingError};
use preslide::control::{Coefficients, Controller, Measurement, Move};
use preslide::{Friction, ParamError, Units};
use preslide_link::{Report, Sample};
use std::path::Path;

/// Triangles of 20, 5 and 1 µm, a step of 100 nm, and rest: 8 moves, which is what the firmware queues.
pub fn motion() -> Vec<Step> {
    let go = |distance_m: f64, speed_m_s: f64| Step::Move {
        distance_m,
        speed_m_s,
        ramp_s: 0.005,
    };
    vec![
        go(20e-6, 200e-6),
        go(-40e-6, 400e-6),
        go(25e-6, 400e-6),
        go(-10e-6, 100e-6),
        go(6e-6, 100e-6),
        go(-2e-6, 40e-6),
        go(0.1e-6, 20e-6),
        Step::Dwell(0.1),
    ]
}

/// The steps as the firmware gets them: through single precision.
fn narrowed(steps: &[Step]) -> Vec<Step> {
    let narrow = |value: f64| f64::from(value as f32);
    steps
        .iter()
        .map(|step| match *step {
            Step::Move {
                distance_m,
                speed_m_s,
                ramp_s,
            } => Step::Move {
                distance_m: narrow(distance_m),
                speed_m_s: narrow(speed_m_s),
                ramp_s: narrow(ramp_s),
            },
            Step::Dwell(time_s) => Step::Dwell(narrow(time_s)),
        })
        .collect()
}

/// How the emulator's commands compare with the host's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// Commands compared.
    pub ticks: usize,
    /// Largest difference (codes).
    pub largest: u32,
    /// Commands that differ.
    pub different: usize,
    /// Largest command (codes), to show that there was something to compare.
    pub reach: u32,
    /// A number that stands for all commands and all telemetry of the emulator (FNV-1a).
    pub digest: u64,
}

/// Runs [`motion`] on the firmware and on the host with the controller built from `friction` in `units`.
///
/// # Errors
/// [`RigError`] where a run cannot be made, or the firmware never moved.
pub fn agreement<F: Friction>(
    elf: &Path,
    friction: F,
    units: Units,
) -> Result<(Agreement, Record), RigError> {
    let steps = motion();
    let ticks = 16_000;
    let script = Script::quiet(ticks).send(20, &requests(&steps));
    let record = run(elf, &script, Listener::File)?;
    let agreement = compare(&record, &script, &steps, friction, units, |_, _, _| {})?;
    Ok((agreement, record))
}

/// Compares a run of the script, which asked for `steps` one behind the other, with the host's. `observe` is shown the host's
/// controller after every tick, and the move that waits.
pub(super) fn compare<F: Friction>(
    record: &Record,
    script: &Script,
    steps: &[Step],
    friction: F,
    units: Units,
    observe: impl FnMut(u64, &mut Controller<F, u32>, Option<Move>),
) -> Result<Agreement, RigError> {
    // Requests are read below the interrupt, so the ticks of enabling, from which what learns counts its looks, and of the
    // first move are the firmware's to tell.
    let enabled = record
        .enabled
        .ok_or(RigError::Answer("never enabled the axis"))?;
    let begin = samples(record)
        .find(|sample| sample.reference != 0)
        .map_or(u64::MAX, |sample| u64::from(sample.tick));
    let ticks = [enabled, begin];
    let host = simulate(script, &narrowed(steps), friction, units, ticks, observe)?;
    let pairs = record.codes.iter().zip(&host);
    let differences = pairs
        .clone()
        .map(|(a, b)| (i32::from(*a) - b).unsigned_abs());
    let mut digest = Digest::new();
    for code in &record.codes {
        digest.add(&code.to_le_bytes());
    }
    for report in &record.remains.reports {
        digest.add(format!("{report:?}").as_bytes());
    }
    Ok(Agreement {
        ticks: pairs.count(),
        largest: differences.clone().max().unwrap_or(u32::MAX),
        different: differences.filter(|difference| *difference > 0).count(),
        reach: host
            .iter()
            .map(|code| code.unsigned_abs())
            .max()
            .unwrap_or(0),
        digest: digest.0,
    })
}

/// The samples among the reports.
pub fn samples(record: &Record) -> impl Iterator<Item = Sample> + '_ {
    record
        .remains
        .reports
        .iter()
        .filter_map(|report| match report {
            Report::Sample(sample) => Some(*sample),
            _ => None,
        })
}

/// The host's simulation: the code of every exchange.
fn simulate<F: Friction>(
    script: &Script,
    steps: &[Step],
    friction: F,
    units: Units,
    [enabled, begin]: [u64; 2],
    mut observe: impl FnMut(u64, &mut Controller<F, u32>, Option<Move>),
) -> Result<Vec<i32>, RigError> {
    let settings = script.axis;
    let parameter = |error: ParamError| RigError::Tracking(TrackingError::Parameter(error));
    let mut stage = Stage::try_new(script.stage.clone()).map_err(TrackingError::from)?;
    let coefficients = Coefficients::try_new(&settings, friction, units).map_err(parameter)?;
    let first = registers(stage.tick(0.0), &settings.hardware).count;
    let mut controller = Controller::new(coefficients, first);
    let moves = steps
        .iter()
        .map(|step| step.plan(&settings))
        .collect::<Result<Vec<_>, _>>()
        .map_err(parameter)?;
    let mut moves = moves.into_iter();
    let mut codes = vec![0];
    let mut code = 0;
    for tick in 1..=script.ticks {
        codes.push(code);
        (script.disturb)(tick, &mut stage);
        let reading = stage.tick(f64::from(code) / f64::from(settings.hardware.steps));
        let reading = registers(reading, &settings.hardware);
        if tick == enabled {
            controller.enable().map_err(TrackingError::Stopped)?;
        }
        if tick >= begin
            && controller.is_idle()
            && let Some(next) = moves.next()
        {
            controller
                .start(next)
                .map_err(|_| RigError::Answer("was sent a move beyond the axis's limits"))?;
        }
        // The firmware hears the script often enough.
        controller.heard();
        code = controller
            .tick(Measurement {
                count: reading.count,
                supply: reading.supply,
                current: reading.current,
                late: false,
            })
            .code;
        // Before the first is made, none has come.
        let next = moves.as_slice().first().filter(|_| tick >= begin);
        observe(tick, &mut controller, next.copied());
    }
    Ok(codes)
}

/// FNV-1a.
struct Digest(u64);

impl Digest {
    fn new() -> Self {
        Self(0xCBF2_9CE4_8422_2325)
    }

    fn add(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3);
        }
    }
}
