//! Strokes between reversals, and the period in which they repeat.

use std::ops::Range;

use super::Warning;
use crate::statistics::bounds;

/// A reversal counts once the motion has come back by this share of the run's travel: more than
/// an encoder's glitches (1 % of travel in real recordings), less than a deliberate inner loop
/// that is worth a segment of its own.
const HYSTERESIS: f64 = 0.02;
/// The same in encoder quanta, for motion of a few counts.
const HYSTERESIS_QUANTA: f64 = 4.0;
/// End points of matching strokes agree within this share of the travel …
const SAME_END: f64 = 0.05;
/// … and durations within this share of the longer.
const SAME_DURATION: f64 = 0.2;
/// Longest period looked for (strokes).
const MAX_PERIOD: usize = 256;

/// The motion of one run: where it starts, turns and ends.
pub(super) struct Strokes {
    /// Samples of the run.
    pub(super) run: Range<usize>,
    /// The samples where the motion turns, in order; stroke `k` ends at `reversals(k)`.
    pub(super) reversals: Vec<usize>,
    /// Highest less lowest position (m or rad).
    pub(super) travel: f64,
    /// Last less first position (m or rad).
    pub(super) net: f64,
    /// Smallest step between two samples (m or rad), 0 without motion.
    pub(super) quantum: f64,
}

impl Strokes {
    pub(super) fn count(&self) -> usize {
        self.reversals.len() + 1
    }

    /// The first sample of each stroke. Rest before a stroke belongs to it.
    fn starts(&self) -> Vec<usize> {
        std::iter::once(self.run.start)
            .chain(self.reversals.iter().copied())
            .collect()
    }
}

/// Finds the reversals of `x` within `run`, with hysteresis.
pub(super) fn strokes(x: &[f64], run: Range<usize>) -> Strokes {
    let samples = x.get(run.clone()).unwrap_or_default();
    let (low, high) = bounds(samples);
    let travel = if high > low { high - low } else { 0.0 };
    let steps = samples.windows(2).map(|p| (p[1] - p[0]).abs());
    let quantum = steps.filter(|step| *step > 0.0).reduce(f64::min);
    let quantum = quantum.unwrap_or(0.0);
    let threshold = (HYSTERESIS * travel).max((HYSTERESIS_QUANTA * quantum).min(0.5 * travel));
    let mut reversals = Vec::new();
    // Before the direction is known both extremes are candidates for the start.
    let (mut lowest, mut highest) = ((run.start, f64::INFINITY), (run.start, f64::NEG_INFINITY));
    let mut direction = 0.0;
    for (i, &v) in (run.start..).zip(samples) {
        if v < lowest.1 {
            lowest = (i, v);
        }
        if v > highest.1 {
            highest = (i, v);
        }
        if direction <= 0.0 && v - lowest.1 > threshold {
            if direction < 0.0 {
                reversals.push(lowest.0);
            }
            direction = 1.0;
            highest = (i, v);
        } else if direction >= 0.0 && highest.1 - v > threshold {
            if direction > 0.0 {
                reversals.push(highest.0);
            }
            direction = -1.0;
            lowest = (i, v);
        }
    }
    let net = samples
        .first()
        .zip(samples.last())
        .map_or(0.0, |(first, last)| last - first);
    Strokes {
        run,
        reversals,
        travel,
        net,
        quantum,
    }
}

/// One number per sample, counted from 0: a new one at each stroke and each piece.
pub(super) fn segments(strokes: &[Strokes], pieces: &[Range<usize>], samples: usize) -> Vec<u32> {
    let mut starts: Vec<usize> = strokes.iter().flat_map(Strokes::starts).collect();
    starts.extend(pieces.iter().map(|p| p.start));
    starts.sort_unstable();
    starts.dedup();
    number(&starts, samples)
}

/// Numbers samples by the starts at or before them.
fn number(starts: &[usize], samples: usize) -> Vec<u32> {
    let mut numbers = vec![0; samples];
    for (k, range) in (0u32..).zip(super::timing::ranges(starts, samples)) {
        if let Some(part) = numbers.get_mut(range) {
            part.fill(k);
        }
    }
    numbers
}

/// The cycles of a periodic motion, one repeat each; otherwise one repeat and a warning. Strokes
/// left over after the last whole cycle belong to it.
pub(super) fn repeats(
    x: &[f64],
    t: &[f64],
    strokes: &[Strokes],
    samples: usize,
    warnings: &mut Vec<Warning>,
) -> (Vec<u32>, bool) {
    let none = |warnings: &mut Vec<Warning>, why: String| {
        warnings.push(warning!(
            "no-repeats",
            "{why}; all samples are one repeat, so cross-validation needs --train and --test or a column `repeat`"
        ));
        (vec![0; samples], false)
    };
    let [motion] = strokes else {
        return none(
            warnings,
            format!(
                "{} separate runs, not known to repeat each other",
                strokes.len()
            ),
        );
    };
    let Some(period) = period(x, t, motion) else {
        return none(
            warnings,
            match motion.count() {
                1 => "the motion is one stroke".to_owned(),
                count => format!("the motion of {count} strokes has no period"),
            },
        );
    };
    let cycles = motion.count() / period;
    let starts: Vec<usize> = motion
        .starts()
        .into_iter()
        .step_by(period)
        .take(cycles)
        .collect();
    (number(&starts, samples), true)
}

