//! Faults, injected one at a time, and what the firmware makes of each, as text to compare with a golden file.

use super::{Listener, Record, RigError, Script, frame, motion, requests, run};
use crate::stage::{EncoderConfig, StageConfig};
use preslide_host::drive::starting;
use preslide_link::{GainSettings, ModelPart, Numbered, PART, Report, Request};
use std::fmt::Write;
use std::path::Path;

/// The tick of the injection.
const AT: u64 = 2000;

/// A run that has something to log: a fault, its end, and a move faster than its limit.
pub fn logged() -> Script<'static> {
    let fast = Request::Move {
        distance_m: 1e-4,
        speed_m_s: 1.0,
        ramp_s: 0.1,
    };
    let mut script = encoder_jump().send(AT + 600, &[fast]);
    script.ticks = AT + 1000;
    script
}

/// One fault.
pub struct Injection {
    /// Name of the golden file.
    pub name: &'static str,
    /// What is done, and what should happen.
    pub story: &'static str,
    /// Ticks from the injection within which the safe state must be reached; `None` where it must not be.
    within: Option<u32>,
    script: fn() -> Script<'static>,
    /// The commands differ from an undisturbed run's.
    unlike_undisturbed: bool,
}

fn moving(ticks: u64) -> Script<'static> {
    Script::quiet(ticks).send(20, &requests(&motion()))
}

/// Of a request that is sent as bytes: far from those that scripts give.
const NUMBER: u16 = 1000;

fn numbered(request: Request) -> Vec<u8> {
    frame(&Numbered {
        id: NUMBER,
        request,
    })
}

const GAINS: GainSettings = GainSettings {
    proportional: 1e5,
    integral: 3e6,
    derivative: 600.0,
};

/// Breakaway force (N), stiffness (N/m) and weight of each block.
const MODEL: [f32; PART] = [
    0.9, 313_728.0, 0.339, 43_670.0, 0.236, 10_545.0, 0.171, 5_858.0, 0.253, 0.0, 0.0, 0.0,
];

fn model(values: [f32; PART]) -> Request {
    Request::Model(ModelPart {
        layout: starting(),
        first: 0,
        values,
    })
}

/// All of them.
pub fn injections() -> Vec<Injection> {
    let injection = |name, story, script| Injection {
        name,
        story,
        within: None,
        script,
        unlike_undisturbed: true,
    };
    vec![
        Injection {
            // At 2 mm/s the following error's 50 µm are 25 ms; the frozen-encoder watch is sooner once the push is large.
            within: Some(500),
            ..injection(
                "encoder_frozen",
                "the count stops while the axis moves: safe state once the error or the push is too large",
                encoder_frozen,
            )
        },
        Injection {
            // In the tick that sees it.
            within: Some(0),
            ..injection(
                "encoder_jump",
                "the count jumps by 4000 in one tick: safe state in that tick; a restart stands where the axis is",
                encoder_jump,
            )
        },
        Injection {
            unlike_undisturbed: false,
            ..injection(
                "count_wrap",
                "the counter wraps during the motion: nothing happens, the commands are those of any other origin",
                count_wrap,
            )
        },
        Injection {
            // The third late tick of the last series is seen in the next tick.
            within: Some(203),
            ..injection(
                "overrun",
                "one late tick, then two in a row, are ridden out; four in a row are not",
                overrun,
            )
        },
        Injection {
            unlike_undisturbed: false,
            ..injection(
                "corrupt_parameters",
                "a parameter block with a flipped bit: refused by its CRC, the running parameters stay",
                corrupt_parameters,
            )
        },
        Injection {
            unlike_undisturbed: false,
            ..injection(
                "invalid_parameters",
                "NaN, infinite, negative, and weights that do not sum to 1: refused, the running parameters stay",
                invalid_parameters,
            )
        },
        Injection {
            // The watch's 1 ms.
            within: Some(20),
            ..injection(
                "supply_sag",
                "the supply falls to 4 V: ridden out for 1 ms, then safe state",
                supply_sag,
            )
        },
        Injection {
            unlike_undisturbed: false,
            ..injection(
                "telemetry_unread",
                "nobody reads the telemetry for a second: samples are lost and counted, the commands do not change",
                telemetry_unread,
            )
        },
        Injection {
            unlike_undisturbed: false,
            ..injection(
                "garbage",
                "noise, a truncated, an oversized and an unknown frame: each refused by kind, the next one is read",
                garbage,
            )
        },
        injection(
            "watchdog",
            "the control task hangs: after ten ticks the watchdog turns the PWM off, before any other exchange with the stage",
            watchdog,
        ),
    ]
}

