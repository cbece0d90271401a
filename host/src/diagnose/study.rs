//! A recording with its dictionary, and one hypothesis about what acts in it.

use super::columns::{self, Baseline, spread};
use super::noise::{Noise, Variability};
use super::score::{Bound, Fit, Gain, Problem};
use super::signals::{Signals, bounds, quantile};
use super::weak::{Weak, curvature};
use crate::identify::stop::Deflection;
use crate::recording::Recording;
use rayon::prelude::*;

/// Blocks of the over-resolved core. On simulated stages naming the missing physics rose from 45 % with the paper's six to
/// 71 % with 24: error of the hysteresis core is the main impostor.
const CORE: usize = 24;
/// Realisations of the noise alone behind each threshold.
const DRAWS: usize = 16;
/// Hats over the displacement since reversal, and classes of stroke length, of the law's own error.
const ERROR_HATS: usize = 7;

/// What stays the same for every hypothesis.
pub struct Study {
    /// Coordinates.
    pub s: Signals,
    /// Kernel and rows.
    pub weak: Weak,
    /// Measured effort at the rows.
    pub force: Vec<f64>,
    /// Whether the effort contains inertia.
    pub inertial: bool,
    /// Yield displacements of the core [m or rad].
    pub yields: Vec<f64>,
    acceleration: Vec<f64>,
    deflections: Vec<Vec<f64>>,
    deflection_rows: Vec<Vec<f64>>,
    error_rows: Vec<Vec<f64>>,
    path_rows: Vec<f64>,
}

/// An effect of a given shape.
#[derive(Clone, Debug)]
pub struct Term {
    /// Id in the catalogue.
    pub id: &'static str,
    /// Shape parameters.
    pub shape: Vec<f64>,
    /// Part of the user's model: kept, and not reported.
    pub given: bool,
}

/// A hypothesis, fitted.
pub struct State {
    /// Effects in it.
    pub terms: Vec<Term>,
    /// First coefficient of each term.
    pub places: Vec<std::ops::Range<usize>>,
    /// The model that effects act through.
    pub baseline: Baseline,
    /// Noise.
    pub noise: Noise,
    /// Gram matrices.
    pub problem: Problem,
    /// Its fit, with the law's own error.
    pub fit: Fit,
    /// Columns at the rows.
    pub rows: Vec<Vec<f64>>,
    /// Their bounds.
    pub bounds: Vec<Bound>,
}

impl Study {
    /// Prepares a recording.
    ///
    /// # Errors
    /// What it lacks.
    pub fn new(recording: &Recording) -> Result<Self, String> {
        let s = Signals::of(recording);
        let inertial = recording.role.contains_inertia();
        let weak = Weak::new(&s, inertial);
        if weak.folds.len() < 3 {
            return Err(format!(
                "{}: {} {}(s) long enough to fit: too few to hold any out; record at least six reversals, or give several recordings of the machine",
                recording.name,
                weak.folds.len(),
                s.unit
            ));
        }
        let yields = yields(&s);
        let deflections: Vec<Vec<f64>> = yields
            .par_iter()
            .map(|&d| Deflection::along(&s.x, &s.pieces, d).z)
            .collect();
        let deflection_rows = deflections.par_iter().map(|z| weak.rows(z)).collect();
        let error_rows = law_error(&s).par_iter().map(|c| weak.rows(c)).collect();
        Ok(Self {
            force: weak.rows(&recording.effort),
            acceleration: weak.rows(&curvature(&s.x, &s.pieces, s.dt)),
            path_rows: weak.at_centres(&s.path),
            deflections,
            deflection_rows,
            error_rows,
            yields,
            inertial,
            weak,
            s,
        })
    }

    /// Fits a hypothesis; `from` gives the friction that its columns act through and the first noise model.
    pub fn fit(&self, terms: &[Term], from: Option<&State>) -> Option<State> {
        self.fit_core(terms, from, None)
    }

    /// As [`fit`](Self::fit), with the blocks of the core at `only` these yields (indices) where given.
    pub fn fit_core(
        &self,
        terms: &[Term],
        from: Option<&State>,
        only: Option<&[usize]>,
    ) -> Option<State> {
        let mut state: Option<State> = None;
        let rounds = if from.is_some() { 2 } else { 3 };
        for round in 0..rounds {
            let before = state.as_ref().or(from);
            let (rows, bounds, places) = self.assemble(terms, before.map(|b| &b.baseline), only);
            let last = round + 1 == rounds;
            let noise = match before {
                None => Noise::estimate(
                    &self.force,
                    &self.weak.folds,
                    &Variability {
                        parts: [&vec![0.0; self.force.len()], &vec![0.0; self.force.len()]],
                        path: &self.path_rows,
                        correlation: f64::INFINITY,
                    },
                ),
                Some(before) => self.noise(before),
            };
            let draws = if last { DRAWS } else { 1 };
            let problem = Problem::new(&noise, &rows, bounds.clone(), &self.force, draws);
            let fit = problem.fit()?;
            let baseline = self.baseline(&fit, &rows, terms, &places, before.map(|b| &b.baseline));
            state = Some(State {
                terms: terms.to_vec(),
                places,
                baseline,
                noise,
                problem,
                fit,
                rows,
                bounds,
            });
        }
        state
    }

