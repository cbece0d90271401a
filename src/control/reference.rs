//! The trajectory that the controller follows: moves with a trapezoidal velocity, in exact integer arithmetic.

use crate::param::{Bound, ParamError, at_most, positive, to_scalar};
use crate::scalar::saturated;
use crate::{Scalar, Units};

/// Fraction bits of a position: 2⁻³² of a count, ± 2³¹ counts.
const FRACTION: f64 = 4_294_967_296.0;

/// One move, planned outside the interrupt: ramp up, cruise, ramp down, exactly over its distance.
///
/// Nested triangles are moves that follow each other; a dwell is [`Move::dwell`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move<S> {
    /// 2⁻³² counts.
    distance: i64,
    /// 2⁻³² counts per tick².
    acceleration: i64,
    /// 2⁻³² counts per tick.
    cruise: i64,
    /// Ticks to the end of the ramp up, of the cruise, and of the whole.
    ramp_end: u32,
    cruise_end: u32,
    end: u32,
    /// The acceleration in velocity units per second.
    felt: S,
}

impl<S: Scalar> Move<S> {
    /// Plans a move by `distance` (m or rad, signed) at up to `speed` (m/s) and `acceleration` (m/s²).
    ///
    /// Times are rounded to ticks, speed and acceleration then follow from the distance. `count` is one encoder
    /// count (m or rad), `sample_time` is `T_s` (s).
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite or not positive, the move takes more than 2³¹ ticks, or its
    /// acceleration does not fit `S` in `units`.
    pub fn plan(
        distance: f64,
        speed: f64,
        acceleration: f64,
        count: f64,
        sample_time: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        units.check()?;
        positive("length of a count", count)?;
        positive("sample time", sample_time)?;
        let counts = positive("distance of a move", distance.abs())? / count;
        at_most("distance of a move in counts", counts, 1e9)?;
        let per_tick = positive("speed of a move", speed)? * sample_time / count;
        let gain =
            positive("acceleration of a move", acceleration)? * sample_time * sample_time / count;
        let ramp = at_most("ramp of a move in ticks", libm::ceil(per_tick / gain), 1e9)?;
        let (ramp, cruise) = if per_tick * ramp > counts {
            (libm::floor(libm::sqrt(counts / gain)), 0.0)
        } else {
            (ramp, libm::round((counts - per_tick * ramp) / per_tick))
        };
        let ramp = if ramp < 1.0 { 1.0 } else { ramp };
        at_most(
            "length of a move in ticks",
            2.0 * ramp + cruise,
            2_147_483_647.0,
        )?;
        // Up and down together cover `a·n²`, the cruise `a·n·m`.
        let gain = counts / (ramp * (ramp + cruise));
        let sign = if distance < 0.0 { -1.0 } else { 1.0 };
        let acceleration = (sign * gain * FRACTION) as i64;
        let distance = (sign * counts * FRACTION) as i64;
        let (ramp, cruise) = (ramp as i64, cruise as i64);
        // What rounding the acceleration left over is made up for by the cruise.
        let cruise_speed = if cruise > 0 {
            (distance - acceleration * ramp * ramp) / cruise
        } else {
            acceleration * ramp
        };
        Ok(Self {
            distance,
            acceleration,
            cruise: cruise_speed,
            // `2·ramp + cruise` is below 2³¹, by the check above.
            ramp_end: ramp as u32,
            cruise_end: (ramp + cruise) as u32,
            end: (2 * ramp + cruise) as u32,
            felt: to_scalar(
                "acceleration of a move",
                sign * gain * count / (sample_time * sample_time) / units.velocity,
            )?,
        })
    }

    /// Stays where it is for `time` (s).
    ///
    /// # Errors
    /// [`ParamError`] where a time is not positive or takes more than 2³¹ ticks.
    pub fn dwell(time: f64, sample_time: f64) -> Result<Self, ParamError> {
        let ticks = positive("dwell", time)? / positive("sample time", sample_time)?;
        if ticks > 2_147_483_647.0 {
            return Err(ParamError {
                parameter: "dwell in ticks",
                block: None,
                value: ticks,
                bound: Bound::AtMost(2_147_483_647.0),
            });
        }
        let ticks = libm::ceil(ticks) as u32;
        Ok(Self {
            cruise_end: ticks,
            end: ticks,
            ..Self::NONE
        })
    }

    /// The move that is over.
    const NONE: Self = Self {
        distance: 0,
        acceleration: 0,
        cruise: 0,
        ramp_end: 0,
        cruise_end: 0,
        end: 0,
        felt: S::ZERO,
    };

    /// How many ticks it takes.
    #[inline]
    pub fn ticks(&self) -> u32 {
        self.end
    }
}

/// The reference at the end of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<S> {
    /// Position (2⁻¹⁶ counts).
    pub position: i64,
    /// Travel in this tick (2⁻¹⁶ counts).
    pub displacement: i32,
    /// Acceleration (velocity units per second).
    pub acceleration: S,
}

/// Follows one move after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference<S> {
    /// 2⁻³² counts.
    position: i64,
    velocity: i64,
    target: i64,
    current: Move<S>,
    tick: u32,
}

impl<S: Scalar> Reference<S> {
    /// Stands at `count`.
    pub fn at(count: i32) -> Self {
        let position = i64::from(count) << 32;
        Self {
            position,
            velocity: 0,
            target: position,
            current: Move::NONE,
            tick: 0,
        }
    }

    /// The move is done; the next may start.
    #[inline]
    pub fn is_idle(&self) -> bool {
        self.tick >= self.current.ticks()
    }

    /// Starts a move from where the reference stands; ends a running one there, at once.
    #[inline]
    pub fn start(&mut self, next: Move<S>) {
        self.velocity = 0;
        self.tick = 0;
        self.target = self.position.wrapping_add(next.distance);
        self.current = next;
    }

    /// Advances by one tick.
    #[inline]
    pub fn step(&mut self) -> Sample<S> {
        let before = self.position >> 16;
        let mut acceleration = S::ZERO;
        if !self.is_idle() {
            let plan = &self.current;
            self.tick += 1;
            if self.tick <= plan.ramp_end {
                self.velocity = self.velocity.wrapping_add(plan.acceleration);
                acceleration = plan.felt;
            } else if self.tick <= plan.cruise_end {
                self.velocity = plan.cruise;
            } else {
                if self.tick == plan.cruise_end + 1 {
                    self.velocity = plan.acceleration.wrapping_mul(i64::from(plan.ramp_end));
                }
                self.velocity = self.velocity.wrapping_sub(plan.acceleration);
                acceleration = -plan.felt;
            }
            self.position = self.position.wrapping_add(self.velocity);
            if self.is_idle() {
                self.position = self.target;
                self.velocity = 0;
            }
        }
        let position = self.position >> 16;
        Sample {
            position,
            displacement: saturate(position.wrapping_sub(before)),
            acceleration,
        }
    }
}

/// `i64` to `i32`, at the range's ends instead of wrapping.
#[inline]
pub(crate) fn saturate(value: i64) -> i32 {
    saturated!(value, i64, i32)
}
