//! What both file formats come to: columns of numbers, and where each sample stands in the file.

use super::columns::Plan;
use super::extra;
use super::labels::Labels;

/// The columns that a [`Plan`] asks for.
#[derive(Debug)]
pub(super) struct Table {
    pub(super) plan: Plan,
    /// One per source of the plan, in its order.
    pub(super) data: Vec<Data>,
    /// The columns that the plan does not use.
    pub(super) extra: Vec<extra::Reading>,
    pub(super) place: Location,
    /// Unused columns that keep their first value for a while, and the sample where they first
    /// change: candidates for a segment where time starts again.
    pub(super) first_change: Vec<(String, usize)>,
}

/// The samples of one source.
#[derive(Debug)]
pub(super) enum Data {
    Numbers(Vec<f64>),
    Labels(Labels),
}

/// Where samples stand in their file.
#[derive(Debug)]
pub(super) struct Location {
    /// What is counted: "line" of a text, "element" of a variable, both from 1.
    pub(super) what: &'static str,
    /// `(sample, place)` wherever a place does not follow its predecessor's.
    pub(super) breaks: Vec<(usize, u64)>,
}

impl Location {
    /// "line 17" or "element 16", for messages.
    pub(super) fn of(&self, sample: usize) -> String {
        format!("{} {}", self.what, self.number(sample))
    }

    fn number(&self, sample: usize) -> u64 {
        let before = self.breaks.partition_point(|&(first, _)| first <= sample);
        let known = before.checked_sub(1).and_then(|i| self.breaks.get(i));
        let (first, place) = known.copied().unwrap_or((0, 1));
        place + sample.saturating_sub(first) as u64
    }

    /// The places of the samples that are kept.
    pub(super) fn keep(&mut self, kept: &[bool]) {
        let old = (0..kept.len()).filter(|i| kept[*i]);
        let places = old.map(|i| self.number(i)).enumerate();
        self.breaks = places.collect();
    }
}
