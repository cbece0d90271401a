//! The regression behind an identification: a force that is linear in everything but the yields.
//!
//! A fit at any yields needs sums of products only ([`Sums`]): exact ones pass over the samples, and those of a [`Surface`] lie between the
//! yields of a grid, whose sums are taken once. Between two yields `D` the deflection is Hermite's cubic through both deflections with their
//! slopes `∂z/∂D`.

use super::weights::Weights;
use crate::signal::Deflection;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::ops::Range;

/// A regressor that enters linearly beside the friction model: inertia, viscous friction, offset.
#[derive(Clone, Debug)]
pub struct Regressor {
    /// Its coefficient's name, as in the JSON output.
    pub name: &'static str,
    /// Its value for every sample.
    pub values: Vec<f64>,
}

/// A filter that returns as many values as it is given.
pub type Filter<'a> = Box<dyn Fn(&[f64]) -> Vec<f64> + Send + Sync + 'a>;

/// What is to be explained (`force`), by what (`position` through Maxwell-slip blocks, and `columns`).
pub struct Regression<'a> {
    /// Position (m or rad) that drives the blocks, for every sample of the recording.
    pub position: &'a [f64],
    /// Contiguous stretches of it.
    pub pieces: &'a [Range<usize>],
    /// Measured effort (N or N·m).
    pub force: Vec<f64>,
    /// Linear columns.
    pub columns: Vec<Regressor>,
    /// The filter that `force` and `columns` went through, to be applied to the blocks' deflections too.
    pub filter: Filter<'a>,
    /// Samples used for fitting, in folds: a fold is the unit that is held out, or resampled for confidence.
    pub folds: Vec<Vec<usize>>,
    /// How much each sample counts.
    pub weights: Weights,
}

/// A fitted Maxwell-slip model with its linear companions.
#[derive(Clone, Debug)]
pub struct MaxwellSlipFit {
    /// Yield displacements `D_i` (m or rad), ascending.
    pub yields: Vec<f64>,
    /// Stiffnesses `k_i` (N/m or N·m/rad).
    pub stiffness: Vec<f64>,
    /// Coefficients of the regression's linear columns, in their order.
    pub linear: Vec<f64>,
    /// Squared error over the fitted samples.
    pub squared_error: f64,
}

/// Sums of products `Σ aᵢaⱼ` of columns over some samples, the last column being the force.
#[derive(Clone)]
pub struct Gram {
    /// Symmetric, `columns + 1` square.
    pub products: DMatrix<f64>,
    /// Sum of the force.
    pub force_sum: f64,
    /// Number of samples.
    pub samples: usize,
}

impl Gram {
    /// Sums over `rows` of the columns; the last one is the force.
    pub fn of(columns: &[&[f64]], rows: &[usize]) -> Self {
        let p = columns.len();
        let mut products = DMatrix::zeros(p, p);
        // Blocks of rows keep the gathered values in cache.
        for rows in rows.chunks(256) {
            let block = DMatrix::from_fn(rows.len(), p, |i, j| columns[j][rows[i]]);
            products.gemm_tr(1.0, &block, &block, 1.0);
        }
        let force_sum = columns
            .last()
            .map_or(0.0, |force| rows.iter().map(|&i| force[i]).sum());
        Self {
            products,
            force_sum,
            samples: rows.len(),
        }
    }

    /// The sum of several.
    pub fn sum<'a>(parts: impl IntoIterator<Item = &'a Gram>) -> Option<Gram> {
        parts.into_iter().fold(None, |sum: Option<Gram>, part| {
            Some(match sum {
                None => part.clone(),
                Some(sum) => Gram {
                    products: sum.products + &part.products,
                    force_sum: sum.force_sum + part.force_sum,
                    samples: sum.samples + part.samples,
                },
            })
        })
    }

    /// `Ns·σ²` of eq. (13): the force's squared deviation from its mean.
    pub fn force_variation(&self) -> f64 {
        let last = self.products.nrows() - 1;
        let mean = self.force_sum / self.samples as f64;
        self.products[(last, last)] - self.samples as f64 * mean * mean
    }

    /// The normal equations of the columns `chosen`: matrix and right hand side.
    pub fn normal(&self, chosen: &[usize]) -> (DMatrix<f64>, DVector<f64>) {
        let last = self.products.nrows() - 1;
        (
            DMatrix::from_fn(chosen.len(), chosen.len(), |i, j| {
                self.products[(chosen[i], chosen[j])]
            }),
            DVector::from_fn(chosen.len(), |i, _| self.products[(chosen[i], last)]),
        )
    }

    /// The same of the columns `chosen` alone, in that order, and the force.
    pub fn part(&self, chosen: &[usize]) -> Gram {
        let force = self.products.nrows() - 1;
        let of = |i: usize| chosen.get(i).copied().unwrap_or(force);
        Gram {
            products: DMatrix::from_fn(chosen.len() + 1, chosen.len() + 1, |i, j| {
                self.products[(of(i), of(j))]
            }),
            ..*self
        }
    }

    /// Squared error that the coefficients of the columns `chosen` leave.
    pub fn squared_error(&self, chosen: &[usize], coefficients: &DVector<f64>) -> f64 {
        let (matrix, right) = self.normal(chosen);
        let last = self.products.nrows() - 1;
        let error = self.products[(last, last)] - 2.0 * coefficients.dot(&right)
            + coefficients.dot(&(matrix * coefficients));
        error.max(0.0)
    }
}

