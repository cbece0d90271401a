//! The catalogue: what each effect is, what it needs, and what it is easily taken for.

use super::signals::{Signals, bounds};

/// One entry of the catalogue.
pub struct Entry {
    /// Its name, as in model files and JSON.
    pub id: &'static str,
    /// What it is, for a control engineer.
    pub words: &'static str,
    /// Effects that it is easily taken for.
    pub rivals: &'static [&'static str],
    /// The experiment that tells it from them.
    pub experiment: &'static str,
}

/// Every effect that is tested, in the order in which a tie is decided: the simpler one first.
pub const TESTED: [Entry; 25] = [
    Entry {
        id: "constant_force",
        words: "a constant force: gravity, tilt or a current offset",
        rivals: &["coulomb_asymmetry"],
        experiment: "turn the stage end for end: a tilt changes its sign, an asymmetry of friction does not; or change the load",
    },
    Entry {
        id: "viscous",
        words: "a force proportional to velocity",
        rivals: &["stribeck", "channel_delay", "quadratic_drag"],
        experiment: "strokes at 1, 3 and 10 times the speed, long enough for constant velocity",
    },
    Entry {
        id: "coulomb_asymmetry",
        words: "friction that differs by direction",
        rivals: &["constant_force"],
        experiment: "turn the stage end for end, or change the load: an asymmetry scales with the friction level",
    },
    Entry {
        id: "quadratic_drag",
        words: "a force that grows with the square of velocity",
        rivals: &["viscous"],
        experiment: "constant speeds over a decade, up to the highest",
    },
    Entry {
        id: "stribeck",
        words: "friction that falls with speed at low speed",
        rivals: &["dwell_aging", "viscous", "frictional_lag"],
        experiment: "rests of 0.1, 1 and 10 s before slow moves at several speeds",
    },
    Entry {
        id: "position_spring",
        words: "a spring over the travel, such as a cable",
        rivals: &["constant_force", "position_force"],
        experiment: "the same strokes about two distant positions",
    },
    Entry {
        id: "position_force",
        words: "a force that depends on position, the same in both directions",
        rivals: &["periodic_force", "position_spring"],
        experiment: "slow passes over the whole travel in both directions",
    },
    Entry {
        id: "position_friction",
        words: "a friction level that varies over the travel",
        rivals: &["position_force", "run_in", "local_friction_spot"],
        experiment: "slow passes over the whole travel in both directions, repeated later",
    },
    Entry {
        id: "local_friction_spot",
        words: "a narrow place of higher or lower friction",
        rivals: &["position_friction"],
        experiment: "slow passes over the place, started from both sides",
    },
    Entry {
        id: "periodic_force",
        words: "a force with a fixed period in position: cogging or torque ripple",
        rivals: &["encoder_error", "periodic_friction", "external_vibration"],
        experiment: "slow constant-speed passes at two speeds and with the motor off (pushed): cogging stays",
    },
    Entry {
        id: "periodic_friction",
        words: "a friction level with a fixed period in position: screw or ball passage",
        rivals: &["periodic_force"],
        experiment: "slow passes over several periods in both directions: friction flips with the direction",
    },
    Entry {
        id: "encoder_error",
        words: "interpolation error of the encoder",
        rivals: &["periodic_force"],
        experiment: "creep over several encoder periods within the pre-sliding range, against a reference",
    },
    Entry {
        id: "external_vibration",
        words: "a vibration from outside, of fixed frequency in time",
        rivals: &["periodic_force", "periodic_friction"],
        experiment: "a recording at rest with the controller off",
    },
    Entry {
        id: "channel_delay",
        words: "force and position sampled at different times",
        rivals: &["drive_compliance", "viscous"],
        experiment: "fast sine motion at two frequencies: a delay's phase grows in proportion",
    },
    Entry {
        id: "drive_compliance",
        words: "an elastic drive between motor and load",
        rivals: &["channel_delay", "backlash"],
        experiment: "a sweep through the expected resonance",
    },
    Entry {
        id: "frictional_lag",
        words: "friction that follows the velocity with a delay",
        rivals: &["stribeck", "channel_delay"],
        experiment: "sliding with sinusoidal velocity that does not reverse, at two frequencies",
    },
    Entry {
        id: "thermal_drift",
        words: "a friction level that follows temperature",
        rivals: &["run_in"],
        experiment: "the same strokes cold and warm, temperature recorded",
    },
    Entry {
        id: "run_in",
        words: "a friction level that decays with travelled path",
        rivals: &["thermal_drift"],
        experiment: "a rest of an hour in between: run-in stays, temperature does not",
    },
    Entry {
        id: "dwell_aging",
        words: "a breakaway peak that grows with the duration of rest",
        rivals: &["stribeck"],
        experiment: "rests of 0.1, 1 and 10 s before the same slow move",
    },
    Entry {
        id: "load_dependent_friction",
        words: "a friction level that follows the load",
        rivals: &["position_friction"],
        experiment: "the same strokes at two loads",
    },
    Entry {
        id: "presliding_shape",
        words: "a hysteresis that the model's friction law does not have",
        rivals: &["backlash", "drive_compliance"],
        experiment: "reversals of 5, 20 and 100 µm at one slow speed",
    },
    Entry {
        id: "backlash",
        words: "a gap between motor and load",
        rivals: &["presliding_shape", "drive_compliance"],
        experiment: "slow reversals under a constant push to one side",
    },
    Entry {
        id: "actuator_dead_zone",
        words: "a drive that gives nothing at small commands",
        rivals: &["presliding_shape", "backlash"],
        experiment: "a slow ramp of the command through zero at rest, with the force measured",
    },
    Entry {
        id: "actuator_saturation",
        words: "a drive that gives less than it is asked for",
        rivals: &[],
        experiment: "the same motion with half the acceleration",
    },
    Entry {
        id: "creep",
        words: "slow motion under a constant force",
        rivals: &["dwell_aging", "channel_delay"],
        experiment: "holds of 10 s at several forces below breakaway, the controller off",
    },
];

