//! What a perfect model would leave: sensor noise that is autocorrelated, and friction that does not repeat.
//!
//! `r = e + F̂·(g + Σ h_j·u_j)` within each fold, `e` autoregressive, `g` a random gain of the fold and `h_j` hat functions along the
//! travelled path with random heights `u_j`, the same once more for the part of the friction with short yields, so that its
//! shape may wander as well. Variances come from the recording at hand, by expectation–maximisation.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::ops::Range;

/// Order of the autoregression.
const ORDER: usize = 6;
/// Share of white noise added to what is left. Without it a recording without sensor noise has a residual that is predicted
/// almost perfectly, and thousandths of a percent of force count as thousands of nats: the law's error is no noise.
const WHITE: f64 = 0.1;
/// Most hats along the path of one fold.
const HATS: usize = 40;
/// Rounds of expectation–maximisation.
const ROUNDS: usize = 12;

/// Random columns of one fold, before whitening.
struct Random {
    columns: DMatrix<f64>,
    /// Variance group of each column.
    group: Vec<usize>,
}

/// Number of variance groups: gain and hats, each for short and long yields.
const GROUPS: usize = 4;

/// The noise model, ready to whiten.
pub struct Noise {
    folds: Vec<Range<usize>>,
    ar: Vec<f64>,
    /// Standard deviation of the innovation [N or N·m].
    pub sigma: f64,
    /// Standard deviations of the relative friction variation, by group [–].
    pub variation: [f64; GROUPS],
    whitened: Vec<Whitened>,
    /// Mean variance that noise and variability leave in a row.
    pub row_variance: f64,
}

struct Whitened {
    columns: DMatrix<f64>,
    factor: Cholesky<f64, Dyn>,
    deviation: DVector<f64>,
}

/// Columns of one fold in whitened form: inner products are `aᵀb − pₐᵀp_b`.
#[derive(Clone)]
pub struct Part {
    a: DMatrix<f64>,
    p: DMatrix<f64>,
}

impl Part {
    /// Inner products of the columns of two parts.
    pub fn products(&self, other: &Part) -> DMatrix<f64> {
        self.a.tr_mul(&other.a) - self.p.tr_mul(&other.p)
    }

    /// Squares of the columns.
    pub fn squares(&self) -> DVector<f64> {
        DVector::from_fn(self.a.ncols(), |j, _| {
            self.a.column(j).norm_squared() - self.p.column(j).norm_squared()
        })
    }

    /// The columns of both.
    pub fn beside(&self, other: &Part) -> Part {
        let join = |a: &DMatrix<f64>, b: &DMatrix<f64>| {
            DMatrix::from_fn(a.nrows(), a.ncols() + b.ncols(), |i, j| {
                if j < a.ncols() {
                    a[(i, j)]
                } else {
                    b[(i, j - a.ncols())]
                }
            })
        };
        Part {
            a: join(&self.a, &other.a),
            p: join(&self.p, &other.p),
        }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.a.nrows()
    }
}

/// What the noise model needs to know of the friction: its parts at the rows, and the path.
pub struct Variability<'a> {
    /// Fitted friction of blocks with short and with long yields [N or N·m].
    pub parts: [&'a [f64]; 2],
    /// Travelled path [m or rad].
    pub path: &'a [f64],
    /// Path between two hats [m or rad].
    pub correlation: f64,
}

