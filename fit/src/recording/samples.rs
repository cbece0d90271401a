//! Some of the samples of a recording, or others in their place: all columns alike.

use super::{Extra, Problem, Recording, RecordingError};
use crate::statistics::bounds;
use std::ops::Range;

impl Recording {
    /// The samples with `from ≤ t < to` (s), so that adjoining windows share none. Segments and
    /// repeats keep their numbers, warnings are those of the whole file.
    ///
    /// # Errors
    /// Where fewer than two samples lie in the window.
    pub fn slice_time(&self, from: f64, to: f64) -> Result<Recording, RecordingError> {
        let inside: Vec<bool> = self.t_s.iter().map(|&t| from <= t && t < to).collect();
        if count(&inside) < 2 {
            let (start, end) = bounds(&self.t_s);
            return Err(RecordingError {
                file: self.name.clone(),
                problem: Problem::Other(format!(
                    "no samples between {from} s and {to} s; the recording covers {start} s to {end} s"
                )),
            });
        }
        Ok(self.masked(&inside))
    }

    /// The samples that are `inside`, in pieces of neighbours.
    pub(super) fn masked(&self, inside: &[bool]) -> Recording {
        let mut start = 0;
        let mut pieces = Vec::new();
        for piece in &self.pieces {
            for run in inside[piece.clone()].split(|inside| !inside) {
                if !run.is_empty() {
                    pieces.push(start..start + run.len());
                    start += run.len();
                }
            }
        }
        let joined = ranges(&self.joined, |run| count(&inside[run.clone()]));
        let t_s = kept(&self.t_s, inside);
        let (numbers, labels) = (|c: &[f64]| kept(c, inside), |c: &[u32]| kept(c, inside));
        self.with_samples(t_s, pieces, joined, numbers, labels)
    }

    /// Other samples: their times and ranges, and how each column of numbers and of labels becomes theirs.
    pub(super) fn with_samples(
        &self,
        t_s: Vec<f64>,
        pieces: Vec<Range<usize>>,
        joined: Vec<Range<usize>>,
        numbers: impl Fn(&[f64]) -> Vec<f64> + Sync,
        labels: impl Fn(&[u32]) -> Vec<u32>,
    ) -> Recording {
        // The two that are always there and may be long.
        let (position, effort) = rayon::join(|| numbers(&self.position), || numbers(&self.effort));
        let some = |column: &Option<Vec<f64>>| column.as_deref().map(&numbers);
        let extra = self.extra.iter().map(|extra| Extra {
            name: extra.name.clone(),
            values: numbers(&extra.values),
        });
        Recording {
            name: self.name.clone(),
            t_s,
            position,
            reference: some(&self.reference),
            velocity: some(&self.velocity),
            effort,
            temperature_c: some(&self.temperature_c),
            load_n: some(&self.load_n),
            pressure_pa: some(&self.pressure_pa),
            extra: extra.collect(),
            constant_extra: self.constant_extra.clone(),
            load_held: self.load_held,
            segment: labels(&self.segment),
            repeat: labels(&self.repeat),
            pieces,
            joined,
            warnings: self.warnings.clone(),
            ..*self
        }
    }
}

/// The values that are `inside`.
pub(super) fn kept<T: Copy>(values: &[T], inside: &[bool]) -> Vec<T> {
    let values = values.iter().zip(inside).filter(|(_, i)| **i);
    values.map(|(v, _)| *v).collect()
}

/// How many are `inside`.
pub(super) fn count(inside: &[bool]) -> usize {
    inside.iter().filter(|i| **i).count()
}

/// Neighbouring ranges, as long as `length` says of each of `old`.
pub(super) fn ranges(
    old: &[Range<usize>],
    length: impl Fn(&Range<usize>) -> usize,
) -> Vec<Range<usize>> {
    let mut start = 0;
    let next = |range: &Range<usize>| {
        let end = start + length(range);
        std::mem::replace(&mut start, end)..end
    };
    old.iter().map(next).collect()
}
