//! What drive and sensors do between force and motion.

use super::Range::{Any, NotNegative, Positive, Within};
use super::{Argument, BARE, CTerm, Form, built};
use crate::effects::Effect;
use preslide::effects::EncoderError;
use preslide::{ParamError, Units};

/// Measured `= x + e·cos(2πx/p + φ)`.
pub static ENCODER_ERROR: Form = Form {
    id: "encoder_error",
    keys: &[("error_m", Any), ("period_m", Positive), ("phase_rad", Any)],
    library: |effect, _| {
        correction(effect)?;
        Ok(None)
    },
    controller: built(
        "EncoderError",
        &[Argument::Units],
        CTerm::shift("-$error_m * wave(x, $period_m, $phase_rad)"),
    ),
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

/// The force is recorded `τ` after the motion.
pub static CHANNEL_DELAY: Form = Form {
    id: "channel_delay",
    keys: &[("delay_s", Any)],
    controller: Err("it belongs to the recording: the force was sampled later than the position"),
    ..BARE
};

/// The load on a spring behind the motor with the encoder, `ω = 2πf = √(4k/M)`.
pub static DRIVE_COMPLIANCE: Form = Form {
    id: "drive_compliance",
    keys: &[("frequency_Hz", Positive)],
    controller: Err("it needs the second derivative of the friction force"),
    ..BARE
};

/// A play of the whole width `gap` between motor and load.
pub static BACKLASH: Form = Form {
    id: "backlash",
    keys: &[("gap_m", NotNegative)],
    controller: Err("crossing the gap takes a move of the motor, not a force"),
    ..BARE
};

/// Largest share: a motor that gives nothing at some place is broken.
const MOST: f64 = 0.9;

/// Command `= F/(1 + a·cos(2πx/p + φ))`.
pub static TORQUE_RIPPLE: Form = Form {
    id: "torque_ripple",
    keys: &[
        ("share", Within(MOST)),
        ("period_m", Positive),
        ("phase_rad", Any),
    ],
    controller: Err(
        "it is a property of the drive: divide the command by 1 + share·cos(2π·position/period + phase)",
    ),
    ..BARE
};

/// Command `= F + ½·width·sgn F`.
pub static ACTUATOR_DEAD_ZONE: Form = Form {
    id: "actuator_dead_zone",
    keys: &[("width_N", NotNegative)],
    controller: Err("it is a property of the drive; set it in the controller's settings"),
    ..BARE
};

/// `F` held within ± limit.
pub static ACTUATOR_SATURATION: Form = Form {
    id: "actuator_saturation",
    keys: &[("limit_N", Positive)],
    controller: Err("it is a property of the drive; set it in the controller's settings"),
    ..BARE
};

/// Displacement less `rate·T_s·sinh(F/(share·F_limit))`.
pub static CREEP: Form = Form {
    id: "creep",
    keys: &[("rate_m_s", NotNegative), ("share_of_breakaway", Positive)],
    controller: Err("its feed-forward would push a resting axis"),
    ..BARE
};
