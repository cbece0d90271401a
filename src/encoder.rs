//! From a wrapping encoder count to displacement and velocity.

use crate::param::{ParamError, Units, at_least, positive, to_positive};
use crate::{Motion, Scalar};

/// A raw reading of a quadrature counter that wraps around.
pub trait Count: Copy {
    /// Counts travelled from `earlier` to `self`, right as long as it is less than half the counter's range.
    fn since(self, earlier: Self) -> i32;
}

impl Count for u16 {
    #[inline]
    fn since(self, earlier: Self) -> i32 {
        i32::from(self.wrapping_sub(earlier).cast_signed())
    }
}

impl Count for u32 {
    #[inline]
    fn since(self, earlier: Self) -> i32 {
        self.wrapping_sub(earlier).cast_signed()
    }
}

/// Follows a wrapping count: displacement per tick, and the position that the counter itself cannot hold.
///
/// ```
/// use preslide::CountTracker;
/// let mut tracker = CountTracker::new(65_530_u16);
/// assert_eq!(tracker.update(4), 10); // over the wrap
/// assert_eq!(tracker.position(), 10);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct CountTracker<C> {
    last: C,
    position: i64,
}

impl<C: Count> CountTracker<C> {
    /// Starts at position 0 with the reading `first`.
    pub fn new(first: C) -> Self {
        Self {
            last: first,
            position: 0,
        }
    }

    /// Takes a reading; returns the counts travelled since the previous one.
    #[inline]
    pub fn update(&mut self, reading: C) -> i32 {
        let travelled = reading.since(self.last);
        self.last = reading;
        self.position = self.position.wrapping_add(i64::from(travelled));
        travelled
    }

    /// Counts from the first reading.
    #[inline]
    pub fn position(&self) -> i64 {
        self.position
    }
}

/// Scales counts per tick to a [`Motion`], with a velocity from the time between edges.
///
/// Counting edges per tick fails at low speed (one 25 nm count in a 50 µs tick reads as 0.5 mm/s), timing single
/// edges fails at high speed. This does both: the travel between two edges at least `window` ticks apart,
/// divided by the ticks between them. Between edges the estimate falls as `one count / time since the last edge`,
/// because a faster motion would have produced an edge by now, and is 0 after `timeout`. An edge in the
/// opposite direction reads as 0 and starts the timing anew.
///
/// At a constant speed the relative error is at most one tick in the time between the edges used. The delay
/// is half of `window`, or half an edge interval where that is longer.
#[derive(Clone, Debug)]
pub struct EncoderScale<S = f32> {
    length: S,
    velocity_per_tick: f32,
    window: u32,
    timeout: u32,
}

/// What [`EncoderScale`] remembers.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeTiming {
    /// Ticks since the edge that the present timing starts from.
    ticks: u32,
    /// The same at the last edge.
    ticks_to_edge: u32,
    /// Counts travelled since the edge that the timing starts from.
    travelled: i32,
    /// Sign of the last edge.
    direction: i32,
    /// Counts per tick.
    estimate: f32,
}

impl<S: Scalar> EncoderScale<S> {
    /// `count` is the length of one count (m or rad), `sample_time` is `T_s` (s), `window` the shortest time
    /// (s) over which velocity is measured, `timeout` the time (s) without an edge that counts as standstill.
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite or not positive, `timeout` is shorter than `window`, or one
    /// count does not fit `S` in `units`, or one count per tick `f32`.
    pub fn try_new(
        count: f64,
        sample_time: f64,
        window: f64,
        timeout: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        units.check()?;
        positive("length of a count", count)?;
        positive("sample time", sample_time)?;
        positive("velocity window", window)?;
        positive("velocity timeout", timeout)?;
        at_least("velocity timeout", timeout, window)?;
        // Saturating casts: a window of more ticks than `u32` holds is as good as endless.
        let ticks = |time: f64| (libm::ceil(time / sample_time) as u32).max(1);
        Ok(Self {
            length: to_positive("length of a count", count / units.length)?,
            velocity_per_tick: to_positive("count per tick", count / sample_time / units.velocity)?,
            window: ticks(window),
            timeout: ticks(timeout),
        })
    }

    /// The state of a motion that stands still.
    pub fn at_rest(&self) -> EdgeTiming {
        EdgeTiming {
            ticks: 0,
            ticks_to_edge: 0,
            travelled: 0,
            direction: 0,
            estimate: 0.0,
        }
    }

    /// The motion of a tick in which the encoder travelled `counts`. Divides by a measured time, once.
    #[inline]
    pub fn step(&self, state: &mut EdgeTiming, counts: i32) -> Motion<S> {
        state.ticks = state.ticks.saturating_add(1);
        if counts != 0 {
            if counts.signum() != state.direction {
                let from_rest = state.direction == 0;
                state.direction = counts.signum();
                state.travelled = 0;
                if !from_rest {
                    state.estimate = 0.0;
                    state.ticks = 0;
                }
            }
            if state.ticks > 0 {
                state.travelled = state.travelled.saturating_add(counts);
            }
            state.ticks_to_edge = state.ticks;
            if state.ticks >= self.window {
                state.estimate = state.travelled as f32 / state.ticks as f32;
                state.ticks = 0;
                state.ticks_to_edge = 0;
                state.travelled = 0;
            }
        }
        let quiet = state.ticks - state.ticks_to_edge;
        if quiet >= self.timeout {
            state.estimate = 0.0;
            state.direction = 0;
        } else if quiet > 0 {
            let fastest = 1.0 / quiet as f32;
            state.estimate = state.estimate.limited(fastest);
        }
        Motion {
            displacement: self.length.mul_input(S::from_int(counts)),
            velocity: S::from_f32(state.estimate * self.velocity_per_tick),
        }
    }
}
