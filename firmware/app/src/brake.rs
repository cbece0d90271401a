//! The holding brake: released once the axis is driven, set before it is not.

/// What the brake does, with the ticks that are left of it.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Brake {
    /// It holds.
    Holds,
    /// It is on its way off; the axis holds its position meanwhile and does not move.
    Releases(u32),
    /// It is off.
    Off,
    /// It is on its way to hold; the axis is driven until it does.
    Sets(u32),
}

impl Brake {
    /// A tick later.
    pub(crate) fn next(self) -> Self {
        match self {
            Brake::Releases(0) => Brake::Off,
            Brake::Releases(ticks) => Brake::Releases(ticks - 1),
            Brake::Sets(ticks) => Brake::Sets(ticks.saturating_sub(1)),
            other => other,
        }
    }

    /// The output is to release it.
    pub(crate) fn is_released(self) -> bool {
        matches!(self, Brake::Releases(_) | Brake::Off)
    }

    /// It is on its way.
    pub(crate) fn is_moving(self) -> bool {
        matches!(self, Brake::Releases(_) | Brake::Sets(_))
    }
}
