//! Global search for breakpoints: which few yields of a fine grid explain the force best.

use super::regression::{Gram, solve_normal};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Subsets kept from one size to the next; the test below compares it with exhaustive search.
const BEAM: usize = 48;

/// Sizes up to this one are searched exhaustively.
const EXHAUSTIVE: usize = 2;

/// Yields chosen from the grid (indices, ascending) and the squared error that they leave.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Indices into the grid of yields.
    pub yields: Vec<usize>,
    /// Squared error of the best fit with them.
    pub squared_error: f64,
}

/// The regression with its linear columns projected out: what the deflections still have to explain.
struct Projected {
    products: DMatrix<f64>,
    right: DVector<f64>,
    rest: f64,
}

impl Projected {
    /// `None` where the linear columns themselves are not independent.
    fn of(gram: &Gram, linear: usize) -> Option<Self> {
        let last = gram.products.nrows() - 1;
        let grid = last - linear;
        let of_grid = gram
            .products
            .view((linear, linear), (grid, grid))
            .into_owned();
        let right = gram
            .products
            .view((linear, last), (grid, 1))
            .column(0)
            .into_owned();
        let rest = gram.products[(last, last)];
        if linear == 0 {
            return Some(Self {
                products: of_grid,
                right,
                rest,
            });
        }
        let cross = gram.products.view((0, linear), (linear, grid)).into_owned();
        let inner = gram.products.view((0, 0), (linear, linear)).into_owned();
        let force = gram
            .products
            .view((0, last), (linear, 1))
            .column(0)
            .into_owned();
        let mut solved = DMatrix::zeros(linear, grid);
        for (j, column) in cross.column_iter().enumerate() {
            solved.set_column(j, &solve_normal(&inner, &column.into_owned())?);
        }
        let own = solve_normal(&inner, &force)?;
        Some(Self {
            products: of_grid - cross.transpose() * &solved,
            right: right - cross.transpose() * &own,
            rest: rest - force.dot(&own),
        })
    }

    /// The error left by these yields, or `None` where a stiffness would not be positive: the best
    /// non-negative fit is then one of fewer blocks, which is searched on its own.
    fn error(&self, yields: &[usize]) -> Option<f64> {
        let n = yields.len();
        let matrix = DMatrix::from_fn(n, n, |i, j| self.products[(yields[i], yields[j])]);
        let right = DVector::from_fn(n, |i, _| self.right[yields[i]]);
        let stiffness = solve_normal(&matrix, &right)?;
        stiffness
            .iter()
            .all(|&k| k > 0.0)
            .then(|| (self.rest - stiffness.dot(&right)).max(0.0))
    }

    fn choice(&self, mut yields: Vec<usize>) -> Option<Choice> {
        yields.sort_unstable();
        let squared_error = self.error(&yields)?;
        Some(Choice {
            yields,
            squared_error,
        })
    }
}

/// The best choices of 1…`most` yields out of the grid, best first, for each size.
///
/// `gram` holds `linear` linear columns, then the grid's deflections, then the force. Sizes 1 and 2 are
/// exhaustive. From then on every one of the best subsets is extended by every yield of the grid, and the best
/// of these are improved by exchanging each member for every other yield until none improves. No start value
/// enters. A size for which no subset has positive stiffness throughout stays empty.
pub fn best_choices(gram: &Gram, linear: usize, most: usize) -> Vec<Vec<Choice>> {
    let grid = gram.products.nrows() - 1 - linear;
    let Some(problem) = Projected::of(gram, linear) else {
        return vec![Vec::new(); most];
    };
    let mut sizes: Vec<Vec<Choice>> = Vec::with_capacity(most);
    for size in 1..=most {
        let start = if size <= EXHAUSTIVE {
            vec![Vec::new()]
        } else {
            sizes[size - 2].iter().map(|c| c.yields.clone()).collect()
        };
        let mut found: Vec<Choice> = start
            .par_iter()
            .flat_map_iter(|yields: &Vec<usize>| {
                let open = size - yields.len();
                extensions(yields, open, grid).filter_map(|yields| problem.choice(yields))
            })
            .collect();
        keep_best(&mut found);
        if size > EXHAUSTIVE {
            found = found
                .into_par_iter()
                .map(|choice| exchange(&problem, choice, grid))
                .collect();
            keep_best(&mut found);
        }
        sizes.push(found);
    }
    sizes
}

