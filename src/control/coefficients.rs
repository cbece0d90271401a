//! From an axis in SI units to the coefficients of a tick, once, outside the interrupt.

use super::{Axis, Compensator, Encoder, Fade, Limiter, Monitor, MotorDrive, Pace, Pid};
use crate::param::{ParamError, to_scalar};
use crate::{EncoderScale, Friction, Scalar, Units};

/// What a tick computes with: validated, scaled, no division left.
///
/// Built where there is time, then handed to [`super::Controller::swap`].
#[derive(Clone, Debug)]
pub struct Coefficients<F: Friction> {
    pub(crate) scale: EncoderScale<F::Scalar>,
    pub(crate) length_per_count: F::Scalar,
    pub(crate) velocity_per_length: F::Scalar,
    pub(crate) acceleration: AccelerationScale<F::Scalar>,
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
    /// Ticks without a word of the host; `u32::MAX` for no end.
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
        let sign = |reversed| if reversed { -1 } else { 1 };
        Ok(Self {
            scale: EncoderScale::try_new(count, sample_time, window, timeout, units)?,
            length_per_count: to_scalar("length of a count", count / units.length)?,
            velocity_per_length: to_scalar(
                "velocity per displacement of a tick",
                units.length / sample_time / units.velocity,
            )?,
            acceleration: AccelerationScale::try_new(
                count / (sample_time * sample_time) / units.velocity,
            )?,
            pid: Pid::try_new(&axis.gains, sample_time, units)?,
            compensator: Compensator::try_new(friction, &axis.feed_forward, units)?,
            motor: MotorDrive::try_new(&axis.motor, hardware.steps, units)?,
            supply_nominal: (axis.motor.supply / hardware.supply_code) as f32,
            limiter: Limiter::try_new(axis.duty_limit, hardware.steps.into())?,
            monitor: Monitor::try_new(axis, units)?,
            fade: Fade::try_new(axis.fade_time, sample_time)?,
            pace: Pace::try_new(&axis.limits, axis.grid())?,
            count_sign: sign(reversed),
            code_sign: sign(axis.motor.reversed),
            // At most 10⁹, by the check above.
            turn: turn as i32,
            silence: if axis.silence > 0.0 {
                // Saturating: more ticks than `u32` holds are as good as endless.
                libm::ceil(axis.silence / sample_time) as u32
            } else {
                u32::MAX
            },
        })
    }
}

/// Scales the reference's acceleration, 2⁻³² counts per tick², to velocity units per second.
#[derive(Clone, Debug)]
pub(crate) struct AccelerationScale<S> {
    shift: u32,
    scale: S,
}

impl<S: Scalar> AccelerationScale<S> {
    /// As many of its bits are used as keep the coefficient in the number type's middle: acceleration in 2⁻²⁰ counts per tick²
    /// for the paper's axis in fixed point.
    fn try_new(per_count: f64) -> Result<Self, ParamError> {
        let name = "acceleration of a count per tick²";
        let bits =
            libm::ceil(libm::log2(per_count) - 0.5 * libm::log2(S::greatest())).clamp(0.0, 16.0);
        let scale = to_scalar(name, per_count / libm::exp2(bits))?;
        Ok(Self {
            shift: 16 - bits as u32,
            scale,
        })
    }

    #[inline]
    pub(crate) fn apply(&self, acceleration: i64) -> S {
        let q16 = super::reference::saturate(acceleration >> self.shift);
        S::from_q16(q16).mul_input(self.scale)
    }
}
