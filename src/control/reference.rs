//! The trajectory that the controller follows: moves, jogs and stops with limited acceleration, smoothed to limited jerk.

use super::smoothing::Smoothing;
use super::{Grid, Limits, MOST_SMOOTHED, Move};
use crate::param::{ParamError, at_least, at_most};
use crate::scalar::saturated;

/// [`Limits`] in counts and ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// 2⁻³² counts per tick, and per tick².
    speed: i64,
    brake: i64,
    /// Counts of braking per squared speed in 2⁻¹⁶ counts per tick.
    per_brake: f32,
    /// 2⁻³² counts.
    travel: Option<(i64, i64)>,
    /// The smoothing takes `2^bits` ticks.
    bits: u32,
}

impl Pace {
    pub(crate) fn try_new(limits: &Limits, grid: Grid) -> Result<Self, ParamError> {
        limits.check()?;
        let brake = grid.acceleration(limits.acceleration);
        at_least(
            "acceleration limit in 2⁻³² counts per tick²",
            brake as f64,
            1.0,
        )?;
        at_most(
            "speed limit in counts per tick",
            limits.speed * grid.sample_time / grid.count,
            8192.0,
        )?;
        let ticks = 2.0 * limits.acceleration / limits.jerk / grid.sample_time;
        at_most(
            "smoothing in ticks, 2·acceleration/jerk,",
            ticks,
            MOST_SMOOTHED.into(),
        )?;
        // Two ticks at least: what shifts by it counts on one bit.
        let bits = (libm::ceil(ticks) as u32)
            .max(2)
            .next_power_of_two()
            .trailing_zeros();
        if let Some((low, high)) = limits.travel {
            for end in [low, high] {
                at_most("end of travel in counts", end.abs() / grid.count, 1e9)?;
            }
        }
        Ok(Self {
            speed: grid.speed(limits.speed),
            brake,
            // A millionth more than needed makes up for single precision.
            per_brake: (1.000_001 / (2.0 * brake as f64)) as f32,
            travel: limits
                .travel
                .map(|(low, high)| (grid.length(low), grid.length(high))),
            bits,
        })
    }

    /// Ticks of the smoothing: half of them is how far the reference lags behind what was planned.
    pub fn smoothing(&self) -> u32 {
        1 << self.bits
    }
}

/// Why a move is not started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Refused {
    /// The axis is not enabled.
    NotEnabled,
    /// It is faster than [`Limits::speed`].
    TooFast,
    /// It is steeper than [`Limits::acceleration`].
    TooSteep,
    /// It ends beyond [`Limits::travel`].
    BeyondTravel,
    /// It is to join a motion that has ended: the stream of points ran dry or was stopped.
    Broken,
    /// The host has been silent for longer than [`super::Axis::silence`].
    Silence,
}

/// The reference at the end of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sample {
    /// Position (2⁻³² counts), which wraps after 2³² counts.
    pub position: i64,
    /// Travel in this tick (2⁻¹⁶ counts).
    pub displacement: i32,
    /// Its change (2⁻¹⁶ counts per tick²), times [`Pace::smoothing`].
    pub change: i32,
}

/// A speed to keep ([`super::Planner::jog`]).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Jog {
    /// 2⁻³² counts per tick.
    pub(super) speed: i64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    /// Follows the plan.
    Planned,
    /// Goes over to this speed and keeps it.
    Jog(i64),
    /// Brakes, then follows the plan.
    Brake,
}

/// Follows one move after the other, jogs, and stops from anywhere.
///
/// A generator keeps acceleration within [`Limits::acceleration`] from one tick to the next, in exact integers; a moving average
/// over `2·acceleration/jerk` then keeps the jerk. Both keep speed and travel. Positions wrap, so an axis may turn without end.
#[derive(Clone, Debug, PartialEq)]
#[repr(C)]
pub struct Reference {
    /// So many ticks from here on are each faster by `gain` than the one before, and none stands; and how many they were at first.
    even: u32,
    run: u32,
    /// Both [lifted](Smoothing::lift), as the smoothing takes them.
    speed: i64,
    gain: i64,
    position: i64,
    /// What is planned, before smoothing (2⁻³² counts), without the even ticks since ([`Reference::settle`]).
    planned: i64,
    mode: Mode,
    plan: Move,
    /// Ticks of the plan that are done, or follow from the tick before by `gain`.
    tick: u32,
    /// The ends of travel are known.
    located: bool,
    smoothing: Smoothing,
}

impl Reference {
    /// Stands at `count`.
    pub fn at(count: i64, pace: &Pace) -> Self {
        let position = count.wrapping_shl(32);
        Self {
            even: 0,
            run: 0,
            speed: 0,
            gain: 0,
            position,
            planned: position,
            mode: Mode::Planned,
            plan: Move::NONE,
            tick: 0,
            located: false,
            smoothing: Smoothing::at_rest(pace.bits),
        }
    }