    fn noise(&self, state: &State) -> Noise {
        let residual = self.residual(state, &state.fit.coefficients);
        let all = self.weak.rows(&state.baseline.friction);
        let short = self.weak.rows(&state.baseline.short);
        let long: Vec<f64> = all.iter().zip(&short).map(|(a, s)| a - s).collect();
        let longest = state
            .baseline
            .blocks
            .iter()
            .map(|b| b.1)
            .fold(0.0, f64::max)
            .max(quantile(&self.s.last_stroke, 0.5) / 4.0);
        Noise::estimate(
            &residual,
            &self.weak.folds,
            &Variability {
                parts: [&short, &long],
                path: &self.path_rows,
                correlation: 2.0 * longest,
            },
        )
    }

    /// Measured less modelled effort at the rows.
    pub fn residual(&self, state: &State, coefficients: &[f64]) -> Vec<f64> {
        let mut residual = self.force.clone();
        for (column, c) in state
            .rows
            .iter()
            .zip(coefficients)
            .filter(|(_, c)| **c != 0.0)
        {
            residual
                .iter_mut()
                .zip(column)
                .for_each(|(r, v)| *r -= c * v);
        }
        residual
    }

    /// Residual of every fold with the coefficients of the others.
    pub fn held_out_residual(&self, state: &State) -> Vec<f64> {
        let mut out = self.force.clone();
        for (range, c) in self.weak.folds.iter().zip(&state.fit.held_out) {
            for (column, c) in state.rows.iter().zip(c).filter(|(_, c)| **c != 0.0) {
                for i in range.clone() {
                    out[i] -= c * column[i];
                }
            }
        }
        out
    }

    /// As [`held_out_residual`](Self::held_out_residual), with further columns.
    pub fn held_out_with(&self, state: &State, columns: Vec<Vec<f64>>) -> Option<Vec<f64>> {
        let mut rows = state.rows.clone();
        let mut bounds = state.bounds.clone();
        bounds.extend(columns.iter().map(|_| Bound::Free));
        rows.extend(columns);
        let problem = Problem::new(&state.noise, &rows, bounds, &self.force, 1);
        let fit = problem.fit()?;
        let mut out = self.force.clone();
        for (range, c) in self.weak.folds.iter().zip(&fit.held_out) {
            for (column, c) in rows.iter().zip(c).filter(|(_, c)| **c != 0.0) {
                for i in range.clone() {
                    out[i] -= c * column[i];
                }
            }
        }
        Some(out)
    }

    /// Force of a term at the rows.
    pub fn force_of(&self, state: &State, index: usize) -> Vec<f64> {
        let mut force = vec![0.0; self.force.len()];
        for j in state.places[index].clone() {
            for (f, v) in force.iter_mut().zip(&state.rows[j]) {
                *f += state.fit.coefficients[j] * v;
            }
        }
        force
    }

    /// Columns at the rows: inertia, blocks, terms, the law's own error.
    #[allow(clippy::type_complexity)]
    fn assemble(
        &self,
        terms: &[Term],
        baseline: Option<&Baseline>,
        only: Option<&[usize]>,
    ) -> (Vec<Vec<f64>>, Vec<Bound>, Vec<std::ops::Range<usize>>) {
        let mut rows = Vec::new();
        let mut bounds = Vec::new();
        if self.inertial {
            rows.push(self.acceleration.clone());
            bounds.push(Bound::NonNegative);
        }
        for (j, column) in self.deflection_rows.iter().enumerate() {
            let used = only.is_none_or(|only| only.contains(&j));
            // A block left out keeps its place, with nothing in it.
            rows.push(if used {
                column.clone()
            } else {
                vec![0.0; column.len()]
            });
            bounds.push(Bound::NonNegative);
        }
        let mut places = Vec::new();
        for term in terms {
            let columns = match baseline {
                Some(b) => self.term_rows(term, b),
                None => Vec::new(),
            };
            places.push(rows.len()..rows.len() + columns.len());
            bounds.extend(columns.iter().map(|_| Bound::Free));
            rows.extend(columns);
        }
        if let (None, Some(b)) = (only, baseline) {
            let level = quantile(&b.friction.iter().map(|f| f.abs()).collect::<Vec<_>>(), 0.9);
            bounds.extend(self.error_rows.iter().map(|_| Bound::Ridge));
            rows.extend(
                self.error_rows
                    .iter()
                    .map(|c| c.iter().map(|v| level * v).collect::<Vec<f64>>()),
            );
        }
        (rows, bounds, places)
    }

    /// A term's columns at the rows.
    pub fn term_rows(&self, term: &Term, b: &Baseline) -> Vec<Vec<f64>> {
        columns::columns(term.id, &term.shape, &self.s, b)
            .iter()
            .map(|c| self.weak.rows(c))
            .collect()
    }

