//! The samples of a recording while they are repaired and brought to even times.

use std::ops::Range;

use super::known::Slot;
use super::{Extra, samples};

/// Columns of equal length, but for those that are not there, and how they hang together in time.
#[derive(Default)]
pub(super) struct Frame {
    pub(super) t_s: Vec<f64>,
    pub(super) numbers: Vec<(Slot, Vec<f64>)>,
    pub(super) parts: Vec<(Slot, Vec<u32>)>,
    pub(super) extra: Vec<Extra>,
    /// Samples between restarts of the clock.
    pub(super) runs: Vec<Range<usize>>,
    /// Samples between restarts and gaps; they cover the runs.
    pub(super) pieces: Vec<Range<usize>>,
}

impl Frame {
    pub(super) fn take(&mut self, slot: Slot) -> Option<Vec<f64>> {
        let at = self.numbers.iter().position(|c| c.0 == slot)?;
        Some(self.numbers.swap_remove(at).1)
    }

    pub(super) fn part(&mut self, slot: Slot) -> Option<Vec<u32>> {
        let at = self.parts.iter().position(|c| c.0 == slot)?;
        Some(self.parts.swap_remove(at).1)
    }

    pub(super) fn column(&mut self, slot: Slot) -> Option<&mut Vec<f64>> {
        let found = self.numbers.iter_mut().find(|c| c.0 == slot);
        found.map(|c| &mut c.1)
    }

    /// Cuts the pieces before each of the samples.
    pub(super) fn cut(&mut self, before: &[usize]) {
        let mut starts: Vec<usize> = self.pieces.iter().map(|p| p.start).collect();
        starts.extend(before);
        starts.sort_unstable();
        starts.dedup();
        self.pieces = super::timing::ranges(&starts, self.t_s.len());
    }

    /// Leaves samples out and cuts the pieces there.
    pub(super) fn leave_out(&mut self, out: &[Range<usize>]) {
        let cuts: Vec<usize> = out.iter().flat_map(|r| [r.start, r.end]).collect();
        let inside = cuts.iter().copied().filter(|&c| c < self.t_s.len());
        self.cut(&inside.collect::<Vec<_>>());
        let mut kept = vec![true; self.t_s.len()];
        for range in out {
            kept[range.clone()].fill(false);
        }
        self.keep(&kept);
    }

    /// Keeps some of the samples, in pieces as they are.
    pub(super) fn keep(&mut self, kept: &[bool]) {
        self.t_s = samples::kept(&self.t_s, kept);
        let numbers = self.numbers.iter_mut().map(|c| &mut c.1);
        for values in numbers.chain(self.extra.iter_mut().map(|e| &mut e.values)) {
            *values = samples::kept(values, kept);
        }
        for (_, numbers) in &mut self.parts {
            *numbers = samples::kept(numbers, kept);
        }
        for ranges in [&mut self.runs, &mut self.pieces] {
            *ranges = samples::ranges(ranges, |r| samples::count(&kept[r.clone()]));
            ranges.retain(|r| !r.is_empty());
        }
    }
}
