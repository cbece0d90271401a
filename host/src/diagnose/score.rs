//! How well a model predicts folds that it was not fitted to, in nats, from one Gram matrix per fold.
//!
//! With flat priors on the coefficients (blocks kept non-negative by choosing which take part, ridge columns with their prior),
//! `ln p(y_s | y_others)` needs only `A = ΣG` with and without fold `s`: the quadratic form of the prediction is
//! `Q − Q₋ₛ` and its determinant `|A|/|A₋ₛ|`. A candidate of few columns is a Schur complement on top.

use super::noise::Noise;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// How a column's coefficient is bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bound {
    /// Any value.
    Free,
    /// Not negative: stiffness of a block.
    NonNegative,
}

/// Added to every scaled column's square, against columns that are alike.
const RIDGE: f64 = 1e-9;
/// A candidate of which less than this share is new to the model cannot be told from it.
const NEW: f64 = 1e-6;

/// Standard deviations of the nats of noise draws above their mean.
const DEVIATIONS: f64 = 4.0;

/// Nats that noise alone does not reach, from those of its draws.
pub fn beyond(draws: &[f64]) -> f64 {
    let n = draws.len() as f64;
    let mean = draws.iter().sum::<f64>() / n;
    let square: f64 = draws.iter().map(|g| (g - mean).powi(2)).sum();
    mean + DEVIATIONS * (square / (n - 1.0)).sqrt()
}

/// The base model against the recording and against draws of the noise alone.
pub struct Problem {
    parts: Vec<DMatrix<f64>>,
    targets: Vec<DMatrix<f64>>,
    /// Products of base columns, by fold.
    base: Vec<DMatrix<f64>>,
    /// Products of base columns with the targets, by fold.
    right: Vec<DMatrix<f64>>,
    /// Squares of the targets, by fold.
    square: Vec<DVector<f64>>,
    rows: Vec<f64>,
    bounds: Vec<Bound>,
    scale: Vec<f64>,
}

/// Nats per fold of one model, and what it is made of.
#[derive(Clone)]
pub struct Fit {
    /// Columns that take part.
    pub active: Vec<usize>,
    /// Coefficient of every column, 0 where it takes no part.
    pub coefficients: Vec<f64>,
    /// Coefficients when each fold is held out.
    pub held_out: Vec<Vec<f64>>,
    /// Log-likelihood of each fold, predicted from the others.
    pub nats: Vec<f64>,
    /// Covariance of the active coefficients.
    pub covariance: DMatrix<f64>,
    systems: Vec<System>,
}

impl Fit {
    /// Sum over folds.
    pub fn total(&self) -> f64 {
        self.nats.iter().sum()
    }
}

/// A factored system: index 0 is all folds, `1 + s` is without fold `s`.
#[derive(Clone)]
struct System {
    factor: Cholesky<f64, Dyn>,
    /// `L⁻¹b` for every target.
    z: DMatrix<f64>,
    /// What each target leaves.
    q: DVector<f64>,
    log_determinant: f64,
    rows: f64,
}

/// What a candidate adds: nats for the recording by fold, and for each draw of noise in total.
#[derive(Clone, Debug)]
pub struct Gain {
    /// Nats by fold.
    pub by_fold: Vec<f64>,
    /// Total for every noise draw.
    pub null: Vec<f64>,
    /// Coefficients of its columns.
    pub coefficients: Vec<f64>,
}

impl Gain {
    /// Sum over folds.
    pub fn total(&self) -> f64 {
        self.by_fold.iter().sum()
    }
}

impl Problem {
    /// `columns` over all rows with their bounds; `draws` noise realisations beside the measured `force`.
    pub fn new(
        noise: &Noise,
        columns: &[Vec<f64>],
        bounds: Vec<Bound>,
        force: &[f64],
        draws: usize,
    ) -> Self {
        let parts = noise.whiten(columns);
        let mut base: Vec<DMatrix<f64>> = parts.iter().map(|p| p.tr_mul(p)).collect();
        let scale: Vec<f64> = (0..columns.len())
            .map(|j| {
                base.iter()
                    .map(|g| g[(j, j)])
                    .sum::<f64>()
                    .max(1e-300)
                    .sqrt()
                    .recip()
            })
            .collect();
        let scales = DMatrix::from_diagonal(&DVector::from_column_slice(&scale));
        base.iter_mut().for_each(|g| *g = &scales * &*g * &scales);
        let own = noise.whiten(&[force.to_vec()]);
        let noise_parts = noise.draws(draws, 1);
        let targets: Vec<DMatrix<f64>> = own
            .into_iter()
            .zip(noise_parts)
            .map(|(y, draws)| beside(&y, &draws))
            .collect();
        let right = parts
            .iter()
            .zip(&targets)
            .map(|(p, y)| &scales * p.tr_mul(y))
            .collect();
        let square = targets
            .iter()
            .map(|t| DVector::from_iterator(t.ncols(), t.column_iter().map(|c| c.norm_squared())))
            .collect();
        let rows = targets.iter().map(|t| t.nrows() as f64).collect();
        Self {
            parts,
            targets,
            base,
            right,
            square,
            rows,
            bounds,
            scale,
        }
    }

