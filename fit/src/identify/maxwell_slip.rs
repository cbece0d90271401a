//! GMS models of 1…10 blocks for one recording: optimal breakpoints, the paper's procedure, and how many blocks
//! the data support.

use super::refine;
use super::regression::MaxwellSlipFit;
use super::regression::{Between, Exact, Gram, Regression, Surface, solve_normal};
use super::search::{Choice, best_choices};
use super::virgin::VirginCurve;
use crate::progress::Progress;
use crate::signal::GROUPS;
use crate::statistics::{mean_and_error, spread};
use rayon::prelude::*;

/// Most blocks that are tried.
pub const MOST: usize = 10;
/// Yields in the grid of the global search.
const GRID: usize = 56;
/// Best subsets of the grid that are refined.
const REFINED: usize = 3;
/// Relative improvement below which a refinement has converged if only the held-out error is wanted.
const HELD_OUT: f64 = 1e-4;

/// Steps of progress that [`select`] makes.
pub const STEPS: u64 = (1 + GROUPS + MOST) as u64;

/// A model of one size.
#[derive(Clone, Debug)]
pub struct Sized {
    /// The fit on all training samples.
    pub fit: MaxwellSlipFit,
    /// NMSE (%) on samples that were held out in turn.
    pub nmse_cross: f64,
    /// Squared error of each held-out group of folds.
    pub held_out: Vec<f64>,
}

/// What the training samples say.
#[derive(Clone, Debug)]
pub struct Selection {
    /// Optimal breakpoints, for each number of blocks that has a fit with positive stiffness.
    pub optimal: Vec<Sized>,
    /// Index into `optimal` of the smallest model that is not clearly worse than the best.
    pub knee: usize,
}

/// The range of yields worth trying: from `shortest` to `longest` (m or rad).
pub fn grid((shortest, longest): (f64, f64)) -> Vec<f64> {
    spread(shortest, longest, GRID)
}

/// Fits models of 1…[`MOST`] blocks with yields on and between those of `surface`, which is of `regression`.
///
/// # Errors
/// Why no model can be fitted.
pub fn select(
    regression: &Regression,
    surface: &Surface,
    progress: &Progress,
) -> Result<Selection, String> {
    let sizing = Sizing::new(surface).ok_or("there are too few samples to fit")?;
    let total = Gram::sum(&sizing.groups).ok_or("there are no samples to fit")?;
    let choices = best_choices(&surface.on_grid(&total), surface.linear, MOST);
    let groups = sizing.groups.len();
    progress.inc(1 + (GROUPS.saturating_sub(groups)) as u64);

    // Every group of folds takes its turn: yields and stiffnesses come from the others alone.
    let held_out: Vec<Vec<f64>> = (0..groups)
        .into_par_iter()
        .map(|out| {
            let errors = sizing.errors_held_out(out);
            progress.inc(1);
            errors
        })
        .collect();
    let variation: f64 = total.force_variation();
    let percent = |errors: &[f64]| 100.0 * errors.iter().sum::<f64>() / variation;

    let rows = regression.folds.concat();
    let whole = Between {
        surface,
        folds: total,
    };
    let exact = Exact {
        regression,
        rows: &rows,
    };
    let mut optimal: Vec<Sized> = (1..=MOST)
        .into_par_iter()
        .filter_map(|size| {
            let fit = sizing.best(&choices[size - 1], &whole);
            progress.inc(1);
            let held_out: Vec<f64> = held_out.iter().map(|errors| errors[size]).collect();
            Some(Sized {
                fit: fit?,
                nmse_cross: percent(&held_out),
                held_out,
            })
        })
        .collect();
    // Where the data are exhausted a further block finds nothing to do.
    let mut least = f64::INFINITY;
    optimal.retain(|model| {
        let improves = model.fit.squared_error < least;
        least = least.min(model.fit.squared_error);
        improves
    });
    if optimal.is_empty() {
        return Err("no Maxwell-slip block with a positive stiffness fits: the effort does not rise after reversals; sample faster, or check its sign (--sign) and column (--map)".to_owned());
    }
    let held_out: Vec<&[f64]> = optimal.iter().map(|m| m.held_out.as_slice()).collect();
    let knee = knee(&held_out);
    // Of what is recommended the samples have the last word; that costs passes along all of the motion.
    let yields = optimal[knee].fit.yields.clone();
    if let Some(fit) = refine::refine(&exact, yields, sizing.range) {
        optimal[knee].fit = fit;
    }
    Ok(Selection { knee, optimal })
}

/// The search for the yields of every size.
struct Sizing<'a> {
    surface: &'a Surface,
    range: (f64, f64),
    /// Groups of folds, each held out in turn.
    groups: Vec<Gram>,
}

impl<'a> Sizing<'a> {
    fn new(surface: &'a Surface) -> Option<Self> {
        let per_group = surface.folds.len().div_ceil(GROUPS).max(1);
        let groups = surface.folds.chunks(per_group);
        Some(Self {
            surface,
            range: (*surface.grid.first()?, *surface.grid.last()?),
            groups: groups.filter_map(Gram::sum).collect(),
        })
    }

