//! What every hypothesis stands on: the rows, the core, the friction that effects act through, and the noise that weights.

use super::axis::Axis;
use super::change::{Change, late_yields};
use super::core::Core;
use super::curve::Curve;
use super::effect::thermal_drift::ThermalDrift;
use super::effect::{self, Baseline, Effect, Scene, constant_force, viscous};
use super::noise::{Course, Noise, rms};
use super::normal::{Bound, Normal};
use super::rows::Rows;
use super::signals::Signals;
use super::simulated::Simulated;
use super::term::{Subject, Term};
use super::weak::Column;
use preslide_fit::evidence::evidence;
use preslide_fit::signal::spectra;
use preslide_fit::statistics::quantile_between_ranks;
use rayon::prelude::*;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, Mutex};

/// Lines in time that stand beside the core while the noise is found.
const LINES: usize = 2;
/// Rounds of core, plain effects and noise in turns.
const ROUNDS: usize = 2;

/// Squares that a weighted fit may leave, all rows alike, over the least. Where the model is wrong a noise model may give whole
/// frequencies no weight, and the fit may then do there what it likes.
const SLACK: f64 = 1.5;
/// Least share of the blocks that must hold the weight of the rows: where friction that wanders is taken for all of the noise, the few rows
/// near its zero outweigh the rest by a thousand, and evidence, which counts blocks, is theirs alone. Chosen after looking at the shared
/// recordings (0.09 where names came and went, 0.66 and more elsewhere) and at made stages (0.44 and more).
const SPREAD: f64 = 1.0 / 3.0;
/// Deviations by which another core predicts better, and share of the mismatch that it takes off, before it is taken: most of it, because
/// a part may as well be an effect's. Chosen after looking at `drives` 13 (0.46 and more where friction has no hysteresis, 0.31 and less
/// elsewhere), at `axes` 5 and at recordings of robots' joints (0.39 and less).
const SURE: f64 = 3.0;
/// See [`SURE`].
const MOSTLY: f64 = 0.5;
/// Floors of white noise, in deviations of what the least squares leave.
const FLOORS: [f64; 4] = [0.1, 0.3, 1.0, 3.0];

/// A column cache's key: the subject and the bits of its shape.
type Key = (String, Vec<u64>);

/// Rows, core, baseline and noise.
pub struct NullModel {
    /// The rows.
    pub rows: Arc<Rows>,
    /// The core.
    pub core: Arc<Core>,
    /// The model that effects act through.
    pub baseline: Baseline,
    /// What weights the rows.
    pub noise: Noise,
    cache: Mutex<HashMap<Key, Arc<Vec<Vec<f64>>>>>,
}

/// A hypothesis, fitted.
pub struct Hypothesis {
    /// What stands beside the core.
    pub terms: Vec<Term>,
    /// Coefficients of each term among all.
    pub places: Vec<Range<usize>>,
    /// The fit.
    pub normal: Normal,
    /// All columns at the rows, not whitened.
    columns: Vec<Arc<Vec<Vec<f64>>>>,
}

/// NMSE (%) fitted and held out.
#[derive(Clone, Copy, Debug)]
pub struct Nmse {
    /// On the rows fitted.
    pub train: f64,
    /// On folds held out in turn.
    pub test: f64,
}

impl NullModel {
    /// Friction without effects at the rows (N or N·m).
    pub fn friction(&self) -> Vec<f64> {
        self.rows.weak.at_centres(&self.baseline.friction)
    }

    /// Its root mean square (N or N·m), or that of all that is fitted beside inertia where the motion never turns: there friction and a constant load
    /// are one.
    pub fn usual_friction(&self) -> f64 {
        let own = rms(&self.friction());
        let (s, weak) = (&self.rows.s, &self.rows.weak);
        if own > 0.0 && s.reversals > 0 {
            return own;
        }
        let along = self.baseline.fitted.iter().zip(&s.a);
        let beside_inertia: Vec<f64> = along.map(|(f, a)| f - self.baseline.mass * a).collect();
        rms(&weak.at_centres(&beside_inertia)).max(own)
    }

