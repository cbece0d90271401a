//! What the control task watches, and when it gives up.

use super::{Axis, Measurement};
use crate::param::{
    ParamError, at_least, at_most, not_negative, positive, reachable, reachable_ticks, to_scalar,
};
use crate::{Scalar, Units};

/// Why the controller is in its safe state: PWM off until [`super::Controller::acknowledge`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Fault {
    /// The count moved further in one tick than the axis can. Found in that tick.
    EncoderJump,
    /// The command pushed beyond [`super::FaultLimits::frozen_duty`], and as far beyond what a load takes, and the count came no further
    /// for [`super::FaultLimits::frozen_time`]: it stands, or goes to and fro as with one phase lost.
    EncoderFrozen,
    /// The position error exceeded [`super::FaultLimits::following_error`]. Found in that tick.
    FollowingError,
    /// The supply stayed outside its range for [`super::FaultLimits::supply_time`].
    SupplyOutOfRange,
    /// More than [`super::FaultLimits::overruns`] ticks in a row came late.
    Overrun,
    /// The command was not a number. Found in that tick.
    NotANumber,
    /// The current exceeded [`super::FaultLimits::current_max`] in two ticks in a row.
    OverCurrent,
    /// The winding has been above [`super::FaultLimits::current_rated`] for too long (I²t).
    Overload,
    /// The current sense reads more than [`super::FaultLimits::current_offset`] while the bridge is off. Found when enabling.
    CurrentOffset,
}

impl Fault {
    /// Every fault, so that who tells of them can hold itself to each.
    pub const ALL: [Fault; 9] = [
        Fault::EncoderJump,
        Fault::EncoderFrozen,
        Fault::FollowingError,
        Fault::SupplyOutOfRange,
        Fault::Overrun,
        Fault::NotANumber,
        Fault::OverCurrent,
        Fault::Overload,
        Fault::CurrentOffset,
    ];

    /// After it the count may be wrong, and with it every place: it jumped, stood still, or stayed behind (of which a count that stands
    /// still may be the reason), or the encoder may have been without supply. The others leave it alone: what counts is hardware.
    pub fn doubts_count(self) -> bool {
        match self {
            Fault::EncoderJump
            | Fault::EncoderFrozen
            | Fault::FollowingError
            | Fault::SupplyOutOfRange => true,
            Fault::Overrun
            | Fault::NotANumber
            | Fault::OverCurrent
            | Fault::Overload
            | Fault::CurrentOffset => false,
        }
    }
}

/// What is read in a tick, for [`Monitor::suspect`].
pub(super) struct Readings {
    /// Counts since the tick before.
    pub counts: i32,
    /// The reference stood in the last tick.
    pub stands: bool,
    /// The command in force so far, in the axis's direction.
    pub code: i32,
    pub supply: u16,
    pub current: i16,
    pub late: bool,
}

/// [`super::FaultLimits`] in counts, codes and ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Monitor<S> {
    jump: u32,
    following_error: S,
    frozen_code: i32,
    frozen_ticks: u32,
    supply_min: u16,
    supply_max: u16,
    /// The one less the other.
    supply_span: u16,
    supply_ticks: u32,
    overruns: u32,
    current_max: i32,
    /// Codes at which the winding does not warm beyond what it stands.
    calm: u32,
    /// Squared codes, and their sum over ticks.
    rated: i32,
    overload: i64,
    offset: i32,
}

/// How long things have been wrong so far, and what the current sense reads at rest.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Suspicion {
    /// One of the counters below is above 0.
    any: bool,
    /// Ticks of pushing in one direction, which one, and the counts that came of it.
    frozen: u32,
    forward: bool,
    gained: i32,
    /// Code that a load takes, as far as it is known, and whether the reference stood.
    held: i32,
    stood: bool,
    supply: u32,
    late: u32,
    current: u32,
    heat: i64,
    /// Mean of the current's code with the bridge off, times 256, and of how many: of the last 256 or so, from then on.
    offset: i32,
    rests: u32,
}

impl Suspicion {
    /// Takes the current's code of a tick with the bridge off.
    #[inline]
    pub(super) fn calibrate(&mut self, current: i16) {
        if self.rests < 256 {
            self.rests += 1;
        }
        // The first is taken whole: an offset is known from the first tick on.
        let share = self.rests.leading_zeros().saturating_sub(23);
        self.offset += (i32::from(current) - (self.offset >> 8)) << share;
    }

    /// What the current sense reads at rest has never been looked at.
    #[inline]
    pub(super) fn knows_no_rest(&self) -> bool {
        self.rests == 0
    }

    /// The current's code with the bridge off.
    pub(super) fn at_rest(&self) -> i16 {
        // A mean of such codes.
        (self.offset >> 8) as i16
    }

    /// Something is wrong, or was lately.
    #[inline]
    pub(super) fn any(&self) -> bool {
        self.any
    }

