//! `F0`.

use super::Range::Any;
use super::{Argument, BARE, CTerm, Constructor, Form, term};
use preslide::Units;
use preslide::effects::ConstantForce;

/// `constant_force`.
pub(crate) static CONSTANT_FORCE: Form = Form {
    id: "constant_force",
    keys: &[("force_N", Any)],
    library: |effect, _| {
        Ok(term(ConstantForce::try_new(
            effect.get("force_N"),
            Units::SI,
        )?))
    },
    controller: Ok(Constructor {
        kind: "ConstantForce",
        more: &[Argument::Units],
        c: CTerm::force("$force_N"),
    }),
    ..BARE
};
