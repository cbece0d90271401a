//! Weighted least squares with folds held out: one factored system for all rows and one without each fold, and what a candidate
//! of few columns explains of rows that its coefficients have not seen, by a Schur complement.

use super::noise::Noise;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;
use std::ops::Range;

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
/// A candidate of which less than this share is new to the model is inseparable from it.
const NEW: f64 = 1e-6;

/// A model, fitted with and without each fold.
pub struct Normal {
    noise: Noise,
    folds: Vec<Range<usize>>,
    /// Whitened columns that take part, of unit length.
    columns: Vec<Vec<f64>>,
    /// Their numbers among all columns.
    pub active: Vec<usize>,
    scale: Vec<f64>,
    target: Vec<f64>,
    /// Index 0 is all folds, `1 + s` without fold `s`.
    systems: Vec<System>,
    /// Coefficient of every column, 0 where it takes no part.
    pub coefficients: Vec<f64>,
    /// Whitened residual of every fold with the coefficients of the others.
    pub held_out: Vec<f64>,
}

#[derive(Clone)]
struct System {
    factor: Cholesky<f64, Dyn>,
    /// Coefficients of the unit columns.
    beta: DVector<f64>,
}

/// One shape's columns against a model.
struct Shape {
    /// For each system: coefficients and the change of the model's own, and what they take off the squares; `None` where the
    /// columns are not new.
    solved: Vec<Option<Solved>>,
}

#[derive(Clone)]
struct Solved {
    c: DVector<f64>,
    u: DVector<f64>,
    reduction: f64,
}

/// What a candidate explains.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The shape that explains most of all rows.
    pub best: usize,
    /// Its coefficients on all rows.
    pub coefficients: Vec<f64>,
    /// Its whitened force at the rows, net of what the model's own coefficients take over; each fold's shape and coefficients are
    /// chosen on the others.
    pub force: Vec<f64>,
    /// Squares that it takes off on folds held out.
    pub gain: f64,
    /// Squares that it takes off where it is fitted, with the best shape.
    pub fitted: f64,
}

/// Sum of products, in eight lanes.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (a8, b8) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a8
        .remainder()
        .iter()
        .zip(b8.remainder())
        .map(|(a, b)| a * b)
        .sum();
    for (a, b) in a8.zip(b8) {
        for k in 0..8 {
            lanes[k] += a[k] * b[k];
        }
    }
    lanes.iter().sum::<f64>() + rest
}

impl Normal {
    /// Fits `columns` with their bounds to `force`; `None` where the columns do not determine their coefficients.
    pub fn new(
        noise: &Noise,
        folds: &[Range<usize>],
        columns: &[&[f64]],
        bounds: &[Bound],
        force: &[f64],
    ) -> Option<Self> {
        let whitened = noise.whitened_all(columns);
        let target = noise.whitened(force);
        let scale: Vec<f64> = whitened
            .iter()
            .map(|c| dot(c, c).max(1e-300).sqrt().recip())
            .collect();
        let unit: Vec<Vec<f64>> = whitened
            .into_iter()
            .zip(&scale)
            .map(|(c, s)| c.into_iter().map(|v| v * s).collect())
            .collect();
        let p = unit.len();
        let grams: Vec<DMatrix<f64>> = folds
            .par_iter()
            .map(|f| {
                let mut gram = DMatrix::zeros(p, p);
                for i in 0..p {
                    for j in 0..=i {
                        gram[(i, j)] = dot(&unit[i][f.clone()], &unit[j][f.clone()]);
                        gram[(j, i)] = gram[(i, j)];
                    }
                }
                gram
            })
            .collect();
        let rights: Vec<DVector<f64>> = folds
            .iter()
            .map(|f| DVector::from_fn(p, |i, _| dot(&unit[i][f.clone()], &target[f.clone()])))
            .collect();
        let ridge = DMatrix::from_diagonal_element(p, p, RIDGE);
        let gram = grams.iter().fold(ridge, |sum, g| sum + g);
        let right = rights.iter().fold(DVector::zeros(p), |sum, r| sum + r);
        let active = non_negative(&gram, &right, bounds)?;
        let pick = |m: &DMatrix<f64>| m.select_rows(&active).select_columns(&active);
        let solve = |g: DMatrix<f64>, r: DVector<f64>| {
            let factor = g.cholesky()?;
            let beta = factor.solve(&r);
            Some(System { factor, beta })
        };
        let whole = solve(pick(&gram), right.select_rows(&active))?;
        let prior = DMatrix::from_diagonal(&whole.beta.map(expected));
        let mut systems = vec![whole];
        for (own, r) in grams.iter().zip(&rights) {
            systems.push(solve(
                pick(&(&gram - own)) + &prior,
                (&right - r).select_rows(&active),
            )?);
        }
        let mut coefficients = vec![0.0; p];
        for (i, &j) in active.iter().enumerate() {
            coefficients[j] = systems[0].beta[i] * scale[j];
        }
        let columns: Vec<Vec<f64>> = unit
            .into_iter()
            .enumerate()
            .filter(|(j, _)| active.contains(j))
            .map(|(_, c)| c)
            .collect();
        let mut held_out = target.clone();
        for (s, fold) in folds.iter().enumerate() {
            for (column, b) in columns.iter().zip(systems[s + 1].beta.iter()) {
                subtract(&mut held_out[fold.clone()], &column[fold.clone()], *b);
            }
        }
        Some(Self {
            noise: noise.clone(),
            folds: folds.to_vec(),
            columns,
            scale: active.iter().map(|&j| scale[j]).collect(),
            active,
            target,
            systems,
            coefficients,
            held_out,
        })
    }

