//! Which samples are fitted and which are held out.

use crate::recording::Recording;
use std::collections::BTreeMap;

/// A window of time [s], from (inclusive) to (exclusive).
pub type Window = (f64, f64);

/// Reads `100..145`.
///
/// # Errors
/// What is wrong with it, for a person to read.
pub fn parse_window(text: &str) -> Result<Window, String> {
    let wrong =
        || format!("`{text}` is no window of time: write FROM..TO in seconds, such as 100..145");
    let (from, to) = text.split_once("..").ok_or_else(wrong)?;
    let read = |part: &str| part.trim().parse::<f64>().ok().filter(|t| t.is_finite());
    match (read(from), read(to)) {
        (Some(from), Some(to)) if from < to => Ok((from, to)),
        (Some(_), Some(_)) => Err(format!(
            "`{text}` is no window of time: it must end after it starts"
        )),
        _ => Err(wrong()),
    }
}

/// Training samples in folds, and the held-out samples where a window of their own was asked for.
#[derive(Clone, Debug)]
pub struct Split {
    /// Samples to fit, by repeat, or by segment where the motion does not repeat.
    pub folds: Vec<Vec<usize>>,
    /// What a fold is: "repeat" or "segment".
    pub unit: &'static str,
    /// Samples of the test window; `None` means cross-validation over the folds.
    pub test: Option<Vec<usize>>,
}

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
        let repeats = group(&recording.repeat);
        let (folds, unit) = if repeats.len() > 2 {
            (repeats, "repeat")
        } else {
            (group(&recording.segment), "segment")
        };
        let test = test.map(|_| (0..recording.len()).filter(|&i| within(test, i)).collect());
        Self { folds, unit, test }
    }

    /// All training samples, in order.
    pub fn train(&self) -> Vec<usize> {
        let mut rows = self.folds.concat();
        rows.sort_unstable();
        rows
    }
}
