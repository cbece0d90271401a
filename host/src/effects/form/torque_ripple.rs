//! Command `= F/(1 + a·cos(2πx/p + φ))`.

use super::Range::{Any, Positive, Within};
use super::{BARE, Form};

/// Largest share: a motor that gives nothing at some place is broken.
const MOST: f64 = 0.9;

/// `torque_ripple`.
pub(crate) static TORQUE_RIPPLE: Form = Form {
    id: "torque_ripple",
    keys: &[
        ("share", Within(MOST)),
        ("period_m", Positive),
        ("phase_rad", Any),
    ],
    controller: Err(
        "it is a property of the drive: divide the command by 1 + share·cos(2π·position/period + phase)",
    ),
    ..BARE
};
