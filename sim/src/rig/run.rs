//! A run: the firmware in lock step with the stage, with what is sent to it and what is done to it.

use super::{Emulator, Listener, Remains, RigError};
use crate::stage::concealed::Concealed;
use crate::stage::{ElectricalConfig, EncoderReading, Stage, StageConfig};
use crate::tracking::{Step, TrackingError};
use preslide::control::{Axis, Hardware};
use preslide_link::{LARGEST_FRAME, Name, Numbered, Reading, Request, encode};
use std::path::Path;

/// The exchange of the initialisation, tick 0, carries no byte.
const FIRST: u64 = 1;

/// Tick in which an axis has learned its current sense's offset: eight times the time constant of its mean.
pub const CALIBRATED: u64 = 2048;

/// Ticks by which a queued step comes early.
const AHEAD: u64 = 2000;

/// What an axis is told of its bridge.
pub(super) fn bridge(electrical: &ElectricalConfig) -> [(&'static str, f64); 2] {
    [
        ("hardware.dead_time", electrical.dead_time_s),
        ("hardware.diode_drop", electrical.diode_v),
    ]
}

/// A script is silent for longer than a host may be: the axis is told not to mind, and to be enabled.
fn enabling() -> Vec<Request> {
    let silence = set("silence", 0.0);
    silence.into_iter().chain([Request::Enable]).collect()
}

fn set(name: &str, value: f64) -> Option<Request> {
    Some(Request::Set(Name::new(name)?, value as f32))
}

/// The motion as requests.
pub fn requests(steps: &[Step]) -> Vec<Request> {
    steps
        .iter()
        .map(|step| match *step {
            Step::Move {
                distance_m,
                speed_m_s,
                ramp_s,
            } => Request::Move {
                distance_m: distance_m as f32,
                speed_m_s: speed_m_s as f32,
                ramp_s: ramp_s as f32,
            },
            Step::Dwell(time_s) => Request::Dwell {
                time_s: time_s as f32,
            },
        })
        .collect()
}

/// Does something to `T` in the tick given.
pub type ByTick<'a, T> = Box<dyn Fn(u64, &mut T) + 'a>;

/// What happens in a run, by tick.
pub struct Script<'a> {
    /// Ticks before the quit.
    pub ticks: u64,
    /// What the firmware was built for.
    pub axis: Axis,
    /// The stage.
    pub stage: StageConfig,
    /// What it hides.
    pub concealed: Option<Concealed>,
    /// Bytes on the command link: from which tick on, and what.
    pub bytes: Vec<(u64, Vec<u8>)>,
    /// Requests among them, which are numbered from 0.
    pub requests: u16,
    /// Changes the stage before the tick.
    pub disturb: ByTick<'a, Stage>,
    /// Falsifies what the board reads in the tick.
    pub falsify: ByTick<'a, Reading>,
    /// A QEMU plugin that watches, with its arguments.
    pub plugin: Option<String>,
}

impl Script<'_> {
    /// Nothing but the stage at rest, the axis enabled.
    pub fn quiet(ticks: u64) -> Self {
        Self {
            ticks,
            ..Self::told(FIRST, &[])
        }
    }

    /// As [`Script::quiet`], with nothing to run: an axis that is told `settings`, and enabled in the tick `enabled`. What is built for
    /// them, `axis`, is the caller's.
    pub fn told(enabled: u64, settings: &[(&str, f64)]) -> Self {
        let set: Vec<Request> = settings
            .iter()
            .filter_map(|(name, value)| set(name, *value))
            .collect();
        Self {
            ticks: 0,
            axis: Axis::PAPER_AXIS,
            stage: StageConfig {
                seed: 7,
                ..StageConfig::default()
            },
            concealed: None,
            bytes: Vec::new(),
            requests: 0,
            disturb: Box::new(|_, _| {}),
            falsify: Box::new(|_, _| {}),
            plugin: None,
        }
        .send(FIRST, &set)
        .send(enabled, &enabling())
    }

    /// As [`Script::told`] of the dead time of its bridge, and enabled once it has learned what its current sense reads at rest. The stage is
    /// the caller's.
    pub fn electrical(electrical: &ElectricalConfig) -> Self {
        Self::told(CALIBRATED, &bridge(electrical))
    }

    /// As [`Script::quiet`], with the integral's place free for an outer task.
    pub fn guided(ticks: u64) -> Self {
        let mut script = Self::told(FIRST, &[("gains.integral", 0.0)]);
        script.ticks = ticks;
        script.axis.gains.integral = 0.0;
        script
    }

    /// Sends requests from `tick` on, one behind the other.
    #[must_use]
    pub fn send(mut self, tick: u64, requests: &[Request]) -> Self {
        let mut bytes = Vec::new();
        for &request in requests {
            let id = self.requests;
            bytes.extend(frame(&Numbered { id, request }));
            self.requests = id.wrapping_add(1);
        }
        self.bytes.push((tick, bytes));
        self
    }

    /// Sends steps from `tick` on, each 2000 ticks before the one ahead of it ends, so that there is no rest between them; the script ends before
    /// the last does. From the first on there is a sample of telemetry every 20th tick only, for speed.
    ///
    /// # Errors
    /// A step that cannot be planned.
    pub fn queue(mut self, mut tick: u64, steps: &[Step]) -> Result<Self, TrackingError> {
        for (i, step) in steps.iter().enumerate() {
            self = self.send(tick, &requests(std::slice::from_ref(step)));
            let ticks = u64::from(step.plan(&self.axis)?.ticks());
            if i == 0 {
                // Its start is to be seen.
                self = self.send(tick + 1000, &[Request::Telemetry { every: 20 }]);
                tick -= AHEAD;
            }
            tick += ticks;
        }
        self.ticks = tick;
        Ok(self)
    }

    /// Sends moves from `tick` on, one request a move, each in time for the one before it to end; the script ends with the
    /// last, and 10 ms of rest.
    ///
    /// # Errors
    /// A move that cannot be planned.
    pub fn follow(mut self, mut tick: u64, steps: &[Step]) -> Result<Self, TrackingError> {
        for step in steps {
            self = self.send(tick, &requests(std::slice::from_ref(step)));
            let planned = step.plan(&self.axis)?;
            tick += u64::from(planned.ticks());
        }
        self.ticks = tick + 200;
        Ok(self)
    }
}

