//! A delay between effort and position as what it is, a shift: the first term of its series, which stands in every hypothesis, does not do where
//! the delay is as long as what the motion changes in.

use super::effect::{constant_force::ConstantForce, viscous::Viscous};
use super::evidence::{Evidence, evidence};
use super::ground::Ground;
use super::normal::{Bound, Normal};
use super::term::{Subject, Term};
use super::weak::Column;
use crate::recording::Recording;
use crate::statistics::{Estimate, LeastSquares};
use std::ops::Range;

/// Longest shift that is looked for (s).
const LONGEST_S: f64 = 0.06;
/// Places of a first look to each side.
const PLACES: usize = 20;
/// Samples up to which the first term of the series does.
const SHORT: f64 = 2.0;
/// Share of what the first term leaves that the shift must take off, and standard errors: an elastic drive looks a little like one, too.
const TAKES: f64 = 0.25;
/// Standard errors that a delay or an end must be beyond nothing.
pub const SURE: f64 = 3.0;
/// Steps of the search between two places of the first look.
const STEPS: usize = 12;

/// A shift that the recording asks for.
pub struct Shift {
    /// How much later the effort is than the position that it goes with (s).
    pub delay: Estimate,
    /// What it is worth beyond nothing.
    pub evidence: Evidence,
    /// Held-out NMSE (%) without and with it.
    pub nmse: [f64; 2],
    /// What it changes, at the rows (N or N·m).
    pub force: Vec<f64>,
}

impl Shift {
    /// The shift of a recording; `None` where the first term of the series does as well.
    pub fn of(ground: &Ground, recording: &Recording) -> Option<Self> {
        let rows = &ground.rows;
        let (columns, bounds) = columns(ground);
        let all: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let fast = LeastSquares::of(&all)?;
        let shifted = |delay: f64| rows.weak.rows(&Column::of(earlier(recording, delay)));
        let left = |delay: f64| fast.squares_left(&shifted(delay));
        let delay = least(left, recording.sample_time_s())?;
        if delay.abs() <= SHORT * recording.sample_time_s() {
            return None;
        }
        let white = ground.unweighted();
        let folds = &rows.weak.folds;
        let fit = |more: &[f64], target: &[f64]| {
            let all: Vec<&[f64]> = all.iter().copied().chain([more]).collect();
            let bounds: Vec<Bound> = bounds.iter().copied().chain([Bound::Free]).collect();
            let fit = Normal::new(&white, folds, &all, &bounds, target)?;
            let left = fit.held_out_residual(&all, target);
            Some((fit, left))
        };
        let slope = |effort: Vec<f64>| {
            rows.weak.rows(&Column {
                sloped: effort,
                ..Column::default()
            })
        };
        let target = shifted(delay);
        let (_, first_term) = fit(&slope(recording.effort.clone()), &rows.force)?;
        let (with, left_with) = fit(&slope(earlier(recording, delay)), &target)?;
        let without = Normal::new(&white, folds, &all, &bounds, &rows.force)?;
        let left_without = without.held_out_residual(&all, &rows.force);
        let difference = |from: &[f64]| -> Vec<f64> {
            from.iter().zip(&left_with).map(|(a, b)| a - b).collect()
        };
        let beyond = evidence(&difference(&first_term), &first_term, &rows.blocks);
        if beyond.share < TAKES || beyond.z < SURE {
            return None;
        }
        let mut block_of = vec![0; rows.force.len()];
        for (b, own) in rows.blocks.iter().enumerate() {
            block_of[own.clone()].fill(b);
        }
        let error = with.errors(&block_of).last().copied().flatten();
        let force = difference(&left_without);
        Some(Self {
            delay: Estimate::new(delay, error, folds.len()),
            evidence: evidence(&force, &left_without, &rows.blocks),
            nmse: [&left_without, &left_with].map(|left| rows.nmse(left)),
            force,
        })
    }

    /// The recording with its effort as early as its position.
    pub fn taken_off(&self, recording: &Recording) -> Recording {
        let mut aligned = recording.clone();
        aligned.effort = earlier(recording, self.delay.value);
        aligned
    }
}

/// Inertia and hysteresis, a constant, viscous friction, a spring and gravity, with how they are bound.
fn columns(ground: &Ground) -> (Vec<Vec<f64>>, Vec<Bound>) {
    let s = &ground.rows.s;
    let mut columns = ground.core.rows.to_vec();
    let mut bounds = ground.core.bounds();
    let plain = [Subject::Effect(&ConstantForce), Subject::Effect(&Viscous)];
    let mut beside: Vec<Vec<f64>> = plain
        .iter()
        .flat_map(|subject| ground.columns(&Term::new(*subject, &[])).to_vec())
        .collect();
    let of = |column: Vec<f64>| ground.rows.weak.rows(&Column::of(column));
    beside.push(of(s.x.clone()));
    if s.rotary {
        beside.push(of(s.x.iter().map(|x| x.sin()).collect()));
        beside.push(of(s.x.iter().map(|x| x.cos()).collect()));
    }
    bounds.extend(beside.iter().map(|_| Bound::Free));
    columns.extend(beside);
    (columns, bounds)
}

/// The effort a delay earlier, between samples by a straight line; each piece ends with its own last value.
fn earlier(recording: &Recording, delay: f64) -> Vec<f64> {
    let ticks = delay / recording.sample_time_s();
    let mut effort = recording.effort.clone();
    for piece in &recording.pieces {
        shift(&recording.effort, piece, ticks, &mut effort);
    }
    effort
}

fn shift(from: &[f64], piece: &Range<usize>, ticks: f64, into: &mut [f64]) {
    let last = piece.len().saturating_sub(1);
    for (n, value) in into[piece.clone()].iter_mut().enumerate() {
        let at = (n as f64 + ticks).clamp(0.0, last as f64);
        let low = at.floor() as usize;
        let part = at - low as f64;
        let of = |n: usize| from[piece.start + n.min(last)];
        *value = of(low) + part * (of(low + 1) - of(low));
    }
}

/// The delay (s) that leaves least: a first look, then about its best place.
fn least(left: impl Fn(f64) -> f64, sample_time: f64) -> Option<f64> {
    let step = (LONGEST_S / PLACES as f64).max(sample_time);
    let places = (LONGEST_S / step) as i32;
    let looked = (-places..=places).map(|k| f64::from(k) * step);
    let (mut best, mut value) = looked
        .map(|delay| (delay, left(delay)))
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    let mut step = 0.5 * step;
    for _ in 0..STEPS {
        let beside = [best - step, best + step].map(|delay| (delay, left(delay)));
        match beside.into_iter().find(|b| b.1 < value) {
            Some(better) => (best, value) = better,
            None => step *= 0.5,
        }
    }
    Some(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shift_goes_between_samples_and_stays_in_its_piece() {
        let from: Vec<f64> = (0..10).map(f64::from).collect();
        let mut into = from.clone();
        shift(&from, &(0..5), 1.5, &mut into);
        shift(&from, &(5..10), -1.0, &mut into);
        assert_eq!(into, [1.5, 2.5, 3.5, 4.0, 4.0, 5.0, 5.0, 6.0, 7.0, 8.0]);
    }

    #[test]
    fn the_least_is_found_between_the_first_places() {
        let found = least(|delay| (delay - 0.0168).powi(2), 1e-3).expect("a least");
        assert!((found - 0.0168).abs() < 2e-5, "{found}");
    }
}
