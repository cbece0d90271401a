//! Rigid body and hysteresis along a recording, which effort and motion are held against before there is a model.

use super::{Deflection, Kinematics, not_yet_known};
use crate::recording::Recording;
use crate::statistics::LeastSquares;
use std::ops::Range;

/// Samples that are fitted at most.
const MOST: usize = 30_000;
/// Blocks of contiguous samples by which intervals are found.
pub(super) const BLOCKS: usize = 24;

/// So many samples in these.
pub(super) fn blocks(samples: usize) -> impl Iterator<Item = Range<usize>> {
    let cut = move |k: usize| k * samples / BLOCKS;
    (0..BLOCKS).map(move |k| cut(k)..cut(k + 1))
}

/// One of so many samples is fitted.
pub(super) fn every(recording: &Recording) -> usize {
    recording.len().div_ceil(MOST)
}

/// Rigid body and hysteresis along a recording, to be fitted to one effort or another.
pub(super) struct Rigid<'a> {
    pub(super) recording: &'a Recording,
    pub(super) kinematics: &'a Kinematics,
    pub(super) columns: Vec<Vec<f64>>,
    yields: Vec<f64>,
    /// Samples that are fitted.
    pub(super) rows: Vec<usize>,
}

impl<'a> Rigid<'a> {
    /// With blocks of these yields (m or rad).
    pub(super) fn of(recording: &'a Recording, kinematics: &'a Kinematics, yields: &[f64]) -> Self {
        let smooth = |column: Vec<f64>| kinematics.filter.smooth(&column);
        let blocks = yields
            .iter()
            .map(|d| smooth(Deflection::along(&recording.position, &recording.pieces, *d).z));
        let mut columns: Vec<Vec<f64>> = blocks.collect();
        columns.push(kinematics.acceleration.clone());
        columns.push(kinematics.velocity.clone());
        columns.push(vec![1.0; recording.len()]);
        let position = recording.position.iter();
        columns.push(position.clone().map(|x| x.sin()).collect());
        columns.push(position.map(|x| x.cos()).collect());
        let every = every(recording);
        let known = (recording.pieces.iter())
            .flat_map(|piece| not_yet_known(recording, piece).end..piece.end);
        Self {
            recording,
            kinematics,
            columns,
            yields: yields.to_vec(),
            rows: known.step_by(every).collect(),
        }
    }

    /// The same within another band.
    pub(super) fn within<'b>(&'b self, kinematics: &'b Kinematics) -> Rigid<'b> {
        Rigid {
            rows: self.rows.clone(),
            ..Rigid::of(self.recording, kinematics, &self.yields)
        }
    }

    /// Time from one of the samples that may be fitted to the next (s).
    pub(super) fn step_s(&self) -> f64 {
        every(self.recording) as f64 * self.recording.sample_time_s()
    }

    /// Values of all samples at those that are fitted.
    pub(super) fn fitted(&self, values: &[f64]) -> Vec<f64> {
        self.rows.iter().map(|&i| values[i]).collect()
    }

    /// The columns at some rows.
    pub(super) fn at(&self, rows: &[usize]) -> Vec<Vec<f64>> {
        let one = |column: &Vec<f64>| rows.iter().map(|&i| column[i]).collect();
        self.columns.iter().map(one).collect()
    }

    /// What is left of an effort at every sample by the fit to the rows that `fits` admits.
    pub(super) fn left(&self, effort: &[f64], fits: impl Fn(usize) -> bool) -> Option<Vec<f64>> {
        let rows: Vec<usize> = self.rows.iter().copied().filter(|i| fits(*i)).collect();
        let columns = self.at(&rows);
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let target: Vec<f64> = rows.iter().map(|&i| effort[i]).collect();
        let solved = LeastSquares::of(&columns)?.coefficients(&target);
        let modelled = |i: usize| -> f64 {
            let parts = solved.iter().zip(&self.columns);
            parts.map(|(c, column)| c * column[i]).sum()
        };
        Some((0..effort.len()).map(|i| effort[i] - modelled(i)).collect())
    }

    pub(super) fn squares(&self, left: &[f64], of: impl Fn(usize) -> bool) -> f64 {
        let rows = self.rows.iter().filter(|i| of(**i));
        let (sum, count) = rows.fold((0.0, 0.0), |(s, n), i| (s + left[*i].powi(2), n + 1.0));
        sum / f64::max(count, 1.0)
    }
}
