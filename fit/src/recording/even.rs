//! Even times: coarse time stamps are put right, jittered ones and lost samples are interpolated.

use crate::report::figures::quantity;
use std::ops::Range;

use super::Warning;
use super::frame::Frame;
use super::timing::ranges;
use crate::statistics::quantile;

/// Distance from an even grid (samples) within which a piece is even: what a filter with a cut-off at a fifth of the
/// sample rate does not notice.
const EVEN: f64 = 0.05;

/// Steps that differ from the median by more than this share of it are not of the usual length; a step of three units of a
/// coarse clock beside one of two is.
const UNUSUAL: f64 = 0.51;

/// Distance of rounded stamps from the true times, in steps of their resolution: half, and some slack for the fitted line.
const ROUNDED: f64 = 0.55;

/// Most different lengths of steps that a coarse clock shows: two, and two more where single precision becomes coarser on the
/// way. Jitter shows more.
const COARSE_STEPS: usize = 4;
/// Steps that differ by less than this share of one have the same length, but for the digits that a file writes.
const SAME_STEP: f64 = 1e-3;
/// Where fewer steps than this are unequal, they must be multiples of a resolution that is finer than this share of a step:
/// a lost sample adds a whole one.
const COARSE_SHARE: f64 = 0.05;
const COARSE_FINE: f64 = 0.6;

/// Most samples that a piece may have on its even grid for each that was recorded.
const MOST_GROWTH: f64 = 3.0;

/// Replaces time stamps that are even but for their resolution, as of a millisecond clock or of single precision, by the
/// line through them.
pub(super) fn regularise(t: &mut [f64], warnings: &mut Vec<Warning>) {
    let mut starts = vec![0];
    starts.extend((1..t.len()).filter(|&i| t[i] < t[i - 1]));
    let mut said: Option<(f64, f64, f64)> = None;
    for run in ranges(&starts, t.len()) {
        let stamps = &mut t[run];
        let Some((first, step, resolution)) = coarse(stamps) else {
            continue;
        };
        for (i, stamp) in stamps.iter_mut().enumerate() {
            let even = first + step * i as f64;
            let change = (even - *stamp).abs();
            said = Some(said.map_or((step, resolution, change), |s| (s.0, s.1, s.2.max(change))));
            *stamp = even;
        }
    }
    if let Some((step, resolution, change)) = said {
        warnings.push(warning!(
            "coarse-time",
            "the time stamps have a resolution of {}: replaced by even ones {} apart, none moved by more than {}",
            quantity(resolution, "s"),
            quantity(step, "s"),
            quantity(change, "s")
        ));
    }
}

/// First stamp, step and resolution of the line through stamps that are even but for their rounding.
fn coarse(t: &[f64]) -> Option<(f64, f64, f64)> {
    let n = t.len();
    if n < 8 {
        return None;
    }
    let mut steps: Vec<f64> = t.windows(2).map(|p| p[1] - p[0]).collect();
    let median = quantile(&mut steps.clone(), 0.5)?;
    let mean = (t[n - 1] - t[0]) / (n - 1) as f64;
    let unequal = steps
        .iter()
        .filter(|s| (**s - median).abs() > SAME_STEP * mean)
        .count();
    if unequal == 0 {
        return None;
    }
    steps.sort_by(f64::total_cmp);
    let jumps = jumps(&steps, SAME_STEP * mean)?;
    let rare = (unequal as f64) < COARSE_SHARE * steps.len() as f64;
    if jumps.len() >= COARSE_STEPS || rare && !are_multiples(&steps, &jumps, median) {
        return None;
    }
    // Least squares, with indices about their middle.
    let middle = 0.5 * (n - 1) as f64;
    let average = t.iter().sum::<f64>() / n as f64;
    let (mut ix, mut ii) = (0.0, 0.0);
    for (i, &stamp) in t.iter().enumerate() {
        let i = i as f64 - middle;
        ix += i * (stamp - average);
        ii += i * i;
    }
    let step = ix / ii;
    let first = average - step * middle;
    // Rounded to multiples of it, steps differ by it at most.
    let resolution = steps[steps.len() - 1] - steps[0];
    let worst = t
        .iter()
        .enumerate()
        .map(|(i, stamp)| (stamp - first - step * i as f64).abs())
        .fold(0.0, f64::max);
    (step > 0.0 && worst <= ROUNDED * resolution).then_some((first, step, resolution))
}