    /// Nothing is wrong yet; what the current sense reads at rest stays.
    pub(super) fn clear(&mut self) {
        *self = Self {
            offset: self.offset,
            rests: self.rests,
            // A winding does not cool by being told so.
            heat: self.heat,
            any: self.heat > 0,
            ..Self::default()
        };
    }
}

impl<S: Scalar> Monitor<S> {
    /// `length_per_q16` is what errors are computed with, `largest` the code at which the limiter cuts.
    ///
    /// Whatever is refused here by [`reachable`] would be a limit that watches nothing: readings, codes and errors end at the range
    /// of what holds them.
    pub(crate) fn try_new(
        axis: &Axis,
        units: Units,
        length_per_q16: S,
        largest: i32,
    ) -> Result<Self, ParamError> {
        let (watch, hardware) = (&axis.watch, &axis.hardware);
        let sample_time = axis.sample_time();
        // A tick may see one count more than the speed alone makes.
        let jump = positive("top speed", watch.top_speed)? * sample_time / axis.encoder.count + 1.0;
        at_least("top speed", watch.top_speed, axis.limits.speed)?;
        // A counter of 16 bits shows no more in a tick.
        let counts = f64::from(i16::MAX);
        let jump = reachable("top speed", jump, counts, axis.encoder.count / sample_time)?;
        positive("following error", watch.following_error)?;
        let following_error: S =
            to_scalar("following error", watch.following_error / units.length)?;
        let farthest = length_per_q16.of_q16(i32::MAX).to_f64();
        reachable(
            "following error",
            following_error.to_f64(),
            farthest,
            units.length,
        )?;
        let steps = f64::from(hardware.steps);
        let frozen_code = libm::floor(not_negative("frozen duty", watch.frozen_duty)? * steps);
        // Else nothing that the limiter passes would be a push.
        reachable("frozen duty", frozen_code, largest.into(), 1.0 / steps)?;
        let ticks = |name, time| reachable_ticks(name, positive(name, time)?, sample_time);
        reachable("overruns", watch.overruns.into(), u32::MAX.into(), 1.0)?;
        positive("lowest supply voltage", watch.supply_min)?;
        at_least("highest supply voltage", watch.supply_max, watch.supply_min)?;
        // At least one code: the supply is divided by.
        at_least(
            "lowest supply voltage",
            watch.supply_min,
            hardware.supply_code,
        )?;
        // What is read at rest is taken off what ends at the largest code.
        let codes = |name, current: f64| {
            Ok(libm::floor(
                positive(name, current)? / hardware.current_code,
            ))
        };
        let offset = codes("offset of the current", watch.current_offset)?;
        let room = f64::from(i16::MAX) - offset;
        let largest = codes("largest current", watch.current_max)?;
        let largest = reachable("largest current", largest, room, hardware.current_code)?;
        // Where the other fault is not sooner.
        let rated = positive("rated current", watch.current_rated)? / hardware.current_code;
        reachable("rated current", rated, largest, hardware.current_code)?;
        // It cools by that.
        at_least("rated current", watch.current_rated, hardware.current_code)?;
        let thermal = positive("thermal time", watch.thermal_time)? / sample_time;
        at_most("thermal time in ticks", thermal, 4e9)?;
        let supply_min = libm::ceil(watch.supply_min / hardware.supply_code);
        let supply_max = libm::floor(watch.supply_max / hardware.supply_code);
        let supply_max = reachable(
            "highest supply voltage",
            supply_max,
            u16::MAX.into(),
            hardware.supply_code,
        )?;
        at_least(
            "codes of the highest supply voltage",
            supply_max,
            supply_min,
        )?;
        let (supply_min, supply_max) = (supply_min as u16, supply_max as u16);
        Ok(Self {
            jump: jump as u32,
            following_error,
            frozen_code: frozen_code as i32,
            frozen_ticks: ticks("frozen time", watch.frozen_time)?,
            supply_min,
            supply_max,
            supply_span: supply_max - supply_min,
            supply_ticks: ticks("supply time", watch.supply_time)?,
            overruns: watch.overruns,
            current_max: largest as i32,
            calm: (rated as u32).min(largest as u32),
            rated: (rated * rated) as i32,
            overload: (rated * rated * thermal) as i64,
            offset: offset as i32,
        })
    }

    /// Nothing that was measured is unusual: a few comparisons, which is all that an ordinary tick takes.
    #[inline]
    pub(super) fn finds_usual<C>(
        &self,
        suspicion: &Suspicion,
        counts: i32,
        measured: &Measurement<C>,
    ) -> bool {
        let current = i32::from(measured.current) - (suspicion.offset >> 8);
        // In words: halves would have to be made of what was computed with.
        let supply = u32::from(measured.supply).wrapping_sub(self.supply_min.into());
        counts.unsigned_abs() <= self.jump
            && supply <= u32::from(self.supply_span)
            && current.unsigned_abs() <= self.calm
            && !measured.late
    }

