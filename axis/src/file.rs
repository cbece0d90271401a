//! The file's tables.

use super::{AxisError, OWN, SCHEMA, VARIABLE, usable};
use preslide::control::{
    Axis, Encoder, FaultLimits, FeedForward, Hardware, Limits, Motor, Notch, PidGains,
    VelocitySource,
};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

// How the tables are read into the structs of the library, which knows no serde: the compiler holds each pair together.

#[derive(Deserialize)]
#[serde(remote = "Hardware", deny_unknown_fields)]
struct HardwareTable {
    rate_hz: u32,
    steps: u16,
    supply_code: f64,
    current_code: f64,
    dead_time: f64,
    diode_drop: f64,
}

#[derive(Deserialize)]
#[serde(remote = "Encoder", deny_unknown_fields)]
struct EncoderTable {
    count: f64,
    window: f64,
    timeout: f64,
    reversed: bool,
    turn: u32,
}

#[derive(Deserialize)]
#[serde(remote = "Motor", deny_unknown_fields)]
struct MotorTable {
    torque_constant: f64,
    resistance: f64,
    /// Whoever leaves it out has it not followed.
    #[serde(default)]
    resistance_span: f64,
    inductance: f64,
    gear_ratio: f64,
    screw_lead: f64,
    efficiency: f64,
    supply: f64,
    reversed: bool,
}

#[derive(Deserialize)]
#[serde(remote = "PidGains", deny_unknown_fields)]
struct GainsTable {
    proportional: f64,
    integral: f64,
    derivative: f64,
    integral_limit: f64,
    deadband: f64,
}

#[derive(Deserialize)]
#[serde(remote = "Notch", deny_unknown_fields)]
struct NotchTable {
    frequency: f64,
    width: f64,
    depth: f64,
}

#[derive(Deserialize)]
#[serde(remote = "FeedForward", deny_unknown_fields)]
struct FeedForwardTable {
    #[serde(with = "VelocitySourceName")]
    drive: VelocitySource,
    share: f64,
    limit: f64,
    mass: f64,
}

#[derive(Deserialize)]
#[serde(remote = "FaultLimits", deny_unknown_fields)]
struct FaultLimitsTable {
    top_speed: f64,
    following_error: f64,
    frozen_duty: f64,
    frozen_time: f64,
    supply_min: f64,
    supply_max: f64,
    supply_time: f64,
    overruns: u32,
    current_max: f64,
    current_rated: f64,
    thermal_time: f64,
    current_offset: f64,
}

#[derive(Deserialize)]
#[serde(remote = "VelocitySource", rename_all = "snake_case")]
enum VelocitySourceName {
    Reference,
    Measured,
}

/// Two keys for the two ends of the travel.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct LimitsTable {
    speed: f64,
    acceleration: f64,
    jerk: f64,
    travel_low: Option<f64>,
    travel_high: Option<f64>,
}

/// What a board has between the processor and the axis: of the bridge and the converters that someone soldered to it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Board {
    /// Both gates of a half bridge are off for so long after an edge (s).
    pub dead_time: f64,
    /// Forward voltage of its diodes (V).
    pub diode_drop: f64,
    /// Supply at the converter's full scale (V).
    pub supply_full: f64,
    /// Current from end to end of the converter's scale, zero in the middle (A).
    pub current_span: f64,
    /// The holding brake takes so long to be released (s); left out where there is none.
    #[serde(default)]
    pub brake_release: f64,
    /// And so long to hold (s).
    #[serde(default)]
    pub brake_set: f64,
}

impl Board {
    /// Limits that nothing reaches which this board reads.
    fn out_of_reach(&self, name: &str, watch: &FaultLimits) -> Vec<String> {
        // The last of 4096 codes, on the side of the middle that has fewer; in mV and 0.1 mA, which end at 16 bits.
        let supply = (self.supply_full * 4095.0 / 4096.0).min(65.535);
        let current = (self.current_span * 2047.0 / 4096.0).min(3.2767);
        let mut wrong = Vec::new();
        let mut expect = |limit: &str, value: f64, most: f64, key: &str| {
            if value >= most {
                wrong.push(format!(
                    "{limit} is {value}, but with boards.{name}.{key} the board reads {most:.4} at most, so that the fault would never come; lower the limit, or leave [boards.{name}] out if this axis has another board"
                ));
            }
        };
        expect("watch.supply_max", watch.supply_max, supply, "supply_full");
        expect(
            "watch.current_max with watch.current_offset",
            watch.current_max + watch.current_offset,
            current,
            "current_span",
        );
        wrong
    }

    fn wrong(&self, name: &str) -> Vec<String> {
        let mut wrong = Vec::new();
        let mut expect = |key: &str, value: f64, valid: bool, bound: &str| {
            if !(valid && value.is_finite()) {
                wrong.push(format!(
                    "boards.{name}.{key} is {value}; it must be {bound}"
                ));
            }
        };
        expect(
            "dead_time",
            self.dead_time,
            (0.0..=5e-6).contains(&self.dead_time),
            "within 0..5e-6 s",
        );
        expect(
            "diode_drop",
            self.diode_drop,
            (0.0..=3.0).contains(&self.diode_drop),
            "within 0..3 V",
        );
        for (key, delay) in [
            ("brake_release", self.brake_release),
            ("brake_set", self.brake_set),
        ] {
            // A brake takes tens of milliseconds; what is given in ms would be caught here.
            expect(key, delay, (0.0..=5.0).contains(&delay), "within 0..5 s");
        }
        expect(
            "supply_full",
            self.supply_full,
            self.supply_full > 0.0,
            "positive",
        );
        expect(
            "current_span",
            self.current_span,
            self.current_span > 0.0,
            "positive",
        );
        wrong
    }
}

