//! `F` held within ± limit.

use super::Range::Positive;
use super::{BARE, Form};

/// `actuator_saturation`.
pub(crate) static ACTUATOR_SATURATION: Form = Form {
    id: "actuator_saturation",
    keys: &[("limit_N", Positive)],
    controller: Err("it is a property of the drive; set it in the controller's settings"),
    ..BARE
};
