//! The best parameters of a model on a recording: variable projection, Levenberg–Marquardt, several starts.

use super::starts::latin_hypercube;
use super::{Bounded, Family, Span};
use crate::friction::Path;
use crate::identify::plain::Plain;
use crate::identify::regression::{Gram, Regressor, solve_normal};
use crate::model::Model;
use crate::recording::Recording;
use crate::signal::ZeroPhase;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};
use rayon::prelude::*;
use std::ops::Range;

/// Places of the Latin hypercube, per nonlinear parameter, that are tried before any is refined.
const TRIED_PER_PARAMETER: usize = 10;
/// The best of these that the optimiser starts from.
const STARTS: usize = 3;
/// Pieces of a recording, and samples in them, that starts are told apart by.
const PIECES: usize = 2;
const FEWEST: usize = 2_000;
/// Samples from which on these are stretches of pieces, how many, and how long each.
const LONG: usize = 12_000;
const STRETCHES: usize = 3;
const STRETCH: usize = 2_000;
/// Share of a stretch at either end that is run and not scored: the motion before is unknown there.
const SETTLES: usize = 8;
/// Most residuals; above, only every second, third, … sample is scored, while the model still runs along all.
const MOST_SCORED: usize = 20_000;
/// How hard the optimiser tries: the relative gain in the error that no longer counts, and the most trials.
#[derive(Clone, Copy)]
struct Effort {
    gain: f64,
    trials: usize,
}
/// To find which start leads furthest.
const QUICK: Effort = Effort {
    gain: 1e-4,
    trials: 15,
};
/// For the best start.
const FULL: Effort = Effort {
    gain: 1e-6,
    trials: 24,
};
/// Step of the forward differences, in the transformed parameter: Hsieh's bisection leaves noise of 1e-6 of a parameter's range in the force.
const STEP: f64 = 1e-3;
/// Longest step (of a transformed parameter) to the optimum of other samples, and what is added to the normal equations for it, of their trace.
const LONGEST: f64 = 0.3;
const RIDGE: f64 = 1e-9;
/// Parts of that step that are tried: it may go too far.
const PARTS: [f64; 4] = [1.0, 0.5, 0.25, 0.0];
/// Share of the logarithmic range from either end within which a parameter counts as stopped by its bound.
const AT_EDGE: f64 = 1e-3;

/// A recording as the optimiser sees it.
pub struct Data<'a> {
    /// What is fitted.
    pub recording: &'a Recording,
    /// The motion, run from rest.
    pub path: Path<'a>,
    /// Measured effort (N or N·m), through `filter` where there is one.
    pub effort: &'a [f64],
    /// The filter that `effort` went through, where it contains inertia.
    pub filter: Option<&'a ZeroPhase>,
    /// What acts beside friction.
    pub plain: Plain,
    /// Its columns.
    pub columns: Vec<Regressor>,
}

/// A fitted model.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The model, with plain physics.
    pub model: Model,
    /// Coefficients of the columns.
    pub linear: Vec<f64>,
    /// Nonlinear parameters, in the family's order.
    pub nonlinear: Vec<f64>,
    /// NMSE (13) over the scored samples (%).
    pub nmse: f64,
    /// Parameters that the optimiser would have moved further.
    pub at_edge: Vec<&'static str>,
}

/// The linear part of a fit with fixed nonlinear parameters: what the columns are and their coefficients.
struct Projection {
    coefficients: Linear,
    /// Residual at each scored sample, scaled so that its squares sum to the NMSE (%).
    residual: DVector<f64>,
}

/// Coefficients that least squares finds exactly.
struct Linear {
    amplitude: f64,
    damping: f64,
    /// Of the columns; 0 for one that another takes the place of.
    plain: Vec<f64>,
}

/// Columns of the regression, in this order; then come those of plain physics, and the effort last.
const AMPLITUDE: usize = 0;
const DAMPING: usize = 1;
const PLAIN: usize = 2;

