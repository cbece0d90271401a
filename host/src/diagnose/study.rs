//! A recording with its dictionary, and one hypothesis about what acts in it.

use super::blocks::{FINER, between_samples, deflection, yields};
use super::columns::{self, Baseline};
use super::noise::{Course, Noise};
use super::score::{Bound, Fit, Gain, Problem};
use super::signals::{Signals, quantile};
use super::weak::{Column, Weak};
use crate::friction::{FrictionModel, Path};
use crate::recording::Recording;
use rayon::prelude::*;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, Mutex};

/// Realisations of the noise alone behind each threshold.
const DRAWS: usize = 16;
/// Ratio of held-out errors up to which a spring explains as much as blocks that yield late.
const SPRING: f64 = 1.02;
/// Share of the travel after which a block is said to yield late.
const LATE: f64 = 16.0;
/// Blocks of rows of a fold, between which an improvement is compared.
const BLOCKS: usize = 20;
/// Smooth maps over the travel among the plain effects that the noise model must not swallow.
const PLAIN_MAPS: f64 = 5.0;

/// Kinds of strokes that take turns in being left out.
const KINDS: usize = 8;

/// What stays the same for every hypothesis.
pub struct Study {
    /// Coordinates.
    pub s: Signals,
    /// Kernel and rows.
    pub weak: Weak,
    /// Measured effort at the rows.
    pub force: Vec<f64>,
    /// Measured effort at the samples, which columns of an actuator's limits need.
    pub effort: Vec<f64>,
    /// Whether the effort contains inertia.
    pub inertial: bool,
    /// Kind of the stroke that each row belongs to.
    pub kinds: Vec<usize>,
    /// Yield displacements of the core (m or rad).
    pub yields: Vec<f64>,
    /// The model that effects act through: the core, fitted together with plain effects.
    pub reference: Baseline,
    /// The noise that core and plain effects leave.
    pub noise: Noise,
    /// Inertia, then the blocks of the core, at the rows.
    core_rows: Vec<Vec<f64>>,
    core_bounds: Vec<Bound>,
    deflections: Vec<Vec<f64>>,
    acceleration: Vec<f64>,
    plain: Vec<Term>,
    at: Places,
    cache: Mutex<HashMap<Key, Arc<Vec<Vec<f64>>>>>,
}

