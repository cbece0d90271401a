//! Moves, planned outside the interrupt: trapezoids of velocity in exact integer arithmetic.

use crate::param::{ParamError, at_most, positive};

/// Fraction bits of a position: 2⁻³² of a count.
const FRACTION: f64 = 4_294_967_296.0;

/// Longest move or dwell (ticks).
const LONGEST: f64 = 2_147_483_647.0;

/// Share of the acceleration that is planned with: the corners of the cruise, where integers leave something over, need the rest.
const BELOW: f64 = 1.0 - 2e-5;

/// What one count and one tick are, for planning.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Grid {
    /// One encoder count (m or rad).
    pub count: f64,
    /// `T_s` (s).
    pub sample_time: f64,
}

impl Grid {
    fn check(&self) -> Result<(), ParamError> {
        positive("length of a count", self.count)?;
        positive("sample time", self.sample_time)?;
        Ok(())
    }

    /// A length (m or rad) in 2⁻³² counts; saturates.
    pub(crate) fn length(&self, length: f64) -> i64 {
        libm::round(length / self.count * FRACTION) as i64
    }

    /// A speed (m/s or rad/s) in 2⁻³² counts per tick; saturates.
    pub(crate) fn speed(&self, speed: f64) -> i64 {
        self.length(speed * self.sample_time)
    }

    /// An acceleration (m/s² or rad/s²) in 2⁻³² counts per tick².
    pub(crate) fn acceleration(&self, acceleration: f64) -> i64 {
        self.speed(acceleration * self.sample_time)
    }
}

/// One move: ramp up, cruise, ramp down, exactly over its distance. A dwell is [`Move::dwell`].
///
/// The [reference](super::Reference) smooths it, so that its corners are not felt.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Move {
    /// 2⁻³² counts.
    pub(super) distance: i64,
    /// 2⁻³² counts per tick².
    pub(super) acceleration: i64,
    /// 2⁻³² counts per tick, and how many ticks of the cruise are one faster. Of a move that joins, the speed it begins with.
    pub(super) cruise: i64,
    pub(super) faster: u32,
    /// Ticks to the end of the ramp up, of the cruise, and of the whole.
    pub(super) ramp_end: u32,
    pub(super) cruise_end: u32,
    pub(super) end: u32,
    /// It goes on at the speed of the one before it, and ends at one ([`super::Planner::point`]).
    pub(super) joins: bool,
}

impl Move {
    /// The move that is over.
    pub(super) const NONE: Self = Self {
        distance: 0,
        acceleration: 0,
        cruise: 0,
        faster: 0,
        ramp_end: 0,
        cruise_end: 0,
        end: 0,
        joins: false,
    };

    /// It is over, as [`Move::NONE`] is; the rest is not looked at, and clearing it would be a good part of the longest tick.
    pub(super) fn end(&mut self) {
        (self.distance, self.end) = (0, 0);
    }

    /// Plans a move by `distance` (m or rad, signed) at up to `speed` (m/s) and `acceleration` (m/s²).
    ///
    /// Times are rounded up to ticks, speed and acceleration then follow from the distance and are never above what was asked.
    /// It does not know the axis's limits: [`super::Planner`] does, and [`super::Controller::start`] refuses what exceeds them.
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite or not positive, or the move takes more than 2³¹ ticks.
    pub fn plan(
        distance: f64,
        speed: f64,
        acceleration: f64,
        grid: Grid,
    ) -> Result<Self, ParamError> {
        grid.check()?;
        let Grid { count, sample_time } = grid;
        let counts = positive("distance of a move", distance.abs())? / count;
        at_most("distance of a move in counts", counts, 1e9)?;
        let per_tick = positive("speed of a move", speed)? * sample_time / count;
        let gain = positive("acceleration of a move", acceleration)?
            * (sample_time * sample_time / count * BELOW);
        let whole = at_most("ramp of a move in ticks", libm::ceil(per_tick / gain), 1e9)?;
        // A move too short for the whole ramp has as much of it as fits.
        let ramp = whole.min(libm::ceil(libm::sqrt(counts / gain))).max(1.0);
        // The cruise takes up what integers leave of the distance; an eighth of the ramp keeps that from being felt.
        let cruise = libm::ceil(counts / per_tick) - ramp;
        let cruise = cruise.max(1.0 + libm::floor(ramp / 8.0));
        at_most("length of a move in ticks", 2.0 * ramp + cruise, LONGEST)?;
        // Up and down together cover `a·n²`, the cruise `a·n·m`.
        let gain = counts / (ramp * (ramp + cruise));
        let sign = if distance < 0.0 { -1.0 } else { 1.0 };
        let acceleration = (sign * gain * FRACTION) as i64;
        let distance = libm::round(sign * counts * FRACTION) as i64;
        // Both are below 2³¹, by the checks above.
        let (ramp, ticks) = (ramp as u32, cruise as u32);
        let left = distance - acceleration * i64::from(ramp) * i64::from(ramp);
        Ok(Self {
            distance,
            acceleration,
            cruise: left.div_euclid(ticks.into()),
            faster: left.rem_euclid(ticks.into()) as u32,
            ramp_end: ramp,
            cruise_end: ramp + ticks,
            end: 2 * ramp + ticks,
            joins: false,
        })
    }

