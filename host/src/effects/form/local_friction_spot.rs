//! `m = 1 + a·exp(−((x − x_s)/w)²)`.

use super::Range::{Any, Positive};
use super::{Argument, BARE, CTerm, Constructor, Form, LEVEL, term};
use preslide::Units;
use preslide::effects::LocalFrictionSpot;

/// `local_friction_spot`.
pub(crate) static LOCAL_FRICTION_SPOT: Form = Form {
    id: "local_friction_spot",
    keys: &[("level", LEVEL), ("position_m", Any), ("width_m", Positive)],
    library: |effect, _| {
        Ok(term(LocalFrictionSpot::try_new(
            effect.get("level"),
            effect.get("position_m"),
            effect.get("width_m"),
            Units::SI,
        )?))
    },
    controller: Ok(Constructor {
        kind: "LocalFrictionSpot",
        more: &[Argument::Units],
        c: CTerm::level("$level * spot((x - $position_m) / $width_m)").placed(),
    }),
    ..BARE
};
