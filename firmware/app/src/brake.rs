//! The holding brake: released once the axis is driven, set before it is not.

/// What the brake was told, and the ticks until it has done it: meanwhile the axis holds its position and does not move.
#[derive(Clone, Copy, Default)]
pub(crate) struct Brake {
    pub(crate) released: bool,
    ticks: u32,
}

impl Brake {
    /// Told otherwise, which takes so many ticks.
    pub(crate) fn tell(&mut self, released: bool, ticks: u32) {
        if self.released != released {
            *self = Self { released, ticks };
        }
    }

    /// A tick later; whether it holds from this one on.
    pub(crate) fn next(&mut self) -> bool {
        let moves = self.is_moving();
        self.ticks = self.ticks.saturating_sub(1);
        moves && !self.is_moving() && !self.released
    }

    /// It is on its way.
    pub(crate) fn is_moving(self) -> bool {
        self.ticks > 0
    }
}