    /// Fits the base.
    pub fn fit(&self) -> Option<Fit> {
        let p = self.bounds.len();
        let mut a = DMatrix::zeros(p, p);
        let mut b = DVector::zeros(p);
        for (g, r) in self.base.iter().zip(&self.right) {
            a += g;
            b += r.column(0);
        }
        let used: Vec<usize> = (0..p).collect();
        for j in 0..p {
            a[(j, j)] += RIDGE;
        }
        let active = non_negative(&a, &b, &used, &self.bounds)?;
        let k = active.len();
        let pick = |m: &DMatrix<f64>| DMatrix::from_fn(k, k, |i, j| m[(active[i], active[j])]);
        let mut systems = Vec::new();
        for out in std::iter::once(None).chain((0..self.base.len()).map(Some)) {
            let mut g = DMatrix::zeros(k, k);
            let mut r = DMatrix::zeros(k, self.right[0].ncols());
            let mut q = DVector::zeros(self.right[0].ncols());
            let mut rows = 0.0;
            for s in (0..self.base.len()).filter(|s| Some(*s) != out) {
                g += pick(&self.base[s]);
                r += self.right[s].select_rows(active.iter());
                q += &self.square[s];
                rows += self.rows[s];
            }
            for i in 0..k {
                g[(i, i)] += RIDGE;
            }
            let factor = g.cholesky()?;
            let z = factor.l_dirty().solve_lower_triangular(&r)?;
            for (t, q) in q.iter_mut().enumerate() {
                *q = (*q - z.column(t).norm_squared()).max(1e-12);
            }
            let log_determinant = 2.0
                * factor
                    .l_dirty()
                    .diagonal()
                    .iter()
                    .map(|d| d.ln())
                    .sum::<f64>();
            systems.push(System {
                factor,
                z,
                q,
                log_determinant,
                rows,
            });
        }
        let solve = |system: &System| -> Vec<f64> {
            let mut all = vec![0.0; p];
            let z = system.z.column(0).into_owned();
            let Some(solved) = system.factor.l_dirty().tr_solve_lower_triangular(&z) else {
                return all;
            };
            for (i, &j) in active.iter().enumerate() {
                all[j] = solved[i] * self.scale[j];
            }
            all
        };
        let dispersion = systems[0].q[0] / systems[0].rows;
        let mut covariance = systems[0].factor.inverse() * dispersion;
        for i in 0..k {
            for j in 0..k {
                covariance[(i, j)] *= self.scale[active[i]] * self.scale[active[j]];
            }
        }
        let nats = (1..systems.len())
            .map(|s| predictive(&systems[0], &systems[s], 0, 0.0, 0.0, 0.0, 0.0))
            .collect();
        Some(Fit {
            coefficients: solve(&systems[0]),
            held_out: systems[1..].iter().map(solve).collect(),
            nats,
            covariance,
            active,
            systems,
        })
    }

    /// Standard errors of the coefficients of `fit` by leaving out one kind of rows after the other (a jackknife): a form that
    /// is wrong gives other values on other motions, which repeats of the same motion do not show. `kinds` tells the kind of
    /// each row.
    pub fn error_of_form(&self, fit: &Fit, kinds: &[usize]) -> Option<Vec<f64>> {
        let k = fit.active.len();
        let count = kinds.iter().max()? + 1;
        let mut grams = vec![DMatrix::zeros(k, k); count];
        let mut rights = vec![DVector::zeros(k); count];
        let mut first = 0;
        for (part, target) in self.parts.iter().zip(&self.targets) {
            let own = &kinds[first..first + part.nrows()];
            first += part.nrows();
            for kind in 0..count {
                let rows: Vec<usize> = (0..own.len()).filter(|i| own[*i] == kind).collect();
                let mut x = part.select_rows(&rows).select_columns(&fit.active);
                for (i, &j) in fit.active.iter().enumerate() {
                    x.column_mut(i).scale_mut(self.scale[j]);
                }
                grams[kind] += x.tr_mul(&x);
                rights[kind] += x.tr_mul(&target.column(0).select_rows(&rows));
            }
        }
        let ridge = DMatrix::from_diagonal_element(k, k, RIDGE);
        let gram = grams.iter().fold(ridge, |sum, own| sum + own);
        let right = rights.iter().fold(DVector::zeros(k), |sum, own| sum + own);
        let whole = gram.clone().cholesky()?.solve(&right);
        let mut square = vec![0.0; self.bounds.len()];
        for (own, own_right) in grams.iter().zip(&rights) {
            let without = (&gram - own).cholesky()?.solve(&(&right - own_right));
            for (i, &j) in fit.active.iter().enumerate() {
                square[j] += ((without[i] - whole[i]) * self.scale[j]).powi(2);
            }
        }
        let share = (count as f64 - 1.0) / count as f64;
        Some(square.into_iter().map(|s| (share * s).sqrt()).collect())
    }

