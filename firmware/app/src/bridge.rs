//! The H bridge, as a board has it.

/// Takes a signed code, or opens.
pub trait Bridge {
    /// Drives with a PWM code within ± the steps of the board's [`preslide::control::Hardware`]. Closes the bridge if it was open.
    fn drive(&mut self, code: i32);

    /// Opens all switches, so that the axis coasts: both low sides on would brake it.
    fn open(&mut self);

    /// The bridge's own protection has opened it since it was last driven.
    fn is_broken(&mut self) -> bool;
}