/// An effect and the bits of its shape.
type Key = (&'static str, Vec<u64>);

/// The rows in time and along the path, and what the noise acts through there.
#[derive(Default)]
struct Places {
    time: Vec<f64>,
    path: Vec<f64>,
    friction: Vec<f64>,
    stiffness: Vec<f64>,
    stroke: f64,
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

impl Term {
    /// An effect to be tried.
    pub fn new(id: &'static str, shape: &[f64]) -> Self {
        Self {
            id,
            shape: shape.to_vec(),
            given: false,
        }
    }
}

/// A hypothesis, fitted.
pub struct State {
    /// Effects in it.
    pub terms: Vec<Term>,
    /// Coefficients of each term.
    pub places: Vec<Range<usize>>,
    /// Noise.
    pub noise: Noise,
    /// Gram matrices.
    pub problem: Problem,
    /// Its fit.
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
        let (fine, pieces) = between_samples(&s);
        let deflections: Vec<Vec<f64>> = yields
            .par_iter()
            .map(|&d| deflection(&fine, &pieces, d))
            .collect();
        let mut core_rows: Vec<Vec<f64>> = deflections
            .par_iter()
            .map(|z| weak.rows(&Column::of(z.clone())))
            .collect();
        if inertial {
            let curved = s.x.clone();
            core_rows.insert(
                0,
                weak.rows(&Column {
                    curved,
                    ..Column::default()
                }),
            );
        }
        let force = weak.rows(&Column::of(recording.effort.clone()));
        let none = vec![0.0; force.len()];
        let at = Places {
            time: weak.at_centres(&s.t),
            path: weak.at_centres(&s.path),
            friction: none.clone(),
            stiffness: none,
            stroke: quantile(&s.last_stroke, 0.9),
        };
        let kinds = s.kinds_of_strokes(KINDS);
        let mut study = Self {
            kinds: weak.centres.iter().map(|&c| kinds[c]).collect(),
            noise: Noise::white(&force, &at.course(&weak.folds)),
            force,
            effort: recording.effort.clone(),
            core_bounds: vec![Bound::NonNegative; core_rows.len()],
            core_rows,
            // The kinematics' own acceleration is smooth enough to be differentiated again.
            acceleration: s.a.clone(),
            reference: Baseline::default(),
            plain: plain(&s),
            cache: Mutex::default(),
            inertial,
            deflections,
            yields,
            weak,
            at,
            s,
        };
        study.refer_to(&[]).ok_or_else(|| {
            format!(
                "{}: the motion does not determine inertia and friction; record both directions at several speeds",
                recording.name
            )
        })?;
        study.without_springs();
        Ok(study)
    }

    /// Finds the friction that effects act through, and the noise: core, given and plain effects in turns with the noise.
    pub fn refer_to(&mut self, terms: &[Term]) -> Option<()> {
        let mut noise = self.noise.clone();
        if self.reference.blocks.is_empty() {
            let alone = self.problem(&[], &noise, 1).0.fit()?;
            self.set_reference(&alone, &[]);
        }
        let all: Vec<Term> = terms.iter().chain(&self.plain).cloned().collect();
        for round in 0..2 {
            let (problem, rows, _) = self.problem(&all, &noise, 1);
            let fit = problem.fit()?;
            self.set_reference(&fit, &all);
            let residual = residual(&self.force, &rows, &fit.coefficients);
            let before = (round > 0 && !terms.is_empty()).then_some(&noise);
            noise = Noise::estimate(&residual, &self.at.course(&self.weak.folds), before);
        }
        self.noise = noise;
        Some(())
    }

    /// A block that yields late in the travel is a spring by another name. Where a spring explains as much, it is left out.
    fn without_springs(&mut self) {
        let last = self.s.travel() / LATE;
        let first = usize::from(self.inertial);
        let kept = first + self.yields.iter().filter(|d| **d <= last).count();
        let all = self.core_rows.len();
        let error = |core: &[Vec<f64>], spring: bool| -> Option<f64> {
            let mut rows = core.to_vec();
            let mut bounds = vec![Bound::NonNegative; rows.len()];
            let plain = self.plain.iter().filter(|t| t.id != "position_force");
            let spring = spring.then(|| Term::new("position_spring", &[]));
            for term in plain.cloned().chain(spring) {
                let own = self.term_rows(&term);
                bounds.extend(own.iter().map(|_| Bound::Free));
                rows.extend(own.iter().cloned());
            }
            let fit = Problem::new(&self.noise, &rows, bounds, &self.force, 1).fit()?;
            Some(self.held_out_square(&rows, &fit))
        };
        if kept < all
            && let (Some(short), Some(long)) = (
                error(&self.core_rows[..kept], true),
                error(&self.core_rows, false),
            )
            && short < SPRING * long
        {
            self.yields.truncate(kept - first);
            self.deflections.truncate(kept - first);
            self.core_rows.truncate(kept);
            self.core_bounds.truncate(kept);
            self.reference.blocks.clear();
            // What was determined with more blocks is determined with fewer.
            let _ = self.refer_to(&[]);
        }
    }

    fn set_reference(&mut self, fit: &Fit, terms: &[Term]) {
        let first = usize::from(self.inertial);
        let mass = if self.inertial {
            fit.coefficients[0]
        } else {
            0.0
        };
        let n = self.s.x.len();
        let (mut friction, mut slipping, mut stiffness) =
            (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let blocks = self.blocks(fit);
        for (j, z) in self.deflections.iter().enumerate() {
            let (k, d) = (fit.coefficients[first + j], self.yields[j]);
            if k <= 0.0 {
                continue;
            }
            for (i, z) in z.iter().enumerate() {
                friction[i] += k * z;
                if z.abs() >= 0.999 * d {
                    slipping[i] += k * z;
                } else {
                    stiffness[i] += k;
                }
            }
        }
        let mut fitted: Vec<f64> = friction
            .iter()
            .zip(&self.acceleration)
            .map(|(f, a)| f + mass * a)
            .collect();
        let mut next = first + self.yields.len();
        for term in terms {
            let columns = columns::columns(term.id, &term.shape, self);
            for column in &columns {
                let c = fit.coefficients[next];
                next += 1;
                if !term.acts_on_measurement() {
                    let value = if column.value.is_empty() {
                        &self.s.v
                    } else {
                        &column.value
                    };
                    fitted.iter_mut().zip(value).for_each(|(f, v)| *f += c * v);
                }
            }
        }
        self.at.friction = self.weak.rows(&Column::of(friction.clone()));
        self.at.stiffness = self.weak.rows(&Column::of(stiffness.clone()));
        self.reference = Baseline {
            mass,
            blocks,
            level: quantile(&friction.iter().map(|f| f.abs()).collect::<Vec<_>>(), 0.9).max(1e-300),
            friction,
            slipping,
            stiffness,
            fitted,
        };
        if let Ok(mut cache) = self.cache.lock() {
            cache.clear();
        }
    }

    /// Blocks of the core that take part: stiffness and yield displacement.
    pub fn blocks(&self, fit: &Fit) -> Vec<(f64, f64)> {
        let first = usize::from(self.inertial);
        self.yields
            .iter()
            .enumerate()
            .map(|(j, d)| (fit.coefficients[first + j], *d))
            .filter(|b| b.0 > 0.0)
            .collect()
    }

    /// Core and terms against the recording.
    fn problem(
        &self,
        terms: &[Term],
        noise: &Noise,
        draws: usize,
    ) -> (Problem, Vec<Vec<f64>>, Vec<Range<usize>>) {
        let mut rows = self.core_rows.clone();
        let mut bounds = self.core_bounds.clone();
        let own: Vec<Arc<Vec<Vec<f64>>>> = terms.par_iter().map(|t| self.term_rows(t)).collect();
        let mut places = Vec::new();
        for columns in own {
            places.push(rows.len()..rows.len() + columns.len());
            bounds.extend(columns.iter().map(|_| Bound::Free));
            rows.extend(columns.iter().cloned());
        }
        let problem = Problem::new(noise, &rows, bounds, &self.force, draws);
        (problem, rows, places)
    }

    /// Fits a hypothesis, with the noise that it and the plain effects leave.
    pub fn fit(&self, terms: &[Term], from: Option<&State>) -> Option<State> {
        let mut noise = from.map_or(&self.noise, |s| &s.noise).clone();
        if !terms.is_empty() {
            let all: Vec<Term> = terms.iter().chain(&self.plain).cloned().collect();
            let (problem, rows, _) = self.problem(&all, &noise, 1);
            let residual = residual(&self.force, &rows, &problem.fit()?.coefficients);
            noise = Noise::estimate(&residual, &self.at.course(&self.weak.folds), Some(&noise));
        }
        self.fit_with(terms, noise)
    }

    /// Fits a hypothesis with a noise model that is known.
    pub fn fit_with(&self, terms: &[Term], noise: Noise) -> Option<State> {
        let (problem, rows, places) = self.problem(terms, &noise, DRAWS);
        let fit = problem.fit()?;
        Some(State {
            terms: terms.to_vec(),
            places,
            noise,
            bounds: self
                .core_bounds
                .iter()
                .copied()
                .chain(vec![Bound::Free; rows.len() - self.core_bounds.len()])
                .collect(),
            problem,
            fit,
            rows,
        })
    }

    /// The hypothesis less one of its terms, with the same noise.
    pub fn without(&self, state: &State, index: usize) -> Option<State> {
        let mut terms = state.terms.clone();
        terms.remove(index);
        self.fit_with(&terms, state.noise.clone())
    }

    /// Sum of squares of the measured effort about its mean.
    pub fn variation(&self) -> f64 {
        let mean = columns::mean(&self.force);
        self.force.iter().map(|f| (f - mean).powi(2)).sum()
    }

    /// The residual weighed by how well each row is known, and the same times the friction: what lines of force and of the friction
    /// level are looked for in.
    pub fn weighed_residual(&self, state: &State) -> (Vec<f64>, Vec<f64>) {
        let weights = state.noise.inverse(&self.residual(state));
        let friction = self.weak.at_centres(&self.reference.friction);
        let by_friction = weights.iter().zip(&friction).map(|(w, f)| w * f).collect();
        (weights, by_friction)
    }

    /// Measured less modelled effort at the rows.
    pub fn residual(&self, state: &State) -> Vec<f64> {
        residual(&self.force, &state.rows, &state.fit.coefficients)
    }

    /// Sum of squares of [`held_out`](Self::held_out).
    fn held_out_square(&self, rows: &[Vec<f64>], fit: &Fit) -> f64 {
        self.held_out(rows, fit).iter().map(|r| r * r).sum()
    }

    /// Residual of every fold with the coefficients of the others.
    pub fn held_out_residual(&self, state: &State) -> Vec<f64> {
        self.held_out(&state.rows, &state.fit)
    }

    fn held_out(&self, rows: &[Vec<f64>], fit: &Fit) -> Vec<f64> {
        let mut out = self.force.clone();
        for (range, c) in self.weak.folds.iter().zip(&fit.held_out) {
            for (column, c) in rows.iter().zip(c).filter(|(_, c)| **c != 0.0) {
                for i in range.clone() {
                    out[i] -= c * column[i];
                }
            }
        }
        out
    }

    /// What `with` explains better than `without` on folds held out, in squared effort and without any noise model: the
    /// share taken off, and its size over its standard error between blocks of rows.
    pub fn improvement(&self, without: &State, with: &State) -> (f64, f64) {
        let (before, after) = (
            self.held_out_residual(without),
            self.held_out_residual(with),
        );
        let mut blocks = Vec::new();
        let mut total = 0.0;
        for rows in &self.weak.folds {
            let length = rows.len().div_ceil(BLOCKS).max(1);
            let (before, after) = (&before[rows.clone()], &after[rows.clone()]);
            for (b, a) in before.chunks(length).zip(after.chunks(length)) {
                let square = |r: &[f64]| r.iter().map(|r| r * r).sum::<f64>();
                blocks.push(square(b) - square(a));
                total += square(b);
            }
        }
        let n = blocks.len() as f64;
        let sum: f64 = blocks.iter().sum();
        let spread = blocks
            .iter()
            .map(|b| (b - sum / n).powi(2))
            .sum::<f64>()
            .sqrt();
        (sum / total.max(1e-300), sum / spread.max(1e-300))
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

    /// A term's columns at the rows; computed once.
    pub fn term_rows(&self, term: &Term) -> Arc<Vec<Vec<f64>>> {
        let key = (term.id, term.shape.iter().map(|v| v.to_bits()).collect());
        if let Ok(cache) = self.cache.lock()
            && let Some(rows) = cache.get(&key)
        {
            return rows.clone();
        }
        let rows: Arc<Vec<Vec<f64>>> = Arc::new(
            columns::columns(term.id, &term.shape, self)
                .iter()
                .map(|c| self.weak.rows(c))
                .collect(),
        );
        if let Ok(mut cache) = self.cache.lock() {
            cache.insert(key, rows.clone());
        }
        rows
    }

    /// Held-out NMSE (%) of a hypothesis with the user's friction, free by a common factor only, and with the core: least
    /// squares both, because a wrong shape misleads a fit that trusts its noise model. `None` where the library refuses a
    /// parameter.
    pub fn shape_error(&self, friction: &FrictionModel, state: &State) -> Option<[f64; 2]> {
        let (fine, pieces) = between_samples(&self.s);
        let held = |v: &f64| std::iter::repeat_n(*v, FINER);
        let velocity: Vec<f64> = self.s.v.iter().flat_map(held).collect();
        let path = Path {
            position: &fine,
            velocity: &velocity,
            pieces: &pieces,
            sample_time: self.s.dt / FINER as f64,
        };
        let mut friction = friction.clone();
        if let FrictionModel::Gms { sliding, .. } = &mut friction {
            // Its Stribeck curve is among the given terms.
            *sliding = None;
        }
        let force = friction.force(path).ok()?;
        let friction = force.into_iter().step_by(FINER).collect();
        let mut rows = vec![self.weak.rows(&Column::of(friction))];
        if self.inertial {
            rows.push(self.core_rows[0].clone());
        }
        rows.extend_from_slice(&state.rows[self.core_rows.len()..]);
        let white = Noise::white(&self.force, &self.at.course(&self.weak.folds));
        let square = |rows: &[Vec<f64>], bounds: Vec<Bound>| -> Option<f64> {
            let fit = Problem::new(&white, rows, bounds, &self.force, 1).fit()?;
            Some(self.held_out_square(rows, &fit))
        };
        let variation = self.variation();
        let own = square(&rows, vec![Bound::Free; rows.len()])?;
        let core = square(&state.rows, state.bounds.clone())?;
        Some([own, core].map(|sum| 100.0 * sum / variation))
    }

    /// What a further term would add to a hypothesis.
    pub fn gain(&self, state: &State, term: &Term) -> Option<Gain> {
        self.gain_of(state, &self.term_rows(term))
    }

    /// What further columns would add to a hypothesis.
    pub fn gain_of(&self, state: &State, rows: &[Vec<f64>]) -> Option<Gain> {
        if rows.is_empty() {
            return None;
        }
        state.problem.gain(&state.fit, &state.noise, rows)
    }
}

impl Places {
    fn course<'a>(&'a self, folds: &'a [Range<usize>]) -> Course<'a> {
        Course {
            folds,
            time: &self.time,
            path: &self.path,
            friction: &self.friction,
            stiffness: &self.stiffness,
            stroke: self.stroke,
        }
    }
}

impl Term {
    /// Whether its columns are derived from the fitted effort itself.
    fn acts_on_measurement(&self) -> bool {
        matches!(
            self.id,
            "channel_delay" | "drive_compliance" | "backlash" | "actuator_dead_zone"
        )
    }
}

fn residual(force: &[f64], rows: &[Vec<f64>], coefficients: &[f64]) -> Vec<f64> {
    let mut residual = force.to_vec();
    for (column, c) in rows.iter().zip(coefficients).filter(|(_, c)| **c != 0.0) {
        residual
            .iter_mut()
            .zip(column)
            .for_each(|(r, v)| *r -= c * v);
    }
    residual
}

/// Plain effects that stand beside the core while friction and noise are found: physics that is not in the hypothesis yet
/// must not be taken for noise.
fn plain(s: &Signals) -> Vec<Term> {
    let (slow, fast) = s.speeds();
    let middle = (slow * fast).sqrt();
    let mut terms = vec![
        Term::new("constant_force", &[]),
        Term::new("coulomb_asymmetry", &[]),
        Term::new("viscous", &[]),
        Term::new("position_force", &[PLAIN_MAPS]),
        Term::new("position_friction", &[PLAIN_MAPS]),
        Term::new("channel_delay", &[]),
    ];
    if fast > 3.0 * slow {
        terms.push(Term::new("stribeck", &[2.0 * slow, 1.0, 0.0]));
        terms.push(Term::new("stribeck", &[middle, 1.0, 0.0]));
        terms.push(Term::new("quadratic_drag", &[]));
    }
    terms
}
