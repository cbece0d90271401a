//! Model files: what `identify` writes and every other command reads.

mod along;
mod feed_forward;
mod friction;
mod refuse;

use crate::effects::Effect;
use crate::friction::{FrictionModel, Path};
use crate::recording::MotionKind;
use friction::FrictionToml;
use serde::Deserialize;
use std::fmt::Write as _;
use std::path::Path as FilePath;
use thiserror::Error;

pub use along::Measured;
pub use feed_forward::Chosen;
pub use refuse::{reduced, refused};

/// The only schema there is.
pub const SCHEMA: &str = "preslide.model/1";

/// A machine's rigid body and friction, in SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Linear or rotary.
    pub motion: MotionKind,
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

/// Key endings of rotary files and what they are called on a linear axis, longest first.
const ROTARY: [(&str, &str); 9] = [
    ("inertia_kg_m2", "mass_kg"),
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

/// A key of the file in the words of the other kind of axis, or `None` where it belongs to that other kind.
/// A key of a linear axis in the words of an axis that moves so.
pub(crate) fn key_of(motion: MotionKind, key: &str) -> String {
    match motion {
        MotionKind::Linear => key.to_owned(),
        MotionKind::Rotary => translate(key, false).unwrap_or_else(|| key.to_owned()),
    }
}

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

/// The text of a model file, which has an end.
///
/// # Errors
/// What the system says, text that is not UTF-8, and more than a megabyte.
pub fn read(path: &FilePath) -> std::io::Result<String> {
    use std::io::Read;
    let mut text = String::new();
    let file = std::fs::File::open(path)?;
    let bytes = file.take(MOST_BYTES + 1).read_to_string(&mut text)? as u64;
    if bytes > MOST_BYTES {
        return Err(std::io::Error::other(format!(
            "more than {MOST_BYTES} bytes, which no model file has"
        )));
    }
    Ok(text)
}

/// Largest magnitude of a parameter, in SI: what is beyond is a broken number, and its products are infinite.
const ABSURD: f64 = 1e15;

impl Model {
    /// Friction and nothing else.
    pub fn of_friction(motion: MotionKind, friction: FrictionModel) -> Self {
        Self {
            motion,
            inertia: 0.0,
            viscous: 0.0,
            friction,
            constant_force: 0.0,
            effects: Vec::new(),
            mechanics: Vec::new(),
        }
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
        let table: toml::Table = toml::from_str(text).map_err(|e| e.to_string())?;
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
        let (mut constant_force, mut effects) = (0.0, Vec::new());
        for (i, entry) in file.effects.iter().enumerate() {
            let effect =
                Effect::read(entry, &say).map_err(|e| format!("effects[{}].{e}", i + 1))?;
            match effect.id {
                "constant_force" => constant_force += effect.get("force_N"),
                _ => effects.push(effect),
            }
        }
        let MechanicsToml {
            screw_lead_m,
            motor_period_m,
            encoder_period_m,
            encoder_count_m,
        } = file.mechanics;
        let mechanics = [
            ("screw_lead_m", screw_lead_m),
            ("motor_period_m", motor_period_m),
            ("encoder_period_m", encoder_period_m),
            ("encoder_count_m", encoder_count_m),
        ]
        .into_iter()
        .filter_map(|(key, value)| Some((key.to_owned(), value?)))
        .collect();
        let model = Self {
            motion,
            inertia: file.inertia.map_or(0.0, |inertia| inertia.mass_kg),
            viscous: file.friction.viscous_N_s_per_m.unwrap_or(0.0),
            friction: file
                .friction
                .model()
                .map_err(|(key, reason)| format!("friction.{}: {reason}", say(key)))?,
            constant_force,
            effects,
            mechanics,
        };
        model
            .check()
            .map_err(|(key, reason)| format!("{}: {reason}", say(&key)))?;
        Ok(model)
    }

    fn check(&self) -> Result<(), (String, String)> {
        let fail = |key: &str, reason: String| Err((key.to_owned(), reason));
        if !(self.inertia.is_finite() && self.inertia >= 0.0) {
            return fail(
                "inertia.mass_kg",
                format!("{} must be finite and not negative", self.inertia),
            );
        }
        if !self.viscous.is_finite() {
            return fail(
                "friction.viscous_N_s_per_m",
                format!("{} must be finite", self.viscous),
            );
        }
        if !self.constant_force.is_finite() {
            return fail(
                "effects.force_N",
                format!("{} must be finite", self.constant_force),
            );
        }
        let effects = self.effects.iter().enumerate();
        let of_effects = effects.flat_map(|(i, e)| {
            let named =
                move |(key, value): &(String, f64)| (format!("effects[{}].{key}", i + 1), *value);
            e.values.iter().map(named)
        });
        let of_blocks = match &self.friction {
            FrictionModel::Gms { blocks, .. } | FrictionModel::Leuven { blocks, .. } => {
                blocks.as_slice()
            }
            _ => &[],
        };
        let scalars = self.friction.scalars().into_iter();
        let named = scalars
            .map(|(key, value)| (format!("friction.{key}"), value))
            .chain(
                of_blocks
                    .iter()
                    .map(|b| ("friction.blocks.stiffness_N_per_m".to_owned(), b.stiffness)),
            )
            .chain(of_effects)
            .chain([
                ("inertia.mass_kg".to_owned(), self.inertia),
                ("friction.viscous_N_s_per_m".to_owned(), self.viscous),
                ("effects.force_N".to_owned(), self.constant_force),
            ]);
        for (key, value) in named {
            // An attraction without end is a friction model without lag.
            if value.is_finite() && value.abs() > ABSURD {
                return fail(
                    &key,
                    format!(
                        "{value:e} is beyond {ABSURD:e}, which no machine has; check the number and its unit"
                    ),
                );
            }
        }
        for (key, value) in &self.mechanics {
            if !(value.is_finite() && *value > 0.0) {
                return fail(
                    &format!("mechanics.{key}"),
                    format!("{value} must be finite and above zero"),
                );
            }
        }
        if self.motion == MotionKind::Linear && self.effects.iter().any(|e| e.id == "gravity") {
            return fail(
                "effects.id",
                "gravity changes with the angle of a rotary axis; on a linear one it is a constant_force with force_N".to_owned(),
            );
        }
        // The library is the judge of the friction parameters; one step of no motion builds the model.
        let still = Path {
            position: &[0.0],
            velocity: &[0.0],
            pieces: std::slice::from_ref(&(0..1)),
            sample_time: 1e-3,
        };
        match self.friction.force(still) {
            Ok(_) => Ok(()),
            Err(e) => fail("friction", e.to_string()),
        }
    }

    /// A key of a linear axis in the words of this model's files.
    pub fn key(&self, key: &str) -> String {
        key_of(self.motion, key)
    }

    /// The text of the model file. `remarks` become comments at its head.
    pub fn to_toml(&self, remarks: &[String]) -> String {
        let mut text = String::new();
        for remark in remarks {
            for line in remark.lines() {
                let _ = writeln!(text, "# {line}");
            }
        }
        let key = |key: &str| self.key(key);
        let _ = writeln!(
            text,
            "schema = \"{SCHEMA}\"\nmotion = \"{}\"",
            self.motion.name()
        );
        if self.inertia > 0.0 {
            let _ = writeln!(
                text,
                "\n[inertia]\n{} = {}",
                key("mass_kg"),
                number(self.inertia)
            );
        }
        let _ = writeln!(text, "\n[friction]\nkind = \"{}\"", self.friction.kind());
        for (name, value) in self.friction.scalars() {
            let _ = writeln!(text, "{} = {}", key(name), number(value));
        }
        if let FrictionModel::Gms { blocks, .. } | FrictionModel::Leuven { blocks, .. } =
            &self.friction
        {
            let _ = writeln!(text, "blocks = [");
            for block in blocks {
                let _ = writeln!(
                    text,
                    "  {{ {} = {}, weight = {} }},",
                    key("stiffness_N_per_m"),
                    number(block.stiffness),
                    number(block.weight)
                );
            }
            let _ = writeln!(text, "]");
        }
        let _ = writeln!(
            text,
            "{} = {}",
            key("viscous_N_s_per_m"),
            number(self.viscous)
        );
        if !self.mechanics.is_empty() {
            let _ = writeln!(text, "\n[mechanics]");
            for (name, value) in &self.mechanics {
                let _ = writeln!(text, "{} = {}", key(name), number(*value));
            }
        }
        if self.constant_force != 0.0 {
            let _ = writeln!(
                text,
                "\n[[effects]]\nid = \"constant_force\"\n{} = {}",
                key("force_N"),
                number(self.constant_force)
            );
        }
        for effect in &self.effects {
            let _ = writeln!(text, "\n[[effects]]\nid = \"{}\"", effect.id);
            for (name, value) in &effect.values {
                let _ = writeln!(text, "{} = {}", key(name), number(*value));
            }
        }
        text
    }
}

/// A float that TOML reads back as the same float.
fn number(value: f64) -> String {
    format!("{value:?}")
}
