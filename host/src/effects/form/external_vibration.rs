//! `A·sin(2πft + φ)`.

use super::Range::{Any, Positive};
use super::{BARE, Form, term};
use preslide::Units;
use preslide::effects::ExternalVibration;

/// `external_vibration`.
pub(crate) static EXTERNAL_VIBRATION: Form = Form {
    id: "external_vibration",
    keys: &[
        ("force_N", Any),
        ("frequency_Hz", Positive),
        ("phase_rad", Any),
    ],
    library: |effect, sample_time| {
        Ok(term(ExternalVibration::try_new(
            effect.get("force_N"),
            effect.get("frequency_Hz"),
            effect.get("phase_rad"),
            sample_time,
            Units::SI,
        )?))
    },
    controller: Err(
        "its phase is that of the recording's clock, which the controller does not know",
    ),
    ..BARE
};