    /// The count moved further than the axis can.
    #[inline]
    pub(super) fn jumped(&self, counts: i32) -> bool {
        counts.unsigned_abs() > self.jump
    }

    /// A tick without current: the winding cools as it does at rest while it is driven.
    #[inline]
    pub(super) fn cool(&self, suspicion: &mut Suspicion) {
        let heat = suspicion.heat - i64::from(self.rated);
        suspicion.heat = if heat > 0 { heat } else { 0 };
    }

    /// The largest |code| that does not push so hard that the axis must come on.
    pub(super) fn gentle(&self) -> i32 {
        self.frozen_code
    }

    /// Checks what was measured where it is not usual or the last command not gentle, or was so lately.
    #[inline(never)]
    pub(super) fn suspect(&self, suspicion: &mut Suspicion, read: &Readings) -> Option<Fault> {
        let last = |counter: &mut u32, wrong: bool, allowed: u32| {
            *counter = if wrong { counter.saturating_add(1) } else { 0 };
            *counter > allowed
        };
        let frozen = self.frozen(suspicion, read);
        let outside = read.supply < self.supply_min || read.supply > self.supply_max;
        let sag = last(&mut suspicion.supply, outside, self.supply_ticks);
        let overrun = last(&mut suspicion.late, read.late, self.overruns);
        let current = i32::from(read.current) - (suspicion.offset >> 8);
        // Its square fits.
        let current = current.clamp(-32_767, 32_767);
        let large = current > self.current_max || current < -self.current_max;
        let over_current = last(&mut suspicion.current, large, 1);
        let heat = suspicion.heat + i64::from(current * current - self.rated);
        suspicion.heat = if heat > 0 { heat } else { 0 };
        suspicion.any = suspicion.frozen > 0
            || suspicion.held != 0
            || suspicion.supply > 0
            || suspicion.late > 0
            || suspicion.current > 0
            || suspicion.heat > 0;
        if self.jumped(read.counts) {
            Some(Fault::EncoderJump)
        } else if frozen {
            Some(Fault::EncoderFrozen)
        } else if sag {
            Some(Fault::SupplyOutOfRange)
        } else if overrun {
            Some(Fault::Overrun)
        } else if over_current {
            Some(Fault::OverCurrent)
        } else if heat > self.overload {
            Some(Fault::Overload)
        } else {
            None
        }
    }

    /// Pushed for too long in one direction without coming on by two counts.
    ///
    /// A weight or a spring takes a push while the axis stands, so that what tells is how much more is pushed than that: than at
    /// the begin of the rest, or when the axis last gave way to the push. In motion the load that is known is kept, but that an axis
    /// which comes on shows to have at least the push less what friction may take.
    #[inline]
    fn frozen(&self, suspicion: &mut Suspicion, read: &Readings) -> bool {
        let beyond = |code: i32| code > self.frozen_code || code < -self.frozen_code;
        let forward = read.code > 0;
        let pushes = beyond(read.code);
        let turns = forward != suspicion.forward;
        if !pushes || turns {
            suspicion.forward = forward;
            suspicion.frozen = 0;
            suspicion.gained = 0;
        }
        if !pushes {
            suspicion.stood = false;
            let (low, high) = (read.code - self.frozen_code, read.code + self.frozen_code);
            let held = if suspicion.held < low {
                low
            } else if suspicion.held > high {
                high
            } else {
                suspicion.held
            };
            // A load that needs no push need not be known, and the ticks after it may be ordinary.
            let forgotten = read.stands || !beyond(held);
            suspicion.held = if forgotten { 0 } else { held };
        }
        if !pushes || turns {
            return false;
        }
        let sign = if forward { 1 } else { -1 };
        let counts = read.counts.wrapping_mul(sign);
        if read.stands && (!suspicion.stood || counts > 0) {
            suspicion.held = read.code;
        }
        suspicion.stood = read.stands;
        suspicion.gained = suspicion.gained.saturating_add(counts);
        suspicion.frozen = suspicion.frozen.saturating_add(1);
        let more = (read.code - suspicion.held).wrapping_mul(sign);
        let comes_on = suspicion.gained > 1;
        if comes_on || more <= self.frozen_code {
            suspicion.frozen = 0;
            suspicion.gained = 0;
        }
        if comes_on && more > self.frozen_code {
            suspicion.held = read.code - sign * self.frozen_code;
        }
        suspicion.frozen > self.frozen_ticks
    }

    /// Checks what the current sense reads with the bridge off.
    pub(super) fn at_rest(&self, suspicion: &Suspicion) -> Option<Fault> {
        let offset = (suspicion.offset >> 8).abs();
        (offset > self.offset).then_some(Fault::CurrentOffset)
    }

    /// Checks the position error.
    #[inline]
    #[must_use]
    pub fn followed(&self, error: S) -> Option<Fault> {
        (error.magnitude() > self.following_error).then_some(Fault::FollowingError)
    }

    /// The supply code to compute with, within what is healthy.
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
