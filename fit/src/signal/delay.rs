//! An effort that is recorded later, or earlier, than the position that it goes with: a shift of the signal. The first term of its series, the
//! slope of the effort, is not enough where the motion changes within the delay.

use super::rigid::{BLOCKS, Rigid, blocks};
use super::{Kinematics, LATE, step_at_reversals};
use crate::evidence::evidence;
use crate::recording::Recording;
use crate::statistics::{Estimate, LeastSquares, earlier, jackknife};
use serde::Serialize;
use std::ops::Range;

/// Longest shift that is looked for (s).
const LONGEST_S: f64 = 0.06;
/// Places of a first look to each side.
const PLACES: usize = 20;
/// Samples up to which the first term of the series does.
const SHORT: f64 = 2.0;
/// Share of what the first term leaves that the shift must take off, and standard errors of that over blocks of the recording: an elastic drive
/// looks a little like one, too.
pub const TAKES: f64 = 0.25;
const SURE: f64 = 3.0;
/// Parts of the band in which a delay must be the same, by how much of itself at most (and a sample) it may differ. What a closed loop makes of a rattle or a
/// vibration has a phase, not a delay. Made ones of 2.5 to 17 ms differ by 4 % down to an eighth of the band, that of a
/// rattling screw by a factor of three: set with these four in sight.
const NARROWER: [f64; 2] = [2.0, 4.0];
const SAME: f64 = 0.2;
/// Blocks beside the rigid body.
const BESIDE: usize = 24;
/// Steps of the search between two places of the first look.
const STEPS: usize = 12;

/// A delay of the effort.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Delay {
    /// How much later the effort is than the position that it goes with (s).
    pub delay_s: Estimate,
}

impl Delay {
    /// The delay of an effort that has one, beside rigid body and hysteresis.
    pub(super) fn of(effort: &[f64], rigid: &Rigid) -> Option<Self> {
        let (recording, kinematics) = (rigid.recording, rigid.kinematics);
        let dt = recording.sample_time_s();
        let delay = shift(effort, rigid)?;
        if delay.abs() <= SHORT * dt {
            return None;
        }
        let columns = rigid.at(&rigid.rows);
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let at = |values: &[f64], delay: f64| {
            rigid.fitted(&effort_earlier(values, &recording.pieces, delay / dt))
        };
        let smooth = kinematics.filter.smooth(effort);
        let slope = kinematics.filter.derivative(effort, 1);
        let (first_term, rest) = (at(&slope, 0.0), at(&slope, delay));
        let beside = |slope| {
            columns
                .iter()
                .copied()
                .chain([slope])
                .collect::<Vec<&[f64]>>()
        };
        let (unshifted, target) = (at(&smooth, 0.0), at(&smooth, delay));
        let with = beside(&rest);
        is_sure(
            &left(&beside(&first_term), &unshifted)?,
            &left(&with, &target)?,
        )
        .then_some(())?;
        let is_the_same = |part: f64| {
            let slower = Kinematics::below(recording, kinematics.filter.cutoff_hz() / part);
            let found = shift(effort, &rigid.within(&slower));
            found.is_some_and(|found| (found - delay).abs() <= SAME * delay.abs() + dt)
        };
        NARROWER.into_iter().all(is_the_same).then_some(())?;
        Some(Self {
            delay_s: Estimate::new(delay, Some(error_of_last(&with, &target)), BLOCKS),
        })
    }

    /// The recording with its effort as early as its position.
    pub fn taken_off(&self, recording: &Recording) -> Recording {
        let ticks = self.delay_s.value / recording.sample_time_s();
        let mut on_time = recording.clone();
        on_time.effort = effort_earlier(&recording.effort, &recording.pieces, ticks);
        on_time
    }

    /// In words, a sentence without its full stop.
    pub fn words(&self) -> String {
        format!("{}; the fit allows for it", self.recorded())
    }

    /// How the effort is recorded, in a clause.
    pub fn recorded(&self) -> String {
        let ms = |seconds: f64| 1e3 * seconds;
        let Estimate { value, ci95 } = self.delay_s;
        let reach = ci95.map_or_else(String::new, |[low, high]| {
            format!(" ± {:.2}", ms(0.5 * (high - low)))
        });
        format!(
            "the effort is recorded {:.2}{reach} ms {} than its position",
            ms(value.abs()),
            if value > 0.0 { "later" } else { "earlier" }
        )
    }
}

/// The shift (s) of an effort that leaves least beside rigid body and hysteresis.
fn shift(effort: &[f64], rigid: &Rigid) -> Option<f64> {
    let smooth = rigid.kinematics.filter.smooth(effort);
    let columns = rigid.at(&rigid.rows);
    let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let fast = LeastSquares::of(&columns)?;
    let (pieces, dt) = (&rigid.recording.pieces, rigid.recording.sample_time_s());
    let shifted = |delay: f64| rigid.fitted(&effort_earlier(&smooth, pieces, delay / dt));
    least(|delay| fast.squares_left(&shifted(delay)), dt)
}

