//! What the control task watches, and when it gives up.

use crate::Scalar;
use crate::param::{ParamError, at_least, not_negative, positive, to_scalar};

/// Why the controller is in its safe state: PWM at 0 until [`super::Controller::restart`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The count moved further in one tick than the axis can. Found in that tick.
    EncoderJump,
    /// The command pushed beyond [`Watch::frozen_duty`] and no count came for [`Watch::frozen_time`].
    EncoderFrozen,
    /// The position error exceeded [`Watch::following_error`]. Found in that tick.
    FollowingError,
    /// The supply stayed outside its range for [`Watch::supply_time`].
    SupplyOutOfRange,
    /// More than [`Watch::overruns`] ticks in a row came late.
    Overrun,
    /// The command was not a number. Found in that tick.
    NotANumber,
}

/// Bounds of what counts as healthy (SI).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Watch {
    /// Fastest motion the axis can make (m/s or rad/s).
    pub top_speed: f64,
    /// Largest position error (m or rad).
    pub following_error: f64,
    /// |duty| (-) that moves the axis whatever the friction.
    pub frozen_duty: f64,
    /// Time (s) at that duty without a count.
    pub frozen_time: f64,
    /// Lowest supply voltage (V).
    pub supply_min: f64,
    /// Highest supply voltage (V).
    pub supply_max: f64,
    /// Time (s) that the supply may be outside.
    pub supply_time: f64,
    /// Late ticks in a row that are ridden out.
    pub overruns: u32,
}

/// [`Watch`] in counts, codes and ticks.
#[derive(Clone, Debug)]
pub struct Monitor<S> {
    jump: u32,
    following_error: S,
    frozen_code: u32,
    frozen_ticks: u32,
    supply_min: u16,
    supply_max: u16,
    supply_ticks: u32,
    overruns: u32,
}

/// How long things have been wrong so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Suspicion {
    frozen: u32,
    supply: u32,
    late: u32,
}

/// What scales a [`Watch`] to raw values.
pub(crate) struct RawScale {
    /// One count (m or rad).
    pub count: f64,
    /// `T_s` (s).
    pub sample_time: f64,
    /// PWM codes at full duty.
    pub steps: f64,
    /// One code of the supply measurement (V).
    pub supply_code: f64,
    /// The model's unit of length (m or rad).
    pub length: f64,
}

impl<S: Scalar> Monitor<S> {
    pub(crate) fn try_new(watch: &Watch, scale: &RawScale) -> Result<Self, ParamError> {
        // A tick may see one count more than the speed alone makes.
        let jump = positive("top speed", watch.top_speed)? * scale.sample_time / scale.count + 1.0;
        positive("following error", watch.following_error)?;
        not_negative("frozen duty", watch.frozen_duty)?;
        let ticks = |name, time| {
            positive(name, time).map(|time| libm::ceil(time / scale.sample_time) as u32)
        };
        positive("lowest supply voltage", watch.supply_min)?;
        at_least("highest supply voltage", watch.supply_max, watch.supply_min)?;
        // At least one code: the supply is divided by.
        at_least("lowest supply voltage", watch.supply_min, scale.supply_code)?;
        Ok(Self {
            jump: jump as u32,
            following_error: to_scalar("following error", watch.following_error / scale.length)?,
            frozen_code: (watch.frozen_duty * scale.steps) as u32,
            frozen_ticks: ticks("frozen time", watch.frozen_time)?,
            supply_min: libm::ceil(watch.supply_min / scale.supply_code) as u16,
            supply_max: (watch.supply_max / scale.supply_code) as u16,
            supply_ticks: ticks("supply time", watch.supply_time)?,
            overruns: watch.overruns,
        })
    }

    /// Checks what was measured, before anything is computed from it. `code` is the command that was in force.
    #[inline]
    pub fn measured(
        &self,
        suspicion: &mut Suspicion,
        counts: i32,
        code: i32,
        supply: u16,
        late: bool,
    ) -> Option<Fault> {
        let last = |counter: &mut u32, wrong: bool, allowed: u32| {
            *counter = if wrong { counter.saturating_add(1) } else { 0 };
            *counter > allowed
        };
        let pushing = code.unsigned_abs() > self.frozen_code;
        let frozen = last(
            &mut suspicion.frozen,
            pushing && counts == 0,
            self.frozen_ticks,
        );
        let outside = supply < self.supply_min || supply > self.supply_max;
        let sag = last(&mut suspicion.supply, outside, self.supply_ticks);
        let overrun = last(&mut suspicion.late, late, self.overruns);
        if counts.unsigned_abs() > self.jump {
            Some(Fault::EncoderJump)
        } else if frozen {
            Some(Fault::EncoderFrozen)
        } else if sag {
            Some(Fault::SupplyOutOfRange)
        } else if overrun {
            Some(Fault::Overrun)
        } else {
            None
        }
    }

    /// Checks the position error.
    #[inline]
    pub fn followed(&self, error: S) -> Option<Fault> {
        (error.magnitude() > self.following_error).then_some(Fault::FollowingError)
    }

    /// The supply code to compute with, never below the lowest healthy one.
    #[inline]
    pub(crate) fn usable(&self, supply: u16) -> u16 {
        if supply < self.supply_min {
            self.supply_min
        } else if supply > self.supply_max {
            self.supply_max
        } else {
            supply
        }
    }
}