impl Noise {
    /// Estimates the noise model from the residual of the present model.
    pub fn estimate(residual: &[f64], folds: &[Range<usize>], friction: &Variability) -> Self {
        let random: Vec<Random> = folds.iter().map(|rows| random(rows, friction)).collect();
        let mean_square = residual.iter().map(|r| r * r).sum::<f64>() / residual.len() as f64;
        let mut variation = [0.05; GROUPS];
        let mut rest = residual.to_vec();
        let (mut ar, mut sigma) = autoregression(&rest, folds);
        sigma = sigma.max(1e-6 * mean_square.sqrt()).max(1e-300);
        for _ in 0..ROUNDS {
            let whitened = whiten_random(&random, &ar, sigma, &variation);
            let (mut sums, mut counts) = ([0.0; GROUPS], [0.0; GROUPS]);
            for ((rows, w), random) in folds.iter().zip(&whitened).zip(&random) {
                if w.columns.ncols() == 0 {
                    continue;
                }
                let y = DMatrix::from_column_slice(
                    rows.len(),
                    1,
                    &filtered(&residual[rows.clone()], &ar, sigma),
                );
                let posterior = w.factor.solve(&w.columns.tr_mul(&y));
                let covariance = w.factor.inverse();
                let u: Vec<f64> = (0..posterior.nrows())
                    .map(|j| posterior[(j, 0)] * w.deviation[j])
                    .collect();
                for (j, &g) in random.group.iter().enumerate() {
                    sums[g] += u[j].powi(2) + covariance[(j, j)] * w.deviation[j].powi(2);
                    counts[g] += 1.0;
                }
                for (k, i) in rows.clone().enumerate() {
                    rest[i] = residual[i]
                        - (0..u.len())
                            .map(|j| random.columns[(k, j)] * u[j])
                            .sum::<f64>();
                }
            }
            for g in 0..GROUPS {
                if counts[g] > 0.0 {
                    variation[g] = (sums[g] / counts[g]).sqrt().clamp(1e-5, 1.0);
                }
            }
            (ar, sigma) = autoregression(&rest, folds);
            sigma = sigma.max(1e-6 * mean_square.sqrt()).max(1e-300);
        }
        let mut total = rest.iter().map(|r| r * r).sum::<f64>();
        for random in &random {
            for (j, &g) in random.group.iter().enumerate() {
                total += random.columns.column(j).norm_squared() * variation[g].powi(2);
            }
        }
        let whitened = whiten_random(&random, &ar, sigma, &variation);
        Self {
            folds: folds.to_vec(),
            ar,
            sigma,
            variation,
            whitened,
            row_variance: total / residual.len().max(1) as f64,
        }
    }

    /// Whitens columns given over all rows.
    pub fn whiten(&self, columns: &[Vec<f64>]) -> Vec<Part> {
        self.folds
            .iter()
            .zip(&self.whitened)
            .map(|(rows, w)| {
                let mut a = DMatrix::zeros(rows.len(), columns.len());
                for (j, column) in columns.iter().enumerate() {
                    a.column_mut(j).copy_from_slice(&filtered(
                        &column[rows.clone()],
                        &self.ar,
                        self.sigma,
                    ));
                }
                self.project(a, w)
            })
            .collect()
    }