    /// What `columns` add to `fit` when their coefficients are fitted jointly with the rest.
    pub fn gain(&self, fit: &Fit, noise: &Noise, columns: &[Vec<f64>]) -> Option<Gain> {
        let k = columns.len();
        let candidate = noise.whiten(columns);
        let folds = self.base.len();
        let targets = self.right[0].ncols();
        let scaled: Vec<f64> = fit.active.iter().map(|&j| self.scale[j]).collect();
        let cross: Vec<DMatrix<f64>> = (0..folds)
            .map(|s| {
                let all = self.parts[s].tr_mul(&candidate[s]);
                DMatrix::from_fn(fit.active.len(), k, |i, j| {
                    all[(fit.active[i], j)] * scaled[i]
                })
            })
            .collect();
        let own: Vec<DMatrix<f64>> = candidate.iter().map(|c| c.tr_mul(c)).collect();
        let right: Vec<DMatrix<f64>> = (0..folds)
            .map(|s| candidate[s].tr_mul(&self.targets[s]))
            .collect();
        let sum = |parts: &[DMatrix<f64>]| {
            parts
                .iter()
                .skip(1)
                .fold(parts[0].clone(), |sum, part| sum + part)
        };
        let (cross_all, own_all, right_all) = (sum(&cross), sum(&own), sum(&right));
        let mut reductions = Vec::new();
        let mut coefficients = Vec::new();
        for (index, system) in fit.systems.iter().enumerate() {
            let (c, g, r) = match index.checked_sub(1) {
                None => (cross_all.clone(), own_all.clone(), right_all.clone()),
                Some(s) => (
                    &cross_all - &cross[s],
                    &own_all - &own[s],
                    &right_all - &right[s],
                ),
            };
            let w = system.factor.l_dirty().solve_lower_triangular(&c)?;
            let schur = &g - w.tr_mul(&w);
            if (0..k).any(|j| schur[(j, j)] <= NEW * own_all[(j, j)]) {
                return None;
            }
            let factor = schur.cholesky()?;
            let t = factor
                .l_dirty()
                .solve_lower_triangular(&(r - w.tr_mul(&system.z)))?;
            if index == 0 {
                let own = t.column(0).into_owned();
                coefficients = factor
                    .l_dirty()
                    .tr_solve_lower_triangular(&own)?
                    .iter()
                    .copied()
                    .collect();
            }
            let log: f64 = 2.0
                * factor
                    .l_dirty()
                    .diagonal()
                    .iter()
                    .map(|d| d.ln())
                    .sum::<f64>();
            reductions.push((
                t.column_iter()
                    .map(|t| t.norm_squared())
                    .collect::<Vec<_>>(),
                log,
            ));
        }
        let of = |target: usize| -> Vec<f64> {
            (1..fit.systems.len())
                .map(|s| {
                    let (whole, part) = (&fit.systems[0], &fit.systems[s]);
                    let with = predictive(
                        whole,
                        part,
                        target,
                        reductions[0].0[target],
                        reductions[s].0[target],
                        reductions[0].1,
                        reductions[s].1,
                    );
                    with - predictive(whole, part, target, 0.0, 0.0, 0.0, 0.0)
                })
                .collect()
        };
        Some(Gain {
            by_fold: of(0),
            coefficients,
            null: (1..targets).map(|t| of(t).iter().sum()).collect(),
        })
    }
}

/// The columns of both.
fn beside(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut both = a.clone().resize_horizontally(a.ncols() + b.ncols(), 0.0);
    both.columns_mut(a.ncols(), b.ncols()).copy_from(b);
    both
}

/// Log-likelihood of one fold given the others, up to a constant; the last four tell what a candidate takes off the
/// squared errors and adds to the log-determinants.
fn predictive(
    whole: &System,
    part: &System,
    target: usize,
    off_whole: f64,
    off_part: f64,
    log_whole: f64,
    log_part: f64,
) -> f64 {
    let q = (whole.q[target] - off_whole).max(1e-12);
    let q_part = (part.q[target] - off_part).max(1e-12);
    let dispersion = q_part / part.rows;
    -0.5 * ((q - q_part) / dispersion
        + (whole.rows - part.rows) * dispersion.ln()
        + (whole.log_determinant + log_whole)
        - (part.log_determinant + log_part))
}