/// An axis.toml.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisFile {
    schema: String,
    duty_limit: f64,
    fade_time: f64,
    silence: f64,
    #[serde(with = "HardwareTable")]
    hardware: Hardware,
    #[serde(with = "EncoderTable")]
    encoder: Encoder,
    #[serde(with = "MotorTable")]
    motor: Motor,
    #[serde(with = "GainsTable")]
    gains: PidGains,
    /// Whoever leaves it out has none.
    #[serde(with = "NotchTable", default)]
    notch: Notch,
    #[serde(with = "FeedForwardTable")]
    feed_forward: FeedForward,
    limits: LimitsTable,
    #[serde(with = "FaultLimitsTable")]
    watch: FaultLimits,
    /// By name.
    #[serde(default)]
    boards: BTreeMap<String, Board>,
    #[serde(skip)]
    name: String,
    #[serde(skip)]
    values: toml::Table,
}

impl AxisFile {
    /// Reads a file.
    ///
    /// # Errors
    /// [`AxisError`]: what is wrong with it, and where.
    pub fn read(path: &Path) -> Result<Self, AxisError> {
        let file = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|error| AxisError::Read {
            file: file.clone(),
            error,
        })?;
        Self::parse(&file, &text)
    }

    /// The file that is named, or else that of the variable [`VARIABLE`], or else the project's [`OWN`].
    ///
    /// # Errors
    /// [`AxisError`]: what is wrong with it, and where.
    pub fn chosen(named: Option<&Path>) -> Result<Self, AxisError> {
        match (named, std::env::var_os(VARIABLE)) {
            (Some(path), _) => Self::read(path),
            (None, Some(path)) => Self::read(Path::new(&path)),
            (None, None) => Self::parse("axis.toml", OWN),
        }
    }

    /// The number that the file has under a parameter's name, such as `gains.derivative`.
    pub fn value(&self, name: &str) -> Option<f64> {
        let (tables, key) = name.rsplit_once('.').unwrap_or(("", name));
        let mut table = &self.values;
        for part in tables.split('.').filter(|part| !part.is_empty()) {
            table = table.get(part)?.as_table()?;
        }
        let value = table.get(key)?;
        value
            .as_float()
            .or(value.as_integer().map(|whole| whole as f64))
    }

    /// Takes the text of the file called `name`.
    ///
    /// # Errors
    /// [`AxisError`]: what is wrong with it, and where.
    pub fn parse(name: &str, text: &str) -> Result<Self, AxisError> {
        let told = |error| AxisError::Toml {
            file: name.to_owned(),
            error: Box::new(error),
        };
        let mut file: Self = toml::from_str(text).map_err(told)?;
        name.clone_into(&mut file.name);
        file.values = toml::from_str(text).map_err(told)?;
        if file.schema != SCHEMA {
            return Err(AxisError::Schema {
                file: file.name,
                found: file.schema,
            });
        }
        let mut errors: Vec<String> = file
            .boards
            .iter()
            .flat_map(|(name, board)| {
                let mut wrong = board.wrong(name);
                wrong.extend(board.out_of_reach(name, &file.watch));
                wrong
            })
            .collect();
        let limits = &file.limits;
        if limits.travel_low.is_some() != limits.travel_high.is_some() {
            errors.push(
                "limits.travel_low and limits.travel_high go together: give both, or neither for an axis without end".to_owned(),
            );
        }
        if let Err(error) = usable(&file.axis()) {
            errors.push(error.to_string());
        }
        if errors.is_empty() {
            Ok(file)
        } else {
            Err(AxisError::Values {
                file: file.name,
                errors,
            })
        }
    }

    /// What the file says of a board.
    ///
    /// # Errors
    /// [`AxisError::Values`] where it says nothing.
    pub fn board(&self, name: &str) -> Result<&Board, AxisError> {
        self.boards.get(name).ok_or_else(|| AxisError::Values {
            file: self.name.clone(),
            errors: vec![format!(
                "there is no [boards.{name}]; it needs dead_time, diode_drop, supply_full and current_span"
            )],
        })
    }

    /// The axis, on the hardware that the file names: the emulator's and the simulation's.
    pub fn axis(&self) -> Axis {
        let LimitsTable {
            speed,
            acceleration,
            jerk,
            travel_low,
            travel_high,
        } = self.limits;
        Axis {
            hardware: self.hardware,
            encoder: self.encoder,
            motor: self.motor,
            gains: self.gains,
            notch: self.notch,
            feed_forward: self.feed_forward,
            limits: Limits {
                speed,
                acceleration,
                jerk,
                travel: travel_low.zip(travel_high),
            },
            duty_limit: self.duty_limit,
            watch: self.watch,
            fade_time: self.fade_time,
            silence: self.silence,
        }
    }
}