    fn baseline(
        &self,
        fit: &Fit,
        rows: &[Vec<f64>],
        terms: &[Term],
        places: &[std::ops::Range<usize>],
        before: Option<&Baseline>,
    ) -> Baseline {
        let first = usize::from(self.inertial);
        let mass = if self.inertial {
            fit.coefficients[0]
        } else {
            0.0
        };
        let n = self.s.x.len();
        let (mut friction, mut slipping, mut short) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let mut blocks = Vec::new();
        let used: Vec<usize> = (0..self.yields.len())
            .filter(|j| fit.coefficients[first + j] > 0.0)
            .collect();
        let level: f64 = used
            .iter()
            .map(|&j| fit.coefficients[first + j] * self.yields[j])
            .sum();
        let mut sum = 0.0;
        for j in used {
            let (k, d) = (fit.coefficients[first + j], self.yields[j]);
            blocks.push((k, d));
            let is_short = sum < 0.5 * level;
            sum += k * d;
            for (i, z) in self.deflections[j].iter().enumerate() {
                friction[i] += k * z;
                if z.abs() >= 0.999 * d {
                    slipping[i] += k * z;
                }
                if is_short {
                    short[i] += k * z;
                }
            }
        }
        let mut fitted: Vec<f64> = friction.clone();
        if self.inertial {
            let a = curvature(&self.s.x, &self.s.pieces, self.s.dt);
            // Smooth enough to be differentiated again: the kinematics' own acceleration where it exists.
            let a = if self.s.a.len() == n { &self.s.a } else { &a };
            fitted.iter_mut().zip(a).for_each(|(f, a)| *f += mass * a);
        }
        if let Some(before) = before {
            for (term, place) in terms.iter().zip(places) {
                let columns = columns::columns(term.id, &term.shape, &self.s, before);
                for (column, j) in columns.iter().zip(place.clone()) {
                    if matches!(term.id, "channel_delay" | "drive_compliance") {
                        continue;
                    }
                    let c = fit.coefficients[j];
                    fitted.iter_mut().zip(column).for_each(|(f, v)| *f += c * v);
                }
            }
        }
        debug_assert_eq!(rows.len(), fit.coefficients.len());
        Baseline {
            mass,
            blocks,
            friction,
            slipping,
            short,
            fitted,
            shortest_s: self.weak.half_width_s,
        }
    }

    /// What a further term would add to a hypothesis.
    pub fn gain(&self, state: &State, term: &Term) -> Option<Gain> {
        let rows = self.term_rows(term, &state.baseline);
        if rows.is_empty() {
            return None;
        }
        state.problem.gain(&state.fit, &state.noise, &rows)
    }
}

/// Log-spaced yields from what a typical sample moves to half of the longest stroke.
fn yields(s: &Signals) -> Vec<f64> {
    let steps: Vec<f64> =
        s.x.windows(2)
            .map(|p| (p[1] - p[0]).abs())
            .filter(|d| *d > 0.0)
            .collect();
    let (low, high) = bounds(&s.x);
    let longest = 0.5 * (high - low);
    let stroke = quantile(&s.since_reversal, 0.999).min(high - low) * 0.5;
    let long = if stroke > 0.0 { stroke } else { longest };
    let short = (0.5 * quantile(&steps, 0.1))
        .max(quantile(&steps, 0.0))
        .min(long / 10.0)
        .max(long / 3e4);
    spread(short, long, CORE)
}

/// What no parallel arrangement of blocks can follow of a hysteresis: a smooth function of the displacement since reversal, for
/// short, middle and long strokes before it. Its size is found with the rest, so that an effect has to beat it.
fn law_error(s: &Signals) -> Vec<Vec<f64>> {
    let longest = quantile(&s.since_reversal, 0.999);
    let shortest = quantile(&s.since_reversal, 0.02).max(longest / 1e3);
    if s.reversals < 4 || longest <= 0.0 {
        return Vec::new();
    }
    let (low, high) = (
        quantile(&s.last_stroke, 0.33),
        quantile(&s.last_stroke, 0.67),
    );
    let classes = if high > 1.5 * low { 2 } else { 1 };
    let class = |i: usize| usize::from(classes == 2 && s.last_stroke[i] > (low * high).sqrt());
    let ratio = (longest / shortest).ln();
    let mut columns = Vec::new();
    for c in 0..classes {
        for hat in 0..ERROR_HATS {
            columns.push(
                (0..s.x.len())
                    .map(|i| {
                        if class(i) != c {
                            return 0.0;
                        }
                        let u = (s.since_reversal[i].max(shortest) / shortest).ln() / ratio;
                        let place = u.min(1.0) * (ERROR_HATS - 1) as f64;
                        s.direction[i] * (1.0 - (place - hat as f64).abs()).max(0.0)
                    })
                    .collect(),
            );
        }
    }
    columns
}
