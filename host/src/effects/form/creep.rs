//! Displacement less `rate·T_s·sinh(F/(share·F_limit))`.

use super::Range::{NotNegative, Positive};
use super::{BARE, Form};

/// `creep`.
pub(crate) static CREEP: Form = Form {
    id: "creep",
    keys: &[("rate_m_s", NotNegative), ("share_of_breakaway", Positive)],
    controller: Err("its feed-forward would push an axis that rests"),
    ..BARE
};
