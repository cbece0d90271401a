//! `Σ c_j·cos(jπu)`, `u = (x − from)/(to − from)` in 0…1.

use super::Range::Any;
use super::{Argument, BARE, CTerm, Constructor, Form, term};
use preslide::Units;
use preslide::effects::PositionForce;

/// `position_force`.
pub(crate) static POSITION_FORCE: Form = Form {
    id: "position_force",
    keys: &[("from_m", Any), ("to_m", Any), ("cosine*_N", Any)],
    library: |effect, _| {
        Ok(term(PositionForce::try_new(
            effect.get("from_m"),
            effect.get("to_m"),
            effect.padded_cosines(),
            Units::SI,
        )?))
    },
    controller: Ok(Constructor {
        kind: "PositionForce",
        more: &[Argument::Units],
        c: CTerm::force("cosines((x - $from_m) / ($to_m - $from_m), $cosines)").placed(),
    }),
    ..BARE
};
