//! `m = 1 + a·exp(−t/τ)`: the other set of keys of `thermal_drift`.

use super::Range::Positive;
use super::{Argument, BARE, Constructor, Form, LEVEL, term};
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
    }),
    cost: Some("warm_up"),
    ..BARE
};
