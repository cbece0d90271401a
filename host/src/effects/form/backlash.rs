//! A play of the whole width `gap` between motor and load.

use super::Range::NotNegative;
use super::{BARE, Form};

/// `backlash`.
pub(crate) static BACKLASH: Form = Form {
    id: "backlash",
    keys: &[("gap_m", NotNegative)],
    controller: Err("crossing the gap takes a move of the motor, not a force"),
    ..BARE
};