/// A message as it goes over the line.
pub fn frame<T: serde::Serialize>(message: &T) -> Vec<u8> {
    let mut out = [0; LARGEST_FRAME];
    let length = encode(message, &mut out).unwrap_or(0);
    out.get(..length).unwrap_or_default().to_vec()
}

/// What the board's registers show for a reading of the stage.
pub fn registers(reading: EncoderReading, hardware: &Hardware) -> Reading {
    Reading {
        count: reading.count.cast_unsigned(),
        // Saturating casts: what an ADC does.
        supply: (reading.supply_v / hardware.supply_code).round() as u16,
        current: (reading.current_a / hardware.current_code).round() as i16,
        ..Reading::default()
    }
}

/// A finished run.
pub struct Record {
    /// The code of every exchange; the first is the one before the first tick.
    pub codes: Vec<i16>,
    /// The first tick in which the bridge was driven: that in which the axis was enabled. `None` where it never was.
    pub enabled: Option<u64>,
    /// Telemetry and log.
    pub remains: Remains,
    /// The firmware broke the lock step before the script's end, as a watchdog does.
    pub broke_off: bool,
}

/// Runs the script on the firmware `elf`.
///
/// # Errors
/// [`RigError`] where QEMU or the stage cannot be started.
pub fn run(elf: &Path, script: &Script, listener: Listener) -> Result<Record, RigError> {
    let steps = f64::from(script.axis.hardware.steps);
    let config = script.stage.clone();
    let mut stage = match script.concealed {
        Some(effect) => Stage::concealing(config, effect),
        None => Stage::try_new(config),
    }
    .map_err(TrackingError::from)?;
    let mut emulator = Emulator::start(elf, listener, script.plugin.as_deref())?;
    let mut codes = Vec::new();
    let mut enabled = None;
    let mut broke_off = false;
    let mut line = script
        .bytes
        .iter()
        .flat_map(|(from, bytes)| bytes.iter().map(move |&byte| (*from, byte)));
    let mut waiting = line.next();
    for tick in 0..=script.ticks {
        let Ok(order) = emulator.order() else {
            broke_off = true;
            break;
        };
        codes.push(order.code);
        if order.driven {
            // What a tick orders comes with the next exchange.
            enabled = enabled.or(Some(tick.saturating_sub(1)));
        }
        (script.disturb)(tick, &mut stage);
        let reading = stage.tick(f64::from(order.code) / steps);
        let mut reading = registers(reading, &script.axis.hardware);
        if let Some((_, byte)) = waiting.filter(|(from, _)| *from <= tick) {
            reading.byte = Some(byte);
            waiting = line.next();
        }
        (script.falsify)(tick, &mut reading);
        reading.quit = tick == script.ticks;
        let shown = emulator.reading(reading);
        broke_off = shown.is_err();
        if broke_off || reading.quit {
            break;
        }
    }
    Ok(Record {
        codes,
        enabled,
        remains: emulator.finish(),
        broke_off,
    })
}
