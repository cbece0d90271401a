//! `b·v`, which a model file has among the keys of `[friction]`.

use super::Range::Any;
use super::{Argument, BARE, CTerm, Constructor, Form};

/// `viscous`.
pub(crate) static VISCOUS: Form = Form {
    id: "viscous",
    keys: &[("viscous_N_s_per_m", Any)],
    controller: Ok(Constructor {
        kind: "Viscous",
        more: &[Argument::ForceLimit, Argument::Units],
        c: CTerm::force("limited($viscous_N_s_per_m * v, FORCE_LIMIT)"),
    }),
    ..BARE
};