/// Differences between neighbouring lengths of sorted steps; `None` where steps spread between lengths, as jitter's do.
fn jumps(steps: &[f64], same: f64) -> Option<Vec<f64>> {
    let (mut jumps, mut shortest) = (Vec::new(), steps[0]);
    for pair in steps.windows(2) {
        if pair[1] - pair[0] > same {
            jumps.push(pair[1] - pair[0]);
            shortest = pair[1];
        } else if pair[1] - shortest > 2.0 * same {
            return None;
        }
    }
    Some(jumps)
}

/// Whether all steps are multiples of the smallest difference between two of them, as those of stamps rounded to it are.
fn are_multiples(steps: &[f64], differences: &[f64], median: f64) -> bool {
    let quantum = differences.iter().copied().fold(f64::INFINITY, f64::min);
    let whole = |step: &f64| ((step / quantum).round() * quantum - step).abs() < 0.02 * quantum;
    quantum < COARSE_FINE * median && steps.iter().all(whole)
}

/// Brings every piece whose samples are not even to even times at its usual rate, and says so.
pub(super) fn resample(frame: &mut Frame, warnings: &mut Vec<Warning>) {
    let plans: Vec<Option<Grid>> = frame
        .pieces
        .iter()
        .map(|p| Grid::of(&frame.t_s[p.clone()]))
        .collect();
    let uneven: Vec<&Grid> = plans.iter().flatten().collect();
    let Some(first) = uneven.first() else {
        return;
    };
    let places = uneven.iter().flat_map(|g| &g.places);
    let moved = places.filter(|p| (**p - p.round()).abs() > EVEN).count();
    let lost: usize = uneven.iter().map(|g| g.lost).sum();
    let bridged = match lost {
        1 => "1 lost sample is bridged".to_owned(),
        n => format!("{n} lost samples are bridged"),
    };
    let uneven = format!(
        "{moved} of {} samples are not evenly spaced",
        frame.t_s.len()
    );
    let what = match (moved, lost) {
        (_, 0) => uneven,
        (0, _) => bridged,
        _ => format!("{uneven}, and {bridged}"),
    };
    warnings.push(warning!(
        "resampled",
        "{what}: brought to times {} apart by cubic interpolation",
        quantity(first.step, "s")
    ));
    let pieces = frame.pieces.clone();
    let each = |of: &dyn Fn(&Grid, Range<usize>) -> Vec<f64>, keep: &[f64]| -> Vec<f64> {
        let parts = pieces.iter().zip(&plans).map(|(piece, plan)| match plan {
            Some(grid) => of(grid, piece.clone()),
            None => keep[piece.clone()].to_vec(),
        });
        parts.collect::<Vec<_>>().concat()
    };
    for (_, values) in &mut frame.numbers {
        *values = each(&|grid, piece| grid.cubic(&values[piece]), values);
    }
    for extra in &mut frame.extra {
        let values = &extra.values;
        extra.values = each(&|grid, piece| grid.linear(&values[piece]), values);
    }
    for (_, labels) in &mut frame.parts {
        let of = |(piece, plan): (&Range<usize>, &Option<Grid>)| match plan {
            Some(grid) => grid.last(&labels[piece.clone()]),
            None => labels[piece.clone()].to_vec(),
        };
        *labels = pieces
            .iter()
            .zip(&plans)
            .map(of)
            .collect::<Vec<_>>()
            .concat();
    }
    frame.t_s = each(
        &|grid, piece| grid.times(frame.t_s[piece.start]),
        &frame.t_s,
    );
    let mut ends = vec![0];
    for (piece, plan) in pieces.iter().zip(&plans) {
        let length = plan.as_ref().map_or(piece.len(), |grid| grid.length);
        ends.push(ends[ends.len() - 1] + length);
    }
    let place = |sample: usize| ends[pieces.partition_point(|p| p.start < sample)];
    frame
        .runs
        .iter_mut()
        .for_each(|r| *r = place(r.start)..place(r.end));
    frame.pieces = ends.windows(2).map(|e| e[0]..e[1]).collect();
}

