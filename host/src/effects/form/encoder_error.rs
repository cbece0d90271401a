//! Measured `= x + e·cos(2πx/p + φ)`.

use super::Range::{Any, Positive};
use super::{Argument, BARE, CTerm, Constructor, Form};
use crate::effects::Effect;
use preslide::effects::EncoderError;
use preslide::{ParamError, Units};

/// `encoder_error`.
pub(crate) static ENCODER_ERROR: Form = Form {
    id: "encoder_error",
    keys: &[("error_m", Any), ("period_m", Positive), ("phase_rad", Any)],
    library: |effect, _| {
        correction(effect)?;
        Ok(None)
    },
    controller: Ok(Constructor {
        kind: "EncoderError",
        more: &[Argument::Units],
        c: CTerm::shift("-$error_m * wave(x, $period_m, $phase_rad)"),
    }),
    ..BARE
};

/// The library's correction.
///
/// # Errors
/// Which parameter the library refuses.
pub(crate) fn correction(effect: &Effect) -> Result<EncoderError<f64>, ParamError> {
    let get = |key| effect.get(key);
    EncoderError::try_new(get("error_m"), get("period_m"), get("phase_rad"), Units::SI)
}
