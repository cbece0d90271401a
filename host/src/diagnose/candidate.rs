//! Every candidate on top of a hypothesis: effects of the catalogue, free curves and changes of the core, each with its best shape.

use super::change::Change;
use super::curve::Curve;
use super::effect::{self, Effect, Line, Scale};
use super::normal::Trial;
use super::null_model::{Hypothesis, NullModel};
use super::term::{Subject, Term};
use preslide_fit::evidence::{Evidence, chance, evidence};
use preslide_fit::signal::spectra;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// Share of the moving samples below the speed at which the rows must still resolve a line of position.
const SLOW: f64 = 0.2;
/// Fewest periods of a line within the travel: what does not come twice is a map of the travel and no ripple.
const PERIODS: f64 = 2.0;
/// The same of a declared part, whose period is known.
const OF_A_PART: f64 = 1.5;
/// Share of the fewest periods that may be left of a line whose period is refined.
const REFINED: f64 = 0.9;

/// Share of the effort's squares that must not be friction's for its ripples to be looked for by themselves: on a tribometer, where less is, five of
/// them took the place of one friction spot. There one is tried in place of a friction ripple alone.
const FRICTION_ALONE: f64 = 0.5;

/// Standard deviations by which a rival is clearly worse.
pub const WORSE: f64 = 2.0;

/// A candidate, judged.
#[derive(Clone)]
pub struct Candidate {
    /// It, with its best shape.
    pub term: Term,
    /// What it explains.
    pub trial: Trial,
    /// What that is worth.
    pub evidence: Evidence,
    /// Deviation of its force, of the measured effort's deviation.
    pub relative: f64,
    /// Among how many independent places of its spectrum it was found.
    pub tries: f64,
}

impl Candidate {
    /// Whether it is a vibration at a frequency of the motion itself, where no recording separates what shakes the axis from what the motion makes.
    pub fn keeps_step(&self, null: &NullModel) -> bool {
        let effect = self.term.effect();
        if effect.and_then(|e| e.line()) != Some(Line::Time) {
            return false;
        }
        let force = combined(&null.columns(&self.term), &self.trial.coefficients);
        let (rows, hz) = (&null.rows, self.term.shape[0]);
        let t = rows.weak.at_centres(&rows.s.t);
        let longest = rows.s.pieces.iter().max_by_key(|piece| piece.len());
        let is_harmonic = |piece: &Range<usize>| {
            let [t, x] = [&rows.s.t, &rows.s.x].map(|values| &values[piece.clone()]);
            spectra::is_harmonic(t, x, hz)
        };
        spectra::keeps_step(&t, &force, &rows.force, hz) || longest.is_some_and(is_harmonic)
    }

    /// Effects of its shape in its place, on top of a hypothesis, each with the shape that is best for it.
    pub fn in_its_place(&self, null: &NullModel, without: &Hypothesis) -> Vec<Self> {
        let effects = self.term.effect().map_or(&[][..], |e| e.card().in_place);
        let judged = |effect: &&'static dyn Effect| {
            let term = Term::new(Subject::Effect(*effect), &self.term.shape);
            candidate_of(null, without, &[refined(null, without, &term)], self.tries)
        };
        effects.iter().filter_map(judged).collect()
    }

    /// Standard deviations, over blocks, by which it leaves less than a rival of `held_out` at the rows.
    pub fn leaves_less_than(&self, rival: &Self, null: &NullModel, held_out: &[f64]) -> f64 {
        let differences: Vec<f64> = null
            .rows
            .blocks
            .iter()
            .map(|rows| {
                rows.clone()
                    .map(|i| {
                        (held_out[i] - rival.trial.force[i]).powi(2)
                            - (held_out[i] - self.trial.force[i]).powi(2)
                    })
                    .sum()
            })
            .collect();
        let n = differences.len() as f64;
        let sum: f64 = differences.iter().sum();
        let square: f64 = differences.iter().map(|d| (d - sum / n).powi(2)).sum();
        sum / (square * n / (n - 1.0)).sqrt().max(1e-300)
    }

    /// The chance that any of `families` candidates does as well without any effect.
    pub fn chance(&self, families: usize) -> f64 {
        chance(self.evidence.z, self.tries * families as f64)
    }
}

/// One candidate with its shapes.
struct Family {
    subject: Subject,
    shapes: Vec<Vec<f64>>,
    tries: f64,
}

