//! Estimates with their confidence, the jackknife, the paper's measure of fit, quantiles.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// A parameter's estimate.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Estimate {
    /// Its value (SI).
    pub value: f64,
    /// 95 % confidence interval; `None` where the recording has too few folds to tell. It comes from the scatter
    /// between folds, so it does not contain what is the same in all of them: a sensor's scale, or where within an
    /// encoder count a motion turns that repeats exactly.
    pub ci95: Option<[f64; 2]>,
}

impl Estimate {
    /// So many times it, more than none.
    pub fn times(self, factor: f64) -> Self {
        Self {
            value: factor * self.value,
            ci95: self.ci95.map(|ends| ends.map(|end| factor * end)),
        }
    }

    /// With a standard error estimated from `folds` independent folds (Student's t with `folds − 1` degrees
    /// of freedom).
    pub fn new(value: f64, standard_error: Option<f64>, folds: usize) -> Self {
        let reach = standard_error.and_then(|e| Some(e * students_t(folds)?));
        Self {
            value,
            ci95: reach.map(|reach| [value - reach, value + reach]),
        }
    }

    /// For a value that is positive and was estimated as its logarithm; without an interval where that would say nothing.
    pub fn logarithmic(value: f64, error_of_log: Option<f64>, folds: usize) -> Self {
        /// A factor of a thousand, up and down.
        const NOTHING: f64 = 6.9;
        let reach = error_of_log.and_then(|e| Some(e * students_t(folds)?));
        let reach = reach.filter(|reach| *reach < NOTHING);
        Self {
            value,
            ci95: reach.map(|reach| [value * (-reach).exp(), value * reach.exp()]),
        }
    }

    /// Half the width of its interval: what follows a ±.
    pub fn reach(&self) -> Option<f64> {
        self.ci95.map(|[low, high]| 0.5 * (high - low))
    }
}

/// The jackknife's standard error of a value, from what it is without each group in turn (Efron and Tibshirani, An introduction to the
/// bootstrap, 1993, eq. 11.5).
pub fn jackknife(without: &[f64]) -> f64 {
    let n = without.len() as f64;
    let mean = without.iter().sum::<f64>() / n;
    let scatter: f64 = without.iter().map(|v| (v - mean).powi(2)).sum();
    ((n - 1.0) / n * scatter).sqrt()
}

/// The 97.5 % quantile of Student's t with `folds − 1` degrees of freedom.
fn students_t(folds: usize) -> Option<f64> {
    let freedom = folds.checked_sub(1).filter(|&n| n > 0)?;
    let t = StudentsT::new(0.0, 1.0, freedom as f64).ok()?;
    Some(t.inverse_cdf(0.975))
}

/// `count` values from `low` to `high`, evenly on a logarithmic scale; none where they are no range above zero.
pub fn spread(low: f64, high: f64, count: usize) -> Vec<f64> {
    let usable = low > 0.0 && high > low;
    (0..count)
        .filter(|_| usable)
        .map(|i| low * (high / low).powf(i as f64 / (count - 1).max(1) as f64))
        .collect()
}

/// Lowest and highest of some values.
pub fn bounds(values: &[f64]) -> (f64, f64) {
    let widen = |(low, high): (f64, f64), &v: &f64| (low.min(v), high.max(v));
    values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), widen)
}

/// Least squares on the same columns for many targets.
pub struct LeastSquares<'a> {
    columns: &'a [&'a [f64]],
    /// Of each column to one of squares 1.
    scale: Vec<f64>,
    factor: nalgebra::Cholesky<f64, nalgebra::Dyn>,
}

impl<'a> LeastSquares<'a> {
    /// Factors the normal equations; `None` where they cannot be.
    pub fn of(columns: &'a [&'a [f64]]) -> Option<Self> {
        /// Of the columns' squares, added to keep the normal equations solvable.
        const RIDGE: f64 = 1e-9;
        // A column of zeros has the coefficient 0.
        let scale = |c: &&[f64]| {
            Some(dot(c, c).sqrt())
                .filter(|n| *n > 0.0)
                .map_or(0.0, f64::recip)
        };
        let scale: Vec<f64> = columns.iter().map(scale).collect();
        let p = columns.len();
        let mut gram = DMatrix::from_diagonal_element(p, p, RIDGE);
        for i in 0..p {
            for j in 0..=i {
                let product = scale[i] * scale[j] * dot(columns[i], columns[j]);
                gram[(i, j)] += product;
                if i != j {
                    gram[(j, i)] += product;
                }
            }
        }
        Some(Self {
            columns,
            scale,
            factor: gram.cholesky()?,
        })
    }

    /// Products of the scaled columns with a target, and what they solve to.
    fn solved(&self, target: &[f64]) -> [DVector<f64>; 2] {
        let right = DVector::from_fn(self.columns.len(), |i, _| {
            self.scale[i] * dot(self.columns[i], target)
        });
        let solution = self.factor.solve(&right);
        [right, solution]
    }

    /// The coefficient of each column.
    pub fn coefficients(&self, target: &[f64]) -> Vec<f64> {
        let [_, solution] = self.solved(target);
        solution
            .iter()
            .zip(&self.scale)
            .map(|(c, s)| c * s)
            .collect()
    }

    /// What the columns leave of a target.
    pub fn left(&self, target: &[f64]) -> Vec<f64> {
        let mut left = target.to_vec();
        for (c, column) in self.coefficients(target).iter().zip(self.columns) {
            left.iter_mut().zip(*column).for_each(|(l, x)| *l -= c * x);
        }
        left
    }

    /// Squares that the columns leave of a target.
    pub fn squares_left(&self, target: &[f64]) -> f64 {
        let [right, solution] = self.solved(target);
        dot(target, target) - right.dot(&solution)
    }
}