/// The best fit of the columns `linear`, of either sign, and `blocks`, whose stiffness is not negative (Lawson and Hanson, Solving Least
/// Squares Problems, 1974, ch. 23): the columns that take part and their coefficients. `None` if the columns cannot be separated.
pub fn non_negative(
    gram: &Gram,
    linear: &[usize],
    blocks: &[usize],
) -> Option<(Vec<usize>, DVector<f64>)> {
    let problem = Projected::of(&gram.part(&[linear, blocks].concat()), linear.len())?;
    let n = blocks.len();
    let (mut active, mut stiffness): (Vec<usize>, Vec<f64>) = (Vec::new(), vec![0.0; n]);
    let solve = |active: &[usize]| {
        let of = |i: usize, j: usize| problem.products[(active[i], active[j])];
        let matrix = DMatrix::from_fn(active.len(), active.len(), of);
        let right = DVector::from_fn(active.len(), |i, _| problem.right[active[i]]);
        solve_normal(&matrix, &right)
    };
    for _ in 0..3 * n {
        let gain = |j: usize| {
            let taken: f64 = active
                .iter()
                .map(|&i| problem.products[(j, i)] * stiffness[i])
                .sum();
            (problem.right[j] - taken) / problem.products[(j, j)].sqrt()
        };
        let open = (0..n).filter(|j| !active.contains(j) && problem.products[(*j, *j)] > 0.0);
        let next = open.max_by(|a, b| gain(*a).total_cmp(&gain(*b)));
        let Some(next) = next.filter(|j| gain(*j) > 1e-6 * problem.rest.max(0.0).sqrt()) else {
            break;
        };
        active.push(next);
        loop {
            let Some(wanted) = solve(&active) else {
                // The newest is the others in disguise.
                active.pop();
                break;
            };
            let short = active.iter().zip(wanted.iter()).filter(|(_, k)| **k <= 0.0);
            let part = short
                .map(|(&i, k)| stiffness[i] / (stiffness[i] - k))
                .fold(1.0, f64::min);
            for (&i, k) in active.iter().zip(wanted.iter()) {
                stiffness[i] += part * (k - stiffness[i]);
            }
            if part >= 1.0 {
                break;
            }
            let least = 1e-12 * stiffness.iter().copied().fold(0.0, f64::max);
            active.retain(|&i| stiffness[i] > least);
            (0..n)
                .filter(|i| !active.contains(i))
                .for_each(|i| stiffness[i] = 0.0);
        }
        if !active.contains(&next) {
            break;
        }
    }
    let chosen: Vec<usize> = linear
        .iter()
        .copied()
        .chain(active.iter().map(|&i| blocks[i]))
        .collect();
    let (matrix, right) = gram.normal(&chosen);
    let coefficients = solve_normal(&matrix, &right)?;
    Some((chosen, coefficients))
}

/// `yields` with `open` (1 or 2) more members of the grid, each set once.
fn extensions(yields: &[usize], open: usize, grid: usize) -> impl Iterator<Item = Vec<usize>> {
    let firsts = (0..grid).filter(move |j| !yields.contains(j));
    firsts.flat_map(move |j| {
        let with = |extra: &[usize]| [yields, extra].concat();
        if open == 1 {
            vec![with(&[j])]
        } else {
            (j + 1..grid).map(|k| with(&[j, k])).collect()
        }
    })
}

/// Exchanges members one at a time, each for its best replacement, until none improves.
fn exchange(problem: &Projected, mut best: Choice, grid: usize) -> Choice {
    loop {
        let before = best.squared_error;
        for member in 0..best.yields.len() {
            let yields = best.yields.clone();
            let improved = (0..grid)
                .filter(|j| !yields.contains(j))
                .filter_map(|j| {
                    let mut trial = yields.clone();
                    trial[member] = j;
                    problem.choice(trial)
                })
                .min_by(|a, b| a.squared_error.total_cmp(&b.squared_error));
            if let Some(improved) = improved
                && improved.squared_error < best.squared_error
            {
                best = improved;
            }
        }
        if best.squared_error >= before {
            return best;
        }
    }
}

fn keep_best(found: &mut Vec<Choice>) {
    found.sort_by(|a, b| {
        a.squared_error
            .total_cmp(&b.squared_error)
            .then_with(|| a.yields.cmp(&b.yields))
    });
    found.dedup_by(|a, b| a.yields == b.yields);
    found.truncate(BEAM);
}
