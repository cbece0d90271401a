//! The load on a spring behind the motor with the encoder, `ω = 2πf = √(4k/M)`.

use super::Range::Positive;
use super::{BARE, Form};

/// `drive_compliance`.
pub(crate) static DRIVE_COMPLIANCE: Form = Form {
    id: "drive_compliance",
    keys: &[("frequency_Hz", Positive)],
    controller: Err("it needs the second derivative of the friction force"),
    ..BARE
};