/// One family on one recording, over some of its samples.
struct Problem<'a> {
    data: &'a Data<'a>,
    family: Family,
    bounds: Vec<Bounded>,
    rows: Vec<usize>,
    /// One sample in so many is scored.
    every: usize,
    /// The pieces of the path up to the last scored sample; all of them where a filter looks ahead.
    pieces: Vec<Range<usize>>,
    /// The model's own viscous term is fitted.
    damped: bool,
    /// `√(100/(N_s·σ²))` of eq. (13).
    scale: f64,
}

impl Data<'_> {
    /// Effort (N or N·m) of a fit at every sample, through the filter where there is one.
    ///
    /// # Errors
    /// Which parameter the library refuses.
    pub fn effort_of(&self, fit: &Fit) -> Result<Vec<f64>, String> {
        let friction = fit.model.friction.force(self.path);
        let mut effort = self.filtered(friction.map_err(|e| e.to_string())?);
        for (column, coefficient) in self.columns.iter().zip(&fit.linear) {
            let of_column = column.values.iter();
            (effort.iter_mut().zip(of_column)).for_each(|(e, v)| *e += coefficient * v);
        }
        Ok(effort)
    }

    fn filtered(&self, force: Vec<f64>) -> Vec<f64> {
        match self.filter {
            Some(filter) => filter.smooth(&force),
            None => force,
        }
    }

    /// Fits `family` to the samples `rows` from several starts; `None` where no start leads to a force that
    /// resists the motion. The same `seed` gives the same answer.
    pub fn fit(&self, family: Family, span: &Span, rows: &[usize], seed: u64) -> Option<Fit> {
        let screened = self.in_stretches(rows);
        let screened =
            screened.and_then(|(on, rows)| Problem::along(self, family, span, &on, &rows));
        let mut problem = match screened {
            Some(problem) => problem,
            None => Problem::new(self, family, span, &self.screened(rows))?,
        };
        // Hsieh's C_v·dx_s/dt is so near the viscous part that this stands in for it during the search, which
        // saves half of the model's many steps.
        problem.damped &= family != Family::Hsieh;
        let tried = TRIED_PER_PARAMETER * problem.bounds.len();
        let mut starts: Vec<(f64, DVector<f64>)> =
            latin_hypercube(tried, problem.bounds.len(), seed)
                .into_par_iter()
                .filter_map(|shares| {
                    let angles = DVector::from_vec(shares).map(angle);
                    let found = problem.project(&angles)?;
                    let resists = found.coefficients.amplitude > 0.0;
                    resists.then(|| (found.residual.norm_squared(), angles))
                })
                .collect();
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        starts.truncate(STARTS);
        let best = starts
            .into_par_iter()
            .filter_map(|(_, angles)| problem.minimised(angles, QUICK))
            .min_by(|a, b| a.nmse.total_cmp(&b.nmse))?;
        let problem = Problem::new(self, family, span, rows)?;
        problem.minimised(problem.angles(&best), FULL)
    }

    /// The samples of one piece in so many, where there are enough: they show which start leads furthest.
    fn screened(&self, rows: &[usize]) -> Vec<usize> {
        let every = (self.path.pieces.len() / PIECES).max(1);
        let pieces: Vec<&Range<usize>> = self.path.pieces.iter().step_by(every).collect();
        let own = |i: &&usize| pieces.iter().any(|piece| piece.contains(*i));
        let screened: Vec<usize> = rows.iter().filter(own).copied().collect();
        match screened.len() < FEWEST {
            true => rows.to_vec(),
            false => screened,
        }
    }

    /// The same of a long recording: stretches all over it, and samples in them.
    fn in_stretches(&self, rows: &[usize]) -> Option<(Vec<Range<usize>>, Vec<usize>)> {
        let cut = |piece: &Range<usize>| {
            let (starts, end) = (piece.clone().step_by(STRETCH), piece.end);
            starts.map(move |start| start..(start + STRETCH).min(end))
        };
        let stretches: Vec<Range<usize>> = self.path.pieces.iter().flat_map(cut).collect();
        let every = stretches.len().div_ceil(STRETCHES).max(1);
        let on: Vec<Range<usize>> = stretches.into_iter().step_by(every).collect();
        let inner = |of: &Range<usize>| {
            let margin = of.len() / SETTLES;
            of.start + margin..of.end - margin
        };
        let scored: Vec<Range<usize>> = on.iter().map(inner).collect();
        let own = |i: &&usize| scored.iter().any(|of| of.contains(*i));
        let own: Vec<usize> = rows.iter().filter(own).copied().collect();
        (rows.len() > LONG && own.len() >= FEWEST).then_some((on, own))
    }

    /// The fits to all groups of samples but one each, in their order: a step of Gauss and Newton from the fit to all, which lies so near that
    /// another search would find the same at a hundred times the price; where the step leaves more, the parameters stay. The
    /// linear ones are solved for anew.
    pub fn without_each(
        &self,
        family: Family,
        span: &Span,
        groups: &[Vec<usize>],
        from: &Fit,
    ) -> Vec<Option<Fit>> {
        let slopes = Slopes::of(self, family, span, groups, from);
        (0..groups.len())
            .into_par_iter()
            .map(|out| {
                let rest = groups.iter().enumerate().filter(|(i, _)| *i != out);
                let rest: Vec<usize> = rest.flat_map(|(_, rows)| rows.iter().copied()).collect();
                let problem = Problem::new(self, family, span, &rest)?;
                let stays = problem.angles(from);
                let step = slopes.as_ref().and_then(|slopes| slopes.step_without(out));
                let step = step.unwrap_or_else(|| DVector::zeros(stays.len()));
                PARTS
                    .into_iter()
                    .filter_map(|part| problem.at(&stays + part * &step))
                    .min_by(|a, b| a.nmse.total_cmp(&b.nmse))
            })
            .collect()
    }
}