    /// Finds friction and noise of a recording, beside the terms of a model that is given and blocks of the yields `fitted` among others (m
    /// or rad); `None` where the motion does not show them.
    pub fn new(rows: Rows, given: &[Term], fitted: Option<&[f64]>) -> Option<Self> {
        let core = Core::new(&rows, fitted);
        let course_less = Baseline::default();
        let noise = Noise::white(
            &rows.target,
            &course(&rows, &Places::of(&rows, &course_less)),
        );
        let mut null = Self {
            baseline: course_less,
            noise,
            cache: Mutex::default(),
            rows: Arc::new(rows),
            core: Arc::new(core.hysteretic()),
        };
        let smooth = null.with_core(core);
        if null.predicts_worse_than(&smooth)? {
            null = smooth;
        }
        let alone = null.fit(&[])?;
        null = null.with_baseline(&alone);
        null.referred_to(given)
    }

    /// Whether another core predicts blocks held out better than its own, beside viscous friction and what is plain but curves over speed.
    fn predicts_worse_than(&self, other: &Self) -> Option<bool> {
        let beside: Vec<Term> = plain()
            .filter(|t| !t.is_free_over_speed())
            .chain([Term::new(Subject::Effect(&viscous::Viscous), &[])])
            .collect();
        let held_out = |g: &Self| Some(g.fit_unweighted(&beside)?.held_out_residual(&g.rows));
        let (own, left) = (held_out(self)?, held_out(other)?);
        let gain: Vec<f64> = own.iter().zip(&left).map(|(o, l)| o - l).collect();
        let found = evidence(&gain, &own, &self.rows.blocks);
        Some(found.z > SURE && found.share > MOSTLY)
    }

    /// The same recording with friction and noise found beside `terms` and plain effects, in what least squares leave of all rows alike:
    /// what weights leave is more where they are small, and the noise that is found in it makes them smaller still. The friction is found without
    /// free curves over speed, which nothing separates from it in sliding: beside two of them its level would be anything.
    pub fn referred_to(&self, terms: &[Term]) -> Option<Self> {
        let warming = warming(&self.rows.s).filter(|w| !terms.iter().any(|t| t.is_like(w)));
        let beside = plain().chain(warming);
        let all: Vec<Term> = terms.iter().cloned().chain(beside).collect();
        let steady: Vec<Term> = all
            .iter()
            .filter(|t| !t.is_free_over_speed())
            .cloned()
            .collect();
        let mut null: Option<Self> = None;
        for _ in 0..ROUNDS {
            let from = null.as_ref().unwrap_or(self);
            let mut fitted = from.fit_unweighted(&all)?;
            let lines = from.strongest_lines(&fitted);
            if !lines.is_empty() {
                fitted = from.fit_unweighted(&[all.as_slice(), &lines].concat())?;
            }
            let mut next = from.with_baseline(&fitted);
            if !next.core.corrects {
                let steadily = from.with_baseline(&from.fit_unweighted(&steady)?);
                next.baseline = Baseline {
                    fitted: next.baseline.fitted,
                    ..steadily.baseline
                };
            }
            let places = Places::of(&next.rows, &next.baseline);
            next.noise =
                Noise::estimate(&fitted.residual(&next.rows), &course(&next.rows, &places));
            null = Some(next.with_a_hold(&all)?);
        }
        null
    }

    /// The same beside `terms` with blocks no finer than a slow sample, for a model that a controller follows: those that are known from reversals
    /// alone predict better, and track worse (`cargo xtask chain --count 1`: 315 nm for 203).
    pub fn coarser(&self, terms: &[Term]) -> Option<Self> {
        let core = Core::new(&self.rows, None);
        let core = if self.core.follows_velocity() {
            core
        } else {
            core.hysteretic()
        };
        self.with_core(core).settled(terms)
    }

    /// The same recording with effects that act through the friction which `terms` themselves leave, not through what was found beside free
    /// curves: a level refers to the friction of the model that it is stated with. The noise stays.
    pub fn settled(&self, terms: &[Term]) -> Option<Self> {
        let mut null = self.with_baseline(&self.fit(terms)?);
        for _ in 1..ROUNDS {
            null = null.with_baseline(&null.fit(terms)?);
        }
        Some(null)
    }

