//! The Stribeck curve and the lag in whole numbers.

use super::product::{upper, whole};
use crate::param::{at_most, positive};
use crate::{ParamError, Sliding, Units};

/// Intervals of the table of speed; beyond the last the curves are flat.
const INTERVALS: usize = 63;

/// The threshold `σ(v)` and the lag `λ(v)` of [`Gms`](crate::Gms), by a table with linear interpolation.
#[derive(Clone, Debug, PartialEq)]
#[repr(C)]
pub(super) struct Curves {
    /// Intervals per unit of velocity, times 2³².
    per_velocity: u32,
    table: [Interval; INTERVALS + 1],
}

/// `σ` and `λ` in the middle of an interval of speed, and their differences across it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
struct Interval {
    /// In parts of `one`.
    weakening: i32,
    weakening_step: i32,
    /// Times 2³¹.
    lag: i32,
    lag_step: i32,
}

impl Curves {
    /// `breakaway` is `F_s` (N or N·m), `sample_time` is `T_s` (s), `one` stands for a threshold of 1.
    pub(super) fn try_new(
        sliding: &Sliding,
        breakaway: f64,
        sample_time: f64,
        units: Units,
        one: f64,
    ) -> Result<Self, ParamError> {
        sliding.check(breakaway)?;
        positive("sample time", sample_time)?;
        at_most("sample time", sample_time, 1.0)?;
        let end = sliding.levelled();
        let per_velocity = INTERVALS as f64 * units.velocity / end * 4_294_967_296.0;
        at_most("unit of velocity", units.velocity, end / INTERVALS as f64)?;
        let relaxation = sliding.attraction * sample_time / breakaway;
        Ok(Self {
            per_velocity: (per_velocity as u32).max(1),
            table: table(one, |place| {
                let speed = end * place as f64 / INTERVALS as f64;
                let weakening = if place < INTERVALS {
                    sliding.weakening(breakaway, speed)
                } else {
                    sliding.coulomb / breakaway
                };
                [weakening, -libm::expm1(-relaxation / weakening)]
            }),
        })
    }

    /// Intervals per unit of velocity, times 2³², and of each `σ` in its middle, its difference across, and the same of `λ`.
    pub(super) fn numbers(&self) -> (u32, impl Iterator<Item = [i32; 4]>) {
        let intervals = self.table.iter();
        let intervals = intervals.map(|i| [i.weakening, i.weakening_step, i.lag, i.lag_step]);
        (self.per_velocity, intervals)
    }

    /// `σ(v)` in parts of `one`, and `λ(v)` times 2³¹.
    #[inline]
    pub(super) fn at(&self, velocity: i32) -> (i32, i32) {
        let [interval, part] = whole(velocity.unsigned_abs(), self.per_velocity);
        let interval = &self.table[(interval as usize).min(INTERVALS)];
        // From the middle of the interval, −½ to ½ of it.
        let part = (part ^ 0x8000_0000).cast_signed();
        (
            interval.weakening + upper(interval.weakening_step, part),
            interval.lag + upper(interval.lag_step, part),
        )
    }
}

/// `functions(place)` gives `σ` and `λ` at the start of interval `place`.
fn table(one: f64, functions: impl Fn(usize) -> [f64; 2]) -> [Interval; INTERVALS + 1] {
    // λ = 1 becomes 1 − 2⁻³¹.
    let whole = |[weakening, lag]: [f64; 2]| {
        [
            libm::round(weakening * one) as i32,
            (lag * 2_147_483_648.0) as i32,
        ]
    };
    let nodes: [[i32; 2]; INTERVALS + 1] = core::array::from_fn(|place| whole(functions(place)));
    core::array::from_fn(|place| {
        let [weakening, lag] = nodes[place];
        let [next_weakening, next_lag] = nodes[(place + 1).min(INTERVALS)];
        let middle = |a: i32, b: i32| ((i64::from(a) + i64::from(b)) / 2) as i32;
        Interval {
            weakening: middle(weakening, next_weakening),
            weakening_step: next_weakening - weakening,
            lag: middle(lag, next_lag),
            lag_step: next_lag - lag,
        }
    })
}