/// Slopes of the projected residual by the transformed parameters at a fit, with the group of each sample.
struct Slopes {
    residual: DVector<f64>,
    slopes: DMatrix<f64>,
    group: Vec<usize>,
}

impl Slopes {
    fn of(
        data: &Data,
        family: Family,
        span: &Span,
        groups: &[Vec<usize>],
        at: &Fit,
    ) -> Option<Self> {
        let problem = Problem::new(data, family, span, &groups.concat())?;
        let of_sample = groups.iter().enumerate();
        let of_sample = of_sample.flat_map(|(g, rows)| std::iter::repeat_n(g, rows.len()));
        let group = of_sample.step_by(problem.every).collect();
        let angles = problem.angles(at);
        let search = Search {
            problem: &problem,
            now: problem.project(&angles),
            best: (f64::INFINITY, angles.clone()),
            angles,
        };
        Some(Self {
            residual: search.residuals()?,
            slopes: search.jacobian()?,
            group,
        })
    }

    /// The step to the least error without one group's samples.
    fn step_without(&self, out: usize) -> Option<DVector<f64>> {
        let kept: Vec<usize> = (0..self.group.len())
            .filter(|i| self.group[*i] != out)
            .collect();
        let slopes = self.slopes.select_rows(&kept);
        let residual = self.residual.select_rows(&kept);
        let mut normal = slopes.tr_mul(&slopes);
        let ridge = RIDGE * normal.trace();
        for i in 0..normal.nrows() {
            normal[(i, i)] += ridge;
        }
        let step = -normal.cholesky()?.solve(&slopes.tr_mul(&residual));
        let most = step.amax();
        Some(step * (LONGEST / most.max(LONGEST)))
    }
}

/// The transformed parameter of a share `0..1` of its logarithmic range; the sine keeps every step of the
/// optimiser inside.
fn angle(share: f64) -> f64 {
    (2.0 * share - 1.0).clamp(-1.0, 1.0).asin()
}

/// The share `0..1` of a transformed parameter.
fn share(angle: f64) -> f64 {
    0.5 + 0.5 * angle.sin()
}

impl<'a> Problem<'a> {
    fn new(data: &'a Data<'a>, family: Family, span: &Span, rows: &[usize]) -> Option<Self> {
        Self::along(data, family, span, data.path.pieces, rows)
    }

