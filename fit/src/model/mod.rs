//! Model files: what `identify` writes and every other command reads.

mod along;
mod check;
mod feed_forward;
mod friction;
mod refuse;
mod running;
mod stepper;
mod write;

use crate::effects::{Effect, form};
use crate::friction::FrictionModel;
use crate::recording::{EffortRole, MotionKind, Recording};
use friction::FrictionToml;
use serde::Deserialize;
use serde_json::Value;
use std::path::Path as FilePath;
use thiserror::Error;

pub use along::Measured;
pub use feed_forward::Chosen;
pub use refuse::{reduced, refused};
pub use stepper::{Now, Stepper};

/// The only schema there is.
pub const SCHEMA: &str = "preslide.model/1";

/// A machine's rigid body and friction, in SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Linear or rotary.
    pub motion: MotionKind,
    /// Unit of its forces where they are none: of the current, voltage or number of no unit that it was identified from.
    pub effort_unit: Option<&'static str>,
    /// Mass (kg) or inertia (kg·m²); 0 where it is not known.
    pub inertia: f64,
    /// Viscous coefficient (N·s/m or N·m·s/rad).
    pub viscous: f64,
    /// The friction model.
    pub friction: FrictionModel,
    /// Effect `constant_force` (N or N·m): gravity, tilt, current offset.
    pub constant_force: f64,
    /// The other effects.
    pub effects: Vec<Effect>,
    /// Known lengths and periods of the drive, by key.
    pub mechanics: Vec<(String, f64)>,
}

