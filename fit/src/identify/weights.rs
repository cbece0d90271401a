//! How much each of several joined recordings counts: by its seconds, and by how closely the model meets it.
//!
//! Samples of a fast recording are no more independent than those of a slow one of the same length, so seconds count rather than
//! samples. A recording whose effort wanders or is noisy says less by the variance that the model leaves in it: feasible
//! generalised least squares with one variance per recording (Greene, *Econometric Analysis*, groupwise heteroscedasticity).

use crate::recording::Recording;
use std::ops::Range;

/// No recording's standard deviation counts as less than the largest divided by this: a recording at rest is met exactly, and
/// tells nothing.
const MOST_APART: f64 = 30.0;

/// The weight of each sample; of one recording alone all count alike.
#[derive(Clone, Debug, Default)]
pub struct Weights {
    /// Square roots of the weights, of mean square 1; `None` where all count alike.
    roots: Option<Vec<f64>>,
}

impl Weights {
    /// By time: of joined recordings each second counts alike.
    pub fn by_time(recording: &Recording) -> Self {
        let steps: Vec<f64> = runs(recording).map(|run| step(recording, run)).collect();
        Self::of_runs(recording, &steps)
    }

    /// By time and by what a model leaves of the rows that it was fitted to: `residual` at every sample (N or N·m), `rows` in order.
    pub fn by_residual(recording: &Recording, residual: &[f64], rows: &[usize]) -> Self {
        let variance = |run: &Range<usize>| {
            let place = |at: usize| rows.partition_point(|row| *row < at);
            let fitted = &rows[place(run.start)..place(run.end)];
            let squares: f64 = fitted.iter().map(|i| residual[*i].powi(2)).sum();
            squares / fitted.len().max(1) as f64
        };
        let variances: Vec<f64> = runs(recording).map(variance).collect();
        let floor = variances.iter().copied().fold(0.0, f64::max) / MOST_APART.powi(2);
        if floor.is_nan() || floor <= 0.0 {
            return Self::by_time(recording);
        }
        let weight =
            |(run, variance): (&Range<usize>, &f64)| step(recording, run) / variance.max(floor);
        let weights: Vec<f64> = runs(recording).zip(&variances).map(weight).collect();
        Self::of_runs(recording, &weights)
    }

    fn of_runs(recording: &Recording, weights: &[f64]) -> Self {
        if weights.len() < 2 {
            return Self::default();
        }
        let mut roots = vec![0.0; recording.len()];
        let sum: f64 = runs(recording)
            .zip(weights)
            .map(|(run, weight)| weight * run.len() as f64)
            .sum();
        let mean = sum / recording.len() as f64;
        for (run, weight) in runs(recording).zip(weights) {
            roots[run.clone()].fill((weight / mean).sqrt());
        }
        Self { roots: Some(roots) }
    }

    /// Whether not all samples count alike.
    pub fn differ(&self) -> bool {
        self.roots.is_some()
    }

    /// The values at `rows`, times the square roots of their weights: what enters least squares.
    pub fn rows(&self, values: &[f64], rows: &[usize]) -> Vec<f64> {
        match &self.roots {
            None => rows.iter().map(|&i| values[i]).collect(),
            Some(roots) => rows.iter().map(|&i| roots[i] * values[i]).collect(),
        }
    }

    /// NMSE (13) (%) over `rows`, weighted.
    pub fn nmse(&self, measured: &[f64], modelled: &[f64], rows: &[usize]) -> f64 {
        if self.roots.is_none() {
            return crate::statistics::nmse(measured, modelled, rows);
        }
        let every: Vec<usize> = (0..rows.len()).collect();
        let of_rows = |values| self.rows(values, rows);
        crate::statistics::nmse(&of_rows(measured), &of_rows(modelled), &every)
    }

    /// Each recording's share of what is fitted, for the user; `None` where there is only one.
    pub fn in_words(&self, recording: &Recording) -> Option<String> {
        let roots = self.roots.as_ref()?;
        let share = |run: &Range<usize>| {
            let sum: f64 = roots[run.clone()].iter().map(|r| r * r).sum();
            format!("{:.2} %", 100.0 * sum / roots.len() as f64)
        };
        let shares: Vec<String> = runs(recording).map(share).collect();
        Some(format!(
            "recordings count by their seconds and by how closely the model meets them: {} of the fit, in the order given; so does the NMSE",
            shares.join(", ")
        ))
    }
}

fn runs(recording: &Recording) -> impl Iterator<Item = &Range<usize>> {
    recording.joined.iter().filter(|run| !run.is_empty())
}

/// Median time between the samples of a run (s).
fn step(recording: &Recording, run: &Range<usize>) -> f64 {
    let mut steps: Vec<f64> = recording.t_s[run.clone()]
        .windows(2)
        .map(|t| t[1] - t[0])
        .filter(|s| *s > 0.0)
        .collect();
    let middle = steps.len() / 2;
    if steps.is_empty() {
        return recording.sample_time_s();
    }
    *steps.select_nth_unstable_by(middle, f64::total_cmp).1
}
