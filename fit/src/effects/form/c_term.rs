//! An effect's term in C99.

/// What a term enters.
#[derive(Clone, Copy, PartialEq)]
pub enum Sum {
    /// The friction level.
    Level,
    /// The force.
    Force,
    /// What is added to the measured position.
    Shift,
}

/// A term as an expression: `$key` stands for the constant of a parameter by its key of a linear axis, `$cosines` for those of a map and their
/// number, `@` for what the effect remembers, and `x`, `v`, `friction`, `temperature` and `load` for what it may know of a tick.
#[derive(Clone, Copy)]
pub struct CTerm {
    /// What it is added to.
    pub sum: Sum,
    /// The expression.
    pub value: &'static str,
    /// It belongs to places.
    pub placed: bool,
    /// What it remembers, if anything.
    pub memory: Option<Memory>,
}

/// What an effect remembers.
#[derive(Clone, Copy)]
pub struct Memory {
    /// Its type.
    pub kind: &'static str,
    /// Its first value.
    pub at_rest: &'static str,
    /// What it becomes in a tick, before the value is taken.
    pub next: &'static str,
}

impl CTerm {
    const fn new(sum: Sum, value: &'static str) -> Self {
        Self {
            sum,
            value,
            placed: false,
            memory: None,
        }
    }

    pub(super) const fn level(value: &'static str) -> Self {
        Self::new(Sum::Level, value)
    }

    pub(super) const fn force(value: &'static str) -> Self {
        Self::new(Sum::Force, value)
    }

    pub(super) const fn shift(value: &'static str) -> Self {
        Self::new(Sum::Shift, value).placed()
    }

    pub(super) const fn placed(self) -> Self {
        Self {
            placed: true,
            ..self
        }
    }

    pub(super) const fn remembers(self, memory: Memory) -> Self {
        Self {
            memory: Some(memory),
            ..self
        }
    }
}
