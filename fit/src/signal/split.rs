//! Which samples are fitted and which are held out.

use crate::recording::Recording;
use std::collections::BTreeMap;

/// A window of time (s), from (inclusive) to (exclusive).
pub type Window = (f64, f64);

/// Reads `100..145`.
///
/// # Errors
/// What is wrong with it, for a person to read.
pub fn parse_window(text: &str) -> Result<Window, String> {
    let wrong =
        || format!("`{text}` is not a window of time: write FROM..TO in seconds, such as 100..145");
    let (from, to) = text.split_once("..").ok_or_else(wrong)?;
    let read = |part: &str| part.trim().parse::<f64>().ok().filter(|t| t.is_finite());
    match (read(from), read(to)) {
        (Some(from), Some(to)) if from < to => Ok((from, to)),
        (Some(_), Some(_)) => Err(format!(
            "`{text}` is not a window of time: it must end after it starts"
        )),
        _ => Err(wrong()),
    }
}

/// A fold shorter than the usual one by this factor, such as a window's or a recording's end cuts it, shows too
/// little to stand alone.
const SHORT: usize = 4;

/// Folds beyond this number add nothing to confidence; neighbours join.
const MOST_FOLDS: usize = 200;

/// Folds below which finer ones are taken: of five signs one in 32 is alike by chance.
pub const FEWEST: usize = 6;

/// Stretches that few strokes or repeats are cut into, together.
const STRETCHES: usize = 10;

/// Each fold in as many stretches of equal length, so that there are some [`STRETCHES`] in all.
fn parts(folds: &[Vec<usize>]) -> Vec<Vec<Vec<usize>>> {
    let total: usize = folds.iter().map(Vec::len).sum();
    let length = total.div_ceil(STRETCHES).max(1);
    let cut = |rows: &Vec<usize>| {
        let count = (rows.len() as f64 / length as f64).round().max(1.0) as usize;
        let each = rows.len().div_ceil(count).max(1);
        rows.chunks(each).map(<[_]>::to_vec).collect()
    };
    folds.iter().map(cut).collect()
}

/// Joins short folds to the one before (leading ones to the first that is not), then neighbours.
fn joined(folds: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
    let mut lengths: Vec<usize> = folds.iter().map(Vec::len).collect();
    lengths.sort_unstable();
    let usual = lengths.get(lengths.len() / 2).copied().unwrap_or(0);
    let mut whole: Vec<Vec<usize>> = Vec::new();
    let mut leading = Vec::new();
    for fold in folds {
        match whole.last_mut() {
            _ if SHORT * fold.len() >= usual => {
                whole.push([std::mem::take(&mut leading), fold].concat());
            }
            Some(before) => before.extend(fold),
            None => leading.extend(fold),
        }
    }
    let together = whole.len().div_ceil(MOST_FOLDS).max(1);
    whole.chunks(together).map(<[_]>::concat).collect()
}

/// Checks that both windows hold samples, and that the test window leaves some of the training window.
///
/// # Errors
/// Which window does not, and what the recording covers.
pub fn check_windows(
    recording: &Recording,
    train: Option<Window>,
    test: Option<Window>,
) -> Result<(), String> {
    let inside = |window: Window, t: f64| (window.0..window.1).contains(&t);
    let bound = |pick: fn(f64, f64) -> f64| recording.t_s.iter().copied().reduce(pick);
    let covers = format!(
        "{} runs from {} to {} s",
        recording.name,
        bound(f64::min).unwrap_or(f64::NAN),
        bound(f64::max).unwrap_or(f64::NAN)
    );
    for (option, window) in [("--train", train), ("--test", test)] {
        if let Some(window) = window
            && recording.t_s.iter().filter(|&&t| inside(window, t)).count() < 2
        {
            return Err(format!(
                "{option} {}..{} holds no two samples: {covers}; choose a window within",
                window.0, window.1
            ));
        }
    }
    let left = |&&t: &&f64| {
        train.is_none_or(|window| inside(window, t))
            && !test.is_some_and(|window| inside(window, t))
    };
    if recording.t_s.iter().filter(left).count() < 2 {
        return Err(format!(
            "--test covers all that --train would fit, and no sample is both fitted and judged: {covers}; choose windows that do not overlap"
        ));
    }
    Ok(())
}

/// Training samples in folds, and the held-out samples where a window of their own was asked for.
#[derive(Clone, Debug)]
pub struct Split {
    /// Samples to fit, by repeat; by segment where the motion does not repeat often enough, by stretches of time where it turns too seldom.
    pub folds: Vec<Vec<usize>>,
    /// What a fold is: "repeat", "segment" or "stretch".
    pub unit: &'static str,
    /// Samples of the test window; `None` means cross-validation over the folds.
    pub test: Option<Vec<usize>>,
}

/// Most groups of folds that take turns in being held out.
pub const GROUPS: usize = 6;

impl Split {
    /// Splits a recording; without windows all of it is fitted and the folds take turns in being held out.
    pub fn new(recording: &Recording, train: Option<Window>, test: Option<Window>) -> Self {
        let within = |window: Option<Window>, i: usize| {
            window.is_none_or(|(from, to)| (from..to).contains(&recording.t_s[i]))
        };
        let outside_test = |i: usize| test.is_none() || !within(test, i);
        let rows: Vec<usize> = (0..recording.len())
            .filter(|&i| within(train, i) && outside_test(i))
            .collect();
        let group = |labels: &[u32]| {
            let mut groups: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
            for &i in &rows {
                groups.entry(labels[i]).or_default().push(i);
            }
            groups.into_values().collect::<Vec<_>>()
        };
        let repeats = joined(group(&recording.repeat));
        let segments = joined(group(&recording.segment));
        // Three repeats and more, each with all of the motion, scatter as another recording would; their strokes scatter less. A repeat of one stroke
        // has not all of it: one direction says nothing of the other.
        let (folds, unit) = if repeats.len() > 2 && segments.len() > repeats.len() {
            (repeats, "repeat")
        } else if segments.len() >= FEWEST {
            (segments, "segment")
        } else {
            (parts(&segments).concat(), "stretch")
        };
        let test = test.map(|_| (0..recording.len()).filter(|&i| within(test, i)).collect());
        Self { folds, unit, test }
    }

    /// Several of [`Split::unit`].
    pub fn units(&self) -> &'static str {
        match self.unit {
            "repeat" => "repeats",
            "segment" => "segments",
            _ => "stretches",
        }
    }

    /// Neighbouring folds that are held out together: at most [`GROUPS`] groups.
    pub fn groups(&self) -> impl Iterator<Item = &[Vec<usize>]> {
        let per_group = self.folds.len().div_ceil(GROUPS).max(1);
        self.folds.chunks(per_group)
    }

    /// Parts of every fold: itself where there are [`FEWEST`], else stretches of it. Few repeats give honest intervals; whether a column predicts
    /// what was held out takes more of them.
    pub fn parts(&self) -> Vec<Vec<Vec<usize>>> {
        match self.folds.len() < FEWEST {
            true => parts(&self.folds),
            false => self.folds.iter().map(|fold| vec![fold.clone()]).collect(),
        }
    }

    /// All training samples, in order.
    pub fn train(&self) -> Vec<usize> {
        let mut rows = self.folds.concat();
        rows.sort_unstable();
        rows
    }
}