    /// What is left of `target` at the rows; `columns` are those that were fitted, not whitened.
    pub fn residual(&self, columns: &[&[f64]], target: &[f64]) -> Vec<f64> {
        let mut left = target.to_vec();
        self.take_off(&mut left, 0..target.len(), &self.coefficients, columns);
        left
    }

    /// The same, each fold with the coefficients of the others.
    pub fn held_out_residual(&self, columns: &[&[f64]], target: &[f64]) -> Vec<f64> {
        let mut left = target.to_vec();
        for (s, fold) in self.folds.iter().enumerate() {
            self.take_off(&mut left, fold.clone(), &self.without_fold(s), columns);
        }
        left
    }

    fn take_off(&self, left: &mut [f64], rows: Range<usize>, c: &[f64], columns: &[&[f64]]) {
        for i in rows {
            for &j in &self.active {
                left[i] -= c[j] * columns[j][i];
            }
        }
    }

    /// Sum of squares of the residual held out.
    pub fn loss(&self) -> f64 {
        dot(&self.held_out, &self.held_out)
    }

    /// Coefficients of all `count` columns with fold `s` held out.
    pub fn without_fold(&self, s: usize) -> Vec<f64> {
        let mut all = vec![0.0; self.coefficients.len()];
        for (i, &j) in self.active.iter().enumerate() {
            all[j] = self.systems[s + 1].beta[i] * self.scale[i];
        }
        all
    }

    /// Standard errors of all coefficients, `None` for those that take no part, robust to errors that are alike within a group
    /// (Liang and Zeger 1986); `group` is the group of each row.
    pub fn errors(&self, group: &[usize]) -> Vec<Option<f64>> {
        let k = self.active.len();
        let mut residual = self.target.clone();
        for (column, b) in self.columns.iter().zip(self.systems[0].beta.iter()) {
            subtract(&mut residual, column, *b);
        }
        let count = group.iter().max().map_or(1, |g| g + 1);
        let mut scores = DMatrix::<f64>::zeros(k, count);
        for (i, column) in self.columns.iter().enumerate() {
            for ((c, r), g) in column.iter().zip(&residual).zip(group) {
                scores[(i, *g)] += c * r;
            }
        }
        let spread = self.systems[0].factor.solve(&scores);
        let n = count as f64;
        let mut errors = vec![None; self.coefficients.len()];
        for (i, &j) in self.active.iter().enumerate() {
            let square = spread.row(i).norm_squared() * n / (n - 1.0).max(1.0);
            errors[j] = Some(self.scale[i] * square.sqrt());
        }
        errors
    }