/// Effects of the catalogue that no recording is tested for, and what it would take.
pub const NOT_TESTED: [(&str, &str); 1] = [("lead_error", "a second measurement of position")];

/// The entry of an id.
pub fn entry(id: &str) -> Option<&'static Entry> {
    TESTED.iter().find(|e| e.id == id)
}

/// What the recording lacks, and what it therefore cannot show.
pub struct Lack {
    /// What is missing.
    pub missing: String,
    /// The effects that it hides.
    pub hides: Vec<&'static str>,
}

/// Looks for excitation that is missing.
pub fn lacks(s: &Signals) -> Vec<Lack> {
    let mut lacks = Vec::new();
    let mut lack = |missing: &str, hides: &[&'static str]| {
        lacks.push(Lack {
            missing: missing.to_owned(),
            hides: hides.to_vec(),
        });
    };
    if s.reversals == 0 {
        lack(
            "motion in both directions",
            &[
                "constant_force",
                "coulomb_asymmetry",
                "position_friction",
                "periodic_friction",
                "local_friction_spot",
                "backlash",
            ],
        );
    }
    let (low, high) = s.speeds();
    if high < 3.0 * low {
        lack(
            "several speeds",
            &["viscous", "quadratic_drag", "stribeck", "frictional_lag"],
        );
    }
    let (from, to) = bounds(&s.dwell);
    if to < 10.0 * from.max(0.02) {
        lack("rests of different length", &["dwell_aging"]);
    }
    match &s.temperature {
        None => lack("temperature", &["thermal_drift"]),
        Some(t) if bounds(t).1 - bounds(t).0 < 1.0 => lack("temperature range", &["thermal_drift"]),
        Some(_) => {}
    }
    if s.load
        .as_ref()
        .is_none_or(|l| bounds(l).1 - bounds(l).0 < 0.1 * bounds(l).1.abs())
    {
        lack("varied load", &["load_dependent_friction"]);
    }
    if s.path.last().copied().unwrap_or(0.0) < 10.0 * s.travel() {
        lack("a long run", &["run_in"]);
    }
    if s.same_ends() {
        lack(
            "strokes between different ends: position and displacement since reversal are one coordinate",
            &[
                "presliding_shape",
                "position_friction",
                "position_force",
                "local_friction_spot",
                "position_spring",
            ],
        );
    }
    for (id, why) in NOT_TESTED {
        lack(why, &[id]);
    }
    lacks
}
