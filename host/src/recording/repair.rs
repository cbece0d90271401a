//! What sensors and loggers do to a signal: wrapped counters, spikes, dropouts. Found, said with the line, and put right where
//! that is safe.

use std::f64::consts::TAU;
use std::ops::Range;

use super::frame::Frame;
use super::known::Slot;
use super::table::Table;
use super::{MotionKind, Warning};
use crate::statistics::quantile;

/// A spike leaves the range of all but 1 % of the samples by as much as that range is wide …
const SPIKE_RANGES: f64 = 1.0;
/// … and lies this many times further from its neighbours' median than all but 1 % of the samples do.
const SPIKE_USUAL: f64 = 8.0;
/// A jump of the position is this many times longer than all but 5 % of the steps …
const JUMP_USUAL: f64 = 20.0;
/// … and either a tenth of the whole range, or this many times longer than the median of the steps around it: a motion speeds up before it is
/// fast, a count that is told where it stands does not.
const JUMP_ALONE: f64 = 10.0;
/// Steps to each side that are around it.
const AROUND: usize = 3;
/// Wraps of one counter agree within this share.
const SAME_WRAP: f64 = 0.05;
/// Samples for which a signal stays exactly as it is while it drops out …
const DROPOUT: usize = 20;
/// … and how many times longer that is than the signal usually stays.
const DROPOUT_USUAL: usize = 5;
/// A signal that comes back from a dropout steps by this many times what all but 1 % of its steps are …
const JUMP_HELD: f64 = 5.0;
/// … and a position that drops out was moving: the step before exceeds this share of that. An axis that comes to rest and is then told
/// where it is jumps, too.
const MOVING: f64 = 0.1;
/// Where more than this share of the recording would be left out, it is another thing than dropouts.
const MOST_LEFT_OUT: f64 = 0.3;

/// Repairs position and effort.
pub(super) fn repair(
    frame: &mut Frame,
    kind: MotionKind,
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
        let cuts = unwrap(position, &pieces, kind, table, warnings);
        frame.cut(&cuts);
    }
    let dropped = dropouts(frame, &pieces);
    if dropped.is_empty() {
        return;
    }
    let count: usize = dropped.iter().map(|d| d.len()).sum();
    let first = &dropped[0];
    let place = format!(
        "{} to {}",
        table.place.of(first.start),
        table.place.of(first.end - 1)
    );
    let found = format!(
        "position or effort stands still for {count} samples in {} places where the other one moves on, first from {place}",
        dropped.len()
    );
    if count as f64 > MOST_LEFT_OUT * frame.t_s.len() as f64 {
        warnings.push(Warning::new(
            "dropout",
            format!("{found}: too much to leave out, so it is kept; do not trust what comes of it"),
        ));
    } else {
        warnings.push(Warning::new(
            "dropout",
            format!("{found}: these samples are left out"),
        ));
        frame.leave_out(&dropped);
    }
}

pub(super) fn extremes(values: &[f64]) -> (f64, f64) {
    let widen = |(low, high): (f64, f64), &v: &f64| (low.min(v), high.max(v));
    values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), widen)
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
    warnings.push(Warning::new(
        "spike",
        format!(
            "{} samples of the {name} stand alone far out, first at {} ({was:.4e}, where all others are between {low:.4e} and {high:.4e}): replaced by their neighbours' median",
            found.len(),
            table.place.of(first)
        ),
    ));
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
    let (low, high) = extremes(x);
    let Some(usual) = quantile(&mut steps.clone(), 0.95) else {
        return Vec::new();
    };
    let moving = steps.iter().copied().filter(|s| *s > 0.0);
    let quantum = moving.fold(f64::INFINITY, f64::min);
    let long = JUMP_USUAL * usual.max(quantum);
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
    let counter = (8..=32).map(|k| 2f64.powi(k) * quantum);
    let candidates = [TAU]
        .into_iter()
        .filter(|_| kind == MotionKind::Rotary)
        .chain(counter);
    let known = candidates.min_by(|a, b| (a - median).abs().total_cmp(&(b - median).abs()));
    let known = known.filter(|w| (w / median - 1.0).abs() < SAME_WRAP);
    let wrap = known.or((jumps.len() > 1).then_some(median));
    let Some(wrap) = wrap.filter(|w| same && *w > 0.8 * (high - low)) else {
        warnings.push(Warning::new(
            "position-jump",
            format!(
                "the position jumps {} times, first by {:.4e} at {}: nothing is filtered across, and what lies beyond may be displaced",
                jumps.len(),
                x[first] - x[first - 1],
                table.place.of(first)
            ),
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
    warnings.push(Warning::new(
        "wrapped",
        format!(
            "the position wraps around at {wrap:.6e} {} times, first at {}: unwrapped",
            jumps.len(),
            table.place.of(first)
        ),
    ));
    Vec::new()
}

/// Stretches of the `pieces` in which one signal stays exactly as it is, beyond its habit, and jumps as it comes back; the effort may jump
/// as it stops instead.
fn dropouts(frame: &mut Frame, pieces: &[Range<usize>]) -> Vec<Range<usize>> {
    let position = frame.column(Slot::Position).cloned();
    let mut found = Vec::new();
    if let Some(x) = &position {
        let (jumps, moves) = (
            steps_over(JUMP_HELD, x, pieces),
            steps_over(MOVING, x, pieces),
        );
        found.extend(held(x, pieces, |r| moves(r.start) && jumps(r.end)));
        let travel = extremes(x);
        let moves = |r: &Range<usize>| {
            let (low, high) = extremes(&x[r.clone()]);
            high - low > 0.01 * (travel.1 - travel.0)
        };
        if let Some(f) = frame.column(Slot::Effort) {
            let extreme = extremes(f);
            // A saturated effort stays at its limit.
            let limited = |v: f64| v == extreme.0 || v == extreme.1;
            let jumps = steps_over(JUMP_HELD, f, pieces);
            found.extend(held(f, pieces, |r| {
                moves(r) && !limited(f[r.start]) && (jumps(r.start) || jumps(r.end))
            }));
        }
    }
    found.sort_by_key(|r| r.start);
    let mut merged: Vec<Range<usize>> = Vec::new();
    for range in found {
        match merged.last_mut() {
            Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
            _ => merged.push(range),
        }
    }
    merged
}

fn held(
    values: &[f64],
    pieces: &[Range<usize>],
    wanted: impl Fn(&Range<usize>) -> bool,
) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for piece in pieces {
        let mut start = piece.start;
        for i in piece.start + 1..=piece.end {
            if i == piece.end || values[i] != values[start] {
                runs.push(start..i);
                start = i;
            }
        }
    }
    let mut lengths: Vec<f64> = runs.iter().map(|r| r.len() as f64).collect();
    let habit = quantile(&mut lengths, 0.99).unwrap_or(0.0) as usize;
    let fewest = DROPOUT.max(DROPOUT_USUAL * habit);
    runs.retain(|r| r.len() >= fewest && wanted(r));
    runs
}

/// Tells of a sample whether the step to it exceeds `times` what all but 1 % of the steps are. Where a piece begins or ends it tells
/// nothing: what stands still there may rest.
fn steps_over<'a>(
    times: f64,
    values: &'a [f64],
    pieces: &'a [Range<usize>],
) -> impl Fn(usize) -> bool + 'a {
    let mut steps: Vec<f64> = values.windows(2).map(|p| (p[1] - p[0]).abs()).collect();
    let long = times * quantile(&mut steps, 0.99).unwrap_or(0.0);
    let inside = |i: usize| pieces.iter().any(|p| p.start < i && i < p.end);
    move |i| inside(i) && (values[i] - values[i - 1]).abs() > long
}

