//! What an axis is: one description in SI units, from which firmware, simulation and capture compute everything else.

use super::{FaultLimits, FeedForward, Grid, Hardware, Motor, Notch, PidGains};
use crate::param::{ParamError, at_least, at_most, not_negative, positive};

/// The encoder, and how velocity is read from it (see [`crate::EncoderScale`]).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Encoder {
    /// One count (m or rad).
    pub count: f64,
    /// Shortest time (s) over which velocity is measured.
    pub window: f64,
    /// Time (s) without an edge that counts as standstill.
    pub timeout: f64,
    /// The counter runs against the axis.
    pub reversed: bool,
    /// Counts of a turn of a rotary axis without end, at least 2; 0 where the axis has an end. What acts by position
    /// ([`crate::effects`]) is told the place within the turn.
    pub turn: u32,
}

/// What a motion must not exceed (SI).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits {
    /// Speed (m/s or rad/s).
    pub speed: f64,
    /// Acceleration (m/s² or rad/s²); a stop brakes with it.
    pub acceleration: f64,
    /// Jerk (m/s³ or rad/s³). It sets the [smoothing](super::Reference): `2·acceleration/jerk`, rounded up to a power of two of
    /// ticks, at most [`super::MOST_SMOOTHED`].
    pub jerk: f64,
    /// Lowest and highest position (m or rad), watched once the axis has been told where it is
    /// ([`super::Controller::set_position`]); `None` for an axis without end.
    pub travel: Option<(f64, f64)>,
}

impl Limits {
    pub(crate) fn check(&self) -> Result<(), ParamError> {
        positive("speed limit", self.speed)?;
        positive("acceleration limit", self.acceleration)?;
        positive("jerk limit", self.jerk)?;
        if let Some((low, high)) = self.travel {
            at_most("low end of travel", low, f64::MAX)?;
            at_least("high end of travel", high, low)?;
            at_most("high end of travel", high, f64::MAX)?;
        }
        Ok(())
    }
}

/// Everything that configures a controller, except its friction model (SI). Plain data: a build script can write it, a host can read it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Axis {
    /// The board.
    pub hardware: Hardware,
    /// The encoder.
    pub encoder: Encoder,
    /// The motor and its supply.
    pub motor: Motor,
    /// The feedback.
    pub gains: PidGains,
    /// What the feedback is not to answer: the drive's first mode.
    pub notch: Notch,
    /// The feed-forward.
    pub feed_forward: FeedForward,
    /// What a motion must not exceed.
    pub limits: Limits,
    /// Largest |duty| (-), 0…1.
    pub duty_limit: f64,
    /// What counts as healthy.
    pub watch: FaultLimits,
    /// How long a change of parameters takes to act fully (s).
    pub fade_time: f64,
    /// Time (s) without a word of the host ([`super::Controller::heard`]) after which a moving axis stops; 0 for never.
    pub silence: f64,
}

/// Its name before it described the whole axis.
pub type Settings = Axis;

impl Axis {
    /// The axis of the paper's Table 1 at 20 kHz, with the gains that `preslide track` uses.
    ///
    /// Assumptions, beside those of [`Motor::PAPER_AXIS`]: the mass is the 30 N weight plus the rotor
    /// (1.0 g·cm² by the motor's catalogue) reflected through gear and screw; duty is limited to what holds the
    /// winding below its rated torque, and the acceleration to what that duty gives with room for friction. The jerk makes the
    /// smoothing 3.2 ms, half the time constant of the loop's crossover; a fade of 0.4 s is long
    /// enough for the feedback to take over what two models that differ by a tenth of the breakaway force disagree about. A travel of ±12.5 mm is a guess at the screw's.
    pub const PAPER_AXIS: Axis = Axis {
        hardware: Hardware::edge_aligned(170_000_000, 20_000),
        encoder: Encoder {
            count: 25e-9,
            window: 1e-3,
            timeout: 0.5,
            reversed: false,
            turn: 0,
        },
        motor: Motor::PAPER_AXIS,
        gains: PidGains {
            proportional: 1e5,
            integral: 3e6,
            derivative: 600.0,
            integral_limit: 5.0,
            deadband: 30e-9,
        },
        notch: Notch::NONE,
        feed_forward: FeedForward {
            drive: super::VelocitySource::Reference,
            share: 1.0,
            limit: 5.0,
            mass: 4.05,
        },
        limits: Limits {
            speed: 15e-3,
            acceleration: 1.0,
            jerk: 625.0,
            travel: Some((-12.5e-3, 12.5e-3)),
        },
        duty_limit: 0.38,
        watch: FaultLimits {
            top_speed: 20e-3,
            following_error: 50e-6,
            frozen_duty: 0.1,
            frozen_time: 5e-3,
            supply_min: 4.5,
            supply_max: 7.5,
            supply_time: 1e-3,
            overruns: 2,
            current_max: 1.0,
            current_rated: 0.68,
            thermal_time: 5.0,
            current_offset: 0.05,
        },
        fade_time: 0.4,
        silence: 2.0,
    };

    /// `T_s` (s).
    pub const fn sample_time(&self) -> f64 {
        self.hardware.sample_time()
    }

    /// Where in a PWM period, counted from the middle of the pulse, the current is its mean (-), ¼…½: there a converter belongs that
    /// samples once.
    ///
    /// After a short pulse the current falls by `e^{−φ·x}` over the part φ of the period, `x = T_s·R/L`, from `x/(1 − e^{−x})` times
    /// its mean; so `φ = ln(x/(1 − e^{−x}))/x`, whatever the back-EMF. It goes from ½, the middle of the freewheeling, where the
    /// inductance is large or not told (0), towards the pulse; a pulse of a third of the period makes it 3 % wrong.
    pub fn sampling_phase(&self) -> f64 {
        let ripple = self.motor.ripple(self.sample_time());
        if ripple < 1e-3 {
            return 0.5;
        }
        // The pulse itself must not reach it: duty is below half.
        (libm::log(ripple / -libm::expm1(-ripple)) / ripple).clamp(0.25, 0.5)
    }

    /// One count and one tick, for planning.
    pub const fn grid(&self) -> Grid {
        Grid {
            count: self.encoder.count,
            sample_time: self.sample_time(),
        }
    }

    pub(crate) fn check(&self) -> Result<(), ParamError> {
        self.hardware.check()?;
        self.limits.check()?;
        positive("length of a count", self.encoder.count)?;
        not_negative("silence of the host", self.silence)?;
        if self.encoder.turn > 0 {
            at_least("counts of a turn", self.encoder.turn.into(), 2.0)?;
            at_most("counts of a turn", self.encoder.turn.into(), 1e9)?;
        }
        Ok(())
    }
}