/// The smallest number of strokes after which end points and durations come again. The start of
/// the first stroke and the end of the last are not compared: a run begins and ends at rest.
fn period(x: &[f64], t: &[f64], motion: &Strokes) -> Option<usize> {
    let at = |values: &[f64]| -> Vec<f64> { motion.reversals.iter().map(|&i| values[i]).collect() };
    let (ends, times) = (at(x), at(t));
    let durations: Vec<f64> = times.windows(2).map(|p| p[1] - p[0]).collect();
    let repeats = |values: &[f64], period: usize, same: &dyn Fn(f64, f64) -> bool| {
        let mut pairs = values.iter().zip(values.iter().skip(period));
        pairs.all(|(&a, &b)| same(a, b))
    };
    // Maxima follow minima: only even periods can be.
    (2..=MAX_PERIOD.min(motion.count() / 2))
        .step_by(2)
        .find(|&period| {
            repeats(&ends, period, &|a, b| {
                (a - b).abs() <= SAME_END * motion.travel
            }) && repeats(&durations, period, &|a, b| {
                (a - b).abs() <= SAME_DURATION * a.max(b)
            })
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Positions along straight lines between `corners`, `n` samples each.
    fn path(corners: &[f64], n: usize) -> Vec<f64> {
        corners
            .windows(2)
            .flat_map(|w| (0..n).map(move |i| w[0] + (w[1] - w[0]) * i as f64 / n as f64))
            .chain(corners.last().copied())
            .collect()
    }
    fn clock(samples: usize) -> Vec<f64> {
        (0..samples).map(|i| i as f64 * 1e-3).collect()
    }

    #[test]
    fn reversals_are_found_at_the_corners_despite_quantisation_noise_and_rests() {
        let mut x = path(&[0.0, 1.0, -0.5, 0.5, 0.0], 100);
        x.splice(100..100, std::iter::repeat_n(0.999, 50));
        for (i, v) in x.iter_mut().enumerate() {
            *v = (*v / 1e-3).round() * 1e-3 + if i % 2 == 0 { 1e-3 } else { 0.0 };
        }
        let s = strokes(&x, 0..x.len());
        assert_eq!(s.count(), 4, "{:?}", s.reversals);
        for (found, corner) in s.reversals.iter().zip([150, 250, 350]) {
            assert!(found.abs_diff(corner) <= 52, "{found} is not near {corner}");
        }
        assert!(s.reversals[1].abs_diff(250) <= 2 && s.reversals[2].abs_diff(350) <= 2);
    }

    #[test]
    fn cycles_with_inner_loops_are_repeats_and_the_rest_joins_the_last() {
        let cycle = [1.0, 0.3, 0.6, -1.0];
        let mut corners = vec![0.1];
        for _ in 0..5 {
            corners.extend(cycle);
        }
        corners.push(0.2);
        let x = path(&corners, 40);
        let s = strokes(&x, 0..x.len());
        assert_eq!(s.count(), 21);
        let mut warnings = Vec::new();
        let (repeat, found) = repeats(&x, &clock(x.len()), &[s], x.len(), &mut warnings);
        assert!(found && warnings.is_empty());
        assert_eq!(repeat.last(), Some(&4));
        assert_eq!((repeat[159], repeat[160], repeat[161]), (0, 1, 1));
    }

    #[test]
    fn strokes_of_other_ends_or_durations_are_no_repeats() {
        let growing: Vec<f64> = (0..12)
            .map(|k| f64::from(k) * if k % 2 == 0 { 1.0 } else { -1.0 })
            .collect();
        let x = path(&growing, 30);
        let mut warnings = Vec::new();
        let (repeat, found) = repeats(
            &x,
            &clock(x.len()),
            &[strokes(&x, 0..x.len())],
            x.len(),
            &mut warnings,
        );
        assert!(!found && repeat.iter().all(|&r| r == 0));
        assert!(warnings.iter().any(|w| w.code == "no-repeats"));

        let mut slower = path(&[0.0, 1.0, 0.0, 1.0, 0.0], 30);
        slower.extend(path(&[0.0, 1.0, 0.0, 1.0, 0.0], 90));
        let s = strokes(&slower, 0..slower.len());
        assert_eq!(s.count(), 8);
        assert!(
            !repeats(
                &slower,
                &clock(slower.len()),
                &[s],
                slower.len(),
                &mut warnings
            )
            .1
        );
    }

    #[test]
    fn a_gap_cuts_a_stroke_in_two() {
        let x = path(&[0.0, 1.0, 0.0], 10);
        let numbers = segments(&[strokes(&x, 0..x.len())], &[0..5, 5..x.len()], x.len());
        assert_eq!(
            (numbers[4], numbers[5], numbers[9], numbers[10], numbers[20]),
            (0, 1, 1, 2, 2)
        );
    }

    #[test]
    fn no_motion_has_one_stroke() {
        let s = strokes(&[1.0; 20], 0..20);
        assert_eq!((s.count(), s.travel, s.quantum), (1, 0.0, 0.0));
        assert_eq!(strokes(&[], 0..0).count(), 1);
    }
}