/// Lawson and Hanson's active set on normal equations (Solving Least Squares Problems, 1974, ch. 23): which of the
/// `used` columns take part so that no bounded coefficient is negative.
fn non_negative(
    a: &DMatrix<f64>,
    b: &DVector<f64>,
    used: &[usize],
    bounds: &[Bound],
) -> Option<Vec<usize>> {
    let bounded = |j: usize| bounds[j] == Bound::NonNegative;
    let mut passive: Vec<usize> = used.iter().copied().filter(|&j| !bounded(j)).collect();
    let solve = |set: &[usize]| -> Option<DVector<f64>> {
        let m = DMatrix::from_fn(set.len(), set.len(), |i, j| a[(set[i], set[j])]);
        Some(
            m.cholesky()?
                .solve(&DVector::from_fn(set.len(), |i, _| b[set[i]])),
        )
    };
    let mut x = vec![0.0; bounds.len()];
    let start = solve(&passive)?;
    for (i, &j) in passive.iter().enumerate() {
        x[j] = start[i];
    }
    for _ in 0..3 * bounds.len() {
        let gradient = |j: usize| b[j] - used.iter().map(|&i| a[(j, i)] * x[i]).sum::<f64>();
        let entering = used
            .iter()
            .copied()
            .filter(|j| bounded(*j) && !passive.contains(j))
            .map(|j| (j, gradient(j)))
            .max_by(|p, q| p.1.total_cmp(&q.1));
        let Some((entering, steepest)) = entering else {
            break;
        };
        if steepest <= 1e-9 * (1.0 + b.amax()) {
            break;
        }
        passive.push(entering);
        loop {
            let next = solve(&passive)?;
            let step = passive
                .iter()
                .enumerate()
                .filter(|(i, j)| bounded(**j) && next[*i] <= 0.0)
                .map(|(i, &j)| x[j] / (x[j] - next[i]))
                .fold(1.0f64, f64::min)
                .max(0.0);
            for (i, &j) in passive.iter().enumerate() {
                x[j] += step * (next[i] - x[j]);
            }
            if step >= 1.0 {
                break;
            }
            passive.retain(|&j| !bounded(j) || x[j] > 1e-14);
            for &j in used {
                if bounded(j) && !passive.contains(&j) {
                    x[j] = 0.0;
                }
            }
        }
    }
    passive.sort_unstable();
    Some(passive)
}

#[cfg(test)]
mod tests {
    use super::super::noise::Course;
    use super::*;

    #[test]
    fn a_negative_coefficient_takes_no_part() {
        // y = 2·x0 − 1·x1 with orthogonal columns: the best non-negative fit leaves x1 out.
        let a = DMatrix::identity(3, 3);
        let b = DVector::from_column_slice(&[2.0, -1.0, -3.0]);
        let bounds = [Bound::NonNegative, Bound::NonNegative, Bound::Free];
        assert_eq!(non_negative(&a, &b, &[0, 1, 2], &bounds), Some(vec![0, 2]));
    }

    /// Of a mean over kinds of equal size the error is the textbook's of the mean of their means.
    #[test]
    fn kinds_that_differ_widen_the_error() {
        let (kinds, rows) = (6, 40);
        let n = kinds * rows;
        let folds = [0..n / 2, n / 2..n];
        let time: Vec<f64> = (0..n).map(|i| i as f64).collect();
        let none = vec![0.0; n];
        let course = Course {
            folds: &folds,
            time: &time,
            path: &none,
            friction: &none,
            stiffness: &none,
            stroke: 1.0,
        };
        let means = [1.0, 3.0, 2.0, -1.0, 0.5, 4.0];
        let kind: Vec<usize> = (0..n).map(|i| i % kinds).collect();
        let force: Vec<f64> = kind.iter().map(|k| means[*k]).collect();
        let noise = Noise::white(&force, &course);
        let problem = Problem::new(&noise, &[vec![1.0; n]], vec![Bound::Free], &force, 1);
        let error = problem
            .error_of_form(&problem.fit().unwrap(), &kind)
            .unwrap()[0];
        let mean = means.iter().sum::<f64>() / kinds as f64;
        let square: f64 = means.iter().map(|m| (m - mean).powi(2)).sum();
        let textbook = (square / (kinds * (kinds - 1)) as f64).sqrt();
        assert!((error / textbook - 1.0).abs() < 1e-6, "{error} {textbook}");
    }
}