    /// The same with the mildest floor of white noise under which the weights leave no more, all rows alike, than they may, and enough blocks
    /// hold them.
    fn with_a_hold(mut self, terms: &[Term]) -> Option<Self> {
        let square = |h: &Hypothesis| {
            let left = h.residual(&self.rows);
            left.iter().map(|r| r * r).sum::<f64>()
        };
        let least = square(&self.fit_unweighted(terms)?);
        let deviation = (least / self.rows.target.len() as f64).sqrt();
        let places = Places::of(&self.rows, &self.baseline);
        let estimated = self.noise.clone();
        for floor in FLOORS {
            let spread = self.noise.spread(&self.rows.blocks);
            if spread >= SPREAD && square(&self.fit(terms)?) <= SLACK * least {
                break;
            }
            self.noise = estimated.with_floor(floor * deviation, &course(&self.rows, &places));
        }
        Some(self)
    }

    /// The strongest lines in time of what a hypothesis leaves: an autoregression would take them for its own.
    fn strongest_lines(&self, fitted: &Hypothesis) -> Vec<Term> {
        let weak = &self.rows.weak;
        let (slowest, fastest) = spectra::band(&self.rows.s.t, 0.45 / weak.half_width_s);
        let left = fitted.residual(&self.rows);
        let found = self.rows.lines_in_time(&left, slowest, fastest);
        let vibration = Subject::Effect(effect::VIBRATION);
        found
            .into_iter()
            .take(LINES)
            .map(|f| Term::new(vibration, &[f]))
            .collect()
    }

    fn with_baseline(&self, fitted: &Hypothesis) -> Self {
        let mut next = self.with_core(self.core.clone());
        if !self.core.corrects {
            let coefficients = &fitted.normal.coefficients;
            next.baseline =
                self.core
                    .baseline(&self.rows, coefficients, &fitted.terms, &self.baseline);
        }
        next
    }

    /// The same on another core, nothing of it computed yet.
    fn with_core(&self, core: impl Into<Arc<Core>>) -> Self {
        Self {
            core: core.into(),
            rows: self.rows.clone(),
            baseline: self.baseline.clone(),
            noise: self.noise.clone(),
            cache: Mutex::default(),
        }
    }

    /// The recording against a simulation's effort, of which an NMSE of `missed` (%) is missed: core and terms, of either sign, stand for
    /// what lies between the two, and effects act through the friction that was found in the recording itself.
    pub fn against(self, simulated: &Column, missed: f64) -> Option<Self> {
        // What a hysteresis would otherwise be bent to: it is not fitted again once the simulation is taken off.
        let map = Curve {
            axis: Axis::Position,
            odd: false,
        };
        let beside = [Subject::Effect(&viscous::Viscous), Subject::Curve(map)];
        let own = self.fit(&beside.map(|subject| Term::new(subject, &[])))?;
        let mut found = self.with_baseline(&own);
        drop((self, own));
        let simulated = found.rows.weak.rows(simulated);
        let laws = Simulated::new(&found.rows, &found.core, &found.noise, &simulated);
        let (smooth, swing) = (laws.smooth_friction(), laws.swing(&found.scene()));
        found.baseline.simulated_swing = swing;
        let mut rows = Arc::into_inner(found.rows)?;
        rows.target
            .iter_mut()
            .zip(simulated)
            .for_each(|(t, s)| *t -= s);
        rows.missed = missed;
        let core = Arc::into_inner(found.core)?;
        let against = Self {
            core: Arc::new(core.correcting(&rows, smooth)),
            rows: Arc::new(rows),
            cache: Mutex::default(),
            ..found
        };
        against.referred_to(&[])
    }

    /// Whether coefficients of a term are what the physics admits; a simulation may have too much of what it may have.
    pub fn admits(&self, term: &Term, coefficients: &[f64]) -> bool {
        let opposite = || coefficients.iter().map(|c| -c).collect::<Vec<_>>();
        let may_have = || {
            let effect = term.effect();
            effect.is_none_or(|e| e.in_simulation(&term.shape) != Some(false))
        };
        term.admits(coefficients) || self.core.corrects && may_have() && term.admits(&opposite())
    }

