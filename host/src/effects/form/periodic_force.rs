//! `A·cos(2πx/p + φ)`.

use super::Range::{Any, Positive};
use super::{Argument, BARE, CTerm, Constructor, Form, term};
use preslide::Units;
use preslide::effects::PeriodicForce;

/// `periodic_force`.
pub(crate) static PERIODIC_FORCE: Form = Form {
    id: "periodic_force",
    keys: &[("force_N", Any), ("period_m", Positive), ("phase_rad", Any)],
    library: |effect, _| {
        Ok(term(PeriodicForce::try_new(
            effect.get("force_N"),
            effect.get("period_m"),
            effect.get("phase_rad"),
            Units::SI,
        )?))
    },
    controller: Ok(Constructor {
        kind: "PeriodicForce",
        more: &[Argument::Units],
        c: CTerm::force("$force_N * wave(x, $period_m, $phase_rad)").placed(),
    }),
    ..BARE
};