    /// Stays where it is for `time` (s).
    ///
    /// # Errors
    /// [`ParamError`] where a time is not positive or takes more than 2³¹ ticks.
    pub fn dwell(time: f64, sample_time: f64) -> Result<Self, ParamError> {
        let ticks = positive("dwell", time)? / positive("sample time", sample_time)?;
        let ticks = libm::ceil(at_most("dwell in ticks", ticks, LONGEST)?) as u32;
        Ok(Self {
            cruise_end: ticks,
            end: ticks,
            ..Self::NONE
        })
    }

    /// How many ticks it takes, before smoothing.
    #[inline]
    pub fn ticks(&self) -> u32 {
        self.end
    }

    /// The largest change of speed from tick to tick, and the largest speed (2⁻³² counts per tick).
    pub(super) fn extremes(&self) -> (u64, u64) {
        let steep = self.acceleration.unsigned_abs();
        if self.ramp_end == 0 || self.joins {
            return (steep, 0);
        }
        let top = self.acceleration * i64::from(self.ramp_end);
        let over = |cruise: i64| {
            cruise
                .abs_diff(top)
                .max(cruise.abs_diff(top - self.acceleration))
        };
        let faster = self.cruise + i64::from(self.faster > 0);
        let steepest = steep.max(over(self.cruise)).max(over(faster));
        let fastest = self.cruise.unsigned_abs().max(faster.unsigned_abs());
        (steepest, fastest.max(top.unsigned_abs()))
    }

    /// The speed of the tick, counted from 1; `last` is that of the tick before it.
    #[inline]
    pub(super) fn speed(&self, tick: u32, last: i64) -> i64 {
        if tick <= self.ramp_end {
            last.wrapping_add(self.acceleration)
        } else if tick <= self.cruise_end {
            let into = tick - self.ramp_end;
            self.cruise.wrapping_add(i64::from(into <= self.faster))
        } else {
            // A product only at the corner: the other ticks subtract.
            let last = if tick == self.cruise_end + 1 {
                self.acceleration.wrapping_mul(i64::from(self.ramp_end))
            } else {
                last
            };
            last.wrapping_sub(self.acceleration)
        }
    }

    /// After `tick` at `speed`: how many ticks differ each by the same from the one before and do not stand, and by how much.
    pub(super) fn evenly(&self, tick: u32, speed: i64) -> (u32, i64) {
        let (until, gain) = if tick <= self.ramp_end {
            (self.ramp_end, self.acceleration)
        } else if tick <= self.cruise_end {
            let slower = self.ramp_end + self.faster;
            (
                if tick <= slower {
                    slower
                } else {
                    self.cruise_end
                },
                0,
            )
        } else {
            // The last one stands.
            (self.end - 1, -self.acceleration)
        };
        let ticks = if speed == 0 {
            0
        } else {
            until.saturating_sub(tick)
        };
        (ticks, gain)
    }
}