/// An even grid over the samples of one piece.
pub(super) struct Grid {
    step: f64,
    length: usize,
    /// Where the samples stand on it, ascending, the first at 0.
    places: Vec<f64>,
    lost: usize,
}

impl Grid {
    /// `None` where the samples are even already, or so uneven that there is no grid for them.
    fn of(t: &[f64]) -> Option<Self> {
        let mut steps: Vec<f64> = t.windows(2).map(|p| p[1] - p[0]).collect();
        let median = quantile(&mut steps, 0.5)?;
        let usual = steps
            .iter()
            .filter(|s| (**s - median).abs() < UNUSUAL * median);
        let (sum, count) = usual.fold((0.0, 0), |(sum, count), s| (sum + s, count + 1));
        let step = sum / f64::from(count);
        let places: Vec<f64> = t.iter().map(|t_i| (t_i - t[0]) / step).collect();
        let off = |(i, place): (usize, &f64)| (place - i as f64).abs() > EVEN;
        if !places.iter().enumerate().any(off) {
            return None;
        }
        // Jitter about a true rate that the mean of the usual steps misses by a little is no loss.
        let lost = steps
            .iter()
            .map(|s| ((s / step).round() as usize).saturating_sub(1))
            .sum();
        let length = (places[places.len() - 1] + 1e-6).floor() as usize + 1;
        let fits = (length as f64) <= MOST_GROWTH * t.len() as f64;
        fits.then_some(Self {
            step,
            length,
            places,
            lost,
        })
    }

    /// A grid of a given step over all of the samples.
    pub(super) fn at(t: &[f64], step: f64) -> Self {
        let places: Vec<f64> = t.iter().map(|t_i| (t_i - t[0]) / step).collect();
        Self {
            length: places
                .last()
                .map_or(0, |last| (last + 1e-6).floor() as usize + 1),
            step,
            places,
            lost: 0,
        }
    }

    pub(super) fn length(&self) -> usize {
        self.length
    }

    pub(super) fn times(&self, first: f64) -> Vec<f64> {
        (0..self.length)
            .map(|i| first + self.step * i as f64)
            .collect()
    }

    /// For every point of the grid the sample at or before it, and how far it is to the next (0…1).
    fn between(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let mut low = 0;
        (0..self.length).map(move |i| {
            let place = i as f64;
            while low + 2 < self.places.len() && self.places[low + 1] <= place {
                low += 1;
            }
            let width = self.places[low + 1] - self.places[low];
            (low, ((place - self.places[low]) / width).clamp(0.0, 1.0))
        })
    }

    /// The cubic through the samples with the slope at each of the parabola through it and its neighbours.
    pub(super) fn cubic(&self, values: &[f64]) -> Vec<f64> {
        let slope = |i: usize| {
            let chord =
                |a: usize, b: usize| (values[b] - values[a]) / (self.places[b] - self.places[a]);
            match i {
                0 => chord(0, 1),
                i if i + 1 == values.len() => chord(i - 1, i),
                i => {
                    let (before, after) = (
                        self.places[i] - self.places[i - 1],
                        self.places[i + 1] - self.places[i],
                    );
                    (chord(i - 1, i) * after + chord(i, i + 1) * before) / (before + after)
                }
            }
        };
        let at = |(i, u): (usize, f64)| {
            let width = self.places[i + 1] - self.places[i];
            let (a, b) = (values[i], values[i + 1]);
            let (da, db) = (slope(i) * width, slope(i + 1) * width);
            let rest = a - b;
            a + u * (da + u * (-3.0 * rest - 2.0 * da - db + u * (2.0 * rest + da + db)))
        };
        self.between().map(at).collect()
    }

    fn linear(&self, values: &[f64]) -> Vec<f64> {
        let at = |(i, u): (usize, f64)| values[i] + u * (values[i + 1] - values[i]);
        self.between().map(at).collect()
    }