    /// The same along some `pieces` of the motion alone.
    fn along(
        data: &'a Data<'a>,
        family: Family,
        span: &Span,
        pieces: &[Range<usize>],
        rows: &[usize],
    ) -> Option<Self> {
        let every = rows.len().div_ceil(MOST_SCORED).max(1);
        let rows: Vec<usize> = rows.iter().copied().step_by(every).collect();
        let variation = Gram::of(&[data.effort], &rows).force_variation();
        let end = match (data.filter, rows.iter().max()) {
            (None, Some(last)) => last + 1,
            _ => data.effort.len(),
        };
        let scored = |piece: &&Range<usize>| rows.iter().any(|i| piece.contains(i));
        let pieces = pieces.iter().filter(scored);
        let pieces = pieces.map(|piece| piece.start..piece.end.min(end));
        let pieces = pieces.collect();
        (variation > 0.0).then(|| Self {
            pieces,
            damped: family.is_damped(),
            data,
            family,
            bounds: family.parameters(span),
            rows,
            every,
            scale: (100.0 / variation).sqrt(),
        })
    }

    fn nonlinear(&self, angles: &DVector<f64>) -> Vec<f64> {
        self.bounds
            .iter()
            .zip(angles.iter())
            .map(|(bound, &angle)| bound.from * (bound.to / bound.from).powf(share(angle)))
            .collect()
    }

    /// Where to go on from an earlier fit: a little inside of bounds, where a parameter has no slope.
    fn angles(&self, from: &Fit) -> DVector<f64> {
        let angles = self
            .bounds
            .iter()
            .zip(&from.nonlinear)
            .map(|(bound, value)| {
                let share = (value / bound.from).ln() / (bound.to / bound.from).ln();
                angle(share.clamp(0.01, 0.99))
            });
        DVector::from_vec(angles.collect())
    }

    /// Solves for everything linear at the transformed parameters `angles`, with amplitude 0 where none that is positive
    /// helps; `None` where the library refuses the parameters.
    fn project(&self, angles: &DVector<f64>) -> Option<Projection> {
        let nonlinear = self.nonlinear(angles);
        let force = |damping: f64| {
            let model = self.family.model(&nonlinear, 1.0, damping)?;
            let path = Path {
                pieces: &self.pieces,
                ..self.data.path
            };
            model.force(path).ok()
        };
        let unit = force(0.0)?;
        let damped = if self.damped {
            let mut with = force(1.0)?;
            with.iter_mut().zip(&unit).for_each(|(w, u)| *w -= u);
            self.data.filtered(with)
        } else {
            Vec::new()
        };
        let unit = self.data.filtered(unit);
        // A column that does not exist is never chosen; any slice of the right length stands in.
        let damped = if damped.is_empty() { &unit } else { &damped };
        let plain = self.data.columns.iter().map(|c| c.values.as_slice());
        let columns: Vec<&[f64]> = [unit.as_slice(), damped]
            .into_iter()
            .chain(plain)
            .chain([self.data.effort])
            .collect();
        let gram = Gram::of(&columns, &self.rows);
        let (chosen, coefficients) = self.solve(&gram)?;
        let residual = DVector::from_iterator(
            self.rows.len(),
            self.rows.iter().map(|&i| {
                let modelled: f64 = chosen
                    .iter()
                    .zip(coefficients.iter())
                    .map(|(&column, c)| c * columns[column][i])
                    .sum();
                self.scale * (self.data.effort[i] - modelled)
            }),
        );
        let of = |column| {
            let at = chosen.iter().position(|&c| c == column);
            at.map_or(0.0, |at| coefficients[at])
        };
        Some(Projection {
            coefficients: Linear {
                amplitude: of(AMPLITUDE),
                damping: of(DAMPING),
                plain: (PLAIN..columns.len() - 1).map(of).collect(),
            },
            residual,
        })
    }