    /// What columns are made of.
    pub fn scene(&self) -> Scene<'_> {
        Scene {
            s: &self.rows.s,
            core: &self.baseline,
            effort: &self.rows.effort,
        }
    }

    /// A term's columns at the rows; computed once.
    pub fn columns(&self, term: &Term) -> Arc<Vec<Vec<f64>>> {
        let key = (
            term.subject.key(),
            term.shape.iter().map(|v| v.to_bits()).collect(),
        );
        if let Ok(cache) = self.cache.lock()
            && let Some(columns) = cache.get(&key)
        {
            return columns.clone();
        }
        let columns = Arc::new(self.columns_once(term));
        if let Ok(mut cache) = self.cache.lock() {
            cache.insert(key, columns.clone());
        }
        columns
    }

    /// The same, not kept: for shapes that are not tried again.
    pub fn columns_once(&self, term: &Term) -> Vec<Vec<f64>> {
        let columns = term.columns(&self.scene());
        columns.iter().map(|c| self.rows.weak.rows(c)).collect()
    }

    /// Blocks of a hypothesis, late ones included: stiffness and yield displacement.
    pub fn blocks(&self, hypothesis: &Hypothesis) -> Vec<(f64, f64)> {
        let mut blocks = self.core.blocks(&hypothesis.normal.coefficients);
        for (index, term) in hypothesis.terms.iter().enumerate() {
            if matches!(term.subject, Subject::Change(Change::LateYields)) {
                let yields = late_yields(&self.rows.s);
                let late = hypothesis.coefficients(index).iter().copied().zip(yields);
                blocks.extend(late.filter(|b| b.0 > 0.0));
            }
        }
        blocks
    }

    /// What noise leaves of a perfect model (%): measured in what is left, as what changes from one row to the next beyond a straight line, faster
    /// than friction and machine do. A noise model that is fitted to all that is left has the missing physics in it.
    pub fn noise_floor(&self, extended: &Hypothesis) -> f64 {
        let rows = &self.rows;
        let left = extended.residual(rows);
        let apart = 2 * rows.weak.spacing;
        let mut squares = Vec::new();
        for i in 1..left.len().saturating_sub(1) {
            if rows.weak.centres[i + 1].abs_diff(rows.weak.centres[i - 1]) == apart {
                squares.push((left[i - 1] - 2.0 * left[i] + left[i + 1]).powi(2) / 6.0);
            }
        }
        let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
        let fitted = self.noise.row_variance;
        100.0 * mean.min(fitted) * left.len() as f64 / rows.variation().max(1e-300)
    }

    /// Fits core and terms.
    pub fn fit(&self, terms: &[Term]) -> Option<Hypothesis> {
        self.fit_columns(&self.noise, terms, &[], |t| self.bound(t))
    }

    /// The same with the signs of a user's model as they are.
    pub fn fit_as_given(&self, terms: &[Term]) -> Option<Hypothesis> {
        self.fit_columns(&self.noise, terms, &[], |t| match t.given {
            true => Bound::Free,
            false => self.bound(t),
        })
    }

    /// Fits core and terms, all rows alike.
    pub fn fit_unweighted(&self, terms: &[Term]) -> Option<Hypothesis> {
        self.fit_columns(&self.unweighted(), terms, &[], |t| self.bound(t))
    }

    /// Fits core, terms and further free columns behind them.
    pub fn fit_beside(&self, terms: &[Term], more: &[Vec<f64>]) -> Option<Normal> {
        let fitted = self.fit_columns(&self.noise, terms, more, |t| self.bound(t))?;
        Some(fitted.normal)
    }

    /// How a term's coefficients are bound: a simulation may have too much of an effect.
    fn bound(&self, term: &Term) -> Bound {
        if self.core.corrects && term.effect().is_some() {
            Bound::Free
        } else {
            term.bound()
        }
    }

    /// A noise model that weights all rows alike.
    pub fn unweighted(&self) -> Noise {
        let places = Places::of(&self.rows, &Baseline::default());
        Noise::white(&self.rows.target, &course(&self.rows, &places))
    }

    fn fit_columns(
        &self,
        noise: &Noise,
        terms: &[Term],
        more: &[Vec<f64>],
        bound: impl Fn(&Term) -> Bound,
    ) -> Option<Hypothesis> {
        let own: Vec<Arc<Vec<Vec<f64>>>> = terms.par_iter().map(|t| self.columns(t)).collect();
        let mut columns: Vec<&[f64]> = self.core.rows.iter().map(Vec::as_slice).collect();
        let mut bounds = self.core.bounds();
        let mut places = Vec::new();
        for (term, own) in terms.iter().zip(&own) {
            places.push(columns.len()..columns.len() + own.len());
            bounds.extend(own.iter().map(|_| bound(term)));
            columns.extend(own.iter().map(Vec::as_slice));
        }
        columns.extend(more.iter().map(Vec::as_slice));
        bounds.extend(more.iter().map(|_| Bound::Free));
        let normal = Normal::new(
            noise,
            &self.rows.weak.folds,
            &columns,
            &bounds,
            &self.rows.target,
        )?;
        let core = Arc::clone(&self.core.rows);
        Some(Hypothesis {
            terms: terms.to_vec(),
            places,
            normal,
            columns: std::iter::once(core).chain(own).collect(),
        })
    }
}