#[cfg(test)]
mod tests {
    use super::super::{LoadOptions, Recording, load_csv};

    /// A swing of 20 mm against 5 N and noise of 20 mN at 1 kHz, `change` put upon it.
    fn load(change: impl Fn(usize, &mut [f64; 2])) -> Recording {
        let mut seed = 14_u32;
        let mut text = "t_s,x_m,force_N\n".to_owned();
        for i in 0..10_000_usize {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let phase = i as f64 * 0.003;
            let noise = 0.04 * (f64::from(seed) / f64::from(u32::MAX) - 0.5);
            let mut row = [
                0.02 * phase.sin(),
                5.0 * (20.0 * phase.cos()).tanh() + noise,
            ];
            change(i, &mut row);
            text += &format!("{:.3},{:.8},{:.5}\n", i as f64 * 1e-3, row[0], row[1]);
        }
        load_csv(text.as_bytes(), "swing.csv", &LoadOptions::default())
            .unwrap_or_else(|e| panic!("{e}"))
    }

    #[test]
    fn half_a_second_of_nothing_is_left_out_whatever_nothing_is() {
        let lost = 4000..4500_usize;
        let phase = 4000.0 * 0.003;
        let held = [
            0.02 * f64::sin(phase),
            5.0 * (20.0 * f64::cos(phase)).tanh(),
        ];
        let both = |to: [f64; 2]| {
            let lost = lost.clone();
            move |i: usize, row: &mut [f64; 2]| {
                if lost.contains(&i) {
                    *row = to;
                }
            }
        };
        // The effort comes back where it is zero anyway: it jumps as it stops only.
        let effort = |i: usize, row: &mut [f64; 2]| match i {
            4000..4500 => row[1] = 0.0,
            4500..4520 => row[1] *= 0.05 * (i - 4499) as f64,
            _ => (),
        };
        for (name, recording) in [
            ("zero", load(both([0.0; 2]))),
            ("held", load(both(held))),
            ("effort", load(effort)),
        ] {
            let said = recording.warnings.iter().find(|w| w.code == "dropout");
            let said = said.unwrap_or_else(|| panic!("{name}: {:?}", recording.warnings));
            assert!(
                said.message.contains("from line 4002 to line 4501"),
                "{name}: {}",
                said.message
            );
            assert_eq!(
                (recording.len(), recording.pieces.len()),
                (9500, 2),
                "{name}"
            );
        }
        assert!(load(|_, _| ()).warnings.iter().all(|w| w.code != "dropout"));
        // It slows down, rests at a reversal, and is told where it is.
        let homed = load(|i, row| {
            let phase = match i {
                0..4712 => i as f64 * 0.003,
                _ => 4712.0 * 0.003,
            };
            if i < 6000 {
                row[0] = 0.02 * phase.sin();
            } else {
                row[0] += 0.3;
            }
        });
        assert!(
            homed.warnings.iter().all(|w| w.code != "dropout"),
            "{:?}",
            homed.warnings
        );
    }
}
