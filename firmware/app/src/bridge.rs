//! The H bridge, as a board has it, and what may stand beside it.

use crate::Limits;

/// Takes a signed code, or opens.
pub trait Bridge {
    /// Drives with a PWM code within ± the steps of the board's [`preslide::control::Hardware`]. Closes the bridge if it was open.
    fn drive(&mut self, code: i32);

    /// Opens all switches, so that the axis coasts: both low sides on would brake it.
    fn open(&mut self);

    /// The bridge's own protection has opened it since it was last driven.
    fn is_broken(&mut self) -> bool;

    /// It has limit switches or a brake: without them the control task has no code for any.
    const GUARDED: bool = false;

    /// The limit switches; none where the board has none. What has them and a brake is [`crate::Guarded`].
    #[inline]
    fn limits(&mut self) -> Limits {
        Limits::default()
    }

    /// Releases the holding brake, or sets it; told again in every tick in which something is up.
    #[inline]
    fn release_brake(&mut self, _released: bool) {}

    /// Ticks that the brake takes to be released, and to hold.
    #[inline]
    fn brake_delays(&self) -> [u32; 2] {
        [0, 0]
    }
}