    pub(super) fn last(&self, labels: &[u32]) -> Vec<u32> {
        let at = |(i, u): (usize, f64)| labels[if u < 1.0 { i } else { i + 1 }];
        self.between().map(at).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coarse_stamps_become_even_and_others_stay() {
        let t = |i: usize| 17.3 + i as f64 * 0.0007;
        let stamps =
            |of: &dyn Fn(f64) -> f64| -> Vec<f64> { (0..4000).map(|i| of(t(i))).collect() };
        for (name, given, most) in [
            ("milliseconds", stamps(&|t| (t * 1e3).floor() / 1e3), 5.5e-4),
            (
                "single precision",
                stamps(&|t| f64::from((t + 1e4) as f32) - 1e4),
                5.5e-4,
            ),
            (
                "single precision that is nearly fine enough",
                stamps(&|t| f64::from((t * 10.0 / 7.0 + 5e3) as f32) * 0.7),
                2.5e-4,
            ),
            (
                "single precision, written with seven digits that fall between two steps",
                stamps(&|t| (f64::from((t * 10.0 / 7.0 + 5e3) as f32) * 1e7).round() / 1e7 * 0.7),
                2.5e-4,
            ),
        ] {
            let mut now = given.clone();
            let mut warnings = Vec::new();
            regularise(&mut now, &mut warnings);
            assert_eq!(warnings.len(), 1, "{name}");
            let step = (now[3999] - now[0]) / 3999.0;
            assert!((step / 0.0007 - 1.0).abs() < 2e-4, "{name}: {step}");
            assert!(
                now.windows(2).all(|p| (p[1] - p[0] - step).abs() < 1e-9),
                "{name}"
            );
            let moved = now
                .iter()
                .zip(&given)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            assert!(moved < most, "{name}: {moved}");
        }
        // A twentieth of jitter, and one lost sample in a hundred.
        let mut seed = 1_u32;
        let mut noise = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
        };
        let jittered: Vec<f64> = (0..4000).map(|i| t(i) + 7e-5 * noise()).collect();
        let lost: Vec<f64> = (0..4000).filter(|_| noise() < 0.49).map(t).collect();
        for given in [stamps(&|t| t), jittered, lost] {
            let mut now = given.clone();
            regularise(&mut now, &mut Vec::new());
            assert!(now == given);
        }
    }

    #[test]
    fn a_sine_is_brought_to_even_times() {
        let step = 1e-3;
        let times: Vec<f64> = (0..5000)
            .filter(|i| i % 97 != 13)
            .map(|i| step * (f64::from(i) + 0.2 * (f64::from(i) * 1.7).sin()))
            .collect();
        let wave = |t: f64| (60.0 * t).sin();
        let n = times.len();
        let mut frame = Frame {
            numbers: vec![(
                super::super::known::Slot::Position,
                times.iter().map(|&t| wave(t)).collect(),
            )],
            parts: vec![(
                super::super::known::Slot::Segment,
                (0..n).map(|i| u32::from(i >= n / 2)).collect(),
            )],
            extra: Vec::new(),
            runs: std::iter::once(0..n).collect(),
            pieces: vec![0..100, 100..n],
            t_s: times,
        };
        let mut warnings = Vec::new();
        resample(&mut frame, &mut warnings);
        assert!(warnings[0].message.contains("lost"), "{warnings:?}");
        let total = frame.t_s.len();
        assert_eq!(
            (
                frame.pieces.len(),
                frame.pieces[1].end,
                frame.runs[0].clone()
            ),
            (2, total, 0..total)
        );
        assert_eq!(
            (frame.numbers[0].1.len(), frame.parts[0].1.len()),
            (total, total)
        );
        for piece in &frame.pieces {
            let t = &frame.t_s[piece.clone()];
            assert!(
                t.windows(2)
                    .all(|p| (p[1] - p[0] - step).abs() < 1e-2 * step)
            );
        }
        let errors = frame.numbers[0]
            .1
            .iter()
            .zip(&frame.t_s)
            .map(|(x, &t)| (x - wave(t)).abs());
        // An eighth of (ωT)³ times the amplitude bounds it between samples, eight times that over a lost one.
        let worst = errors.fold(0.0, f64::max);
        assert!(worst < 2e-4, "{worst:e}");
    }
}