    /// Stands at `count`, in place.
    pub(super) fn stand(&mut self, count: i64, pace: &Pace) {
        self.drop_plan();
        self.planned = count.wrapping_shl(32);
        self.speed = 0;
        self.mode = Mode::Planned;
        self.position = self.planned;
        self.smoothing.rest(pace.bits);
    }

    /// Becomes as another one, in place: an eighth of a copy where the smoothing is as short.
    pub(super) fn become_as(&mut self, other: &Self) {
        (self.even, self.run) = (other.even, other.run);
        (self.speed, self.gain) = (other.speed, other.gain);
        (self.position, self.planned) = (other.position, other.planned);
        (self.mode, self.plan, self.tick) = (other.mode, other.plan, other.tick);
        self.located = other.located;
        self.smoothing.become_as(&other.smoothing);
    }

    /// The ends of travel (2⁻³² counts), where they are known.
    pub(super) fn ends(&self, pace: &Pace) -> Option<(i64, i64)> {
        pace.travel.filter(|_| self.located)
    }

    /// What is followed, or was last.
    pub(super) fn plan(&self) -> &Move {
        &self.plan
    }

    /// What was planned ends in motion: a stream of points that goes on where more is known.
    pub(super) fn is_open(&self) -> bool {
        self.speed != 0 && self.is_idle()
    }

    /// The next move may start: the one before it is done, but for what the smoothing still has to let out.
    #[inline]
    pub fn is_idle(&self) -> bool {
        self.mode == Mode::Planned && self.even == 0 && self.tick >= self.plan.end
    }

    /// It stands still.
    #[inline]
    pub fn is_standing(&self) -> bool {
        self.smoothing.left == 0 && self.is_idle()
    }

    /// It did not move in the last tick.
    #[inline]
    pub(super) fn is_at_rest(&self) -> bool {
        self.smoothing.is_at_rest()
    }

    /// Position (2⁻³² counts), which wraps after 2³² counts.
    #[inline]
    pub(super) fn position(&self) -> i64 {
        self.position
    }

    /// Whether travel is limited from here on, `position` being counted from the axis's origin.
    pub fn locate(&mut self, located: bool) {
        self.located = located;
    }

    /// Calls the present place another one, `by` counts further.
    pub(super) fn shift(&mut self, by: i64) {
        self.planned = self.planned.wrapping_add(by.wrapping_shl(32));
        self.position = self.position.wrapping_add(by.wrapping_shl(32));
    }

    /// Starts a move from where the plan stands. One that runs is stopped first, the new one begins at rest.
    ///
    /// # Errors
    /// [`Refused`] where it exceeds the limits; nothing changes then.
    #[inline(never)]
    pub fn start(&mut self, next: Move, pace: &Pace) -> Result<(), Refused> {
        let (steepest, fastest) = next.extremes();
        if steepest > pace.brake.unsigned_abs() + 1 {
            return Err(Refused::TooSteep);
        }
        if fastest > pace.speed.unsigned_abs() + 1 {
            return Err(Refused::TooFast);
        }
        self.settle();
        let stands = self.speed == 0 && self.is_idle();
        // A joined move keeps in `cruise` the speed that it begins with.
        if next.joins && !(self.is_idle() && self.speed() == next.cruise) {
            return Err(Refused::Broken);
        }
        if (stands || next.joins) && self.leaves(&next, pace) {
            return Err(Refused::BeyondTravel);
        }
        self.plan = next;
        self.tick = 0;
        self.uneven();
        if !(stands || next.joins) {
            self.mode = Mode::Brake;
        }
        Ok(())
    }

    /// Goes on at a speed until it is told otherwise or the travel ends; what was planned is dropped.
    pub fn jog(&mut self, jog: Jog, pace: &Pace) {
        self.drop_plan();
        self.mode = Mode::Jog(bounded(jog.speed, pace.speed));
    }

    /// Brakes to rest by [`Limits::acceleration`]; what was planned is dropped.
    #[inline(never)]
    pub fn stop(&mut self) {
        self.drop_plan();
        self.mode = Mode::Brake;
    }

    fn drop_plan(&mut self) {
        self.settle();
        self.plan.end();
        self.tick = 0;
        self.uneven();
    }

    fn uneven(&mut self) {
        self.even = 0;
        self.run = 0;
    }

    /// The speed before smoothing (2⁻³² counts per tick).
    pub(super) fn speed(&self) -> i64 {
        self.speed >> self.smoothing.lift()
    }

    /// Adds the even ticks since the last time to what is planned: `Σ (v − i·g)` over `i = 0 … n − 1`, `v` being the speed now. An even
    /// tick need not keep it.
    fn settle(&mut self) {
        let ticks = i64::from(self.run - self.even);
        self.run = self.even;
        let gain = self.gain >> self.smoothing.lift();
        let slower = gain.wrapping_mul(ticks * (ticks - 1) / 2);
        let travel = self.speed().wrapping_mul(ticks).wrapping_sub(slower);
        self.planned = self.planned.wrapping_add(travel);
    }

