//! `m = 1 + a·exp(−(abs(v)/v_s)^δ)`.

use super::Range::{Between, Positive};
use super::{Argument, BARE, CTerm, Constructor, Form, LEVEL, term};
use preslide::Units;
use preslide::effects::Stribeck;

/// `stribeck`.
pub(crate) static STRIBECK: Form = Form {
    id: "stribeck",
    keys: &[
        ("level", LEVEL),
        ("velocity_m_s", Positive),
        ("exponent", Between(1.0, 4.0)),
    ],
    library: |effect, _| {
        Ok(term(Stribeck::try_new(
            effect.get("level"),
            effect.get("velocity_m_s"),
            effect.get("exponent"),
            Units::SI,
        )?))
    },
    controller: Ok(Constructor {
        kind: "Stribeck",
        more: &[Argument::Units],
        c: CTerm::level("$level * stribeck(v, $velocity_m_s, $exponent)"),
    }),
    ..BARE
};