/// The candidates of a recording on top of `hypothesis`; `periods` are those of the mechanics (m or rad).
fn families(null: &NullModel, hypothesis: &Hypothesis, periods: &[f64]) -> Vec<Family> {
    let scene = null.scene();
    let mut all: Vec<Family> = Vec::new();
    for effect in effect::ALL {
        let subject = Subject::Effect(effect);
        let present = hypothesis.terms.iter().any(|t| {
            t.effect().is_some_and(|e| {
                e.id() == effect.id() || e.excludes(&t.shape).contains(&effect.id())
            })
        });
        if present && !effect.card().recurs {
            continue;
        }
        let shapes = effect.grid(&scene);
        all.push(Family {
            subject,
            shapes,
            tries: 1.0,
        });
    }
    let friction_alone = is_friction_alone(null);
    if friction_alone {
        let of_effort =
            |f: &Family| matches!(f.subject, Subject::Effect(e) if e.line() == Some(Line::Effort));
        all.retain(|f| !of_effort(f));
    }
    let lines = Lines::of(null, hypothesis, friction_alone);
    for family in &mut all {
        let Subject::Effect(effect) = family.subject else {
            continue;
        };
        let Some(line) = effect.line() else {
            continue;
        };
        let (found, tries) = lines.get(line);
        family.shapes.extend(found.iter().map(|l| vec![*l]));
        family.tries = tries;
        if line != Line::Time {
            let travel = null.rows.s.travel();
            let known = periods.iter().filter(|p| OF_A_PART * **p < travel);
            family
                .shapes
                .extend(known.flat_map(|p| [vec![*p], vec![p / 2.0]]));
        }
    }
    let nameless = Curve::all(&null.rows.s)
        .into_iter()
        .map(Subject::Curve)
        .chain(Change::ALL.map(Subject::Change));
    for subject in nameless {
        if !hypothesis
            .terms
            .iter()
            .any(|t| t.subject.key() == subject.key())
        {
            all.push(Family {
                subject,
                shapes: vec![Vec::new()],
                tries: 1.0,
            });
        }
    }
    all.retain(|f| !f.shapes.is_empty());
    all
}

/// Whether friction is most of what the drive gives, so that a share of the one is a share of the other.
fn is_friction_alone(null: &NullModel) -> bool {
    let baseline = &null.baseline;
    let rest = baseline.fitted.iter().zip(&baseline.friction);
    let rest: f64 = rest.map(|(all, friction)| (all - friction).powi(2)).sum();
    rest < FRICTION_ALONE * squares(&baseline.fitted)
}

/// Every candidate that explains something, best first, and how many were tried.
pub fn candidates(
    null: &NullModel,
    hypothesis: &Hypothesis,
    periods: &[f64],
) -> (Vec<Candidate>, usize) {
    let families = families(null, hypothesis, periods);
    let mut list: Vec<Candidate> = families
        .par_iter()
        .filter_map(|family| {
            let terms: Vec<Term> = family
                .shapes
                .iter()
                .map(|s| Term::new(family.subject, s))
                .collect();
            candidate_of(null, hypothesis, &terms, family.tries)
        })
        .collect();
    list.sort_by(|a, b| b.evidence.share.total_cmp(&a.evidence.share));
    (list, families.len())
}

/// The best of some terms on top of a hypothesis.
pub fn candidate_of(
    null: &NullModel,
    hypothesis: &Hypothesis,
    terms: &[Term],
    tries: f64,
) -> Option<Candidate> {
    let columns: Vec<Arc<Vec<Vec<f64>>>> = terms.par_iter().map(|t| null.columns(t)).collect();
    let some: Vec<usize> = (0..terms.len())
        .filter(|i| !columns[*i].is_empty())
        .collect();
    let shapes: Vec<&[Vec<f64>]> = some.iter().map(|&i| columns[i].as_slice()).collect();
    let admits = |i: usize, c: &[f64]| null.admits(&terms[some[i]], c);
    let trial = hypothesis.normal.trial(&shapes, admits)?;
    let force = combined(shapes[trial.best], &trial.coefficients);
    Some(Candidate {
        relative: (squares(&force) / null.rows.variation().max(1e-300)).sqrt(),
        term: terms[some[trial.best]].clone(),
        evidence: evidence(&trial.force, &hypothesis.normal.held_out, &null.rows.blocks),
        trial,
        tries,
    })
}

fn combined(columns: &[Vec<f64>], coefficients: &[f64]) -> Vec<f64> {
    let mut force = vec![0.0; columns.first().map_or(0, Vec::len)];
    for (column, c) in columns.iter().zip(coefficients) {
        force.iter_mut().zip(column).for_each(|(f, v)| *f += c * v);
    }
    force
}

/// Sum of squares about zero: a constant is a force, too.
fn squares(force: &[f64]) -> f64 {
    force.iter().map(|f| f * f).sum()
}

/// Lines of the mismatch in position and in time, with how many were possible.
struct Lines(BTreeMap<u8, (Vec<f64>, f64)>);

