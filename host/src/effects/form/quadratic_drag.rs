//! `c·v·abs(v)`.

use super::Range::Any;
use super::{Argument, BARE, CTerm, Constructor, FAR, Form, term};
use preslide::Units;
use preslide::effects::QuadraticDrag;

/// `quadratic_drag`.
pub(crate) static QUADRATIC_DRAG: Form = Form {
    id: "quadratic_drag",
    keys: &[("drag_N_s2_per_m2", Any)],
    library: |effect, _| {
        Ok(term(QuadraticDrag::try_new(
            effect.get("drag_N_s2_per_m2"),
            FAR,
            Units::SI,
        )?))
    },
    controller: Ok(Constructor {
        kind: "QuadraticDrag",
        more: &[Argument::ForceLimit, Argument::Units],
        c: CTerm::force("limited($drag_N_s2_per_m2 * (v * fabsf(v)), FORCE_LIMIT)"),
    }),
    ..BARE
};
