//! `m = 1 + a·sgn F` (`= sgn v` in sliding).

use super::Range::Within;
use super::{BARE, CTerm, Constructor, Form, term};
use preslide::effects::CoulombAsymmetry;

/// `coulomb_asymmetry`.
pub(crate) static COULOMB_ASYMMETRY: Form = Form {
    id: "coulomb_asymmetry",
    keys: &[("asymmetry", Within(1.0))],
    library: |effect, _| Ok(term(CoulombAsymmetry::try_new(effect.get("asymmetry"))?)),
    controller: Ok(Constructor {
        kind: "CoulombAsymmetry",
        more: &[],
        c: CTerm::level("friction > 0.0f ? $asymmetry : friction < 0.0f ? -$asymmetry : 0.0f"),
    }),
    ..BARE
};
