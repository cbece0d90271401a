//! What a host asks for, checked against the axis's limits before it is queued.

use super::reference::Jog;
use super::{Axis, Grid, Limits, Move};
use crate::param::{ParamError, at_least, at_most};

/// Plans moves within the axis's [`Limits`], and knows where the last one ends. It runs below the interrupt.
///
/// ```
/// use preslide::control::{Axis, Planner};
/// let mut planner = Planner::try_new(&Axis::PAPER_AXIS)?;
/// planner.stands(0, true);
/// let there = planner.to(1e-3, 5e-3, 0.5)?;
/// assert!(planner.to(13e-3, 5e-3, 0.5).is_err(), "the travel ends at 12.5 mm");
/// let back = planner.by(-1e-3, 5e-3, 0.5)?;
/// assert_eq!(planner.end(), 0.0);
/// # let _ = (there, back);
/// # Ok::<(), preslide::ParamError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Planner {
    grid: Grid,
    limits: Limits,
    /// Where the last move ends (2⁻³² counts), and at what speed (per tick).
    end: i64,
    speed: i64,
    /// The last point of a stream (2⁻³² counts), and the ticks that it took.
    point: i64,
    ticks: u32,
    located: bool,
}

impl Planner {
    /// For an axis that stands at 0 and does not know where that is.
    ///
    /// # Errors
    /// [`ParamError`] where a limit, the count or the rate cannot be.
    pub fn try_new(axis: &Axis) -> Result<Self, ParamError> {
        axis.check()?;
        Ok(Self {
            grid: axis.grid(),
            limits: axis.limits,
            end: 0,
            speed: 0,
            point: 0,
            ticks: 0,
            located: false,
        })
    }

    /// The axis stands at `count`, with nothing queued: after enabling, a stop or a fault. `located`: counted from its origin, so
    /// that the travel ends where the axis's limits say.
    pub fn stands(&mut self, count: i64, located: bool) {
        self.end = count.wrapping_shl(32);
        self.speed = 0;
        self.point = self.end;
        self.located = located;
    }

    /// Where the last move that was planned ends (m or rad).
    pub fn end(&self) -> f64 {
        self.metres(self.end)
    }

    /// Plans a move by `distance` (m or rad, signed) at up to `speed` and `acceleration` (SI).
    ///
    /// # Errors
    /// [`ParamError`] naming what exceeds its limit, or is not a number; nothing is planned then.
    pub fn by(&mut self, distance: f64, speed: f64, acceleration: f64) -> Result<Move, ParamError> {
        at_most("speed of a move", speed, self.limits.speed)?;
        at_most(
            "acceleration of a move",
            acceleration,
            self.limits.acceleration,
        )?;
        self.within("end of a move", self.end() + distance)?;
        let planned = Move::plan(distance, speed, acceleration, self.grid)?;
        self.end = self.end.wrapping_add(planned.distance);
        self.point = self.end;
        Ok(planned)
    }

    /// Plans a move to `position` (m or rad) at up to `speed` and `acceleration` (SI).
    ///
    /// # Errors
    /// As [`Planner::by`]; a move to where the axis already is has no distance and is refused.
    pub fn to(&mut self, position: f64, speed: f64, acceleration: f64) -> Result<Move, ParamError> {
        self.by(position - self.end(), speed, acceleration)
    }

    /// Plans a rest of `time` (s).
    ///
    /// # Errors
    /// [`ParamError`] where it is not positive or takes more than 2³¹ ticks.
    pub fn dwell(&mut self, time: f64) -> Result<Move, ParamError> {
        Move::dwell(time, self.grid.sample_time)
    }

    /// A speed (m/s or rad/s, signed) to keep until the next stop or the end of travel. Call [`Planner::stands`] afterwards.
    ///
    /// # Errors
    /// [`ParamError`] where it exceeds its limit or is not a number.
    pub fn jog(&self, speed: f64) -> Result<Jog, ParamError> {
        at_most("speed of a jog", speed.abs(), self.limits.speed)?;
        Ok(Jog {
            speed: self.grid.speed(speed),
        })
    }

    /// Plans the motion towards the next point of a stream, `position` (m or rad), which takes `ticks`.
    ///
    /// Speed is linear between the middles of two points, so the path is a quadratic spline that they control: it passes half way
    /// between one and the next. The first point follows from where the axis stands; a stream ends at rest where its last point
    /// is sent twice; all its points take as many ticks. One that runs dry is braked, and must begin anew.
    ///
    /// # Errors
    /// [`ParamError`] naming what exceeds its limit; nothing is planned then.
    pub fn point(&mut self, position: f64, ticks: u32) -> Result<Move, ParamError> {
        let length = i64::from(ticks);
        at_least("ticks of a point", ticks.into(), 1.0)?;
        at_most("ticks of a point", ticks.into(), 65_536.0)?;
        if self.speed != 0 {
            // Else it would not pass half way, and the stream would end elsewhere.
            at_least(
                "ticks of a point in a stream",
                ticks.into(),
                self.ticks.into(),
            )?;
            at_most(
                "ticks of a point in a stream",
                ticks.into(),
                self.ticks.into(),
            )?;
        }
        self.within("point of a stream", position)?;
        let point = self.grid.length(position);
        let wanted = point.wrapping_sub(self.point) / length;
        let per_second = 1.0 / self.grid.sample_time;
        let speed = self.metres(wanted) * per_second;
        at_most("speed of a stream", speed.abs(), self.limits.speed)?;
        let acceleration = (wanted - self.speed) / length;
        let asked = self.metres(acceleration) * per_second * per_second;
        at_most(
            "acceleration of a stream",
            asked.abs(),
            self.limits.acceleration,
        )?;
        let distance = self.speed * length + acceleration * (length * (length + 1) / 2);
        let planned = Move {
            distance,
            acceleration,
            cruise: self.speed,
            ramp_end: ticks,
            cruise_end: ticks,
            end: ticks,
            joins: true,
            ..Move::NONE
        };
        self.end = self.end.wrapping_add(distance);
        self.speed += acceleration * length;
        self.point = point;
        self.ticks = ticks;
        Ok(planned)
    }

    fn metres(&self, length: i64) -> f64 {
        length as f64 / 4_294_967_296.0 * self.grid.count
    }

    fn within(&self, name: &'static str, position: f64) -> Result<(), ParamError> {
        // Comparisons that a NaN fails.
        let (low, high) = match self.limits.travel {
            Some(ends) if self.located => ends,
            _ => (-f64::MAX, f64::MAX),
        };
        at_least(name, position, low)?;
        at_most(name, position, high)?;
        Ok(())
    }
}
