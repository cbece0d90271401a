//! Where a force acts: the stretch of a coordinate in which it is large.

use super::axis::Axis;
use super::rows::Rows;
use preslide_fit::statistics::bounds;

/// Stretches into which a coordinate is cut.
const BINS: usize = 60;
/// The same for the mean force over it.
const MEANS: usize = 48;
/// Share of its largest mean square within which a force is said to be largest: half of its amplitude. A free curve is noise elsewhere.
const LARGE: f64 = 0.25;
/// The same within which an effect is said to act, whose form has no noise: a fifth of its amplitude. A Gaussian spot acts over 2.5 of its
/// widths, and is at half of its amplitude over 1.7.
const ACTS: f64 = 0.04;
/// Fewest rows of a stretch that count.
const ROWS: usize = 3;
/// Share of a coordinate's range below which a force is said to be confined to it.
const CONFINED: f64 = 0.5;

/// A stretch of a coordinate.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The coordinate.
    pub axis: Axis,
    /// Its lower end, in the coordinate's unit.
    pub from: f64,
    /// Its upper end.
    pub to: f64,
    /// Share of the force's squares within it.
    pub share: f64,
}

impl Place {
    /// Where a free curve's `force` (at the rows) is at least half of its largest over a coordinate; `None` where the recording does not
    /// have the coordinate or the force.
    pub fn of(rows: &Rows, axis: Axis, force: &[f64]) -> Option<Self> {
        Self::within(LARGE, rows, axis, force)
    }

    /// The mean square of each stretch counts, not its sum: an axis that dwells at a place does not make the force larger there.
    fn within(least: f64, rows: &Rows, axis: Axis, force: &[f64]) -> Option<Self> {
        let values = rows.weak.at_centres(&axis.values(&rows.s)?);
        let (low, high) = bounds(&values);
        let total: f64 = force.iter().map(|f| f * f).sum();
        if total <= 0.0 || high <= low {
            return None;
        }
        let bin = |v: f64| (((v - low) / (high - low) * BINS as f64) as usize).min(BINS - 1);
        let (mut sums, mut counts) = ([0.0; BINS], [0usize; BINS]);
        for (v, f) in values.iter().zip(force) {
            sums[bin(*v)] += f * f;
            counts[bin(*v)] += 1;
        }
        let density = |i: usize| {
            if counts[i] < ROWS {
                0.0
            } else {
                sums[i] / counts[i] as f64
            }
        };
        let peak = (0..BINS).max_by(|a, b| density(*a).total_cmp(&density(*b)))?;
        let within = |i: &usize| density(*i) >= least * density(peak) || counts[*i] < ROWS;
        let first = (0..=peak).rev().take_while(within).last().unwrap_or(peak);
        let last = (peak..BINS).take_while(within).last().unwrap_or(peak);
        let edge = |i: usize| low + (high - low) * i as f64 / BINS as f64;
        Some(Self {
            axis,
            from: edge(first),
            to: edge(last + 1),
            share: (first..=last).map(|i| sums[i]).sum::<f64>() / total,
        })
    }

    /// Where an effect acts over its own coordinate, and the stretches over position, speed and time that confine it.
    pub fn all(rows: &Rows, own: Axis, force: &[f64]) -> Vec<Self> {
        let others = [Axis::Position, Axis::Speed, Axis::Time];
        let confined = |place: &Place| {
            let values = place.axis.values(&rows.s).unwrap_or_default();
            let (low, high) = bounds(&values);
            place.to - place.from < CONFINED * (high - low)
        };
        Self::within(ACTS, rows, own, force)
            .into_iter()
            .chain(
                others
                    .into_iter()
                    .filter(|axis| *axis != own)
                    .filter_map(|axis| Self::within(ACTS, rows, axis, force))
                    .filter(confined),
            )
            .collect()
    }
}

/// Means of `values` over stretches of a coordinate: centre and mean of those that hold any.
pub fn means_over(at: &[f64], values: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (low, high) = bounds(at);
    let mut sums = [(0.0, 0usize); MEANS];
    for (a, v) in at.iter().zip(values) {
        let u = (a - low) / (high - low).max(1e-300);
        let sum = &mut sums[((u * MEANS as f64) as usize).min(MEANS - 1)];
        *sum = (sum.0 + v, sum.1 + 1);
    }
    let held = sums.iter().enumerate().filter(|(_, s)| s.1 >= ROWS);
    held.map(|(i, s)| {
        let centre = low + (high - low) * (i as f64 + 0.5) / MEANS as f64;
        (centre, s.0 / s.1 as f64)
    })
    .unzip()
}