    /// Least squares with a positive amplitude and a damping that is not negative.
    fn solve(&self, gram: &Gram) -> Option<(Vec<usize>, DVector<f64>)> {
        let plain = PLAIN..PLAIN + self.data.columns.len();
        let undamped: Vec<usize> = [AMPLITUDE].into_iter().chain(plain).collect();
        let is_viscous = |c: usize| c >= PLAIN && self.data.columns[c - PLAIN].name == "viscous";
        let damped = |mut columns: Vec<usize>| {
            columns.push(DAMPING);
            if self.family == Family::Hsieh {
                // C_v·dx_s/dt is nearly the viscous term itself; it takes its place.
                columns.retain(|&c| !is_viscous(c));
            }
            columns
        };
        let solved = |chosen: Vec<usize>| {
            let (matrix, right) = gram.normal(&chosen);
            let coefficients = solve_normal(&matrix, &right)?;
            let feasible = chosen.iter().zip(coefficients.iter()).all(|(&c, &value)| {
                (c != AMPLITUDE || value > 0.0) && (c != DAMPING || value >= 0.0)
            });
            feasible.then_some((chosen, coefficients))
        };
        let with_damping = self
            .damped
            .then(|| solved(damped(undamped.clone())))
            .flatten();
        // Without a force that resists, the rest alone: an error that the optimiser turns back from.
        with_damping
            .or_else(|| solved(undamped.clone()))
            .or_else(|| {
                let rest = undamped.iter().copied();
                solved(rest.filter(|&c| c != AMPLITUDE).collect())
            })
    }

    /// Runs the optimiser from `angles`.
    fn minimised(&self, angles: DVector<f64>, work: Effort) -> Option<Fit> {
        let now = self.project(&angles)?;
        let search = Search {
            problem: self,
            best: (now.residual.norm_squared(), angles.clone()),
            angles,
            now: Some(now),
        };
        let (search, _) = LevenbergMarquardt::new()
            .with_ftol(work.gain)
            .with_xtol(1e-7)
            .with_gtol(1e-9)
            .with_patience(work.trials.div_ceil(self.bounds.len() + 1))
            .minimize(search);
        // The optimiser may end on a trial that it rejects.
        self.at(search.best.1)
    }

    /// The fit at `angles`; `None` where no force that resists the motion helps.
    fn at(&self, angles: DVector<f64>) -> Option<Fit> {
        let now = self.project(&angles)?;
        if now.coefficients.amplitude <= 0.0 {
            return None;
        }
        let nonlinear = self.nonlinear(&angles);
        let linear = now.coefficients;
        let at_edge = self
            .bounds
            .iter()
            .zip(angles.iter())
            .filter(|(_, angle)| !(AT_EDGE..1.0 - AT_EDGE).contains(&share(**angle)))
            .map(|(bound, _)| bound.name)
            .collect();
        let friction = self
            .family
            .model(&nonlinear, linear.amplitude, linear.damping)?;
        Some(Fit {
            model: (self.data.plain).model(self.data.recording, friction, &linear.plain),
            linear: linear.plain,
            nonlinear,
            nmse: now.residual.norm_squared(),
            at_edge,
        })
    }
}

/// Where one start has got to.
struct Search<'a> {
    problem: &'a Problem<'a>,
    angles: DVector<f64>,
    now: Option<Projection>,
    /// Least squared error so far, and where.
    best: (f64, DVector<f64>),
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Search<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, angles: &DVector<f64>) {
        self.angles.clone_from(angles);
        self.now = self.problem.project(angles);
        let error = self.now.as_ref().map(|now| now.residual.norm_squared());
        if let Some(error) = error.filter(|error| *error < self.best.0) {
            self.best = (error, angles.clone());
        }
    }

    fn params(&self) -> DVector<f64> {
        self.angles.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        self.now.as_ref().map(|now| now.residual.clone())
    }

    /// Of the projected residual, so that the linear coefficients follow every parameter.
    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let columns = (0..self.angles.len())
            .into_par_iter()
            .map(|j| {
                let shifted = |step: f64| {
                    let mut angles = self.angles.clone();
                    angles[j] += step;
                    self.problem.project(&angles).map(|found| found.residual)
                };
                Some((shifted(STEP)? - &self.now.as_ref()?.residual) / STEP)
            })
            .collect::<Option<Vec<_>>>()?;
        Some(DMatrix::from_columns(&columns))
    }
}
