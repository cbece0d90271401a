//! `m = 1 + Σ c_j·cos(jπu)`.

use super::Range::Any;
use super::{Argument, BARE, CTerm, Constructor, Form, LEVEL, term};
use preslide::Units;
use preslide::effects::PositionFriction;

/// `position_friction`.
pub(crate) static POSITION_FRICTION: Form = Form {
    id: "position_friction",
    keys: &[("from_m", Any), ("to_m", Any), ("cosine*", LEVEL)],
    library: |effect, _| {
        Ok(term(PositionFriction::try_new(
            effect.get("from_m"),
            effect.get("to_m"),
            effect.padded_cosines(),
            Units::SI,
        )?))
    },
    controller: Ok(Constructor {
        kind: "PositionFriction",
        more: &[Argument::Units],
        c: CTerm::level("cosines((x - $from_m) / ($to_m - $from_m), $cosines)").placed(),
    }),
    ..BARE
};
