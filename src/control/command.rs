//! What a tick decides.

use super::Fault;

/// What a tick decided, raw, for the PWM and the telemetry.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Command {
    /// PWM code, within ± the limiter's; 0 while not enabled.
    pub code: i32,
    /// Position (counts) from the axis's origin: the first reading, or what [`super::Controller::set_position`] told.
    pub position: i64,
    /// Reference position (2⁻¹⁶ counts).
    pub reference: i64,
    /// Why the PWM is off, where that is not by order.
    pub fault: Option<Fault>,
    /// The bridge is to be driven; where it is not, open: all switches off.
    pub enabled: bool,
}
