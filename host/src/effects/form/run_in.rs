//! `m = 1 + a·exp(−s/λ)`.

use super::Range::Positive;
use super::{BARE, Form, LEVEL, term};
use preslide::Units;
use preslide::effects::RunIn;

/// `run_in`.
pub(crate) static RUN_IN: Form = Form {
    id: "run_in",
    keys: &[("level", LEVEL), ("path_m", Positive)],
    library: |effect, sample_time| {
        Ok(term(RunIn::try_new(
            effect.get("level"),
            effect.get("path_m"),
            sample_time,
            Units::SI,
        )?))
    },
    controller: Err(
        "it counts from the first sample of the recording and would begin anew whenever the controller starts",
    ),
    ..BARE
};