fn encoder_frozen() -> Script<'static> {
    let frozen = std::cell::Cell::new(0);
    let far = Request::Move {
        distance_m: 2e-3,
        speed_m_s: 2e-3,
        ramp_s: 0.01,
    };
    let mut script = Script::quiet(6000).send(20, &[far]);
    script.falsify = Box::new(move |tick, reading| {
        if tick < AT {
            frozen.set(reading.count);
        } else {
            reading.count = frozen.get();
        }
    });
    script
}

fn encoder_jump() -> Script<'static> {
    let mut script = moving(6000).send(AT + 500, &[Request::Acknowledge, Request::Enable]);
    script.falsify = Box::new(|tick, reading| {
        if tick >= AT {
            reading.count = reading.count.wrapping_add(4000);
        }
    });
    script
}

fn count_wrap() -> Script<'static> {
    let mut script = moving(6000);
    script.stage = StageConfig {
        encoder: EncoderConfig {
            origin_count: -100,
            ..script.stage.encoder
        },
        ..script.stage
    };
    script
}

fn overrun() -> Script<'static> {
    let mut script = moving(6000);
    script.falsify = Box::new(|tick, reading| {
        reading.dawdle = [0, 100, 101, 200, 201, 202, 203]
            .iter()
            .any(|t| tick == AT + t);
    });
    script
}

fn corrupt_parameters() -> Script<'static> {
    let mut bytes = numbered(model(MODEL));
    // Of the first parameter: no length of COBS.
    if let Some(byte) = bytes.get_mut(11) {
        *byte ^= 0x04;
    }
    let mut script = moving(6000);
    script.bytes.push((AT, bytes));
    script
}

fn invalid_parameters() -> Script<'static> {
    let gains = |proportional| {
        Request::Gains(GainSettings {
            proportional,
            ..GAINS
        })
    };
    let with = |at: usize, value| {
        let mut values = MODEL;
        values[at] = value;
        model(values)
    };
    let (heavy, negative) = (with(4, 0.5), with(0, -0.9));
    moving(6000).send(
        AT,
        &[
            gains(f32::NAN),
            gains(f32::INFINITY),
            gains(-1.0),
            gains(1e12),
            heavy,
            negative,
        ],
    )
}

fn supply_sag() -> Script<'static> {
    let mut script = moving(6000);
    script.disturb = Box::new(|tick, stage| {
        if tick == AT {
            // 4 V is a voltage that any stage takes.
            let _ = stage.set_supply_v(4.0);
        }
    });
    script
}

fn telemetry_unread() -> Script<'static> {
    let mut script = moving(14_000);
    // Not by a listener that pauses: what its socket still takes, and when, is the host's matter and not the firmware's.
    script.falsify = Box::new(|tick, reading| reading.unread = (500..12_000).contains(&tick));
    script
}

fn garbage() -> Script<'static> {
    let whole = numbered(Request::Gains(GAINS));
    let truncated = [whole.get(..6).unwrap_or_default(), &[0]].concat();
    let mut script = moving(6000);
    let noise: Vec<u8> = (1..=40_u32)
        .map(|i| (i * 97 % 251) as u8 + 1)
        .chain([0])
        .collect();
    let oversized = [vec![0x55; 200], vec![0]].concat();
    // A well-made frame of a message that does not exist: the tag 99 with its CRC.
    let unknown = frame(&(NUMBER, 99_u8));
    let good = numbered(Request::Ping);
    script
        .bytes
        .push((AT, [noise, truncated, oversized, unknown, good].concat()));
    script
}

