//! `d·abs(v)`: viscous friction is `viscous + d` forwards and `viscous − d` backwards.

use super::Range::Any;
use super::{Argument, BARE, CTerm, Constructor, FAR, Form, term};
use preslide::Units;
use preslide::effects::ViscousAsymmetry;

/// `viscous_asymmetry`.
pub(crate) static VISCOUS_ASYMMETRY: Form = Form {
    id: "viscous_asymmetry",
    keys: &[("half_difference_N_s_per_m", Any)],
    library: |effect, _| {
        Ok(term(ViscousAsymmetry::try_new(
            effect.get("half_difference_N_s_per_m"),
            FAR,
            Units::SI,
        )?))
    },
    controller: Ok(Constructor {
        kind: "ViscousAsymmetry",
        more: &[Argument::ForceLimit, Argument::Units],
        c: CTerm::force("limited($half_difference_N_s_per_m * fabsf(v), FORCE_LIMIT)"),
    }),
    ..BARE
};