impl Lines {
    fn of(null: &NullModel, hypothesis: &Hypothesis, friction_alone: bool) -> Self {
        let (s, weak) = (&null.rows.s, &null.rows.weak);
        let x = weak.at_centres(&s.x);
        let friction = weak.at_centres(&null.baseline.friction);
        let left = hypothesis.residual(&null.rows);
        let weights = null.noise.inverse(&left);
        let effort = weak.at_centres(&null.baseline.fitted);
        let times = |values: &[f64], by: &[f64]| -> Vec<f64> {
            values.iter().zip(by).map(|(w, f)| w * f).collect()
        };
        let (travel, slow) = (s.travel(), s.moving_speed(SLOW).max(1e-300));
        let row_s = weak.half_width_s;
        let (lowest, finest) = (PERIODS / travel, 0.5 / (row_s * slow));
        let duration = (s.duration()).max(1e-300);
        let (slowest, fastest) = spectra::band(&s.t, 0.45 / weak.half_width_s);
        let in_position = (finest * travel).max(1.0);
        let in_time = (fastest * duration).max(1.0);
        let comb = spectra::comb(&x, lowest, finest);
        // Those of the weighted mismatch, and the strongest of the mismatch itself: a noise model that took a line for its own gives it no weight.
        let periods = |weighted: &[f64], left: &[f64]| {
            let mut lines = spectra::lines(&x, weighted, lowest, finest);
            lines.extend(spectra::strongest(&x, left, lowest, finest));
            let lines = spectra::with_aliases(lines, comb, lowest);
            lines.into_iter().map(|nu| 1.0 / nu).collect()
        };
        let modulated = |by: &[f64]| periods(&times(&weights, by), &times(&left, by));
        let of_effort = match friction_alone {
            true => Vec::new(),
            false => modulated(&effort),
        };
        Self(BTreeMap::from([
            (Line::Force as u8, (periods(&weights, &left), in_position)),
            (Line::Level as u8, (modulated(&friction), in_position)),
            (Line::Effort as u8, (of_effort, in_position)),
            (
                Line::Time as u8,
                (null.rows.lines_in_time(&weights, slowest, fastest), in_time),
            ),
        ]))
    }

    fn get(&self, line: Line) -> (&[f64], f64) {
        self.0
            .get(&(line as u8))
            .map_or((&[], 1.0), |l| (&l.0, l.1))
    }
}

/// Rounds of a search along each of one or two shape parameters, and more for each further.
const ROUNDS: usize = 7;
const FURTHER_ROUNDS: usize = 10;

/// The term with the shape that explains most where it is fitted, all coefficients free: along each parameter in turn, and along the way that
/// a round went where there are more than two, which a valley between them asks for (Hooke and Jeeves, 1961).
pub fn refined(null: &NullModel, without: &Hypothesis, term: &Term) -> Term {
    let mut best = term.clone();
    let Some(effect) = term.effect() else {
        return best;
    };
    let value_of = |term: &Term| {
        let columns = null.columns(term);
        let (reduction, c) = without.normal.reduction(&columns)?;
        null.admits(term, &c).then_some(reduction)
    };
    let Some(mut value) = value_of(&best) else {
        return best;
    };
    let scales: Vec<Scale> = effect.card().shape.iter().map(|p| p.1).collect();
    let s = &null.rows.s;
    let mut steps: Vec<f64> = scales
        .iter()
        .zip(&term.shape)
        .map(|(scale, value)| match scale {
            Scale::Chosen => 0.0,
            Scale::Period => 0.15 * value / s.travel(),
            Scale::Frequency => 0.15 / (s.duration() * value),
            Scale::Logarithmic => 0.3,
            Scale::Travel => s.travel() / 80.0,
        })
        .collect();
    let free: Vec<usize> = (0..steps.len())
        .filter(|j| scales[*j] != Scale::Chosen)
        .collect();
    let longest = |start: f64| start.max(s.travel() / PERIODS) / REFINED;
    let start = term.shape.clone();
    let stepped = |from: &Term, by: &[(usize, f64)]| {
        let mut term = from.clone();
        for &(j, by) in by {
            term.shape[j] = match scales[j] {
                Scale::Travel => term.shape[j] + by,
                _ => term.shape[j] * by.exp(),
            };
            term.shape[j] = effect.within(&null.scene(), &term.shape, j);
            if scales[j] == Scale::Period {
                term.shape[j] = term.shape[j].min(longest(start[j]));
            }
        }
        term
    };
    let mut takes = |best: &mut Term, by: &[(usize, f64)]| {
        let trial = stepped(best, by);
        let reached = value_of(&trial).filter(|reached| *reached > value * (1.0 + 1e-9));
        if let Some(reached) = reached {
            (*best, value) = (trial, reached);
        }
        reached.is_some()
    };
    for _ in 0..ROUNDS + FURTHER_ROUNDS * free.len().saturating_sub(2) {
        let from = best.clone();
        let mut moved = false;
        for &j in &free {
            moved |= takes(&mut best, &[(j, -steps[j])]) || takes(&mut best, &[(j, steps[j])]);
        }
        if !moved {
            steps.iter_mut().for_each(|s| *s *= 0.4);
        } else if free.len() > 2 {
            let way = |&j: &usize| match scales[j] {
                Scale::Travel => (j, best.shape[j] - from.shape[j]),
                _ => (j, (best.shape[j] / from.shape[j]).ln()),
            };
            let way: Vec<(usize, f64)> = free.iter().map(way).collect();
            while takes(&mut best, &way) {}
        }
    }
    best
}