    fn yields_of(&self, choice: &Choice) -> Vec<f64> {
        choice
            .yields
            .iter()
            .map(|&j| self.surface.grid[j])
            .collect()
    }

    /// Squared errors on group `out` of models of 0…[`MOST`] blocks that were fitted to the others. The yields are refined here
    /// too: on the grid alone a block between two of its yields is fitted better by two blocks.
    fn errors_held_out(&self, out: usize) -> Vec<f64> {
        let (surface, linear) = (self.surface, self.surface.linear);
        let others = (0..self.groups.len()).filter(|&g| g != out);
        let Some(rest) = Gram::sum(others.map(|g| &self.groups[g])) else {
            return vec![f64::NAN; MOST + 1];
        };
        let mut errors = vec![error_on(&self.groups[out], &rest, linear)];
        let choices = best_choices(&surface.on_grid(&rest), linear, MOST);
        let of = |folds: Gram| Between { surface, folds };
        let (rest, held_out) = (of(rest), of(self.groups[out].clone()));
        for best in &choices {
            let error = best.first().and_then(|choice| {
                let start = self.yields_of(choice);
                let fit = refine::refine_until(&rest, start, self.range, HELD_OUT)?;
                refine::squared_error(&held_out, &fit)
            });
            // A size without a fit of positive stiffness: the best is then a smaller one.
            let smaller = errors.last().copied().unwrap_or(f64::NAN);
            errors.push(error.unwrap_or(smaller));
        }
        errors
    }

    /// The best fit that refining the best of `choices` leads to.
    fn best(&self, choices: &[Choice], sums: &Between) -> Option<MaxwellSlipFit> {
        distinct(choices, REFINED)
            .into_iter()
            .filter_map(|choice| refine::refine(sums, self.yields_of(choice), self.range))
            .min_by(|a, b| a.squared_error.total_cmp(&b.squared_error))
    }
}

/// Squared error on `held_out` of the linear columns alone, fitted on `rest`.
fn error_on(held_out: &Gram, rest: &Gram, linear: usize) -> f64 {
    let chosen: Vec<usize> = (0..linear).collect();
    let (matrix, right) = rest.normal(&chosen);
    match solve_normal(&matrix, &right) {
        Some(coefficients) => held_out.squared_error(&chosen, &coefficients),
        None if chosen.is_empty() => held_out.squared_error(&chosen, &right),
        None => f64::NAN,
    }
}

/// The best choices that are not neighbours of a better one on the grid: starts that lead elsewhere.
fn distinct(choices: &[Choice], most: usize) -> Vec<&Choice> {
    let near = |a: &Choice, b: &Choice| {
        a.yields
            .iter()
            .zip(&b.yields)
            .all(|(i, j)| i.abs_diff(*j) <= 1)
    };
    let mut kept: Vec<&Choice> = Vec::new();
    for choice in choices {
        if kept.len() < most && !kept.iter().any(|k| near(k, choice)) {
            kept.push(choice);
        }
    }
    kept
}

/// A block must take at least this share off the held-out error to be worth its cycles.
const WORTH: f64 = 0.1;

/// Of models of ascending size, by their squared errors on each held-out group, the smallest whose held-out error exceeds the best by no more than
/// a tenth, or by no more than one standard error of the paired difference over the groups (what is common to both does not count).
pub(super) fn knee(held_out: &[&[f64]]) -> usize {
    let left: Vec<f64> = held_out.iter().map(|errors| errors.iter().sum()).collect();
    let best = (0..left.len())
        .min_by(|&a, &b| left[a].total_cmp(&left[b]))
        .unwrap_or(0);
    (0..best)
        .find(|&size| {
            let pairs = held_out[size].iter().zip(held_out[best]);
            let difference: Vec<f64> = pairs.map(|(a, b)| a - b).collect();
            let [mean, error] = mean_and_error(&difference);
            mean <= error || left[size] <= (1.0 + WORTH) * left[best]
        })
        .unwrap_or(best)
}

/// Whether the model without any block, with the held-out error `baseline` (%), does as well.
pub fn baseline_suffices(baseline: f64, models: &[Sized]) -> bool {
    let best = models
        .iter()
        .map(|m| m.nmse_cross)
        .fold(f64::INFINITY, f64::min);
    baseline <= (1.0 + WORTH) * best
}

/// The paper's procedure (7)–(9) with `blocks` breakpoints at equal steps of force.
///
/// `friction` is the effort without what the linear columns of `linear` explain; `strokes` are the training
/// samples of each stroke.
pub fn by_paper(curve: &VirginCurve, blocks: usize) -> MaxwellSlipFit {
    let found = curve.blocks(&curve.equal_force_breakpoints(blocks));
    MaxwellSlipFit {
        yields: found.iter().map(|b| b.0).collect(),
        stiffness: found.iter().map(|b| b.1).collect(),
        linear: Vec::new(),
        squared_error: f64::NAN,
    }
}
