//! What an engineer would do by hand: the catalogue's columns beside a base of inertia and stops, and a standard recipe that picks.
//!
//! A name is the effect of a picked column; its confidence is where it enters on the recipe's path (0 most lenient, 1 strictest), no
//! probability. What a recipe picks at its standard point is stated as confident. Nothing is shared with the tool.

use nalgebra::{DMatrix, DVector};
use serde_json::Value;

use super::motion::Motion;
use super::naive_columns::{Candidates, candidates};
use super::table::{Recording, Table};
use crate::trials::score::{Diagnosis, Named};

/// Points of a path, as many as the thresholds of [`super::summary::THRESHOLDS`].
const POINTS: usize = 20;
/// Multiples of BIC's penalty from the lenient end of the path to the strict one; 1 is BIC.
const PENALTIES: [f64; 2] = [0.25, 1024.0];
/// End of LASSO's path, in the penalty that leaves nothing.
const LAST_LAMBDA: f64 = 1e-3;
/// Folds of LASSO's cross-validation …
const FOLDS: usize = 5;
/// … each of so many blocks spread over the recording.
const SPREAD: usize = 4;
/// Passes of coordinate descent over the columns, at most, and the change (in the effort's deviation) that ends them.
const PASSES: usize = 300;
const STILL: f64 = 1e-6;
/// Thresholds of STLSQ: 10^-2.5 … 1 of the effort's RMS; PySINDy's default 0.1 is among them.
const THRESHOLD: f64 = 0.1;
/// Points a decade of them.
const PER_DECADE: f64 = 8.0;
/// PySINDy's default ridge.
const RIDGE: f64 = 0.05;
/// A column of which the others leave less than this share of its square cannot be told from them.
const OWN: f64 = 1e-6;
/// Exactly equivalent in every fit: the stronger is named and the other declared.
const SAME: [&str; 2] = ["constant_force", "coulomb_asymmetry"];

/// A standard recipe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recipe {
    /// Forward selection while the Bayesian information criterion falls (Schwarz 1978); over a multiple of its penalty.
    Bic,
    /// L1 penalty (Tibshirani 1996) by coordinate descent; the penalty of the one-standard-error rule of five folds.
    Lasso,
    /// Sequentially thresholded least squares with a ridge (Brunton et al. 2016; PySINDy's `STLSQ`, threshold 0.1, α 0.05).
    Stlsq,
}

/// Where each column enters (`None`: never) and whether it is in at the standard point.
type Picked = Vec<Option<(f64, bool)>>;

impl Recipe {
    /// From the name of a command line.
    pub fn of(name: &str) -> Option<Self> {
        [Self::Bic, Self::Lasso, Self::Stlsq]
            .into_iter()
            .find(|r| r.name() == name)
    }

    /// On command lines and in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bic => "bic",
            Self::Lasso => "lasso",
            Self::Stlsq => "pysindy",
        }
    }

    /// The answer to a recording.
    ///
    /// # Errors
    /// Where there are too few rows.
    pub fn diagnose(self, recording: &Recording) -> Result<Diagnosis, String> {
        let finite = |part: &Table| {
            let roles = [part.time(), part.position(), part.effort()];
            part.kept(|row| roles.iter().all(|c| part.columns[*c][row].is_finite()))
        };
        let parts: Vec<Table> = recording.parts.iter().map(finite).collect();
        let motions: Vec<Motion> = parts.iter().map(Motion::of).collect();
        let columns = candidates(&parts, &motions)?;
        let folds = Gram::folds(&columns);
        let picked = match self {
            Self::Bic => bic(&Gram::sum(&folds, None)),
            Self::Lasso => lasso(&folds),
            Self::Stlsq => stlsq(&Gram::sum(&folds, None)),
        };
        Ok(answer(&columns.ids, &picked))
    }
}

