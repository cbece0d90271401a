//! What sensors and loggers do to a signal: wrapped counters, spikes, dropouts (`dropouts`). Found, said with the line, and put right where
//! that is safe.

use std::f64::consts::TAU;
use std::ops::Range;

use super::drive_off::{DriveOff, drive_off};
use super::dropouts::dropouts;
use super::frame::Frame;
use super::known::Slot;
use super::table::Table;
use super::{EffortRole, MotionKind, Warning};
use crate::statistics::{bounds, quantile};

/// A spike leaves the range of all but 1 % of the samples by as much as that range is wide …
const SPIKE_RANGES: f64 = 1.0;
/// … and lies this many times further from its neighbours' median than all but 1 % of the samples do.
const SPIKE_USUAL: f64 = 8.0;
/// A jump of the position is this many times longer than all but 5 % of the steps …
const JUMP_USUAL: f64 = 20.0;
/// … and either a tenth of the whole range, or this many times longer than the median of the steps around it: a motion speeds up before it is
/// fast, a count whose position is set does not.
const JUMP_ALONE: f64 = 10.0;
/// Steps to each side that are around it.
const AROUND: usize = 3;
/// Wraps of one counter agree within this share.
const SAME_WRAP: f64 = 0.05;
/// Where more than this share of the recording would be left out, it is another thing than dropouts.
const MOST_LEFT_OUT: f64 = 0.3;

/// Repairs position and effort.
pub(super) fn repair(
    frame: &mut Frame,
    (kind, role): (MotionKind, EffortRole),
    table: &Table,
    warnings: &mut Vec<Warning>,
) {
    let pieces = frame.pieces.clone();
    for (slot, name) in [(Slot::Position, "position"), (Slot::Effort, "effort")] {
        if let Some(values) = frame.column(slot) {
            spikes(values, &pieces, name, table, warnings);
        }
    }
    if let Some(position) = frame.column(Slot::Position) {
        thrown_ends(position, &pieces, kind, table, warnings);
        let cuts = unwrap(position, &pieces, kind, table, warnings);
        frame.cut(&cuts);
    }
    let off = drive_off(frame, &pieces);
    let no_channel_lost = off.as_ref().map_or(&[][..], |off| &off.ranges);
    let mut out = dropouts(frame, &pieces, kind, no_channel_lost);
    if !dropouts_said(&out, frame.t_s.len(), table, warnings) {
        out.clear();
    }
    if let Some(off) = off
        && drive_off_said(&off, role, table, warnings)
    {
        out.extend(off.ranges);
        out.sort_by_key(|r| r.start);
    }
    if !out.is_empty() {
        frame.leave_out(&out);
    }
}

/// Says where signals drop out, and whether that is left out.
fn dropouts_said(
    dropped: &[Range<usize>],
    samples: usize,
    table: &Table,
    warnings: &mut Vec<Warning>,
) -> bool {
    let Some(first) = dropped.first() else {
        return false;
    };
    let count: usize = dropped.iter().map(|d| d.len()).sum();
    let left_out = count as f64 <= MOST_LEFT_OUT * samples as f64;
    let what = if left_out {
        "these samples are left out"
    } else {
        "too much to leave out, so it is kept; do not trust the result"
    };
    warnings.push(warning!(
        "dropout",
        "position or effort stands still for {count} samples in {} places where the other one moves on, first from {} to {}: {what}",
        dropped.len(),
        table.place.of(first.start),
        table.place.of(first.end - 1)
    ));
    left_out
}

/// Says where the drive is off, and whether that is left out: no force acts then, but what the open coils do is in no voltage.
fn drive_off_said(
    off: &DriveOff,
    role: EffortRole,
    table: &Table,
    warnings: &mut Vec<Warning>,
) -> bool {
    let left_out = role == EffortRole::Voltage;
    let what = if left_out {
        "left out, since no voltage acts on open coils"
    } else {
        "kept, as an effort of zero"
    };
    let count: usize = off.ranges.iter().map(|r| r.len()).sum();
    warnings.push(warning!(
        "drive-off",
        "by `{}` the drive is off for {count} samples in {} places, first from {} to {}: {what}",
        off.column,
        off.ranges.len(),
        table.place.of(off.ranges[0].start),
        table.place.of(off.ranges[0].end - 1)
    ));
    left_out
}

/// All but 1 % of the values are within these bounds.
fn usual_range(values: &[f64]) -> Option<(f64, f64)> {
    let mut sorted = values.to_vec();
    Some((quantile(&mut sorted, 0.005)?, quantile(&mut sorted, 0.995)?))
}