fn watchdog() -> Script<'static> {
    let mut script = moving(6000);
    script.falsify = Box::new(|tick, reading| reading.hang = tick == AT);
    script
}

impl Injection {
    /// Runs it and tells what happened. `undisturbed` is a run of [`motion`] without a fault.
    ///
    /// # Errors
    /// [`RigError`] where the run cannot be made.
    pub fn tell(&self, elf: &Path, undisturbed: &Record) -> Result<String, RigError> {
        let record = run(elf, &(self.script)(), Listener::File)?;
        let mut text = format!("{}\n", self.story);
        let seen = Seen::told(&record.remains.reports, &mut text);
        if let Some(verdict) = self.verdict(seen.fault_after) {
            let _ = writeln!(text, "safe state: {verdict}");
        }
        seen.tell_losses(&mut text);
        if self.unlike_undisturbed {
            let code = record.codes.last().copied().unwrap_or(0);
            let _ = writeln!(text, "last code: {code}");
        }
        let ended = if record.broke_off {
            "broken off"
        } else {
            "to the end"
        };
        let _ = writeln!(text, "lock step: {ended}");
        if !self.unlike_undisturbed {
            let mut both = record.codes.iter().zip(&undisturbed.codes);
            let same = if both.all(|(a, b)| a == b) {
                "yes"
            } else {
                "no"
            };
            let _ = writeln!(text, "commands as without the fault: {same}");
        }
        // The stack's use is the build's, not the fault's.
        let told = |line: &&str| !line.is_empty() && !line.starts_with("stack");
        for line in record.remains.log().lines().filter(told) {
            let _ = writeln!(text, "log: {line}");
        }
        Ok(text)
    }

    /// Whether the safe state, reached so many ticks after the injection, came when it should.
    fn verdict(&self, reached: Option<i64>) -> Option<String> {
        match (self.within, reached) {
            (Some(limit), Some(after)) => {
                let met = (0..=i64::from(limit)).contains(&after);
                Some(format!(
                    "within {limit} ticks: {}",
                    if met { "yes" } else { "NO" }
                ))
            }
            (Some(limit), None) => Some(format!("within {limit} ticks: NO, not at all")),
            (None, Some(_)) => Some("reached, and should NOT be".to_owned()),
            (None, None) => None,
        }
    }
}

/// What the samples of a run show.
struct Seen {
    /// Ticks from the injection to the first fault.
    fault_after: Option<i64>,
    /// Samples that the last one counts as dropped; none where there is no sample.
    dropped: Option<u32>,
    /// Samples that are missing without being counted.
    missing: u64,
}

impl Seen {
    /// Reads the reports and writes into `text` every change of the fault, and what is no sample.
    fn told(reports: &[Report], text: &mut String) -> Self {
        let mut seen = Self {
            fault_after: None,
            dropped: None,
            missing: 0,
        };
        let (mut fault, mut sequence) = (None, 0);
        for report in reports {
            let Report::Sample(sample) = report else {
                let _ = writeln!(text, "{report:?}");
                continue;
            };
            if sample.fault != fault {
                fault = sample.fault;
                // Ticks are counted from 1, the injection's from 0.
                let after = i64::from(sample.tick) - AT as i64;
                seen.fault_after = seen.fault_after.or(Some(after));
                let _ = writeln!(
                    text,
                    "tick {} (injection {after:+}): {fault:?}, code {}",
                    sample.tick, sample.code
                );
            }
            seen.missing += u64::from(sample.sequence.wrapping_sub(sequence));
            sequence = sample.sequence.wrapping_add(1);
            seen.dropped = Some(sample.dropped);
        }
        seen
    }

    /// Writes what of the samples was lost.
    fn tell_losses(&self, text: &mut String) {
        if let Some(dropped) = self.dropped {
            let counted = if dropped > 0 {
                "some, and counted"
            } else {
                "none"
            };
            let _ = writeln!(text, "samples dropped: {counted}");
            let _ = writeln!(
                text,
                "samples missing without being counted: {}",
                self.missing
            );
        }
    }
}