impl Hypothesis {
    /// Measured less modelled effort at the rows.
    pub fn residual(&self, rows: &Rows) -> Vec<f64> {
        self.normal.residual(&self.columns(), &rows.target)
    }

    /// The same with the coefficients of the other folds.
    pub fn held_out_residual(&self, rows: &Rows) -> Vec<f64> {
        self.normal.held_out_residual(&self.columns(), &rows.target)
    }

    /// Its columns at the rows, not whitened.
    pub fn columns(&self) -> Vec<&[f64]> {
        self.columns
            .iter()
            .flat_map(|c| c.iter())
            .map(Vec::as_slice)
            .collect()
    }

    /// Its NMSE.
    pub fn nmse(&self, rows: &Rows) -> Nmse {
        Nmse {
            train: rows.nmse(&self.residual(rows)),
            test: rows.nmse(&self.held_out_residual(rows)),
        }
    }

    /// Force of the core without inertia, at the rows.
    pub fn friction(&self, null: &NullModel) -> Vec<f64> {
        let first = null.core.first_of_friction();
        let own = null.core.rows.iter().zip(&self.normal.coefficients);
        let mut force = vec![0.0; null.rows.force.len()];
        for (column, c) in own.skip(first) {
            force.iter_mut().zip(column).for_each(|(f, v)| *f += c * v);
        }
        force
    }

    /// Force of term `index` at the rows.
    pub fn force_of(&self, index: usize) -> Vec<f64> {
        let own = &self.columns[index + 1];
        let mut force = vec![0.0; own.first().map_or(0, Vec::len)];
        for (column, j) in own.iter().zip(self.places[index].clone()) {
            let c = self.normal.coefficients[j];
            force.iter_mut().zip(column).for_each(|(f, v)| *f += c * v);
        }
        force
    }

    /// Coefficients of term `index`.
    pub fn coefficients(&self, index: usize) -> &[f64] {
        &self.normal.coefficients[self.places[index].clone()]
    }
}

/// The rows in time and along the path, and what the noise acts through there.
struct Places {
    time: Vec<f64>,
    path: Vec<f64>,
    friction: Vec<f64>,
    stiffness: Vec<f64>,
    stroke: f64,
}

impl Places {
    fn of(rows: &Rows, baseline: &Baseline) -> Self {
        let none = || vec![0.0; rows.force.len()];
        let at = |column: &[f64]| {
            if column.is_empty() {
                none()
            } else {
                rows.weak.rows(&Column::of(column.to_vec()))
            }
        };
        Self {
            time: rows.weak.at_centres(&rows.s.t),
            path: rows.weak.at_centres(&rows.s.path),
            friction: at(&baseline.friction),
            stiffness: at(&baseline.stiffness),
            stroke: quantile_between_ranks(&rows.s.last_stroke, 0.9),
        }
    }
}

fn course<'a>(rows: &'a Rows, places: &'a Places) -> Course<'a> {
    Course {
        folds: &rows.weak.folds,
        time: &places.time,
        path: &places.path,
        friction: &places.friction,
        stiffness: &places.stiffness,
        stroke: places.stroke,
    }
}

/// A constant and free curves that stand beside the core while friction and noise are found: physics that is not in the hypothesis yet
/// must not be taken for noise.
fn plain() -> impl Iterator<Item = Term> {
    let curves = [
        (Axis::Position, false),
        (Axis::Position, true),
        (Axis::Velocity, false),
        (Axis::Speed, true),
    ];
    let curves = curves.map(|(axis, odd)| Subject::Curve(Curve { axis, odd }));
    let constant = Subject::Effect(&constant_force::ConstantForce);
    std::iter::once(constant)
        .chain(curves)
        .map(|subject| Term::new(subject, &[]))
}

/// Friction that follows a measured temperature: the noise would take it for friction that wanders, as slowly as it goes.
fn warming(s: &Signals) -> Option<Term> {
    let drift: &'static dyn Effect = &ThermalDrift;
    let told = drift.lacks(s).is_none();
    told.then(|| Term::new(Subject::Effect(drift), &[]))
}
