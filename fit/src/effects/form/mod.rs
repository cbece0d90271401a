//! What an effect is beside the diagnosis: its keys in a model file, its term in the library, its constructor in exported source
//! or why no controller can use it, and its row among the measured costs. To add one, enter it in [the catalogue](catalogue).

mod c_term;
pub mod catalogue;

pub use c_term::{CTerm, Memory, Sum};
pub use catalogue::*;

use super::Effect;
use super::term::Term;
use preslide::ParamError;

/// An effect as a model file, the library and exported source have it. Compared by identity.
pub struct Form {
    /// In model files and answers.
    pub id: &'static str,
    /// Its keys, SI and those of a linear axis, with what they may be.
    pub(super) keys: Keys,
    /// Values of its keys that a small stage may have, in their order, those of a map's cosines last: what a list of every effect is made of.
    pub example: &'static [f64],
    /// The library's term for samples so far apart (s); `None` where it is neither a level nor a force.
    pub library: fn(&Effect, f64) -> Result<Option<Term>, ParamError>,
    /// What builds it in a controller, or why no controller can use it.
    pub controller: Result<Constructor, &'static str>,
    /// It acts by speed alone: on the motor's side of a gear, and not at rest.
    pub(crate) of_speed: bool,
    /// Its row among the measured costs of a tick, where that has not its id.
    cost: Option<&'static str>,
    /// What must be measured beside the motion, and what to put in the model in its place.
    pub needs: Option<(Column, &'static str)>,
}

/// A form of nothing, for what most leave out.
const BARE: Form = Form {
    id: "",
    keys: &[],
    example: &[],
    library: |_, _| Ok(None),
    controller: Err("no constructor is known"),
    of_speed: false,
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
#[derive(Clone, Copy, Debug, PartialEq)]
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
