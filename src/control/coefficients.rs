//! From an axis in SI units to the coefficients of a tick, once, outside the interrupt.

use super::{Axis, Compensator, Encoder, Fade, Limiter, Monitor, MotorDrive, Pace, Pid};
use crate::param::{ParamError, to_scalar};
use crate::{EncoderScale, Friction, Units};

/// What a tick computes with: validated, scaled, no division left.
///
/// Built where there is time, then handed to [`super::Controller::swap`].
#[derive(Clone, Debug)]
pub struct Coefficients<F: Friction> {
    pub(crate) scale: EncoderScale<F::Scalar>,
    pub(crate) length_per_count: F::Scalar,
    pub(crate) velocity_per_length: F::Scalar,
    /// Of a change of the reference's speed that is still to be divided by the smoothing.
    pub(crate) acceleration_per_change: F::Scalar,
    pub(crate) pid: Pid<F::Scalar>,
    pub(crate) compensator: Compensator<F>,
    pub(crate) motor: MotorDrive<F::Scalar>,
    pub(crate) supply_nominal: f32,
    pub(crate) limiter: Limiter,
    pub(crate) monitor: Monitor<F::Scalar>,
    pub(crate) fade: Fade<F::Scalar>,
    pub(crate) pace: Pace,
    /// ±1: the counter's direction and the bridge's.
    pub(crate) count_sign: i32,
    pub(crate) code_sign: i32,
    pub(crate) turn: i32,
    /// Ticks without a word of the host; 0 for no end.
    pub(crate) silence: u32,
}

impl<F: Friction> Coefficients<F> {
    /// Validates `axis` and computes the coefficients in `units`, in which `friction` must have been built.
    ///
    /// # Errors
    /// The first parameter that is not finite, out of range, or does not fit the number type.
    pub fn try_new(axis: &Axis, friction: F, units: Units) -> Result<Self, ParamError> {
        units.check()?;
        axis.check()?;
        let sample_time = axis.sample_time();
        let Encoder {
            count,
            window,
            timeout,
            reversed,
            turn,
        } = axis.encoder;
        let hardware = &axis.hardware;
        let pace = Pace::try_new(&axis.limits, axis.grid())?;
        let smoothing = f64::from(pace.smoothing());
        let sign = |reversed| if reversed { -1 } else { 1 };
        Ok(Self {
            scale: EncoderScale::try_new(count, sample_time, window, timeout, units)?,
            length_per_count: to_scalar("length of a count", count / units.length)?,
            velocity_per_length: to_scalar(
                "velocity per displacement of a tick",
                units.length / sample_time / units.velocity,
            )?,
            acceleration_per_change: to_scalar(
                "acceleration of a count per tick², smoothed,",
                count / (sample_time * sample_time) / units.velocity / smoothing,
            )?,
            pid: Pid::try_new(&axis.gains, sample_time, units)?,
            compensator: Compensator::try_new(friction, &axis.feed_forward, units)?,
            motor: MotorDrive::try_new(&axis.motor, hardware, units)?,
            supply_nominal: (axis.motor.supply / hardware.supply_code) as f32,
            limiter: Limiter::try_new(axis.duty_limit, hardware.steps.into())?,
            monitor: Monitor::try_new(axis, units)?,
            fade: Fade::try_new(axis.fade_time, sample_time)?,
            pace,
            count_sign: sign(reversed),
            code_sign: sign(axis.motor.reversed),
            // At most 10⁹, by the check above.
            turn: turn as i32,
            // Saturating: more ticks than `u32` holds are as good as endless.
            silence: libm::ceil(axis.silence / sample_time) as u32,
        })
    }
}
