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
    #[must_use = "counts that are dropped are travel that no model sees"]
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

/// Edges that a window begins at, at most; the ring has room for one that is older.
const ANCHORS: u32 = 32;

/// Scales counts per tick to a [`Motion`], with a velocity from the time between edges.
///
/// Counting edges per tick fails at low speed (one 25 nm count in a 50 µs tick reads as 0.5 mm/s), timing single
/// edges fails at high speed. This does both: the travel from an edge at least `window` ticks ago to the last one,
/// divided by the ticks between them. The window slides: it begins at the latest of the remembered edges that is old enough, and
/// they are remembered, and the estimate made anew, a thirtieth of it apart, at least two ticks. Between edges the estimate falls as `one count / time since the last edge`,
/// because a faster motion would have produced an edge by now, and is 0 after `timeout`. An edge in the
/// opposite direction reads as 0 and starts the timing anew.
///
/// At a constant speed the relative error is at most one tick in the time between the edges used. Where edges come ten times as fast
/// as windows, the delay is half the window and most of the distance of the remembered edges: at most 0.55 windows in the mean for
/// one of 20 ticks or more (asserted by a test). Where they come more slowly, it is between half an interval and one and a half.
#[derive(Clone, Copy, Debug)]
pub struct EncoderScale<S = f32> {
    length: S,
    /// Of one count per tick.
    velocity: S,
    window: u32,
    spacing: u32,
    timeout: u32,
}

/// What [`EncoderScale`] remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EdgeTiming<S = f32> {
    /// Ticks, and counts of the last edge; both wrap.
    now: u32,
    count: i32,
    last_edge: u32,
    /// Sign of the last edge, 0 at rest.
    direction: i32,
    /// Remembered edges: their ticks and counts, a ring from `oldest` to `newest`.
    anchors: [(u32, i32); ANCHORS as usize],
    oldest: u32,
    newest: u32,
    velocity: S,
}

impl<S: Scalar> EdgeTiming<S> {
    #[inline]
    fn anchor(&self, place: u32) -> (u32, i32) {
        self.anchors[(place % ANCHORS) as usize]
    }

    #[inline]
    fn age(&self, place: u32) -> u32 {
        self.now.wrapping_sub(self.anchor(place).0)
    }

    fn remember(&mut self) {
        self.newest = self.newest.wrapping_add(1);
        self.anchors[(self.newest % ANCHORS) as usize] = (self.now, self.count);
    }

