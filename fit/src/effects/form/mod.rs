//! What an effect is beside the diagnosis: its keys in a model file, its term in the library, its constructor in exported source
//! or why no controller can use it, and its row among the measured costs. To add one, name it in [`ALL`].

mod c_term;
pub(crate) mod drive;
mod force;
mod level;

pub use c_term::{CTerm, Memory, Sum};
pub use drive::{
    ACTUATOR_DEAD_ZONE, ACTUATOR_SATURATION, BACKLASH, CHANNEL_DELAY, CREEP, DRIVE_COMPLIANCE,
    ENCODER_ERROR, TORQUE_RIPPLE,
};
pub use force::{
    CONSTANT_FORCE, EXTERNAL_VIBRATION, GRAVITY, PERIODIC_FORCE, POSITION_FORCE, POSITION_SPRING,
    QUADRATIC_DRAG, VISCOUS, VISCOUS_ASYMMETRY,
};
pub use level::{
    COULOMB_ASYMMETRY, DWELL_AGING, FRICTIONAL_LAG, LOAD_DEPENDENT_FRICTION, LOCAL_FRICTION_SPOT,
    PERIODIC_FRICTION, POSITION_FRICTION, RUN_IN, STRIBECK, THERMAL_DRIFT, TRANSMITTED_FRICTION,
    WARM_UP,
};

use super::Effect;
use super::term::{FAR, Term, term};
use preslide::ParamError;

/// An effect as a model file, the library and exported source have it. Compared by identity.
pub struct Form {
    /// In model files and answers.
    pub id: &'static str,
    /// Its keys, SI and those of a linear axis, with what they may be.
    pub(super) keys: Keys,
    /// The library's term for samples so far apart (s); `None` where it is neither a level nor a force.
    pub library: fn(&Effect, f64) -> Result<Option<Term>, ParamError>,
    /// What builds it in a controller, or why no controller can use it.
    pub controller: Result<Constructor, &'static str>,
    /// Its row among the measured costs of a tick, where that has not its id.
    cost: Option<&'static str>,
    /// What must be measured beside the motion, and what to put in the model in its place.
    pub needs: Option<(Column, &'static str)>,
}

/// A form of nothing, for what most leave out.
const BARE: Form = Form {
    id: "",
    keys: &[],
    library: |_, _| Ok(None),
    controller: Err("no constructor is known"),
    cost: None,
    needs: None,
};

impl Form {
    /// Its row among the measured costs of a tick, the part ROW of `with_ROW_f32`; a map has rows for some numbers of cosines.
    pub fn cost(&self) -> &'static str {
        self.cost.unwrap_or(self.id)
    }

    /// Whether it is a map, whose cosines have a number of their own.
    pub fn is_map(&self) -> bool {
        self.keys.iter().any(|(key, _)| key.contains('*'))
    }
}

/// The forms of the ids of a model file, in the order of [the table](super). Two of an id are two sets of keys.
pub static ALL: [&Form; 28] = [
    &CONSTANT_FORCE,
    &COULOMB_ASYMMETRY,
    &VISCOUS_ASYMMETRY,
    &QUADRATIC_DRAG,
    &STRIBECK,
    &FRICTIONAL_LAG,
    &POSITION_SPRING,
    &POSITION_FORCE,
    &POSITION_FRICTION,
    &LOCAL_FRICTION_SPOT,
    &PERIODIC_FORCE,
    &PERIODIC_FRICTION,
    &ENCODER_ERROR,
    &GRAVITY,
    &EXTERNAL_VIBRATION,
    &CHANNEL_DELAY,
    &DRIVE_COMPLIANCE,
    &BACKLASH,
    &THERMAL_DRIFT,
    &WARM_UP,
    &RUN_IN,
    &DWELL_AGING,
    &LOAD_DEPENDENT_FRICTION,
    &TRANSMITTED_FRICTION,
    &TORQUE_RIPPLE,
    &ACTUATOR_DEAD_ZONE,
    &ACTUATOR_SATURATION,
    &CREEP,
];

/// What acts by speed alone: on the motor's side of a gear, and not at rest.
pub(crate) static OF_SPEED: [&Form; 2] = [&QUADRATIC_DRAG, &VISCOUS_ASYMMETRY];

/// Keys with what they may be; `cosine*` stands for `cosine1`, `cosine2`, … with what follows it.
pub(super) type Keys = &'static [(&'static str, Range)];

/// What a value may be.
#[derive(Clone, Copy)]
pub(super) enum Range {
    Any,
    Positive,
    NotNegative,
    /// A share of the friction level.
    Within(f64),
    Between(f64, f64),
}

/// A change of the friction level.
const LEVEL: Range = Range::Within(preslide::effects::LARGEST_LEVEL);

/// What is measured beside the motion.
#[derive(Clone, Copy, PartialEq)]
pub enum Column {
    /// Of the machine (°C).
    Temperature,
    /// On the axis (N or N·m).
    Load,
}

impl Column {
    /// Its name in a recording.
    pub fn name(self) -> &'static str {
        match self {
            Self::Temperature => "temperature_C",
            Self::Load => "load_N",
        }
    }
}

/// The library's type in [`preslide::effects`], and what its `try_new` takes behind the values of the keys.
pub struct Constructor {
    /// Its name.
    pub kind: &'static str,
    /// The further arguments, in order.
    pub more: &'static [Argument],
    /// The same in C.
    pub c: CTerm,
}

const fn built(
    kind: &'static str,
    more: &'static [Argument],
    c: CTerm,
) -> Result<Constructor, &'static str> {
    Ok(Constructor { kind, more, c })
}

/// An argument of a constructor that is no parameter.
#[derive(Clone, Copy, PartialEq)]
pub enum Argument {
    /// The bound of a force that grows with speed or position.
    ForceLimit,
    /// The bound of a level that follows a measured column.
    LevelLimit,
    /// Of the controller (s).
    SampleTime,
    /// Of the controller's numbers.
    Units,
    /// A number of the library's own.
    Number(&'static str),
}

impl PartialEq for Form {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
    }
}

impl std::fmt::Debug for Form {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(self.id)
    }
}
