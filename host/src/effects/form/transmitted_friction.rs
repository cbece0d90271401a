//! `μ·abs(T)` in the direction of friction, `T` what a gear transmits: the other set of keys of `load_dependent_friction`.

use super::Range::{Between, NotNegative};
use super::{BARE, Form};

/// Most of what is transmitted that may be lost on the way: a gear that loses all of it drives nothing.
const MOST: f64 = 0.99;

/// `load_dependent_friction`.
pub(crate) static TRANSMITTED_FRICTION: Form = Form {
    id: "load_dependent_friction",
    keys: &[
        ("share_of_transmitted", Between(0.0, MOST)),
        ("motor_mass_kg", NotNegative),
    ],
    controller: Err(
        "the controller's library has no friction of what a gear transmits yet; without it the friction of an unloaded gear is left",
    ),
    ..BARE
};
