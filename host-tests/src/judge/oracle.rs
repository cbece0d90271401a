//! Whether an injected effect is there at all: a regression that is given its true column.
//!
//! Rigid body, stops, direction and smooth trends over time and position are fitted by least squares with and without the column, on
//! nine tenths of the recording, and the loss on the last tenth is compared. Nothing of it is shared with the tool.

use super::motion::{Extent, Motion};
use super::table::Table;
use crate::least_squares::least_squares;

/// Rows are averaged over this time (s).
const BIN_S: f64 = 10e-3;
/// Folds held out in turn …
const FOLDS: usize = 10;
/// … each of so many blocks spread over the recording: a trend need not be carried beyond what was fitted.
const SPREAD: usize = 4;
/// Yields of the stops as shares of the travel.
const YIELDS: [f64; 6] = [1e-4, 5e-4, 2e-3, 8e-3, 3e-2, 1e-1];
/// The column is there where it takes this share of the held-out loss, as the generators' oracles ask …
const SHARE: f64 = 0.05;
/// … lowers the loss in this many of the folds (a sign test: p = 0.011), whatever one bad fold does to the mean, …
const AGREE: usize = 9;
/// … and is found about as large as it was added: one that the machine's own physics takes up, or that stands for it, is not seen.
const AS_ADDED: std::ops::RangeInclusive<f64> = 0.6..=1.6;

/// What the oracle says of a column.
#[derive(Clone, Copy, Debug)]
pub struct Verdict {
    /// Share of the held-out loss that the column takes.
    pub share: f64,
    /// Folds in which the loss is lower with the column.
    pub folds: usize,
    /// Its coefficient, of the one with which it was added.
    pub as_added: f64,
    /// All three are enough.
    pub there: bool,
}

/// Columns of a base that is fitted to the effort.
pub struct Base {
    rows: Vec<Vec<f64>>,
    effort: Vec<f64>,
}

/// Averages of consecutive rows that last [`BIN_S`], within the pieces.
fn binned(column: &[f64], motion: &Motion, step: f64) -> Vec<f64> {
    let n = ((BIN_S / step).round() as usize).max(1);
    let pieces = motion.pieces.iter();
    pieces
        .flat_map(|piece| column[piece.clone()].chunks_exact(n))
        .map(|bin| bin.iter().sum::<f64>() / n as f64)
        .collect()
}

impl Base {
    /// Of all parts of a recording, without the columns that are the effect `id` itself or inseparable from it.
    pub fn new(parts: &[Table], motions: &[Motion], id: &str) -> Self {
        let extent = Extent::of(motions);
        let (mut rows, mut effort) = (Vec::new(), Vec::new());
        for (part, motion) in parts.iter().zip(motions) {
            let step = part.sample_time();
            let columns: Vec<Vec<f64>> = base(part, motion, &extent, id)
                .iter()
                .map(|c| binned(c, motion, step))
                .collect();
            effort.extend(binned(&part.columns[part.effort()], motion, step));
            rows.extend((0..columns[0].len()).map(|i| columns.iter().map(|c| c[i]).collect()));
        }
        Self { rows, effort }
    }

    /// Coefficients of all columns by least squares, none where they cannot be found.
    fn coefficients(&self) -> Vec<f64> {
        let all: Vec<usize> = (0..self.rows.len()).collect();
        least_squares(&self.rows, &self.effort, &all).unwrap_or_default()
    }

    /// Mass or inertia and its share of the effort's deviation; the acceleration is the first column.
    pub fn inertia(&self) -> (f64, f64) {
        let inertia = self.coefficients().first().copied().unwrap_or(0.0);
        let accelerations: Vec<f64> = self.rows.iter().map(|row| row[0]).collect();
        (
            inertia,
            inertia * deviation(&accelerations) / deviation(&self.effort),
        )
    }

    /// Level of the friction, whatever sign the effort has: all stops together, which are the last columns.
    pub fn friction(&self) -> f64 {
        let stops = self.coefficients().into_iter().rev().take(YIELDS.len());
        stops.sum::<f64>().abs()
    }

