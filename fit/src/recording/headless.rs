//! Text without a header: what its columns look like, from its first rows.

use super::error::Problem;
use super::layout::{self, Layout, Line};
use super::propose::{quoted, sample_time};

/// Names the columns of a text that does not: those of a joint state as `ros2 topic echo --csv` writes it by what they are, others by number. Returns
/// what is to be said where they are not mapped.
pub(super) fn name(layout: &mut Layout, head: &[Line]) -> Option<Problem> {
    let is_row = |l: &&Line| l.number >= layout.first_line && !l.text.trim().is_empty();
    let rows = head.iter().filter(is_row);
    let rows: Vec<Vec<&str>> = rows
        .map(|l| layout::cells(&l.text, layout.separator, true))
        .collect();
    let first = rows.first()?;
    if let Some(names) = joint_state(first) {
        layout.names = names;
        return None;
    }
    let columns = first.len() - usize::from(first.last() == Some(&""));
    layout.names = (1..=columns).map(|n| format!("column{n}")).collect();
    let comma = layout.separator != b',';
    let numbers = |row: &Vec<&str>| -> Option<Vec<f64>> {
        let cells = row.get(..columns)?.iter();
        cells.map(|c| layout::parse(c, comma)).collect()
    };
    let rows: Vec<Vec<f64>> = rows.iter().filter_map(numbers).collect();
    let column = |i: usize| rows.iter().map(|row| row[i]).collect();
    let values: Vec<Vec<f64>> = (0..columns).map(column).collect();
    let maps = guess(&values, layout.sample_time);
    Some(Problem::no_header(
        layout.first_line,
        first[0],
        columns,
        maps,
    ))
}

/// The columns of `sec,nanosec,frame,NAME…,POSITION…,VELOCITY…,EFFORT…` with as many of each as there are joints.
fn joint_state(cells: &[&str]) -> Option<Vec<String>> {
    let is_number = |cell: &str| layout::parse(cell, false).is_some();
    let whole = |at: usize| cells.get(at)?.parse::<u64>().ok();
    let (seconds, nanoseconds) = (whole(0)?, whole(1)?);
    let frame = *cells.get(2).filter(|cell| !is_number(cell))?;
    let joints = cells[3..].iter().copied();
    let joints: Vec<&str> = joints.take_while(|c| !is_number(c)).collect();
    let numbers = cells.len() - 3 - joints.len();
    let is_stamp = seconds > 0 && nanoseconds < 1_000_000_000;
    if joints.is_empty() || joints.iter().any(|j| j.is_empty()) || !is_stamp {
        return None;
    }
    let kinds = &["position", "velocity", "effort"][..(numbers / joints.len()).min(3)];
    (kinds.len() * joints.len() == numbers).then(|| {
        let name = if frame.is_empty() { "frame" } else { frame };
        let mut names = vec!["sec".to_owned(), "nanosec".to_owned(), name.to_owned()];
        names.extend((1..=joints.len()).map(|n| format!("name{n}")));
        for kind in kinds {
            names.extend(joints.iter().map(|joint| format!("{joint}.{kind}")));
        }
        names
    })
}

/// The `--map`s that would read columns whose numbers look like time, position and effort.
fn guess(columns: &[Vec<f64>], told: Option<f64>) -> Vec<String> {
    let mut open: Vec<usize> = (0..columns.len())
        .filter(|&i| columns[i].windows(2).any(|p| p[0] != p[1]))
        .collect();
    let name = |i: usize| format!("column{}", i + 1);
    let clock = open.iter().copied().find(|&i| is_clock(&columns[i]));
    let counter = open.iter().copied().find(|&i| is_counter(&columns[i]));
    open.retain(|&i| Some(i) != clock && Some(i) != counter);
    let moves = motion(columns, &open);
    let position = match moves {
        Some((position, ..)) => Some(position),
        None => smoothest(columns, &open),
    };
    let mut maps = Vec::new();
    maps.push(match (clock, told, moves) {
        (Some(i), ..) => format!("t_s={}", in_seconds(&columns[i], &name(i))),
        (None, None, Some((_, _, step))) => format!("dt_s={step:.3e}"),
        (None, told, _) => format!("dt_s={}", sample_time(told)),
    });
    let Some(position) = position else {
        return Vec::new();
    };
    let (target, unit) = match travel(&columns[position]) {
        x if x > MOST_RADIANS => ("q_rad", "[deg]"),
        x if x > MOST_METRES => ("q_rad", ""),
        _ => ("x_m", ""),
    };
    maps.push(format!("{target}={}{unit}", name(position)));
    let is_motion =
        |i: usize| i == position || moves.is_some_and(|m| m.1 == i) || alike(columns, i, position);
    let Some(effort) = open.iter().rev().copied().find(|&i| !is_motion(i)) else {
        return Vec::new();
    };
    maps.push(format!("effort_raw={}", name(effort)));
    maps.iter()
        .map(|map| format!("--map {}", quoted(map)))
        .collect()
}

