//! The best parameters of a model on a recording: variable projection, Levenberg–Marquardt, several starts.

use super::starts::latin_hypercube;
use super::{Bounded, Family, Span};
use crate::friction::Path;
use crate::identify::regression::{Gram, solve_normal};
use crate::model::Model;
use crate::recording::MotionKind;
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
/// Most residuals; above, only every second, third, … sample is scored, while the model still runs along all.
const MOST_SCORED: usize = 20_000;
/// How hard the optimiser tries: the relative gain in the error that no longer counts, the most trials, and
/// whether derivatives are central or forward differences.
#[derive(Clone, Copy)]
struct Effort {
    gain: f64,
    trials: usize,
    central: bool,
}
/// To tell which start leads furthest, and to follow an optimum to slightly different samples.
const QUICK: Effort = Effort {
    gain: 1e-4,
    trials: 15,
    central: false,
};
/// For the best start.
const FULL: Effort = Effort {
    gain: 1e-7,
    trials: 36,
    central: true,
};
/// Step of the differences, in the transformed parameter: the truncation error of central ones is 1e-6 of a
/// parameter's range, while Hsieh's bisection leaves noise of the same size in the force.
const STEP: f64 = 1e-3;
/// Share of the logarithmic range from either end within which a parameter counts as stopped by its bound.
const AT_EDGE: f64 = 1e-3;

/// A recording as the optimiser sees it.
pub struct Data<'a> {
    /// Linear or rotary.
    pub motion: MotionKind,
    /// The motion, run from rest.
    pub path: Path<'a>,
    /// Measured effort (N or N·m), through `filter` where there is one.
    pub effort: &'a [f64],
    /// The filter that `effort` went through, where it contains inertia.
    pub filter: Option<&'a ZeroPhase>,
    /// Acceleration (m/s² or rad/s²), where an inertia is fitted.
    pub acceleration: Option<&'a [f64]>,
}

/// A fitted model.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The model, with inertia, viscous part and offset.
    pub model: Model,
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
#[derive(Clone, Copy, Default)]
struct Linear {
    amplitude: f64,
    damping: f64,
    mass: f64,
    viscous: f64,
    offset: f64,
}

/// Columns of the regression, in this order; the effort comes last.
const AMPLITUDE: usize = 0;
const DAMPING: usize = 1;
const MASS: usize = 2;
const VISCOUS: usize = 3;
const OFFSET: usize = 4;

/// One family on one recording, over some of its samples.
struct Problem<'a> {
    data: &'a Data<'a>,
    family: Family,
    bounds: Vec<Bounded>,
    rows: Vec<usize>,
    /// The pieces of the path up to the last scored sample; all of them where a filter looks ahead.
    pieces: Vec<Range<usize>>,
    /// The model's own viscous term is fitted.
    damped: bool,
    ones: Vec<f64>,
    /// `√(100/(N_s·σ²))` of eq. (13).
    scale: f64,
}

impl Data<'_> {
    /// Effort (N or N·m) of a finished model at every sample, through the filter where there is one.
    ///
    /// # Errors
    /// Which parameter the library refuses.
    pub fn effort_of(&self, model: &Model) -> Result<Vec<f64>, String> {
        let mut effort = self.filtered(model.friction.force(self.path).map_err(|e| e.to_string())?);
        for (effort, v) in effort.iter_mut().zip(self.path.velocity) {
            *effort += model.viscous * v + model.constant_force;
        }
        if let Some(acceleration) = self.acceleration {
            for (effort, a) in effort.iter_mut().zip(acceleration) {
                *effort += model.inertia * a;
            }
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
        let mut problem = Problem::new(self, family, span, rows)?;
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
        problem.damped = family.is_damped();
        problem.minimised(problem.angles(&best), FULL)
    }

    /// Fits `family` to other samples, from the parameters that an earlier fit found.
    pub fn refit(&self, family: Family, span: &Span, rows: &[usize], from: &Fit) -> Option<Fit> {
        let problem = Problem::new(self, family, span, rows)?;
        problem.minimised(problem.angles(from), QUICK)
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
        let every = rows.len().div_ceil(MOST_SCORED).max(1);
        let rows: Vec<usize> = rows.iter().copied().step_by(every).collect();
        let variation = Gram::of(&[data.effort], &rows).force_variation();
        let end = match (data.filter, rows.iter().max()) {
            (None, Some(last)) => last + 1,
            _ => data.effort.len(),
        };
        let pieces = data.path.pieces.iter();
        let pieces = pieces.map(|piece| piece.start..piece.end.min(end));
        (variation > 0.0).then(|| Self {
            pieces: pieces.filter(|piece| !piece.is_empty()).collect(),
            damped: family.is_damped(),
            data,
            family,
            bounds: family.parameters(span),
            rows,
            ones: vec![1.0; data.effort.len()],
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
        // Columns that do not exist are never chosen; any slice of the right length stands in.
        let absent = self.ones.as_slice();
        let columns = [
            unit.as_slice(),
            if damped.is_empty() { absent } else { &damped },
            self.data.acceleration.unwrap_or(absent),
            self.data.path.velocity,
            &self.ones,
            self.data.effort,
        ];
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
                mass: of(MASS),
                viscous: of(VISCOUS),
                offset: of(OFFSET),
            },
            residual,
        })
    }

    /// Least squares with a positive amplitude and a damping that is not negative.
    fn solve(&self, gram: &Gram) -> Option<(Vec<usize>, DVector<f64>)> {
        let undamped = if self.data.acceleration.is_some() {
            vec![AMPLITUDE, MASS, VISCOUS, OFFSET]
        } else {
            vec![AMPLITUDE, VISCOUS, OFFSET]
        };
        let damped = |mut columns: Vec<usize>| {
            columns.push(DAMPING);
            if self.family == Family::Hsieh {
                // C_v·dx_s/dt is nearly the viscous term itself; it takes its place.
                columns.retain(|&c| c != VISCOUS);
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
            central: work.central,
        };
        let (search, _) = LevenbergMarquardt::new()
            .with_ftol(work.gain)
            .with_xtol(1e-7)
            .with_gtol(1e-9)
            .with_patience(work.trials.div_ceil(self.bounds.len() + 1))
            .minimize(search);
        // The optimiser may end on a trial that it rejects.
        let (_, angles) = search.best;
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
            model: Model {
                inertia: linear.mass,
                viscous: linear.viscous,
                constant_force: linear.offset,
                ..Model::of_friction(self.data.motion, friction)
            },
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
    central: bool,
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
                if !self.central {
                    let here = &self.now.as_ref()?.residual;
                    return Some((shifted(STEP)? - here) / STEP);
                }
                let (ahead, behind) = rayon::join(|| shifted(STEP), || shifted(-STEP));
                Some((ahead? - behind?) / (2.0 * STEP))
            })
            .collect::<Option<Vec<_>>>()?;
        Some(DMatrix::from_columns(&columns))
    }
}