/// By how many samples a signal is later than what it is held against, and the squares that it leaves there and as it is; `left` tells them of the
/// signal shifted. `None` where the least lies at an end of the `most` samples either way.
pub fn lateness(
    signal: &[f64],
    most: usize,
    left: impl Fn(&[f64]) -> f64 + Sync,
) -> Option<(f64, [f64; 2])> {
    /// Steps of the search within two samples: each leaves two thirds, all of them a thousandth.
    const THIRDS: usize = 18;
    let left_at = |late: f64| left(&earlier(signal, late));
    let reach = most as i32;
    let all: Vec<f64> = (-reach..=reach)
        .into_par_iter()
        .map(|late| left_at(late.into()))
        .collect();
    let best = (0..all.len()).min_by(|a, b| all[*a].total_cmp(&all[*b]))?;
    if best == 0 || best + 1 == all.len() {
        return None;
    }
    // Where a force jumps the least is a kink, which no parabola fits.
    let middle = best as f64 - most as f64;
    let (mut low, mut high) = (middle - 1.0, middle + 1.0);
    for _ in 0..THIRDS {
        let third = (high - low) / 3.0;
        match left_at(low + third) < left_at(high - third) {
            true => high -= third,
            false => low += third,
        }
    }
    let late = 0.5 * (low + high);
    Some((late, [left_at(late), all[most]]))
}

/// The value at `t`, straight between two of the ascending `times` and held beyond their ends.
///
/// # Panics
/// Without values.
pub fn between(times: &[f64], values: &[f64], t: f64) -> f64 {
    match times.partition_point(|own| *own <= t) {
        0 => values[0],
        n if n == times.len() => values[n - 1],
        n => {
            let part = (t - times[n - 1]) / (times[n] - times[n - 1]);
            values[n - 1] + part * (values[n] - values[n - 1])
        }
    }
}

/// Evenly spaced values as they were so many samples later, straight between two and held beyond the ends.
pub fn earlier(values: &[f64], late: f64) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    let at = |i: usize| {
        let place = (i as f64 + late).clamp(0.0, last as f64);
        let before = place as usize;
        let part = place - before as f64;
        values[before] + part * (values[(before + 1).min(last)] - values[before])
    };
    (0..values.len()).map(at).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Normalised mean square error (%), the paper's eq. (13), over `rows`: `100·Σ(F − F̂)² / (N_s·σ²)`, `σ²` being the variance of the
/// measured force about its mean. NaN where the force does not vary.
pub fn nmse(measured: &[f64], modelled: &[f64], rows: &[usize]) -> f64 {
    let mean = rows.iter().map(|&i| measured[i]).sum::<f64>() / rows.len() as f64;
    let (mut error, mut variation) = (0.0, 0.0);
    for &i in rows {
        error += (measured[i] - modelled[i]).powi(2);
        variation += (measured[i] - mean).powi(2);
    }
    100.0 * error / variation
}

/// The `q`-quantile by nearest rank, one of the values; reorders them. `None` without values.
pub fn quantile(values: &mut [f64], q: f64) -> Option<f64> {
    let rank = ((values.len().checked_sub(1)?) as f64 * q).round() as usize;
    Some(*values.select_nth_unstable_by(rank, f64::total_cmp).1)
}

/// The `q`-quantile, between ranks by a straight line: of mirrored values the mirrored one. Of finite values only; 0 without any.
pub fn quantile_between_ranks(values: &[f64], q: f64) -> f64 {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    if sorted.is_empty() {
        return 0.0;
    }
    let place = (sorted.len() - 1) as f64 * q.clamp(0.0, 1.0);
    let (_, below, above) = sorted.select_nth_unstable_by(place as usize, f64::total_cmp);
    let next = above.iter().copied().fold(f64::INFINITY, f64::min);
    match place.fract() {
        0.0 => *below,
        part => *below + part * (next - *below),
    }
}

/// The mean and its standard error; NaN for fewer than two values.
pub fn mean_and_error(values: &[f64]) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    [mean, (squares / (n * (n - 1.0))).sqrt()]
}

/// The mean, and half its 95 % interval's width by the normal law; 0 of a single value.
pub fn mean_and_half_width(values: &[f64]) -> [f64; 2] {
    let [mean, error] = mean_and_error(values);
    [mean, if values.len() > 1 { 1.96 * error } else { 0.0 }]
}

#[cfg(test)]
mod tests {
    use super::Estimate;

    #[test]
    fn what_is_not_determined_has_no_interval() {
        for (error, told) in [(Some(0.1), true), (Some(1e2), false), (None, false)] {
            let found = Estimate::logarithmic(3.0, error, 12);
            println!("{error:?}: {found:?}");
            assert_eq!(found.ci95.is_some(), told);
        }
    }
}