    /// An edge after `counts`: the estimate, by the latest window that is long enough.
    #[inline]
    fn edge(&mut self, counts: i32, scale: &EncoderScale<S>) {
        self.count = self.count.wrapping_add(counts);
        self.last_edge = self.now;
        if counts.signum() != self.direction {
            self.direction = counts.signum();
            self.velocity = S::ZERO;
            self.remember();
            self.oldest = self.newest;
            return;
        }
        if self.age(self.newest) < scale.spacing {
            return;
        }
        // Twice: edges that come in every tick need one step a spacing.
        for _ in 0..2 {
            if self.oldest != self.newest && self.age(self.oldest.wrapping_add(1)) >= scale.window {
                self.oldest = self.oldest.wrapping_add(1);
            }
        }
        let (tick, count) = self.anchor(self.oldest);
        let ticks = self.now.wrapping_sub(tick);
        if ticks >= scale.window {
            self.velocity = scale.velocity.rate(self.count.wrapping_sub(count), ticks);
        }
        if self.newest.wrapping_sub(self.oldest) == ANCHORS - 1 {
            self.oldest = self.oldest.wrapping_add(1);
        }
        self.remember();
    }
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
        // Saturating casts: a window of more ticks than `u32` holds is as good as endless. The part of a tick that a division
        // leaves is none.
        let ticks = |time: f64| (libm::ceil(time / sample_time - 1e-9) as u32).max(1);
        Ok(Self {
            length: to_positive("length of a count", count / units.length)?,
            velocity: to_positive("count per tick", count / sample_time / units.velocity)?,
            window: ticks(window),
            spacing: ticks(window).div_ceil(ANCHORS - 2).max(2),
            timeout: ticks(timeout),
        })
    }

    /// By how many ticks the velocity is behind the last displacement of a tick, in the mean, where edges come in every tick: half the
    /// travel's time and what the estimate ages until the next, less the half tick by which that displacement is behind itself.
    pub fn delay(&self) -> f64 {
        let spacing = f64::from(self.spacing);
        let window = libm::ceil(f64::from(self.window) / spacing) * spacing;
        (window + spacing - 2.0) / 2.0
    }

    /// The state of a motion that stands still.
    pub fn at_rest(&self) -> EdgeTiming<S> {
        EdgeTiming {
            now: 0,
            count: 0,
            last_edge: 0,
            direction: 0,
            anchors: [(0, 0); ANCHORS as usize],
            oldest: 0,
            newest: 0,
            velocity: S::ZERO,
        }
    }

    /// The motion of a tick in which the encoder travelled `counts`. Divides by a measured time, at most once.
    #[inline]
    pub fn step(&self, state: &mut EdgeTiming<S>, counts: i32) -> Motion<S> {
        Motion {
            velocity: self.velocity(state, counts),
            displacement: self.displacement(counts),
        }
    }

    /// The displacement of [`EncoderScale::step`].
    #[inline]
    pub(crate) fn displacement(&self, counts: i32) -> S {
        self.length.mul_input(S::from_int(counts))
    }

    /// The velocity of [`EncoderScale::step`], which is to be asked for in every tick.
    #[inline(always)]
    pub(crate) fn velocity(&self, state: &mut EdgeTiming<S>, counts: i32) -> S {
        state.now = state.now.wrapping_add(1);
        if counts != 0 {
            state.edge(counts, self);
        } else if state.direction != 0 {
            let quiet = state.now.wrapping_sub(state.last_edge);
            if quiet >= self.timeout {
                state.velocity = S::ZERO;
                state.direction = 0;
            } else {
                state.velocity = state.velocity.decayed(self.velocity, quiet);
            }
        }
        state.velocity
    }
}

/// A count in the turn, which is passed in one tick at most once.
#[inline]
pub(crate) fn within(count: i32, turn: i32) -> i32 {
    if count < 0 {
        count.wrapping_add(turn)
    } else if count >= turn {
        count.wrapping_sub(turn)
    } else {
        count
    }
}

/// A position in the turn, of at most 2³⁰ counts: `position.rem_euclid(turn)`, bit by bit. The division of 64 bits that only this would need is
/// a kilobyte of code, which some boards keep in the memory that they have for the control task.
pub(crate) fn in_turn(position: i64, turn: i32) -> i32 {
    let (mut bits, turn) = (position.unsigned_abs(), turn.cast_unsigned());
    let mut rest = 0_u32;
    for _ in 0..64 {
        rest = rest << 1 | (bits >> 63) as u32;
        bits <<= 1;
        if rest >= turn {
            rest -= turn;
        }
    }
    let rest = match position < 0 && rest > 0 {
        true => turn - rest,
        false => rest,
    };
    rest.cast_signed()
}

#[cfg(test)]
mod tests {
    use super::in_turn;

    #[test]
    fn a_place_in_the_turn_is_the_remainder() {
        let mut seed = 1_u64;
        for _ in 0..200_000 {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(99);
            let position = seed.cast_signed() >> (seed % 63);
            let turn = 2 + (seed >> 20) as i32 % 999_999_999_i32;
            let turn = turn.unsigned_abs().max(2).cast_signed();
            assert_eq!(
                i64::from(in_turn(position, turn)),
                position.rem_euclid(turn.into())
            );
        }
        assert_eq!(in_turn(i64::MIN, 1_000_000_000), 145_224_192);
    }
}
