//! From settings in SI units to the coefficients of a tick, once, outside the interrupt.

use super::{Compensator, Fade, FeedForward, Limiter, Motor, MotorDrive, Pid, PidGains, Watch};
use super::{Monitor, faults::RawScale};
use crate::param::{ParamError, at_most, positive, to_scalar};
use crate::{EncoderScale, Friction, Units};

/// The encoder, and how velocity is read from it (see [`EncoderScale`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoder {
    /// One count (m or rad).
    pub count: f64,
    /// Shortest time (s) over which velocity is measured.
    pub window: f64,
    /// Time (s) without an edge that counts as standstill.
    pub timeout: f64,
}

/// Everything a controller is told but its friction model (SI).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Sample time `T_s` (s), at most 0.1.
    pub sample_time: f64,
    /// The encoder.
    pub encoder: Encoder,
    /// The motor and its bridge.
    pub motor: Motor,
    /// One code of the supply measurement (V).
    pub supply_code: f64,
    /// The feedback.
    pub gains: PidGains,
    /// The feed-forward.
    pub feed_forward: FeedForward,
    /// Largest |duty| (-), 0…1.
    pub duty_limit: f64,
    /// What counts as healthy.
    pub watch: Watch,
    /// How long a change of parameters takes to act fully (s).
    pub fade_time: f64,
}

impl Settings {
    /// The axis of the paper's Table 1 at 20 kHz, with the gains that `preslide track` uses.
    ///
    /// Assumptions, beside those of [`Motor::PAPER_AXIS`]: the mass is the 30 N weight plus the rotor
    /// (1.0 g·cm² by the motor's catalogue) reflected through gear and screw; duty is limited to what holds the
    /// winding below its rated torque.
    pub const PAPER_AXIS: Settings = Settings {
        sample_time: 50e-6,
        encoder: Encoder {
            count: 25e-9,
            window: 1e-3,
            timeout: 0.5,
        },
        motor: Motor::PAPER_AXIS,
        supply_code: 1e-3,
        gains: PidGains {
            proportional: 1e5,
            integral: 3e6,
            derivative: 600.0,
            integral_limit: 5.0,
            deadband: 30e-9,
        },
        feed_forward: FeedForward {
            drive: super::Drive::Reference,
            share: 1.0,
            limit: 5.0,
            mass: 4.05,
        },
        duty_limit: 0.38,
        watch: Watch {
            top_speed: 20e-3,
            following_error: 50e-6,
            frozen_duty: 0.1,
            frozen_time: 5e-3,
            supply_min: 4.5,
            supply_max: 7.5,
            supply_time: 1e-3,
            overruns: 2,
        },
        fade_time: 0.1,
    };
}

/// What a tick computes with: validated, scaled, no division left.
///
/// Built where there is time, then handed to [`super::Controller::swap`].
#[derive(Clone, Debug)]
pub struct Coefficients<F: Friction> {
    pub(crate) scale: EncoderScale<F::Scalar>,
    pub(crate) length_per_count: F::Scalar,
    pub(crate) velocity_per_length: F::Scalar,
    pub(crate) pid: Pid<F::Scalar>,
    pub(crate) compensator: Compensator<F>,
    pub(crate) motor: MotorDrive<F::Scalar>,
    pub(crate) supply_nominal: f32,
    pub(crate) limiter: Limiter,
    pub(crate) monitor: Monitor<F::Scalar>,
    pub(crate) fade: Fade<F::Scalar>,
}

impl<F: Friction> Coefficients<F> {
    /// Validates `settings` and computes the coefficients in `units`, in which `friction` must have been built.
    ///
    /// # Errors
    /// The first parameter that is not finite, out of range, or does not fit the number type.
    pub fn try_new(settings: &Settings, friction: F, units: Units) -> Result<Self, ParamError> {
        units.check()?;
        let sample_time = positive("sample time", settings.sample_time)?;
        at_most("sample time", sample_time, 0.1)?;
        let Encoder {
            count,
            window,
            timeout,
        } = settings.encoder;
        positive("length of a count", count)?;
        positive("supply code", settings.supply_code)?;
        let steps = settings.motor.steps;
        let scale = RawScale {
            count,
            sample_time,
            steps,
            supply_code: settings.supply_code,
            length: units.length,
        };
        Ok(Self {
            scale: EncoderScale::try_new(count, sample_time, window, timeout, units)?,
            length_per_count: to_scalar("length of a count", count / units.length)?,
            velocity_per_length: to_scalar(
                "velocity per displacement of a tick",
                units.length / sample_time / units.velocity,
            )?,
            pid: Pid::try_new(&settings.gains, sample_time, units)?,
            compensator: Compensator::try_new(friction, &settings.feed_forward, units)?,
            motor: MotorDrive::try_new(&settings.motor, units)?,
            supply_nominal: (settings.motor.supply / settings.supply_code) as f32,
            limiter: Limiter::try_new(settings.duty_limit, steps)?,
            monitor: Monitor::try_new(&settings.watch, &scale)?,
            fade: Fade::try_new(settings.fade_time, sample_time)?,
        })
    }
}
