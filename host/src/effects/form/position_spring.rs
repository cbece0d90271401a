//! `κ·(x − x0)`.

use super::Range::Any;
use super::{Argument, BARE, CTerm, Constructor, FAR, Form, term};
use preslide::Units;
use preslide::effects::PositionSpring;

/// `position_spring`.
pub(crate) static POSITION_SPRING: Form = Form {
    id: "position_spring",
    keys: &[("stiffness_N_per_m", Any), ("centre_m", Any)],
    library: |effect, _| {
        Ok(term(PositionSpring::try_new(
            effect.get("stiffness_N_per_m"),
            effect.get("centre_m"),
            FAR,
            Units::SI,
        )?))
    },
    controller: Ok(Constructor {
        kind: "PositionSpring",
        more: &[Argument::ForceLimit, Argument::Units],
        c: CTerm::force("limited($stiffness_N_per_m * (x - $centre_m), FORCE_LIMIT)").placed(),
    }),
    ..BARE
};
