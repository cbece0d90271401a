//! `m = 1 + a·cos(2πx/p + φ)`.

use super::Range::{Any, Positive};
use super::{Argument, BARE, CTerm, Constructor, Form, LEVEL, term};
use preslide::Units;
use preslide::effects::PeriodicFriction;

/// `periodic_friction`.
pub(crate) static PERIODIC_FRICTION: Form = Form {
    id: "periodic_friction",
    keys: &[("level", LEVEL), ("period_m", Positive), ("phase_rad", Any)],
    library: |effect, _| {
        Ok(term(PeriodicFriction::try_new(
            effect.get("level"),
            effect.get("period_m"),
            effect.get("phase_rad"),
            Units::SI,
        )?))
    },
    controller: Ok(Constructor {
        kind: "PeriodicFriction",
        more: &[Argument::Units],
        c: CTerm::level("$level * wave(x, $period_m, $phase_rad)").placed(),
    }),
    ..BARE
};