    /// The move would end beyond the ends of travel.
    fn leaves(&self, next: &Move, pace: &Pace) -> bool {
        let end = self.planned.wrapping_add(next.distance);
        let beyond = |(low, high): (i64, i64)| end < low || end > high;
        self.located && next.distance != 0 && pace.travel.is_some_and(beyond)
    }

    /// Advances by one tick.
    #[inline]
    pub fn step(&mut self, pace: &Pace) -> Sample {
        if self.is_even() {
            return self.step_evenly();
        }
        self.turn(pace);
        self.go_on()
    }

    /// The next tick follows evenly from the last one.
    #[inline]
    pub(super) fn is_even(&self) -> bool {
        self.even > 0
    }

    /// [`Reference::step`] where [`Reference::is_even`].
    #[inline]
    pub(super) fn step_evenly(&mut self) -> Sample {
        self.even = self.even.wrapping_sub(1);
        self.speed = self.speed.wrapping_add(self.gain);
        self.go_on()
    }

    /// A tick at the speed.
    #[inline]
    fn go_on(&mut self) -> Sample {
        let before = (self.position >> 16) as i32;
        let (speed, change) = self.smoothing.step(self.speed);
        self.position = self.position.wrapping_add(speed);
        Sample {
            position: self.position,
            // Below 2¹³ counts, by the check of the speed limit.
            displacement: ((self.position >> 16) as i32).wrapping_sub(before),
            change,
        }
    }

    /// A tick that does not follow evenly from the one before.
    #[inline(never)]
    fn turn(&mut self, pace: &Pace) {
        self.settle();
        let most = self.smoothing.clear_ahead().unwrap_or(u32::MAX);
        let speed = self.next_speed(pace, most - 1);
        self.smoothing.note(speed);
        self.run = self.even;
        self.speed = speed << self.smoothing.lift();
        self.planned = self.planned.wrapping_add(speed);
    }

    /// The speed of this tick; at most `even` ticks follow evenly from it.
    fn next_speed(&mut self, pace: &Pace, even: u32) -> i64 {
        let speed = match self.mode {
            Mode::Planned if self.tick < self.plan.end => {
                self.tick += 1;
                let speed = self.plan.speed(self.tick, self.speed());
                if !self.plan.joins {
                    let (ticks, gain) = self.plan.evenly(self.tick, speed);
                    self.gain = gain << self.smoothing.lift();
                    self.even = ticks.min(even);
                    self.tick += self.even;
                    return speed;
                }
                bounded(speed, pace.speed)
            }
            // Nothing follows what should have been joined to.
            Mode::Planned if self.speed == 0 => return 0,
            Mode::Brake => return self.brake(pace),
            Mode::Planned => approach(self.speed(), 0, pace.brake),
            Mode::Jog(speed) => approach(self.speed(), speed, pace.brake),
        };
        if self.must_brake(speed, pace) {
            self.stop();
            return self.brake(pace);
        }
        speed
    }

    #[inline(never)]
    fn brake(&mut self, pace: &Pace) -> i64 {
        let speed = approach(self.speed(), 0, pace.brake);
        if speed == 0 {
            self.mode = Mode::Planned;
            // A move that waited may not fit from where it now begins.
            if self.leaves(&self.plan, pace) {
                self.drop_plan();
            }
        }
        speed
    }

    /// At `speed`, the rest of the way to the end of travel is no more than braking takes.
    ///
    /// Braking by `b` from `v` covers `v²/(2·b) − v/2` and at most `b/8` more; the tick at `v` itself covers `v`.
    #[inline(never)]
    fn must_brake(&self, speed: i64, pace: &Pace) -> bool {
        let Some((low, high)) = pace.travel else {
            return false;
        };
        if !self.located || speed == 0 {
            return false;
        }
        let ahead = if speed > 0 {
            high.wrapping_sub(self.planned)
        } else {
            self.planned.wrapping_sub(low)
        };
        let ahead = (ahead >> 32) as i32;
        let speed = saturate(speed >> 16) as f32;
        let braking = speed * speed * pace.per_brake + speed.abs() * (1.0 / 65536.0);
        // Two counts for what was rounded.
        ahead as f32 - 2.0 <= braking
    }
}

/// `from` moved towards `to` by at most `step`.
#[inline]
fn approach(from: i64, to: i64, step: i64) -> i64 {
    from.wrapping_add(bounded(to.wrapping_sub(from), step))
}

/// `value` within ± `bound`. `clamp` would link a panic.
#[inline]
fn bounded(value: i64, bound: i64) -> i64 {
    if value > bound {
        bound
    } else if value < -bound {
        -bound
    } else {
        value
    }
}

/// `i64` to `i32`, at the range's ends instead of wrapping.
#[inline]
pub(crate) fn saturate(value: i64) -> i32 {
    saturated!(value, i64, i32)
}
