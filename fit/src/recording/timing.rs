//! Time stamps: what must not be, what is a gap, what is jitter.

use crate::report::figures::{between, quantity};
use crate::statistics::quantile;
use std::ops::Range;

use super::Warning;
use super::error::Problem;
use super::table::Table;

/// A step longer than this many median steps is a gap, across which nothing is filtered or
/// integrated. The recordings at hand have steps of 1 to 8.5 medians from busy loggers, and
/// 14 to 270 where samples were lost.
const GAP_MEDIANS: f64 = 10.0;
/// A step of less than this share of the median one is none: two rows have one time but for its last digits, and between them any speed.
const STILL: f64 = 1e-6;
/// Spread (1st to 99th percentile) of the steps, relative to the median, that is worth a warning.
const JITTER: f64 = 0.02;

/// Samples between restarts of the clock, and between restarts and gaps.
pub(super) type Timing = (Vec<Range<usize>>, Vec<Range<usize>>);

/// Median step within the pieces (s), 0 where there is none.
pub(super) fn sample_time(t: &[f64], pieces: &[Range<usize>]) -> f64 {
    let steps = |piece: &Range<usize>| {
        let t = t.get(piece.clone()).unwrap_or_default();
        t.windows(2)
            .map(|pair| pair[1] - pair[0])
            .collect::<Vec<_>>()
    };
    let mut all: Vec<f64> = pieces.iter().flat_map(steps).collect();
    quantile(&mut all, 0.5).unwrap_or(0.0)
}

/// Time from the steps between samples; a "step" that rises throughout is the time itself.
pub(super) fn of_steps(steps: Vec<f64>, warnings: &mut Vec<Warning>) -> Vec<f64> {
    /// Steps that rise so often are no steps.
    const FEWEST: usize = 4;
    if steps.len() >= FEWEST && steps.windows(2).all(|pair| pair[1] > pair[0]) {
        warnings.push(Warning::new(
            "step-is-time",
            "the time step rises from sample to sample: taken as the time",
        ));
        return steps;
    }
    let mut t = 0.0;
    let since = |step: &f64| {
        t += step;
        t
    };
    [0.0]
        .into_iter()
        .chain(steps.iter().skip(1).map(since))
        .take(steps.len())
        .collect()
}

/// Takes the wraps of a counter of 16, 24 or 32 bits, and of seconds of the day, out of the time.
pub(super) fn unwrap(t: &mut [f64], table: &Table, warnings: &mut Vec<Warning>) {
    const BITS: [i32; 3] = [16, 24, 32];
    /// Median steps by which the last sample before a wrap and the first after it may be off its ends.
    const NEAR: f64 = 20.0;
    let time = table.plan.sources.iter();
    let time = time.filter(|s| s.known.slot == super::Slot::Time);
    let Some([term]) = time.map(|s| s.terms.as_slice()).next() else {
        return;
    };
    let falls: Vec<usize> = (1..t.len()).filter(|&i| t[i] < t[i - 1]).collect();
    let steps = t.windows(2).map(|p| p[1] - p[0]).filter(|s| *s > 0.0);
    let Some(step) = quantile(&mut steps.collect::<Vec<_>>(), 0.5).filter(|_| !falls.is_empty())
    else {
        return;
    };
    let counts = |t: &f64| {
        let count = t / term.factor;
        (count - count.round()).abs() < 1e-3
    };
    let counters = BITS.map(|bits| 2f64.powi(bits) * term.factor);
    let counters = counters.into_iter().filter(|_| t.iter().all(counts));
    let day = [86_400.0];
    let fits = |range: &f64| {
        // A counter of so few steps that a wrap is as near as none shows nothing.
        let near = (NEAR * step).min(0.5 * range);
        let at = |&i: &usize| {
            let over = t[i] + range - t[i - 1];
            over > 0.0 && over < near
        };
        falls.iter().all(at) && 4.0 * step < *range
    };
    let Some(range) = counters.chain(day).find(fits) else {
        return;
    };
    warnings.push(warning!(
        "time-wrapped",
        "the clock wraps around at {range} s ({} in all, first at {}): unwrapped",
        falls.len(),
        table.place.of(falls[0])
    ));
    let mut wraps = falls.iter().peekable();
    let mut ahead = 0.0;
    for (i, t) in t.iter_mut().enumerate() {
        if wraps.next_if_eq(&&i).is_some() {
            ahead += range;
        }
        *t += ahead;
    }
}