/// Why a model file cannot be used.
#[derive(Debug, Error)]
pub enum ModelError {
    /// The file cannot be read.
    #[error("{file}: {source}")]
    Unreadable {
        /// File name as given.
        file: String,
        /// The system's reason.
        source: std::io::Error,
    },
    /// TOML or one of its keys is wrong.
    #[error("{file}: {reason}")]
    Invalid {
        /// File name as given.
        file: String,
        /// Key, reason and remedy.
        reason: String,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ModelToml {
    schema: String,
    motion: String,
    effort_unit: Option<String>,
    inertia: Option<InertiaToml>,
    friction: FrictionToml,
    #[serde(default)]
    mechanics: MechanicsToml,
    #[serde(default)]
    effects: Vec<toml::Table>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct InertiaToml {
    mass_kg: f64,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct MechanicsToml {
    screw_lead_m: Option<f64>,
    motor_period_m: Option<f64>,
    encoder_period_m: Option<f64>,
    encoder_count_m: Option<f64>,
}

/// Key of the length of an encoder count.
const ENCODER_COUNT: &str = "encoder_count_m";

impl MechanicsToml {
    fn given(self) -> Vec<(String, f64)> {
        [
            ("screw_lead_m", self.screw_lead_m),
            ("motor_period_m", self.motor_period_m),
            ("encoder_period_m", self.encoder_period_m),
            (ENCODER_COUNT, self.encoder_count_m),
        ]
        .into_iter()
        .filter_map(|(key, value)| Some((key.to_owned(), value?)))
        .collect()
    }
}

/// What a model may be identified from in place of a force or torque.
const OTHERS: [EffortRole; 3] = [EffortRole::Current, EffortRole::Voltage, EffortRole::Raw];

/// The unit of one of them.
fn unit_of_effort(given: &str) -> Result<&'static str, String> {
    let unit = OTHERS
        .map(EffortRole::unit)
        .into_iter()
        .find(|unit| *unit == given);
    unit.ok_or_else(|| {
        format!(
            "effort_unit: \"{given}\" is not A, V or raw; leave it out where forces are in N or N·m"
        )
    })
}

/// The constant force (N or N·m), all of them added up, and the other effects; `say` puts a key in the file's words.
fn effects_of(
    entries: &[toml::Table],
    say: &dyn Fn(&str) -> String,
) -> Result<(f64, Vec<Effect>), String> {
    let (mut constant_force, mut effects) = (0.0, Vec::new());
    for (i, entry) in entries.iter().enumerate() {
        let effect = Effect::read(entry, say).map_err(|e| format!("effects[{}].{e}", i + 1))?;
        if effect.is(&form::CONSTANT_FORCE) {
            constant_force += effect.get("force_N");
        } else {
            effects.push(effect);
        }
    }
    Ok((constant_force, effects))
}

/// Key endings of rotary files and what they are called on a linear axis, longest first.
const ROTARY: [(&str, &str); 12] = [
    ("inertia_kg_m2", "mass_kg"),
    ("_Nm_per_rad_s", "_N_per_m_s"),
    ("_rad_per_Nm", "_m_per_N"),
    ("_Nm2_per_s", "_N2_per_s"),
    ("_Nm_s2_per_rad2", "_N_s2_per_m2"),
    ("_Nm_s_per_rad", "_N_s_per_m"),
    ("_Nm_per_rad", "_N_per_m"),
    ("_Nm_per_s", "_N_per_s"),
    ("_per_rad", "_per_m"),
    ("_rad_s", "_m_s"),
    ("_Nm", "_N"),
    ("_rad", "_m"),
];

/// Keys that any axis has: a phase is an angle (so is that of gravity, which only a rotary axis has), the normal load a force.
const COMMON: [&str; 4] = ["phase_rad", "angle_rad", "load_N", "level_per_N"];

/// A key of a linear axis in the words of an axis that moves so.
pub fn key_of(motion: MotionKind, key: &str) -> String {
    match motion {
        MotionKind::Linear => key.to_owned(),
        MotionKind::Rotary => translate(key, false).unwrap_or_else(|| key.to_owned()),
    }
}

/// An answer for machines whose keys are a linear axis's, in the words of an axis that moves so.
pub fn keys_of(motion: MotionKind, answer: Value) -> Value {
    let each = |answer| keys_of(motion, answer);
    match answer {
        Value::Object(map) => (map.into_iter())
            .map(|(key, value)| (key_of(motion, &key), each(value)))
            .collect(),
        Value::Array(values) => values.into_iter().map(each).collect(),
        plain => plain,
    }
}

/// A key of the file in the words of the other kind of axis, or `None` where it belongs to that other kind.
fn translate(key: &str, to_linear: bool) -> Option<String> {
    if COMMON.contains(&key) {
        return Some(key.to_owned());
    }
    let ending = |linear: bool| {
        ROTARY.iter().find_map(|&(rotary, straight)| {
            let (own, other) = if linear {
                (straight, rotary)
            } else {
                (rotary, straight)
            };
            key.strip_suffix(own).map(|stem| format!("{stem}{other}"))
        })
    };
    match (ending(!to_linear), ending(to_linear)) {
        (Some(translated), _) => Some(translated),
        (None, None) => Some(key.to_owned()),
        (None, Some(_)) => None,
    }
}

/// Renames the keys of a rotary file to those of a linear one, all the way down; linear keys are refused.
fn to_linear_keys(value: &mut toml::Value, path: &str) -> Result<(), String> {
    match value {
        toml::Value::Table(table) => {
            for (key, mut inner) in std::mem::take(table) {
                let here = format!("{path}{key}");
                let key = translate(&key, true).ok_or_else(|| {
                    format!("{here}: this is a key of a linear axis, but the file says motion = \"rotary\"; use the rotary unit (Nm, rad)")
                })?;
                to_linear_keys(&mut inner, &format!("{here}."))?;
                table.insert(key, inner);
            }
            Ok(())
        }
        toml::Value::Array(items) => items
            .iter_mut()
            .enumerate()
            .try_for_each(|(i, item)| to_linear_keys(item, &format!("{path}{}.", i + 1))),
        _ => Ok(()),
    }
}

/// Largest model file (bytes); those of this tool have some thousands.
const MOST_BYTES: u64 = 1 << 20;

/// What to do with a file that is none.
const NO_MODEL: &str = "a model is what `preslide identify RECORDING -o model.toml` writes";

/// The reason why a text is no TOML; of a table, what it was taken for.
fn no_toml(text: &str, error: &toml::de::Error) -> String {
    let mut lines = text.lines().map(str::trim);
    let first = lines.find(|line| !line.is_empty() && !line.starts_with('#'));
    let is_table = |line: &str| line.contains([',', ';', '\t']) && !line.contains('=');
    match first.is_some_and(is_table) {
        true => format!("this is a table, such as a recording, and no model; {NO_MODEL}"),
        false => error.to_string(),
    }
}

/// The text of a model file, which has an end.
///
/// # Errors
/// What the system says, text that is not UTF-8, and more than a megabyte.
pub fn read(path: &FilePath) -> std::io::Result<String> {
    use std::io::Read;
    let mut text = String::new();
    let file = std::fs::File::open(path)?;
    let bytes = file.take(MOST_BYTES + 1).read_to_string(&mut text);
    let bytes = bytes.map_err(|error| match error.kind() {
        std::io::ErrorKind::InvalidData => std::io::Error::other(format!("no text; {NO_MODEL}")),
        _ => error,
    })? as u64;
    if bytes > MOST_BYTES {
        return Err(std::io::Error::other(format!(
            "more than {MOST_BYTES} bytes, which no model file has"
        )));
    }
    Ok(text)
}

impl Model {
    /// Friction and nothing else.
    pub fn of_friction(motion: MotionKind, friction: FrictionModel) -> Self {
        Self {
            motion,
            effort_unit: None,
            inertia: 0.0,
            viscous: 0.0,
            friction,
            constant_force: 0.0,
            effects: Vec::new(),
            mechanics: Vec::new(),
        }
    }

    /// Refuses a recording of another kind of axis, or of an effort in another unit. Where the model states no unit, it is taken to have
    /// the recording's.
    ///
    /// # Errors
    /// Both, and what to do.
    pub fn check_fits(&self, recording: &Recording) -> Result<(), String> {
        let name = &recording.name;
        if self.motion != recording.kind {
            return Err(format!(
                "{name}: the motion is {}, the model is {}; use a model of the same axis, or convert the columns with --map and the ratio of the drive",
                recording.kind.name(),
                self.motion.name()
            ));
        }
        match self.effort_unit {
            Some(unit) if !recording.effort.is_empty() && unit != recording.effort_unit() => {
                Err(format!(
                    "{name}: the effort is in {}, the model's forces are in {unit} (its effort_unit); identify it from a force, with --map force_N=K*COLUMN or torque_Nm=K*COLUMN and the drive's constant K",
                    crate::report::units::symbol(recording.effort_unit())
                ))
            }
            _ => Ok(()),
        }
    }

    /// What its forces are, by their unit.
    pub fn effort(&self) -> EffortRole {
        let other = OTHERS
            .into_iter()
            .find(|role| Some(role.unit()) == self.effort_unit);
        other.unwrap_or(match self.motion {
            MotionKind::Linear => EffortRole::Force,
            MotionKind::Rotary => EffortRole::Torque,
        })
    }

    /// The same with the length of an encoder count (m or rad), which `tune` asks for.
    #[must_use]
    pub fn with_count(mut self, count: f64) -> Self {
        self.mechanics.retain(|(key, _)| key != ENCODER_COUNT);
        self.mechanics.push((ENCODER_COUNT.to_owned(), count));
        self
    }

    /// Length of an encoder count (m or rad), where it is known.
    pub fn count(&self) -> Option<f64> {
        let mut known = self.mechanics.iter();
        known.find(|m| m.0 == ENCODER_COUNT).map(|m| m.1)
    }

    /// Periods (m or rad) of the mechanics, by key; a count is not a period.
    pub fn periods(&self) -> impl Iterator<Item = &(String, f64)> {
        self.mechanics.iter().filter(|m| m.0 != ENCODER_COUNT)
    }

    /// Reads a model file.
    ///
    /// # Errors
    /// [`ModelError`] names the file, the key, the reason and the remedy.
    pub fn load(path: &FilePath) -> Result<Self, ModelError> {
        let file = path.display().to_string();
        let text = read(path).map_err(|source| ModelError::Unreadable {
            file: file.clone(),
            source,
        })?;
        Self::parse(&text).map_err(|reason| ModelError::Invalid { file, reason })
    }

    /// Reads the text of a model file; the error names the key, the reason and the remedy.
    ///
    /// # Errors
    /// The reason, for a person to read.
    pub fn parse(text: &str) -> Result<Self, String> {
        let table: toml::Table = toml::from_str(text).map_err(|e| no_toml(text, &e))?;
        let motion = match table.get("motion").and_then(toml::Value::as_str) {
            Some("linear") => MotionKind::Linear,
            Some("rotary") => MotionKind::Rotary,
            _ => return Err("motion: must be \"linear\" or \"rotary\"".to_owned()),
        };
        // Straight from the text where keys need no translation: the error then shows line and column.
        let file: ModelToml = match motion {
            MotionKind::Linear => toml::from_str(text).map_err(|e| e.to_string())?,
            MotionKind::Rotary => {
                let mut value = toml::Value::Table(table);
                to_linear_keys(&mut value, "")?;
                value
                    .try_into()
                    .map_err(|e: toml::de::Error| format!("{e} (in the words of a linear axis)"))?
            }
        };
        if file.schema != SCHEMA {
            return Err(format!(
                "schema: \"{}\" is not known; this program reads \"{SCHEMA}\"",
                file.schema
            ));
        }
        debug_assert!(file.motion == motion.name());
        let say = |key: &str| match motion {
            MotionKind::Linear => key.to_owned(),
            MotionKind::Rotary => translate(key, false).unwrap_or_else(|| key.to_owned()),
        };
        let (constant_force, effects) = effects_of(&file.effects, &say)?;
        let model = Self {
            motion,
            effort_unit: file
                .effort_unit
                .as_deref()
                .map(unit_of_effort)
                .transpose()?,
            inertia: file.inertia.map_or(0.0, |inertia| inertia.mass_kg),
            viscous: file.friction.viscous_N_s_per_m.unwrap_or(0.0),
            friction: file
                .friction
                .model()
                .map_err(|(key, reason)| format!("friction.{}: {reason}", say(key)))?,
            constant_force,
            effects,
            mechanics: file.mechanics.given(),
        };
        model
            .check()
            .map_err(|(key, reason)| format!("{}: {reason}", say(&key)))?;
        Ok(model)
    }

    /// A key of a linear axis in the words of this model's files.
    pub fn key(&self, key: &str) -> String {
        key_of(self.motion, key)
    }
}