/// Solves a symmetric positive definite system after scaling its diagonal to 1; `None` where it is singular.
pub fn solve_normal(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let scale = matrix.diagonal().map(|d| 1.0 / d.sqrt());
    if scale.iter().any(|s| !s.is_finite()) {
        return None;
    }
    let n = matrix.nrows();
    let scaled = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)] * scale[i] * scale[j]);
    let solution = scaled
        .cholesky()?
        .solve(&right.component_mul(&scale))
        .component_mul(&scale);
    solution.iter().all(|s| s.is_finite()).then_some(solution)
}

impl Regression<'_> {
    /// The filtered deflection of a block and its filtered derivative.
    pub fn deflection(&self, yield_displacement: f64) -> Deflection {
        let raw = Deflection::along(self.position, self.pieces, yield_displacement);
        Deflection {
            z: (self.filter)(&raw.z),
            slope: (self.filter)(&raw.slope),
        }
    }

    /// What `fit` leaves of the force at every sample.
    pub fn residual(&self, fit: &MaxwellSlipFit) -> Vec<f64> {
        let mut left = self.force.clone();
        let mut take = |values: &[f64], factor: f64| {
            left.iter_mut()
                .zip(values)
                .for_each(|(l, v)| *l -= factor * v);
        };
        for (column, coefficient) in self.columns.iter().zip(&fit.linear) {
            take(&column.values, *coefficient);
        }
        for (yields, stiffness) in fit.yields.iter().zip(&fit.stiffness) {
            let raw = Deflection::along(self.position, self.pieces, *yields);
            take(&(self.filter)(&raw.z), *stiffness);
        }
        left
    }

    /// One [`Gram`] per fold over the linear columns, the deflections for `yields`, and the force.
    pub fn grams(&self, yields: &[f64]) -> Vec<Gram> {
        let surface = Surface::new(self, yields.to_vec());
        let folds = surface.folds.iter();
        folds.map(|fold| surface.on_grid(fold)).collect()
    }

    /// One per fold over the linear columns, the deflections for `yields`, their slopes, and the force.
    ///
    /// Of each deflection only the folds' samples are kept, so that thinned folds bound the memory.
    fn by_fold(&self, yields: &[f64]) -> Vec<Gram> {
        let rows = self.folds.concat();
        let columns = self.at(&rows, yields);
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let mut end = 0;
        let parts: Vec<Vec<usize>> = self
            .folds
            .iter()
            .map(|fold| {
                end += fold.len();
                (end - fold.len()..end).collect()
            })
            .collect();
        parts
            .par_iter()
            .map(|rows| Gram::of(&columns, rows))
            .collect()
    }

    /// What the force is regressed on at the samples `rows`: linear columns, deflections, their slopes; then the force.
    fn at(&self, rows: &[usize], yields: &[f64]) -> Vec<Vec<f64>> {
        let of_rows = |values: &[f64]| self.weights.rows(values, rows);
        let (deflections, slopes): (Vec<_>, Vec<_>) = yields
            .par_iter()
            .map(|&d| {
                let Deflection { z, slope } = self.deflection(d);
                (of_rows(&z), of_rows(&slope))
            })
            .unzip();
        let linear = self.columns.iter().map(|c| of_rows(&c.values));
        linear
            .chain(deflections)
            .chain(slopes)
            .chain([of_rows(&self.force)])
            .collect()
    }
}

/// Sums of products of the linear columns, the deflections at any yields, their slopes and the force.
pub trait Sums {
    /// Number of linear columns.
    fn linear(&self) -> usize;
    /// The sums at these yields; `None` where there are no samples.
    fn at(&self, yields: &[f64]) -> Option<Gram>;
}

/// Sums over the samples themselves.
pub struct Exact<'a> {
    /// What is regressed.
    pub regression: &'a Regression<'a>,
    /// Over these samples.
    pub rows: &'a [usize],
}

