//! Stribeck's curve, following with `τ`.

use super::Range::{Between, Positive};
use super::{Argument, BARE, CTerm, Constructor, Form, LEVEL, Memory, term};
use preslide::Units;
use preslide::effects::FrictionalLag;

/// `frictional_lag`.
pub(crate) static FRICTIONAL_LAG: Form = Form {
    id: "frictional_lag",
    keys: &[
        ("level", LEVEL),
        ("velocity_m_s", Positive),
        ("exponent", Between(1.0, 4.0)),
        ("time_constant_s", Positive),
    ],
    library: |effect, sample_time| {
        Ok(term(FrictionalLag::try_new(
            effect.get("level"),
            effect.get("velocity_m_s"),
            effect.get("exponent"),
            effect.get("time_constant_s"),
            sample_time,
            Units::SI,
        )?))
    },
    controller: Ok(Constructor {
        kind: "FrictionalLag",
        more: &[Argument::SampleTime, Argument::Units],
        c: CTerm::level("@").remembers(Memory {
            kind: "float",
            at_rest: "$level",
            next: "@ - expm1f(-SAMPLE_TIME_S / $time_constant_s) * ($level * stribeck(v, $velocity_m_s, $exponent) - @)",
        }),
    }),
    ..BARE
};