/// Travel (m) that few linear axes have in the first second: what is longer is an angle.
const MOST_METRES: f64 = 0.5;
/// Travel (rad) above which an angle is in degrees.
const MOST_RADIANS: f64 = 20.0;

fn travel(values: &[f64]) -> f64 {
    let (low, high) = crate::statistics::bounds(values);
    high - low
}

fn steps(values: &[f64]) -> Vec<f64> {
    values.windows(2).map(|p| p[1] - p[0]).collect()
}

fn ascending(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values
}

fn is_whole(values: &[f64]) -> bool {
    values.iter().all(|v| v.fract() == 0.0)
}

/// It counts the rows.
fn is_counter(values: &[f64]) -> bool {
    is_whole(values) && steps(values).iter().all(|&s| s == 1.0)
}

/// It rises in steps of one length, but for some jitter.
fn is_clock(values: &[f64]) -> bool {
    const JITTER: f64 = 0.5;
    let sorted = ascending(steps(values));
    let [first, .., last] = sorted.as_slice() else {
        return false;
    };
    let usual = sorted[sorted.len() / 2];
    // A motion at an even speed has none of a clock's precision over its first rows.
    let spread = sorted[sorted.len() * 9 / 10] - sorted[sorted.len() / 10];
    *first > 0.0 && *last < 20.0 * usual && spread < JITTER * usual && !is_counter(values)
}

/// A clock's column times what makes seconds of it, by the usual rates of 20 Hz to 20 kHz.
fn in_seconds(values: &[f64], name: &str) -> String {
    let sorted = ascending(steps(values));
    let step = sorted[sorted.len() / 2];
    match step {
        s if s <= 0.2 && !is_whole(values) => name.to_owned(),
        s if s < 50.0 => format!("0.001*{name}"),
        s if s < 5e4 => format!("1e-6*{name}"),
        _ => format!("1e-9*{name}"),
    }
}

/// A position, its velocity and the time step (s) that makes the one the integral of the other.
fn motion(columns: &[Vec<f64>], open: &[usize]) -> Option<(usize, usize, f64)> {
    /// Correlation of steps of the position with the velocity.
    const ALIKE: f64 = 0.98;
    let mut best: Option<(usize, usize, f64, f64)> = None;
    for (&x, &v) in open.iter().flat_map(|x| open.iter().map(move |v| (x, v))) {
        if x == v {
            continue;
        }
        let moved = columns[x].windows(3).map(|p| 0.5 * (p[2] - p[0]));
        let pairs = || moved.clone().zip(columns[v].iter().skip(1).copied());
        let sum = |of: fn(f64, f64) -> f64| pairs().map(|(a, b)| of(a, b)).sum::<f64>();
        let (both, moved_2, v_2) = (sum(|a, b| a * b), sum(|a, _| a * a), sum(|_, b| b * b));
        let like = both / (moved_2 * v_2).sqrt();
        // A reference stands before what it asks for.
        if like > ALIKE && best.is_none_or(|b| like > b.3 - 1e-6) {
            best = Some((x, v, both / v_2, like));
        }
    }
    best.map(|(x, v, step, _)| (x, v, step))
}

/// The column whose steps change least from one to the next.
fn smoothest(columns: &[Vec<f64>], open: &[usize]) -> Option<usize> {
    let square = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>();
    let rough = |i: usize| {
        let first = steps(&columns[i]);
        square(&steps(&first)) / square(&first)
    };
    let with = open.iter().map(|&i| (rough(i), i));
    with.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, i)| i)
}

/// A reference of the position, or the position once more.
fn alike(columns: &[Vec<f64>], i: usize, position: usize) -> bool {
    const SHARE: f64 = 0.05;
    let off = columns[i].iter().zip(&columns[position]);
    let off = off.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    off < SHARE * travel(&columns[position])
}
