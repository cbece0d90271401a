//! `A·sin(q − q0)`, rotary axes only.

use super::Range::Any;
use super::{Argument, BARE, CTerm, Constructor, Form, term};
use preslide::Units;
use preslide::effects::Gravity;

/// `gravity`.
pub(crate) static GRAVITY: Form = Form {
    id: "gravity",
    keys: &[("force_N", Any), ("angle_rad", Any)],
    library: |effect, _| {
        Ok(term(Gravity::try_new(
            effect.get("force_N"),
            effect.get("angle_rad"),
            Units::SI,
        )?))
    },
    controller: Ok(Constructor {
        kind: "Gravity",
        more: &[Argument::Units],
        c: CTerm::force("$force_N * limited(sinf(x - $angle_rad), 1.0f)").placed(),
    }),
    // The same code with other constants.
    cost: Some("periodic_force"),
    ..BARE
};