    /// What a candidate explains: of its shapes, each with its columns, each fold takes the one that explains most of the others.
    /// `admits` tells whether a shape may have such coefficients.
    pub fn trial(
        &self,
        shapes: &[&[Vec<f64>]],
        admits: impl Fn(usize, &[f64]) -> bool + Sync,
    ) -> Option<Trial> {
        let all: Vec<&[f64]> = shapes
            .iter()
            .flat_map(|columns| columns.iter().map(Vec::as_slice))
            .collect();
        let mut all = self.noise.whitened_all(&all).into_iter();
        let own = |columns: &&[Vec<f64>]| all.by_ref().take(columns.len()).collect();
        let whitened: Vec<Vec<Vec<f64>>> = shapes.iter().map(own).collect();
        let solved: Vec<Shape> = whitened.par_iter().map(|w| self.solve(w)).collect();
        let choose = |system: usize| {
            let of = |shape: &Shape, i: usize| {
                let solved = shape.solved[system].as_ref()?;
                admits(i, solved.c.as_slice()).then_some(solved.reduction)
            };
            let all = solved
                .iter()
                .enumerate()
                .filter_map(|(i, shape)| Some((i, of(shape, i)?)));
            all.max_by(|a, b| a.1.total_cmp(&b.1))
        };
        let (best, fitted) = choose(0)?;
        let mut force = vec![0.0; self.target.len()];
        for (s, fold) in self.folds.iter().enumerate() {
            let Some((shape, _)) = choose(s + 1) else {
                continue;
            };
            let Some(own) = &solved[shape].solved[s + 1] else {
                continue;
            };
            let out = &mut force[fold.clone()];
            for (column, c) in whitened[shape].iter().zip(own.c.iter()) {
                subtract(out, &column[fold.clone()], -c);
            }
            for (column, u) in self.columns.iter().zip(own.u.iter()) {
                subtract(out, &column[fold.clone()], *u);
            }
        }
        Some(Trial {
            best,
            coefficients: solved[best].solved[0].as_ref()?.c.as_slice().to_vec(),
            gain: 2.0 * dot(&force, &self.held_out) - dot(&force, &force),
            force,
            fitted,
        })
    }

    /// Squares that columns take off where they are fitted, and their coefficients.
    pub fn reduction(&self, columns: &[Vec<f64>]) -> Option<(f64, Vec<f64>)> {
        let whitened: Vec<Vec<f64>> = columns.iter().map(|c| self.noise.whitened(c)).collect();
        let (cross, own, right) = self.products(&whitened, 0..self.target.len());
        let solved = self.systems[0].schur(&cross, &own, &right)?;
        Some((solved.reduction, solved.c.as_slice().to_vec()))
    }

    fn products(
        &self,
        columns: &[Vec<f64>],
        rows: Range<usize>,
    ) -> (DMatrix<f64>, DMatrix<f64>, DVector<f64>) {
        let k = columns.len();
        let of = |a: &[f64], b: &[f64]| dot(&a[rows.clone()], &b[rows.clone()]);
        (
            DMatrix::from_fn(self.columns.len(), k, |i, j| {
                of(&self.columns[i], &columns[j])
            }),
            DMatrix::from_fn(k, k, |i, j| of(&columns[i], &columns[j])),
            DVector::from_fn(k, |i, _| of(&columns[i], &self.target)),
        )
    }

    fn solve(&self, columns: &[Vec<f64>]) -> Shape {
        let parts: Vec<_> = self
            .folds
            .iter()
            .map(|f| self.products(columns, f.clone()))
            .collect();
        let first = parts[0].clone();
        let (cross, own, right) = parts[1..].iter().fold(first, |(a, b, c), part| {
            (a + &part.0, b + &part.1, c + &part.2)
        });
        let whole = self.systems[0].schur(&cross, &own, &right);
        let held = |j: usize| {
            let c = whole.as_ref().map_or(0.0, |w| w.c[j]);
            own[(j, j)] * (1.0 + expected(c * own[(j, j)].sqrt()))
        };
        let mut prior = own.clone();
        prior.set_diagonal(&DVector::from_fn(own.nrows(), |j, _| held(j)));
        let mut solved = vec![whole];
        for (system, part) in self.systems[1..].iter().zip(&parts) {
            solved.push(system.schur(
                &(&cross - &part.0),
                &(&prior - &part.1),
                &(&right - &part.2),
            ));
        }
        Shape { solved }
    }
}