fn median_of_five(values: &[f64], i: usize) -> f64 {
    let mut near = [0.0; 5];
    near.copy_from_slice(&values[i - 2..i + 3]);
    near.sort_by(f64::total_cmp);
    near[2]
}

/// Replaces one or two samples that stand alone far out by what lies between their neighbours.
fn spikes(
    values: &mut [f64],
    pieces: &[Range<usize>],
    name: &str,
    table: &Table,
    warnings: &mut Vec<Warning>,
) {
    let Some((low, high)) = usual_range(values) else {
        return;
    };
    let far = SPIKE_RANGES * (high - low);
    let inner = |p: &Range<usize>| p.start + 2..p.end.saturating_sub(2);
    // Only what leaves the range can be a spike: no median where there is none.
    let out = |v: f64| v < low - far || v > high + far;
    let suspects: Vec<usize> = pieces
        .iter()
        .flat_map(inner)
        .filter(|&i| out(values[i]))
        .collect();
    if suspects.is_empty() || far == 0.0 {
        return;
    }
    let mut off: Vec<f64> = pieces
        .iter()
        .flat_map(inner)
        .map(|i| (values[i] - median_of_five(values, i)).abs())
        .collect();
    let usual = quantile(&mut off, 0.99).unwrap_or(0.0);
    let alone = |&&i: &&usize| {
        (values[i] - median_of_five(values, i)).abs() > SPIKE_USUAL * usual.max(far / SPIKE_USUAL)
    };
    let found: Vec<usize> = suspects.iter().filter(alone).copied().collect();
    let Some(&first) = found.first() else {
        return;
    };
    let was = values[first];
    for &i in &found {
        values[i] = median_of_five(values, i);
    }
    warnings.push(warning!(
        "spike",
        "{} samples of the {name} stand alone far out, first at {} ({was:.4e}, where all others are between {low:.4e} and {high:.4e}): replaced by their neighbours' median",
        found.len(),
        table.place.of(first)
    ));
}

/// Samples at each end of a piece beyond which nothing shows whether a jump returns …
const END: usize = 2;
/// … and how many usual steps it is off a counter's whole span at most, where it is a wrap.
const OFF_SPAN: f64 = 3.0;

/// Replaces the position at the ends of pieces where it is thrown out of the range of the rest, by no counter's span: a wrap is one whole span, and
/// what follows it goes on from there.
fn thrown_ends(
    x: &mut [f64],
    pieces: &[Range<usize>],
    kind: MotionKind,
    table: &Table,
    warnings: &mut Vec<Warning>,
) {
    let mut found: Vec<(usize, f64)> = Vec::new();
    for piece in pieces.iter().filter(|p| p.len() >= 4 * END) {
        let inner = piece.start + END..piece.end - END;
        let rest = &x[inner.clone()];
        let ((low, high), Some(steps)) = (bounds(rest), Steps::of(rest)) else {
            continue;
        };
        let far = SPIKE_RANGES * (high - low);
        let outer = (piece.start..inner.start).map(|i| (i, inner.start));
        let outer = outer.chain((inner.end..piece.end).map(|i| (i, inner.end - 1)));
        found.extend(outer.filter_map(|(i, near)| {
            let is_out = far > 0.0 && !(low - far..=high + far).contains(&x[i]);
            let jump = (x[i] - x[near]).abs();
            (is_out && !steps.is_span(jump, kind)).then_some((i, x[near]))
        }));
    }
    let Some(&(first, near)) = found.first() else {
        return;
    };
    warnings.push(warning!(
        "spike",
        "{} samples of the position at the ends of a motion stand alone far out, first at {} ({:.4e} beside {near:.4e}): replaced by the nearest of the rest",
        found.len(),
        table.place.of(first),
        x[first]
    ));
    for (i, near) in found {
        x[i] = near;
    }
}

/// How a position moves from sample to sample.
struct Steps {
    /// All but 5 % are shorter.
    usual: f64,
    /// The shortest that is one.
    quantum: f64,
}

impl Steps {
    fn of(x: &[f64]) -> Option<Self> {
        let mut steps: Vec<f64> = x.windows(2).map(|p| (p[1] - p[0]).abs()).collect();
        let moving = steps.iter().copied().filter(|s| *s > 0.0);
        let quantum = moving.fold(f64::INFINITY, f64::min);
        let usual = quantile(&mut steps, 0.95)?;
        Some(Self { usual, quantum })
    }