/// Names, the first to enter first; an effect's columns collapse.
fn answer(ids: &[&'static str], picked: &Picked) -> Diagnosis {
    let mut names: Vec<(&str, f64, bool)> = Vec::new();
    for (id, picked) in ids.iter().zip(picked) {
        let Some((at, standard)) = *picked else {
            continue;
        };
        match names.iter_mut().find(|n| n.0 == *id) {
            Some(n) => *n = (id, n.1.max(at), n.2 || standard),
            None => names.push((id, at, standard)),
        }
    }
    names.sort_by(|a, b| {
        (b.2, b.1)
            .partial_cmp(&(a.2, a.1))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    let mut same = false;
    names.retain(|n| !SAME.contains(&n.0) || !std::mem::replace(&mut same, true));
    let named = |&(id, at, standard): &(&str, f64, bool)| Named {
        id: id.to_owned(),
        confident: standard,
        confidence: at,
        nats: f64::NAN,
        ambiguous_with: SAME
            .iter()
            .filter(|other| SAME.contains(&id) && **other != id)
            .map(|other| (*other).to_owned())
            .collect(),
        places: Vec::new(),
        parameters: Vec::new(),
        features: Value::Null,
    };
    let missing = names.iter().any(|n| n.2);
    Diagnosis {
        verdict: if missing {
            "missing-physics"
        } else {
            "consistent"
        }
        .to_owned(),
        effects: names.iter().map(named).collect(),
        unknown: false,
        unknown_axis: None,
        unnamed: Vec::new(),
        nmse_test: None,
        noise_floor: None,
        seconds: f64::NAN,
    }
}

/// Products of base, candidates and effort (in this order, each scaled to an RMS of 1), summed over rows.
#[derive(Clone)]
struct Gram {
    products: DMatrix<f64>,
    rows: usize,
    base: usize,
}

impl Gram {
    fn folds(columns: &Candidates) -> Vec<Self> {
        let all: Vec<&Vec<f64>> = columns
            .base
            .iter()
            .chain(&columns.columns)
            .chain([&columns.effort])
            .collect();
        let n = columns.effort.len();
        let scales = all
            .iter()
            .map(|c| (c.iter().map(|v| v * v).sum::<f64>() / n as f64).sqrt());
        let scales: Vec<f64> = scales
            .map(|rms| if rms > 0.0 { 1.0 / rms } else { 0.0 })
            .collect();
        let fold = |i: usize| i * FOLDS * SPREAD / n % FOLDS;
        let of = |k: usize| {
            let rows: Vec<usize> = (0..n).filter(|&i| fold(i) == k).collect();
            let x = DMatrix::from_fn(rows.len(), all.len(), |i, j| scales[j] * all[j][rows[i]]);
            Self {
                products: x.tr_mul(&x),
                rows: rows.len(),
                base: columns.base.len(),
            }
        };
        (0..FOLDS).map(of).collect()
    }

    /// All folds but one.
    fn sum(folds: &[Self], but: Option<usize>) -> Self {
        let kept = folds
            .iter()
            .enumerate()
            .filter(|(k, _)| Some(*k) != but)
            .map(|(_, f)| f);
        let mut sum = Self {
            products: DMatrix::zeros(folds[0].products.nrows(), folds[0].products.nrows()),
            ..folds[0]
        };
        sum.rows = 0;
        for fold in kept {
            sum.products += &fold.products;
            sum.rows += fold.rows;
        }
        sum
    }

    fn last(&self) -> usize {
        self.products.nrows() - 1
    }

    /// What the base leaves of candidates and effort: the base is always in and never penalised.
    fn beside_base(&self) -> DMatrix<f64> {
        let mut left = self.products.clone();
        for j in 0..self.base {
            if left[(j, j)] > OWN * self.products[(j, j)] {
                take_out(&mut left, j);
            }
        }
        left.view(
            (self.base, self.base),
            (left.nrows() - self.base, left.nrows() - self.base),
        )
        .into_owned()
    }

    /// Squared error on these rows of what was fitted on `kept`'s: the base follows the candidates' coefficients by least squares there.
    fn error(&self, kept: &Self, candidates: &DVector<f64>) -> f64 {
        let (b, m) = (self.base, candidates.len());
        let mut normal = kept.products.view((0, 0), (b, b)).into_owned();
        for j in 0..b {
            normal[(j, j)] *= 1.0 + 1e-9;
            normal[(j, j)] += f64::MIN_POSITIVE;
        }
        let right = kept.products.view((0, self.last()), (b, 1))
            - kept.products.view((0, b), (b, m)) * candidates;
        let Some(base) = normal.cholesky().map(|c| c.solve(&right)) else {
            return f64::INFINITY;
        };
        let all = base.iter().chain(candidates.iter()).copied().chain([-1.0]);
        let all = DVector::from_iterator(b + m + 1, all);
        all.dot(&(&self.products * &all)) / self.rows as f64
    }
}

/// Makes everything orthogonal to a column, which becomes 0.
fn take_out(left: &mut DMatrix<f64>, j: usize) {
    let column: DVector<f64> = left.column(j).into_owned();
    left.ger(-1.0 / column[j], &column, &column, 1.0);
    left.column_mut(j).fill(0.0);
    left.row_mut(j).fill(0.0);
}

/// Where a value stands between the lenient and the strict end, on a logarithmic scale.
fn along(value: f64, [lenient, strict]: [f64; 2]) -> f64 {
    ((value / lenient).ln() / (strict / lenient).ln()).clamp(0.0, 1.0)
}

fn bic(gram: &Gram) -> Picked {
    let mut left = gram.beside_base();
    let (y, n) = (left.nrows() - 1, gram.rows as f64);
    let mut picked = vec![None; y];
    let mut penalty = f64::INFINITY;
    loop {
        let gain = |j: usize| left[(j, y)].powi(2) / left[(j, j)];
        let free = (0..y).filter(|&j| picked[j].is_none() && left[(j, j)] > OWN * n);
        let Some(best) = free.max_by(|&a, &b| gain(a).total_cmp(&gain(b))) else {
            break;
        };
        let share = (gain(best) / left[(y, y)]).min(1.0 - 1e-12);
        // A path that ended before at a smaller penalty is not taken up again.
        penalty = penalty.min(-n * (-share).ln_1p() / n.ln());
        if penalty <= PENALTIES[0] {
            break;
        }
        picked[best] = Some((along(penalty, PENALTIES), penalty > 1.0));
        take_out(&mut left, best);
    }
    picked
}

/// Coefficients at each penalty, the strictest first; each starts from the one before.
fn descend(left: &DMatrix<f64>, lambdas: &[f64]) -> Vec<DVector<f64>> {
    let y = left.nrows() - 1;
    let mut c = DVector::zeros(y);
    let mut slope = left
        .view((0, y), (y, 1))
        .into_owned()
        .column(0)
        .into_owned();
    lambdas
        .iter()
        .map(|lambda| {
            for _ in 0..PASSES {
                let mut largest: f64 = 0.0;
                for j in 0..y {
                    let own = left[(j, j)];
                    if own <= 0.0 {
                        continue;
                    }
                    let pull: f64 = slope[j] + own * c[j];
                    let new = pull.signum() * (pull.abs() - lambda).max(0.0) / own;
                    let change: f64 = new - c[j];
                    if change != 0.0 {
                        slope.axpy(-change, &left.view((0, j), (y, 1)).column(0), 1.0);
                        c[j] = new;
                        largest = largest.max(change.abs());
                    }
                }
                if largest < STILL {
                    break;
                }
            }
            c.clone()
        })
        .collect()
}

fn lasso(folds: &[Gram]) -> Picked {
    let all = Gram::sum(folds, None);
    let left = all.beside_base();
    let y = left.nrows() - 1;
    let largest = (0..y).map(|j| left[(j, y)].abs()).fold(0.0, f64::max);
    // Per row: the penalty of fewer rows is smaller in proportion.
    let shares: Vec<f64> = (0..=POINTS)
        .map(|i| LAST_LAMBDA.powf(i as f64 / POINTS as f64))
        .collect();
    let lambdas = |rows: usize| -> Vec<f64> {
        shares
            .iter()
            .map(|s| s * largest * (rows as f64 / all.rows as f64))
            .collect()
    };
    let mut errors = vec![Vec::new(); shares.len()];
    for (k, fold) in folds.iter().enumerate() {
        let kept = Gram::sum(folds, Some(k));
        let path = descend(&kept.beside_base(), &lambdas(kept.rows));
        for (errors, c) in errors.iter_mut().zip(&path) {
            errors.push(fold.error(&kept, c));
        }
    }
    let chosen = one_standard_error(&errors);
    let path = descend(&left, &lambdas(all.rows));
    let column = |j: usize| {
        let first = path.iter().position(|c| c[j] != 0.0)?;
        Some((1.0 - first as f64 / POINTS as f64, path[chosen][j] != 0.0))
    };
    (0..y).map(column).collect()
}

/// The strictest point whose mean error is within one standard error of the smallest.
fn one_standard_error(errors: &[Vec<f64>]) -> usize {
    let mean = |e: &[f64]| e.iter().sum::<f64>() / e.len() as f64;
    let means: Vec<f64> = errors.iter().map(|e| mean(e)).collect();
    let best = (0..means.len())
        .min_by(|&a, &b| means[a].total_cmp(&means[b]))
        .unwrap_or(0);
    let spread: f64 = errors[best].iter().map(|e| (e - means[best]).powi(2)).sum();
    let n = errors[best].len() as f64;
    let limit = means[best] + (spread / (n - 1.0) / n).sqrt();
    means.iter().position(|m| *m <= limit).unwrap_or(best)
}

fn stlsq(gram: &Gram) -> Picked {
    let left = gram.beside_base();
    let y = left.nrows() - 1;
    let mut picked: Picked = vec![None; y];
    for i in 0..=POINTS {
        // The default stands on a point: 12 of 20.
        let threshold = THRESHOLD * 10f64.powf((i as f64 - 12.0) / PER_DECADE);
        let mut active: Vec<usize> = (0..y).collect();
        loop {
            let c = ridge(&left, &active);
            let kept: Vec<usize> = active
                .iter()
                .zip(c.iter())
                .filter(|(_, c)| c.abs() >= threshold)
                .map(|(j, _)| *j)
                .collect();
            if kept.len() == active.len() {
                break;
            }
            active = kept;
        }
        for j in active {
            let standard = i == 12 || picked[j].is_some_and(|p| p.1);
            picked[j] = Some((i as f64 / POINTS as f64, standard));
        }
    }
    picked
}

/// Least squares of the effort on some columns, with PySINDy's ridge.
fn ridge(left: &DMatrix<f64>, active: &[usize]) -> DVector<f64> {
    let y = left.nrows() - 1;
    let normal = DMatrix::from_fn(active.len(), active.len(), |i, j| {
        left[(active[i], active[j])] + if i == j { RIDGE } else { 0.0 }
    });
    let right = DVector::from_iterator(active.len(), active.iter().map(|&j| left[(j, y)]));
    normal
        .cholesky()
        .map_or_else(|| DVector::zeros(active.len()), |c| c.solve(&right))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::trials::draw::Draw;

    const RECIPES: [Recipe; 3] = [Recipe::Bic, Recipe::Lasso, Recipe::Stlsq];

    /// Effort 1·a + 0.3·b + 0.05·c + 0.1·d on orthogonal columns of ±1; a is the base, d is in no dictionary.
    fn orthogonal() -> Vec<Gram> {
        let sign = |bits: usize| -> Vec<f64> {
            let one = |i: usize| 1.0 - 2.0 * f64::from((i & bits).count_ones() % 2);
            (0..800).map(one).collect()
        };
        let [a, b, c, d] = [1, 2, 4, 7].map(sign);
        let effort = (0..800).map(|i| a[i] + 0.3 * b[i] + 0.05 * c[i] + 0.1 * d[i]);
        Gram::folds(&Candidates {
            effort: effort.collect(),
            base: vec![a],
            ids: vec!["b", "c"],
            columns: vec![b, c],
        })
    }

    #[test]
    fn criteria_are_those_of_their_formulas() {
        let folds = orthogonal();
        let all = Gram::sum(&folds, None);
        // Forward selection: n·ln(residuals before / after) / ln n, of squares 0.09 + 0.0025 + 0.01.
        let penalty = |before: f64, after: f64| 800.0 * (before / after).ln() / 800f64.ln();
        let strict = [penalty(0.1025, 0.0125), penalty(0.0125, 0.01)];
        for (picked, penalty) in bic(&all).iter().zip(strict) {
            let (at, standard) = picked.unwrap();
            assert!((at - along(penalty, PENALTIES)).abs() < 1e-9 && standard);
        }
        // Soft thresholds: b enters first; c at 1/6 of the penalty that leaves nothing, between points 5 (0.178) and 6 (0.126).
        let entered: Vec<_> = lasso(&folds).iter().map(|p| p.unwrap()).collect();
        assert_eq!(entered, [(0.95, true), (0.7, true)]);
        // In the effort's RMS 1.050, b is 0.286 and c 0.048: points 15 (0.237) and 9 (0.042).
        let kept: Vec<_> = stlsq(&all).iter().map(|p| p.unwrap()).collect();
        assert_eq!(kept, [(0.75, true), (0.45, false)]);
    }

    #[test]
    fn the_strictest_point_within_one_standard_error_is_taken() {
        let errors = [[10.0, 12.0], [5.0, 7.0], [4.0, 6.0], [4.5, 6.5]].map(Vec::from);
        assert_eq!(one_standard_error(&errors), 1);
    }

    /// Three sines of position; inertia, a stop of the base, white noise, and `added` of (position in the travel, velocity).
    fn made(added: impl Fn(f64, f64) -> f64) -> Recording {
        let mut draw = Draw::new(3, 5);
        let waves = [(0.11, 6.0), (0.37, 3.0), (1.3, 1.0)];
        let at = |t: f64, turned: f64| -> f64 {
            let one = |(f, a): &(f64, f64)| {
                a * (TAU * f).powf(turned) * (TAU * f * t + turned * TAU / 4.0).sin()
            };
            1e-3 * waves.iter().map(one).sum::<f64>()
        };
        let t: Vec<f64> = (0..60_000).map(|i| 1e-3 * f64::from(i)).collect();
        let x: Vec<f64> = t.iter().map(|t| at(*t, 0.0)).collect();
        let mut table = Table {
            names: ["t_s", "x_m", "force_N"].map(String::from).to_vec(),
            columns: vec![t.clone(), x.clone(), vec![0.0; t.len()]],
        };
        let motion = Motion::of(&table);
        let travel = super::super::motion::Extent::of(std::slice::from_ref(&motion)).travel;
        let stop = motion.stop(2e-3 * travel);
        for (i, t) in t.iter().enumerate() {
            let noise = 0.1 * draw.uniform(-1.0, 1.0);
            table.columns[2][i] =
                3.0 * at(*t, 2.0) + stop[i] + noise + added(x[i] / travel, at(*t, 1.0));
        }
        Recording::new("made", table, None)
    }

    /// BIC has it first; LASSO and STLSQ, whose penalties depend on what the base leaves of a column, among their names.
    #[test]
    fn a_strong_effect_is_named_by_every_recipe() {
        let viscous = made(|_, v| 30.0 * v);
        let ripple = made(|s, _| 0.3 * (TAU * 12.0 * s).cos());
        for (recording, id) in [(viscous, "viscous"), (ripple, "periodic_force")] {
            for recipe in RECIPES {
                let answer = recipe.diagnose(&recording).unwrap();
                let own = answer.effects.iter().position(|n| n.id == id);
                let place = own.filter(|i| answer.effects[*i].confident);
                let right = place.is_some_and(|i| i == 0 || recipe != Recipe::Bic);
                assert!(right, "{}: {answer:?}", recipe.name());
            }
        }
    }

    #[test]
    fn a_short_recording_is_refused() {
        let mut short = made(|_, _| 0.0);
        short.parts[0] = short.parts[0].kept(|row| row < 500);
        let said = Recipe::Bic.diagnose(&short).unwrap_err();
        assert_eq!(said, "50 rows of 10 ms; a fit needs 200");
    }
}