    /// Whether `column`, what was added to each row of each part, is there.
    pub fn asks(&self, parts: &[Table], motions: &[Motion], column: &[Vec<f64>]) -> Verdict {
        let parts = parts.iter().zip(motions).zip(column);
        let added: Vec<f64> = parts
            .flat_map(|((part, motion), c)| binned(c, motion, part.sample_time()))
            .collect();
        let with: Vec<Vec<f64>> = self
            .rows
            .iter()
            .zip(&added)
            .map(|(row, value)| row.iter().copied().chain([*value]).collect())
            .collect();
        let fold = |i: usize| i * FOLDS * SPREAD / self.rows.len().max(1) % FOLDS;
        let mut scale = None;
        let (mut folds, mut before, mut after) = (0, 0.0, 0.0);
        for k in 0..FOLDS {
            let (held, kept): (Vec<usize>, Vec<usize>) =
                (0..self.rows.len()).partition(|&i| fold(i) == k);
            let (Some(old), Some(new)) = (
                residuals(&self.rows, &self.effort, &kept, &held),
                residuals(&with, &self.effort, &kept, &held),
            ) else {
                continue;
            };
            let scale = *scale.get_or_insert_with(|| 1.345 * 1.4826 * median_size(&old));
            let (old, new) = (loss(&old, scale), loss(&new, scale));
            (before, after) = (before + old, after + new);
            folds += usize::from(new < old);
        }
        let share = 1.0 - after / before;
        let all: Vec<usize> = (0..with.len()).collect();
        let as_added = least_squares(&with, &self.effort, &all)
            .and_then(|c| c.last().copied())
            .unwrap_or(0.0);
        Verdict {
            share,
            folds,
            as_added,
            there: share >= SHARE && folds >= AGREE && AS_ADDED.contains(&as_added),
        }
    }
}

/// Acceleration first.
fn base(part: &Table, motion: &Motion, extent: &Extent, id: &str) -> Vec<Vec<f64>> {
    let from_middle: Vec<f64> = motion
        .x
        .iter()
        .map(|x| 2.0 * (x - extent.low) / extent.travel - 1.0)
        .collect();
    let over = |y: &[f64], f: &dyn Fn(f64) -> f64| y.iter().map(|y| f(*y)).collect::<Vec<f64>>();
    let conservative = ["position_spring", "gravity"].contains(&id);
    let last = motion.t.last().copied().unwrap_or(1.0);
    let mut columns = vec![motion.a.clone()];
    if id != "constant_force" && id != "coulomb_asymmetry" {
        columns.push(vec![1.0; motion.x.len()]);
    }
    if id != "viscous" {
        columns.push(motion.v.clone());
    }
    columns.push(over(&motion.t, &|t: f64| t / last));
    if !conservative {
        for power in 1..=3 {
            columns.push(over(&from_middle, &|x: f64| x.powi(power)));
        }
        if part.rotary() {
            columns.extend([over(&motion.x, &f64::sin), over(&motion.x, &f64::cos)]);
        }
    }
    let longest = if conservative { 0.025 } else { 1.0 };
    let yields = YIELDS.iter().filter(|share| **share < longest);
    columns.extend(yields.map(|share| motion.stop(share * extent.travel)));
    columns
}

fn residuals(
    rows: &[Vec<f64>],
    effort: &[f64],
    kept: &[usize],
    held: &[usize],
) -> Option<Vec<f64>> {
    let c = least_squares(rows, effort, kept)?;
    let left = |&i: &usize| effort[i] - rows[i].iter().zip(&c).map(|(a, b)| a * b).sum::<f64>();
    Some(held.iter().map(left).collect())
}

/// Huber's loss, summed.
fn loss(residuals: &[f64], scale: f64) -> f64 {
    let one = |r: &f64| match r.abs() {
        r if r < scale => 0.5 * r * r,
        r => scale * (r - 0.5 * scale),
    };
    residuals.iter().map(one).sum()
}

fn median_size(y: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = y.iter().map(|y| y.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get(sizes.len() / 2).copied().unwrap_or(0.0)
}

/// Standard deviation, of the values as they are (not of their mean).
pub fn deviation(y: &[f64]) -> f64 {
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    (y.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / y.len() as f64).sqrt()
}