/// Checks that time advances, except where a new segment or repeat starts the clock again.
pub(super) fn check(
    t: &[f64],
    part: impl Fn(usize) -> (u32, u32),
    table: &Table,
    warnings: &mut Vec<Warning>,
) -> Result<Timing, Problem> {
    let mut starts = vec![0];
    for (i, pair) in (1..).zip(t.windows(2)) {
        let &[from, to] = pair else { continue };
        if to > from {
            continue;
        }
        if part(i) == part(i - 1) {
            return Err(not_advancing(i, from, to, table));
        }
        starts.push(i);
    }
    let runs: Vec<Range<usize>> = ranges(&starts, t.len());
    if runs.len() > 1 {
        warnings.push(warning!(
            "time-restarts",
            "restarts of the clock: {}; each run is kept apart",
            runs.len() - 1
        ));
    }
    let mut gaps: Vec<(usize, f64)> = Vec::new();
    for run in &runs {
        let stamps = t.get(run.clone()).unwrap_or_default();
        let mut steps: Vec<f64> = stamps
            .iter()
            .zip(stamps.iter().skip(1))
            .map(|(a, b)| b - a)
            .collect();
        // Runs may differ in rate: the median is each run's own.
        let Some(median) = quantile(&mut steps.clone(), 0.5) else {
            continue;
        };
        for (i, &step) in (run.start + 1..).zip(&steps) {
            if step < STILL * median {
                return Err(not_advancing(i, t[i - 1], t[i], table));
            }
            if step > GAP_MEDIANS * median {
                gaps.push((i, step));
            }
        }
        steps.retain(|&step| step <= GAP_MEDIANS * median);
        spread_warning(&steps, median, run, runs.len(), table, warnings);
    }
    gap_warning(&gaps, table, warnings);
    let mut cuts: Vec<usize> = starts
        .iter()
        .copied()
        .chain(gaps.iter().map(|g| g.0))
        .collect();
    cuts.sort_unstable();
    let pieces = ranges(&cuts, t.len());
    Ok((runs, pieces))
}

/// Ranges from each start to the next.
pub(super) fn ranges(starts: &[usize], len: usize) -> Vec<Range<usize>> {
    let ends = starts.iter().skip(1).copied().chain([len]);
    starts
        .iter()
        .copied()
        .zip(ends)
        .map(|(a, b)| a..b)
        .collect()
}

fn not_advancing(i: usize, from: f64, to: f64, table: &Table) -> Problem {
    let column = table
        .first_change
        .iter()
        .find(|(_, at)| *at == i)
        .map(|(name, _)| name);
    let remedy = match column {
        Some(name) => format!(
            "if `{name}`, which changes there, numbers separate runs, give `--map segment={name}`"
        ),
        None if to >= from => {
            "write the time stamps with more digits, or remove the repeated rows".into()
        }
        None => "sort the rows, or number separate runs in a column `segment`".into(),
    };
    let how = if to < from {
        "runs backwards"
    } else {
        "stands still"
    };
    let at = table.place.of(i);
    Problem::Other(format!(
        "{at}: time {how} (from {from} s to {to} s); {remedy}"
    ))
}

fn gap_warning(gaps: &[(usize, f64)], table: &Table, warnings: &mut Vec<Warning>) {
    let Some(longest) = gaps.iter().map(|g| g.1).max_by(f64::total_cmp) else {
        return;
    };
    const NAMED: usize = 5;
    let mut named: Vec<String> = gaps
        .iter()
        .take(NAMED)
        .map(|&(i, step)| format!("{:.4} s at {}", step, table.place.of(i)))
        .collect();
    if gaps.len() > NAMED {
        named.push(format!(
            "{} more, the longest {longest:.4} s",
            gaps.len() - NAMED
        ));
    }
    warnings.push(warning!(
        "gap",
        "samples are missing: {}; nothing is filtered or integrated across",
        named.join(", ")
    ));
}

fn spread_warning(
    steps: &[f64],
    median: f64,
    run: &Range<usize>,
    runs: usize,
    table: &Table,
    warnings: &mut Vec<Warning>,
) {
    let mut steps = steps.to_vec();
    let (Some(low), Some(high)) = (quantile(&mut steps, 0.01), quantile(&mut steps, 0.99)) else {
        return;
    };
    if high - low > JITTER * median && !warnings.iter().any(|w| w.code == "time-jitter") {
        let of = if runs > 1 {
            format!(" in the run from {}", table.place.of(run.start))
        } else {
            String::new()
        };
        warnings.push(warning!(
            "time-jitter",
            "98 % of the time steps lie {} (median {}){of}",
            between(low, high, "s"),
            quantity(median, "s")
        ));
    }
}

/// Displacement from velocity by the trapezoidal rule, `x_k = x_{k-1} + (v_{k-1} + v_k)/2·Δt`,
/// from 0 in each piece: what moved during a gap is unknown.
pub(super) fn integrate(
    t: &[f64],
    velocity: &[f64],
    pieces: &[Range<usize>],
    warnings: &mut Vec<Warning>,
) -> Vec<f64> {
    warnings.push(Warning::new(
        "position-integrated",
        "no position column: integrated from the velocity, from 0 in each contiguous piece; its drift is not motion",
    ));
    let mut x = Vec::with_capacity(t.len());
    for piece in pieces {
        let (Some(t), Some(v)) = (t.get(piece.clone()), velocity.get(piece.clone())) else {
            continue;
        };
        let mut position = 0.0;
        let mut last: Option<(f64, f64)> = None;
        for (&t, &v) in t.iter().zip(v) {
            if let Some((t0, v0)) = last {
                position += 0.5 * (v0 + v) * (t - t0);
            }
            last = Some((t, v));
            x.push(position);
        }
    }
    x
}
