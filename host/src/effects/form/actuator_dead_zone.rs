//! Command `= F + ½·width·sgn F`.

use super::Range::NotNegative;
use super::{BARE, Form};

/// `actuator_dead_zone`.
pub(crate) static ACTUATOR_DEAD_ZONE: Form = Form {
    id: "actuator_dead_zone",
    keys: &[("width_N", NotNegative)],
    controller: Err("it is a property of the drive; set it in the controller's settings"),
    ..BARE
};
