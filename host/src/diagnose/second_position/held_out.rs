//! Least squares on groups of samples, and what a fit to the others leaves on each.

use super::samples::{COLUMNS, CONSTANT, Samples};
use super::{CERTAIN, MATERIAL};
use nalgebra::{DMatrix, DVector, DVectorView};
use preslide_fit::statistics::{Estimate, jackknife};

/// Sums of one group of samples.
#[derive(Clone)]
pub struct Sums {
    pub normal: DMatrix<f64>,
    pub right: DVector<f64>,
    square: f64,
    pub count: f64,
}

impl Sums {
    pub fn new(columns: usize) -> Self {
        Self {
            normal: DMatrix::zeros(columns, columns),
            right: DVector::zeros(columns),
            square: 0.0,
            count: 0.0,
        }
    }

    /// Of each group of passes.
    pub fn of_passes(samples: &Samples, groups: usize) -> Vec<Self> {
        let mut sums = vec![Self::new(COLUMNS); groups];
        for (i, columns) in samples.columns.iter().enumerate() {
            sums[samples.pass[i] % groups].add(columns, samples.difference[i]);
        }
        sums.retain(|s| s.count > 0.0);
        sums
    }

    pub fn add(&mut self, columns: &[f64], value: f64) {
        let columns = DVectorView::from_slice(columns, columns.len());
        self.normal.ger(1.0, &columns, &columns, 1.0);
        self.right.axpy(value, &columns, 1.0);
        self.square += value * value;
        self.count += 1.0;
    }

    /// Coefficients of all columns, those that are not `used` zero.
    pub fn solve(groups: &[&Self], used: &[usize]) -> Option<DVector<f64>> {
        let n = used.len();
        let sum = |i: usize, j: usize| groups.iter().map(|g| g.normal[(i, j)]).sum::<f64>();
        let normal = DMatrix::from_fn(n, n, |i, j| sum(used[i], used[j]));
        let right = DVector::from_fn(n, |i, _| groups.iter().map(|g| g.right[used[i]]).sum());
        // What is not there, such as an effort of zero, has no coefficient.
        let solved = normal.svd(true, true);
        let least = 1e-12 * solved.singular_values.max();
        let own = solved.solve(&right, least).ok()?;
        let mut all = DVector::zeros(groups.first()?.right.len());
        used.iter().zip(own.iter()).for_each(|(&i, c)| all[i] = *c);
        Some(all)
    }

    /// The same of the difference less what some coefficients make of the columns.
    pub fn less(&self, c: &DVector<f64>) -> Self {
        Self {
            right: &self.right - &self.normal * c,
            square: self.left(c),
            ..self.clone()
        }
    }

    /// Sum of squares that some coefficients leave.
    pub fn left(&self, c: &DVector<f64>) -> f64 {
        (self.square - 2.0 * c.dot(&self.right) + c.dot(&(&self.normal * c))).max(0.0)
    }
}

/// What one fit takes of the squares that another leaves on groups held out.
#[derive(Clone, Copy)]
pub struct Taken {
    /// Share of the squares.
    pub share: f64,
    /// Standard errors between groups.
    pub z: f64,
}

impl Taken {
    /// Of the mean squares on each group, without and with.
    pub fn of(without: &[f64], with: &[f64]) -> Self {
        let less: Vec<f64> = without.iter().zip(with).map(|(a, b)| a - b).collect();
        let n = less.len() as f64;
        let mean = less.iter().sum::<f64>() / n;
        let scatter = less.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        let whole = without.iter().sum::<f64>() / n;
        Self {
            share: mean / whole.max(1e-300),
            z: mean / (scatter / n).sqrt().max(1e-300),
        }
    }

    /// Whether that is certain, and enough to report.
    pub fn is_stated(self) -> bool {
        self.z > CERTAIN && self.share > MATERIAL
    }
}

/// A fit to all groups, and to all but each.
pub struct HeldOut {
    pub coefficients: DVector<f64>,
    others: Vec<DVector<f64>>,
    /// Mean square on each group, of the fit to the others.
    squares: Vec<f64>,
}

impl HeldOut {
    pub fn of(sums: &[Sums], used: &[usize]) -> Option<Self> {
        let all: Vec<&Sums> = sums.iter().collect();
        let but = |k: usize| {
            let rest: Vec<&Sums> = (0..sums.len())
                .filter(|i| *i != k)
                .map(|i| all[i])
                .collect();
            Sums::solve(&rest, used)
        };
        let others: Vec<DVector<f64>> = (0..sums.len()).map(but).collect::<Option<_>>()?;
        let own = sums.iter().zip(&others);
        let squares = own
            .map(|(s, c)| {
                // The level of a group is its own: a drift between passes is no lead.
                let mut c = c.clone();
                let off =
                    (s.right[CONSTANT] - s.normal.row(CONSTANT).transpose().dot(&c)) / s.count;
                c[CONSTANT] += off;
                s.left(&c) / s.count
            })
            .collect();
        Some(Self {
            coefficients: Sums::solve(&all, used)?,
            others,
            squares,
        })
    }

    /// What it takes of what another leaves.
    pub fn better_than(&self, other: &Self) -> Taken {
        Taken::of(&other.squares, &self.squares)
    }

    /// RMS of what is left of the groups held out.
    pub fn left(&self) -> f64 {
        (self.squares.iter().sum::<f64>() / self.squares.len().max(1) as f64).sqrt()
    }

    /// A coefficient times `unit`, with its interval by the jackknife.
    pub fn estimate(&self, column: usize, unit: f64) -> Estimate {
        let error = unit.abs() * self.error(column);
        Estimate::new(
            unit * self.coefficients[column],
            Some(error),
            self.others.len(),
        )
    }

    fn error(&self, column: usize) -> f64 {
        jackknife(&self.others.iter().map(|c| c[column]).collect::<Vec<_>>())
    }

    /// The same where it is certain that it is not zero.
    pub fn certain(&self, column: usize, unit: f64) -> Option<Estimate> {
        let is_certain = self.coefficients[column].abs() > CERTAIN * self.error(column);
        is_certain.then(|| self.estimate(column, unit))
    }
}