/// Yields (m or rad) of blocks from what a sample near a reversal moves to the latest of friction, evenly on a logarithmic scale: what lies
/// between two blocks looks like a delay.
pub(super) fn yields(recording: &Recording) -> Option<[f64; BESIDE]> {
    let (position, segment) = (&recording.position, &recording.segment);
    let turns = (1..segment.len()).filter(|i| segment[*i] != segment[i - 1]);
    let step = step_at_reversals(position, &recording.pieces, turns)?;
    let (low, high) = recording.ends();
    let late = LATE * (high - low);
    let early = (0.5 * step).clamp(late / 3e4, late / 10.0);
    Some(std::array::from_fn(|i| {
        early * (late / early).powf(i as f64 / (BESIDE - 1) as f64)
    }))
}

/// What columns leave of an effort.
fn left(columns: &[&[f64]], target: &[f64]) -> Option<Vec<f64>> {
    Some(LeastSquares::of(columns)?.left(target))
}

/// Standard error of the last column's coefficient, from what it is without each block in turn.
fn error_of_last(columns: &[&[f64]], target: &[f64]) -> f64 {
    let without = |block: Range<usize>| {
        let outside = |values: &[f64]| [&values[..block.start], &values[block.end..]].concat();
        let kept: Vec<Vec<f64>> = columns.iter().map(|c| outside(c)).collect();
        let kept: Vec<&[f64]> = kept.iter().map(Vec::as_slice).collect();
        let solved = LeastSquares::of(&kept)?.coefficients(&outside(target));
        solved.last().copied()
    };
    jackknife(
        &blocks(target.len())
            .filter_map(without)
            .collect::<Vec<f64>>(),
    )
}

/// Shares of the top speed over which a simulation's friction may reverse.
const SMOOTHEST: [f64; 6] = [3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1];

/// What rigid body, hysteresis and friction of the velocity leave of some efforts along a recording, at the samples that `fits` admits. `None` where its motion shows neither.
pub fn beside_the_motion(
    recording: &Recording,
    efforts: &[Vec<f64>],
    fits: &dyn Fn(usize) -> bool,
) -> Option<Vec<Vec<f64>>> {
    let kinematics = Kinematics::of(recording);
    let mut rigid = Rigid::of(recording, &kinematics, &yields(recording)?);
    rigid.rows.retain(|i| fits(*i));
    // Most simulations have friction that reverses with the velocity.
    let top = kinematics
        .velocity
        .iter()
        .fold(0.0, |top: f64, v| top.max(v.abs()));
    for share in SMOOTHEST {
        let slow = share * top.max(1e-300);
        let smooth: Vec<f64> = kinematics
            .velocity
            .iter()
            .map(|v| (v / slow).tanh())
            .collect();
        rigid.columns.push(kinematics.filter.smooth(&smooth));
    }
    let columns = rigid.at(&rigid.rows);
    let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let one = |effort: &Vec<f64>| left(&columns, &rigid.fitted(&kinematics.filter.smooth(effort)));
    efforts.iter().map(one).collect()
}

/// Whether the shift takes off enough of what the first term leaves, in enough of the recording.
fn is_sure(first_term: &[f64], with: &[f64]) -> bool {
    let taken: Vec<f64> = first_term.iter().zip(with).map(|(a, b)| a - b).collect();
    let own: Vec<Range<usize>> = blocks(with.len()).collect();
    let found = evidence(&taken, first_term, &own);
    found.share >= TAKES && found.z >= SURE
}

/// The effort some samples earlier; each piece ends with its own last value.
fn effort_earlier(effort: &[f64], pieces: &[Range<usize>], ticks: f64) -> Vec<f64> {
    let mut shifted = effort.to_vec();
    for piece in pieces {
        shifted[piece.clone()].copy_from_slice(&earlier(&effort[piece.clone()], ticks));
    }
    shifted
}

/// The delay (s) that leaves least: a first look, then about its best place; `None` at the end of what is looked for, where a longer one would leave less.
fn least(left: impl Fn(f64) -> f64, sample_time: f64) -> Option<f64> {
    let step = (LONGEST_S / PLACES as f64).max(sample_time);
    let places = (LONGEST_S / step) as i32;
    let looked = (-places..=places).map(|k| f64::from(k) * step);
    let (mut best, mut value) = looked
        .map(|delay| (delay, left(delay)))
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    if best.abs() >= (f64::from(places) - 0.5) * step {
        return None;
    }
    let mut step = 0.5 * step;
    for _ in 0..STEPS {
        let beside = [best - step, best + step].into_iter();
        let beside = beside.filter(|delay| delay.abs() <= LONGEST_S);
        let beside: Vec<(f64, f64)> = beside.map(|delay| (delay, left(delay))).collect();
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
        let by = |ticks| effort_earlier(&from, &[0..5, 5..10], ticks);
        assert_eq!(by(1.5), [1.5, 2.5, 3.5, 4.0, 4.0, 6.5, 7.5, 8.5, 9.0, 9.0]);
        assert_eq!(by(-1.0), [0.0, 0.0, 1.0, 2.0, 3.0, 5.0, 5.0, 6.0, 7.0, 8.0]);
    }

    #[test]
    fn the_least_is_found_between_the_first_places() {
        let found = least(|delay| (delay - 0.0168).powi(2), 1e-3).expect("a least");
        assert!((found - 0.0168).abs() < 2e-5, "{found}");
        assert_eq!(least(|delay| (delay - 0.5).abs(), 1e-3), None);
    }
}