    /// `V⁻¹r`, for screening: what is left of a residual, weighted by how well each row is known.
    pub fn inverse(&self, residual: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; residual.len()];
        for (rows, w) in self.folds.iter().zip(&self.whitened) {
            let a = filtered(&residual[rows.clone()], &self.ar, self.sigma);
            let a = DVector::from_vec(a);
            let rest = &a - &w.columns * w.factor.solve(&w.columns.tr_mul(&a));
            for i in 0..rest.len() {
                let later: f64 = self
                    .ar
                    .iter()
                    .enumerate()
                    .filter_map(|(k, c)| Some(c * rest.get(i + 1 + k)?))
                    .sum();
                out[rows.start + i] = (rest[i] - later) / self.sigma;
            }
        }
        out
    }

    fn project(&self, a: DMatrix<f64>, w: &Whitened) -> Part {
        let p = w
            .factor
            .l_dirty()
            .solve_lower_triangular(&w.columns.tr_mul(&a))
            .unwrap_or_else(|| DMatrix::zeros(w.columns.ncols(), a.ncols()));
        Part { a, p }
    }

    /// `count` whitened draws of the noise alone.
    pub fn draws(&self, count: usize, seed: u64) -> Vec<Part> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        self.folds
            .iter()
            .zip(&self.whitened)
            .map(|(rows, w)| {
                let mut a = DMatrix::from_fn(rows.len(), count, |_, _| normal(&mut rng));
                let u = DMatrix::from_fn(w.columns.ncols(), count, |_, _| normal(&mut rng));
                a += &w.columns * u;
                self.project(a, w)
            })
            .collect()
    }
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let mut uniform = || ((rng.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
    (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos()
}

fn random(rows: &Range<usize>, friction: &Variability) -> Random {
    let path = &friction.path[rows.clone()];
    let from = path.first().copied().unwrap_or(0.0);
    let length = (path.last().copied().unwrap_or(0.0) - from).max(0.0);
    let knots = ((length / friction.correlation.max(1e-300)).ceil() as usize).clamp(1, HATS);
    let spacing = length / knots as f64;
    let mut group = Vec::new();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for (part, force) in friction.parts.iter().enumerate() {
        let force = &force[rows.clone()];
        if force.iter().all(|f| *f == 0.0) {
            continue;
        }
        columns.push(force.to_vec());
        group.push(2 * part);
        if knots < 2 {
            continue;
        }
        for knot in 0..=knots {
            group.push(2 * part + 1);
            columns.push(
                force
                    .iter()
                    .zip(path)
                    .map(|(f, s)| f * (1.0 - ((s - from) / spacing - knot as f64).abs()).max(0.0))
                    .collect(),
            );
        }
    }
    Random {
        columns: DMatrix::from_fn(rows.len(), columns.len(), |i, j| columns[j][i]),
        group,
    }
}

fn whiten_random(
    random: &[Random],
    ar: &[f64],
    sigma: f64,
    variation: &[f64; GROUPS],
) -> Vec<Whitened> {
    random
        .iter()
        .filter_map(|r| {
            let deviation =
                DVector::from_iterator(r.group.len(), r.group.iter().map(|&g| variation[g]));
            let mut columns = DMatrix::zeros(r.columns.nrows(), r.columns.ncols());
            for j in 0..columns.ncols() {
                let scaled: Vec<f64> = r
                    .columns
                    .column(j)
                    .iter()
                    .map(|v| v * deviation[j])
                    .collect();
                columns
                    .column_mut(j)
                    .copy_from_slice(&filtered(&scaled, ar, sigma));
            }
            let q = columns.ncols();
            let inner = columns.tr_mul(&columns) + DMatrix::identity(q, q);
            Some(Whitened {
                columns,
                factor: inner.cholesky()?,
                deviation,
            })
        })
        .collect()
}

/// `(v_i − Σ a_k·v_{i−k})/σ`; the first rows of a fold see as many predecessors as there are.
fn filtered(values: &[f64], ar: &[f64], sigma: f64) -> Vec<f64> {
    (0..values.len())
        .map(|i| {
            let past: f64 = ar
                .iter()
                .enumerate()
                .take(i)
                .map(|(k, a)| a * values[i - 1 - k])
                .sum();
            (values[i] - past) / sigma
        })
        .collect()
}

/// Autoregression by Yule–Walker over the folds (always stable), and the innovation's standard deviation.
fn autoregression(values: &[f64], folds: &[Range<usize>]) -> (Vec<f64>, f64) {
    let mut c = [0.0; ORDER + 1];
    let mut count = 0usize;
    for rows in folds {
        let v = &values[rows.clone()];
        count += v.len();
        for (lag, c) in c.iter_mut().enumerate() {
            *c += v
                .iter()
                .zip(v.iter().skip(lag))
                .map(|(a, b)| a * b)
                .sum::<f64>();
        }
    }
    if c[0] <= 0.0 || count == 0 {
        return (vec![0.0; ORDER], 1e-300);
    }
    let mut a: Vec<f64> = Vec::new();
    let mut error = c[0] * (1.0 + WHITE);
    for k in 1..=ORDER {
        let past: f64 = a.iter().enumerate().map(|(j, aj)| aj * c[k - 1 - j]).sum();
        let reflection = (c[k] - past) / error;
        let mut next: Vec<f64> = (0..a.len())
            .map(|j| a[j] - reflection * a[a.len() - 1 - j])
            .collect();
        next.push(reflection);
        a = next;
        error *= 1.0 - reflection * reflection;
    }
    (a, (error / count as f64).max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_autoregression_and_the_gain_that_made_the_data() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let (folds, n) = (20, 800);
        let rows: Vec<Range<usize>> = (0..folds).map(|k| k * n..(k + 1) * n).collect();
        let path: Vec<f64> = (0..folds * n).map(|i| i as f64 * 1e-3).collect();
        let friction: Vec<f64> = (0..folds * n)
            .map(|i| if (i / 100) % 2 == 0 { 1.0 } else { -1.0 })
            .collect();
        let none = vec![0.0; folds * n];
        let mut r = vec![0.0; folds * n];
        for rows in &rows {
            let gain = 0.1 * normal(&mut rng);
            let mut e = 0.0;
            for i in rows.clone() {
                e = 0.7 * e + 0.01 * normal(&mut rng);
                r[i] = e + gain * friction[i];
            }
        }
        let noise = Noise::estimate(
            &r,
            &rows,
            &Variability {
                parts: [&none, &friction],
                path: &path,
                correlation: 1.0,
            },
        );
        assert!((noise.sigma / 0.01 - 1.0).abs() < 0.2, "{}", noise.sigma);
        assert!((noise.ar[0] - 0.7).abs() < 0.15, "{:?}", noise.ar);
        assert!(
            (noise.variation[2] / 0.1 - 1.0).abs() < 0.5,
            "{:?}",
            noise.variation
        );
    }
}
