//! `m = 1 + a·exp(−t/τ)`: the other set of keys of `thermal_drift`.

use super::Range::Positive;
use super::{Argument, BARE, CTerm, Constructor, Form, LEVEL, Memory, term};
use preslide::effects::WarmUp;

/// `thermal_drift`.
pub(crate) static WARM_UP: Form = Form {
    id: "thermal_drift",
    keys: &[("level", LEVEL), ("time_constant_s", Positive)],
    library: |effect, sample_time| {
        Ok(term(WarmUp::try_new(
            effect.get("level"),
            effect.get("time_constant_s"),
            sample_time,
        )?))
    },
    controller: Ok(Constructor {
        kind: "WarmUp",
        more: &[Argument::SampleTime],
        c: CTerm::level("$level * expf(-(float)@ * (SAMPLE_TIME_S / $time_constant_s))").remembers(
            // Ticks: seconds in single precision stand still.
            Memory {
                kind: "uint32_t",
                at_rest: "0u",
                next: "@ < UINT32_MAX ? @ + 1u : @",
            },
        ),
    }),
    cost: Some("warm_up"),
    ..BARE
};