impl System {
    fn schur(
        &self,
        cross: &DMatrix<f64>,
        own: &DMatrix<f64>,
        right: &DVector<f64>,
    ) -> Option<Solved> {
        let w = self.factor.solve(cross);
        let schur = own - cross.tr_mul(&w);
        if (0..own.nrows()).any(|j| schur[(j, j)].is_nan() || schur[(j, j)] <= NEW * own[(j, j)]) {
            return None;
        }
        let t = right - cross.tr_mul(&self.beta);
        let c = schur.cholesky()?.solve(&t);
        Some(Solved {
            u: &w * &c,
            reduction: c.dot(&t),
            c,
        })
    }
}

/// Precision that a fold's fit expects of the coefficient `beta` of a unit column on all rows: no fold knows more of its size. A column
/// that only the rows held out excite would have any coefficient, and tell of nothing but that.
fn expected(beta: f64) -> f64 {
    1.0 / (beta * beta).max(1.0)
}

fn subtract(out: &mut [f64], column: &[f64], factor: f64) {
    out.iter_mut()
        .zip(column)
        .for_each(|(o, v)| *o -= factor * v);
}
/// Lawson and Hanson's active set on normal equations (Solving Least Squares Problems, 1974, ch. 23): which columns take part
/// so that no bounded coefficient is negative.
fn non_negative(a: &DMatrix<f64>, b: &DVector<f64>, bounds: &[Bound]) -> Option<Vec<usize>> {
    let used = 0..bounds.len();
    let bounded = |j: usize| bounds[j] == Bound::NonNegative;
    let mut passive: Vec<usize> = used.clone().filter(|&j| !bounded(j)).collect();
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
        let gradient = |j: usize| b[j] - used.clone().map(|i| a[(j, i)] * x[i]).sum::<f64>();
        let entering = used
            .clone()
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
            for j in used.clone() {
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

    /// A column that all but acts in the third of three folds only, beside one that acts in all: the first two folds know its
    /// coefficient to ± 37, and a fit of theirs must not tell the third fold so.
    #[test]
    fn a_column_that_only_the_fold_held_out_excites_predicts_nothing() {
        let folds = [0..40, 40..80, 80..120];
        let wave: Vec<f64> = (0..120).map(|i| (f64::from(i) * 0.7).sin()).collect();
        let late: Vec<f64> = (0..120)
            .map(|i| {
                3e-4 + if i < 80 {
                    0.0
                } else {
                    (f64::from(i) * 0.31).cos()
                }
            })
            .collect();
        let noise = |i: usize| 0.1 * ((i * i) as f64 * 1.7).sin();
        let target: Vec<f64> = (0..120)
            .map(|i| 2.0 * wave[i] + 3.0 * late[i] + noise(i))
            .collect();
        let flat = vec![0.0; 120];
        let course = Course {
            folds: &folds,
            time: &(0..120).map(f64::from).collect::<Vec<_>>(),
            path: &flat,
            friction: &flat,
            stiffness: &flat,
            stroke: 1.0,
        };
        let white = Noise::white(&(0..120).map(noise).collect::<Vec<_>>(), &course);
        let columns = [wave.as_slice(), late.as_slice()];
        let fit = Normal::new(&white, &folds, &columns, &[Bound::Free; 2], &target)
            .expect("two columns determine their coefficients");
        assert!(
            (fit.coefficients[1] - 3.0).abs() < 0.1,
            "{:?}",
            fit.coefficients
        );
        let left = fit.held_out_residual(&columns, &target);
        let rms = |v: &[f64]| (v.iter().map(|x| x * x).sum::<f64>() / v.len() as f64).sqrt();
        let untold: Vec<f64> = (80..120).map(|i| 3.0 * late[i] + noise(i)).collect();
        assert!(
            rms(&left[80..]) < 1.3 * rms(&untold),
            "{} {}",
            rms(&left[80..]),
            rms(&untold)
        );
        assert!(rms(&left[..80]) < 0.09, "{}", rms(&left[..80]));
    }

    #[test]
    fn a_negative_coefficient_takes_no_part() {
        // y = 2·x0 − 1·x1 with orthogonal columns: the best non-negative fit leaves x1 out.
        let a = DMatrix::identity(3, 3);
        let b = DVector::from_column_slice(&[2.0, -1.0, -3.0]);
        let bounds = [Bound::NonNegative, Bound::NonNegative, Bound::Free];
        assert_eq!(non_negative(&a, &b, &bounds), Some(vec![0, 2]));
    }
}
