//! The weak form: every column is averaged with one compact kernel and thinned out.
//!
//! With `φ(t) = (1 − (t/h)²)⁴` and finite differences at the sample rate, `φ∗Δ²x/Δt²` is, by summation by parts, the same as
//! `φ''∗x`: a quantised encoder is never differentiated, and as all columns pass the same kernel nothing is biased by it.

use super::signals::Signals;
use std::ops::Range;

/// Most rows kept: more would cost time and tell nothing new.
const ROWS: usize = 20_000;

/// The kernel and where its rows are.
pub struct Weak {
    kernel: Vec<f64>,
    /// Sample at the centre of each row, ascending within each fold.
    pub centres: Vec<usize>,
    /// Rows of each fold.
    pub folds: Vec<Range<usize>>,
    /// Half-width of the kernel [s].
    pub half_width_s: f64,
    /// Samples between two rows.
    pub spacing: usize,
}

impl Weak {
    /// Chooses the kernel: about 25 ms wide, wider where the encoder's noise asks for it (−6 dB at the band of the
    /// kinematics), never below four samples. `inertial` tells whether an acceleration is needed at all.
    pub fn new(s: &Signals, inertial: bool) -> Self {
        let by_band = if inertial { 0.62 / s.band_hz } else { 0.0 };
        let by_rows = s.x.len() as f64 * s.dt / ROWS as f64;
        let half_s = by_band.max(12.5e-3).max(by_rows);
        let half = ((half_s / s.dt).round() as usize).max(4);
        let mut kernel: Vec<f64> = (0..=2 * half)
            .map(|i| {
                let u = (i as f64 - half as f64) / (half as f64 + 0.5);
                (1.0 - u * u).powi(4)
            })
            .collect();
        let sum: f64 = kernel.iter().sum();
        kernel.iter_mut().for_each(|k| *k /= sum);
        // Neighbours overlap little: white noise stays white.
        let spacing = half;
        let mut by_fold: Vec<Vec<usize>> = vec![Vec::new(); s.folds];
        for piece in &s.pieces {
            let first = piece.start + half + 1;
            let last = piece.end.saturating_sub(half + 1);
            for centre in (first..last).step_by(spacing) {
                by_fold[s.fold[centre]].push(centre);
            }
        }
        by_fold.retain(|rows| rows.len() > 20);
        let mut folds = Vec::new();
        let mut centres = Vec::new();
        for rows in by_fold {
            folds.push(centres.len()..centres.len() + rows.len());
            centres.extend(rows);
        }
        Self {
            kernel,
            centres,
            folds,
            half_width_s: half as f64 * s.dt,
            spacing,
        }
    }

    /// The column as rows.
    pub fn rows(&self, column: &[f64]) -> Vec<f64> {
        let half = self.kernel.len() / 2;
        self.centres
            .iter()
            .map(|&c| {
                column[c - half..=c + half]
                    .iter()
                    .zip(&self.kernel)
                    .map(|(v, k)| v * k)
                    .sum()
            })
            .collect()
    }

    /// The value at the centre of each row.
    pub fn at_centres(&self, column: &[f64]) -> Vec<f64> {
        self.centres.iter().map(|&c| column[c]).collect()
    }
}

/// Central difference of a column [1/s], within pieces.
pub fn slope(column: &[f64], pieces: &[Range<usize>], dt: f64) -> Vec<f64> {
    differences(column, pieces, |before, _, after| {
        (after - before) / (2.0 * dt)
    })
}

/// Second difference of a column [1/s²], within pieces.
pub fn curvature(column: &[f64], pieces: &[Range<usize>], dt: f64) -> Vec<f64> {
    differences(column, pieces, |before, here, after| {
        (after - 2.0 * here + before) / (dt * dt)
    })
}

fn differences(
    column: &[f64],
    pieces: &[Range<usize>],
    of: impl Fn(f64, f64, f64) -> f64,
) -> Vec<f64> {
    let mut out = vec![0.0; column.len()];
    for piece in pieces {
        for i in piece.start + 1..piece.end.saturating_sub(1) {
            out[i] = of(column[i - 1], column[i], column[i + 1]);
        }
    }
    out
}