impl Sums for Exact<'_> {
    fn linear(&self) -> usize {
        self.regression.columns.len()
    }

    fn at(&self, yields: &[f64]) -> Option<Gram> {
        let columns = self.regression.at(self.rows, yields);
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let parts: Vec<Gram> = (0..self.rows.len())
            .collect::<Vec<usize>>()
            .par_chunks(4096)
            .map(|rows| Gram::of(&columns, rows))
            .collect();
        Gram::sum(&parts)
    }
}

/// Sums at the yields of a grid, fold by fold.
pub struct Surface {
    /// Yields (m or rad), ascending.
    pub grid: Vec<f64>,
    /// Number of linear columns.
    pub linear: usize,
    /// Of each fold: linear columns, deflections, slopes, force.
    pub folds: Vec<Gram>,
}

impl Surface {
    /// Passes over the samples once.
    pub fn new(regression: &Regression, grid: Vec<f64>) -> Self {
        Self {
            folds: regression.by_fold(&grid),
            linear: regression.columns.len(),
            grid,
        }
    }

    /// With so many neighbouring folds together.
    pub fn joined(&self, counts: impl Iterator<Item = usize>) -> Self {
        let mut rest = self.folds.as_slice();
        let next = |count: usize| {
            let (these, after) = rest.split_at(count);
            rest = after;
            Gram::sum(these)
        };
        Self {
            grid: self.grid.clone(),
            linear: self.linear,
            folds: counts.filter_map(next).collect(),
        }
    }

    /// With some of the linear columns, and yields up to `longest`.
    pub fn part(&self, linear: &[usize], longest: f64) -> Self {
        let kept = self.grid.iter().filter(|d| **d <= longest).count();
        let blocks = self.linear..self.linear + kept;
        let slopes = blocks.clone().map(|j| j + self.grid.len());
        let chosen = linear.iter().copied().chain(blocks.clone()).chain(slopes);
        let chosen: Vec<usize> = chosen.collect();
        Self {
            grid: self.grid[..kept].to_vec(),
            linear: linear.len(),
            folds: self.folds.iter().map(|fold| fold.part(&chosen)).collect(),
        }
    }

    /// The sums of some folds, without slopes: linear columns, deflections of the grid, force.
    pub fn on_grid(&self, folds: &Gram) -> Gram {
        folds.part(&(0..self.linear + self.grid.len()).collect::<Vec<_>>())
    }
}

/// Sums between the yields of a grid.
pub struct Between<'a> {
    /// The grid.
    pub surface: &'a Surface,
    /// The sum of the folds that count.
    pub folds: Gram,
}

impl Sums for Between<'_> {
    fn linear(&self) -> usize {
        self.surface.linear
    }

    fn at(&self, yields: &[f64]) -> Option<Gram> {
        let (grid, p) = (&self.surface.grid, self.surface.linear);
        let (mut deflections, mut slopes) = (Vec::new(), Vec::new());
        for &d in yields {
            let after = grid.partition_point(|g| *g <= d).clamp(1, grid.len() - 1);
            let (from, to) = (grid[after - 1], grid[after]);
            let (h, t) = (to - from, ((d - from) / (to - from)).clamp(0.0, 1.0));
            let [z0, z1, s0, s1] = [after - 1, after, after - 1 + grid.len(), after + grid.len()];
            let (tt, ttt) = (t * t, t * t * t);
            deflections.push(vec![
                (p + z0, 2.0 * ttt - 3.0 * tt + 1.0),
                (p + z1, 3.0 * tt - 2.0 * ttt),
                (p + s0, h * (ttt - 2.0 * tt + t)),
                (p + s1, h * (ttt - tt)),
            ]);
            slopes.push(vec![
                (p + z0, 6.0 * (tt - t) / h),
                (p + z1, 6.0 * (t - tt) / h),
                (p + s0, 3.0 * tt - 4.0 * t + 1.0),
                (p + s1, 3.0 * tt - 2.0 * t),
            ]);
        }
        let own = |i: usize| vec![(i, 1.0)];
        let columns: Vec<Vec<(usize, f64)>> = (0..p)
            .map(own)
            .chain(deflections)
            .chain(slopes)
            .chain([own(p + 2 * grid.len())])
            .collect();
        let sums = &self.folds.products;
        let product = |a: &[(usize, f64)], b: &[(usize, f64)]| -> f64 {
            let of = |(i, by): &(usize, f64)| {
                b.iter()
                    .map(|(j, with)| by * with * sums[(*i, *j)])
                    .sum::<f64>()
            };
            a.iter().map(of).sum()
        };
        let n = columns.len();
        let mut products = DMatrix::zeros(n, n);
        for i in 0..n {
            for j in 0..=i {
                products[(i, j)] = product(&columns[i], &columns[j]);
                products[(j, i)] = products[(i, j)];
            }
        }
        Some(Gram {
            products,
            ..self.folds
        })
    }
}