    /// The span of a counter or an angle that is nearest to a jump.
    fn nearest_span(&self, jump: f64, kind: MotionKind) -> Option<f64> {
        let counter = (8..=32).map(|k| 2f64.powi(k) * self.quantum);
        let turn = (kind == MotionKind::Rotary).then_some(TAU);
        let spans = turn.into_iter().chain(counter);
        spans.min_by(|a, b| (a - jump).abs().total_cmp(&(b - jump).abs()))
    }

    /// Whether a jump is one whole span, but for what the motion makes.
    fn is_span(&self, jump: f64, kind: MotionKind) -> bool {
        let span = self.nearest_span(jump, kind);
        span.is_some_and(|span| (span - jump).abs() <= OFF_SPAN * self.usual.max(self.quantum))
    }
}

/// Whether a step stands out from those around it.
fn is_alone(steps: &[f64], at: usize) -> bool {
    let around = at.saturating_sub(AROUND)..(at + AROUND + 1).min(steps.len());
    let mut others: Vec<f64> = around.filter(|&i| i != at).map(|i| steps[i]).collect();
    quantile(&mut others, 0.5).is_some_and(|median| steps[at] > JUMP_ALONE * median)
}

/// Takes the wraps of a counter or an angle out of the position; returns the samples before which it jumps by something else.
fn unwrap(
    x: &mut [f64],
    pieces: &[Range<usize>],
    kind: MotionKind,
    table: &Table,
    warnings: &mut Vec<Warning>,
) -> Vec<usize> {
    let starts: Vec<usize> = pieces.iter().map(|p| p.start).collect();
    let steps: Vec<f64> = x.windows(2).map(|p| (p[1] - p[0]).abs()).collect();
    let (low, high) = bounds(x);
    let Some(usual) = Steps::of(x) else {
        return Vec::new();
    };
    let long = JUMP_USUAL * usual.usual.max(usual.quantum);
    let is_jump = |at: usize| {
        let size = steps.get(at).copied().unwrap_or(0.0);
        size > long && (size > 0.1 * (high - low) || is_alone(&steps, at))
    };
    // A mean over a jump has made two of it, one of them however small.
    let is_part =
        |at: usize| (is_jump(at + 1) || at > 0 && is_jump(at - 1)) && is_alone(&steps, at);
    let jumps: Vec<usize> = (1..x.len())
        .filter(|i| starts.binary_search(i).is_err())
        .filter(|i| is_jump(i - 1) || is_part(i - 1))
        .collect();
    let Some(&first) = jumps.first() else {
        return Vec::new();
    };
    // The step that the motion itself makes there is that before it.
    let size = |&i: &usize| {
        let before = if i >= 2 { x[i - 1] - x[i - 2] } else { 0.0 };
        (x[i] - x[i - 1] - before).abs()
    };
    let mut sizes: Vec<f64> = jumps.iter().map(size).collect();
    let median = quantile(&mut sizes, 0.5).unwrap_or(0.0);
    let same = sizes.iter().all(|s| (s / median - 1.0).abs() < SAME_WRAP);
    let known = usual.nearest_span(median, kind);
    let known = known.filter(|w| (w / median - 1.0).abs() < SAME_WRAP);
    // At an end what goes on does not tell, the size alone does.
    let is_end = |p: &Range<usize>| first <= p.start + END || first + END >= p.end;
    let at_an_end = pieces.iter().any(|p| p.contains(&first) && is_end(p));
    let known = known.filter(|_| jumps.len() > 1 || !at_an_end || usual.is_span(median, kind));
    let wrap = known.or((jumps.len() > 1).then_some(median));
    let Some(wrap) = wrap.filter(|w| same && *w > 0.8 * (high - low)) else {
        warnings.push(warning!(
            "position-jump",
            "jumps of the position: {}, first by {:.4e} at {}; nothing is filtered across, and what follows may be displaced",
            jumps.len(),
            x[first] - x[first - 1],
            table.place.of(first)
        ));
        return jumps;
    };
    let mut turns = 0.0;
    let mut next = jumps.iter().peekable();
    let mut last = x[0];
    for (i, x) in x.iter_mut().enumerate().skip(1) {
        if next.next_if_eq(&&i).is_some() {
            turns -= ((*x - last) / wrap).round();
        } else if starts.binary_search(&i).is_ok() {
            turns = 0.0;
        }
        last = *x;
        *x += turns * wrap;
    }
    warnings.push(warning!(
        "wrapped",
        "the position wraps around at {wrap:.6e} ({} in all, first at {}): unwrapped",
        jumps.len(),
        table.place.of(first)
    ));
    Vec::new()
}
