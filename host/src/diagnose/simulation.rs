//! What a simulation of the user's own gets wrong in inertia and friction: the core stands for it, and is judged as every candidate is.

use super::axis::Axis;
use super::effect::ALWAYS_FREE;
use super::normal::{Bound, Normal};
use super::null_model::{Hypothesis, NullModel};
use super::search::ALPHA;
use super::term::{Subject, Term};
use preslide_fit::evidence::{Evidence, NAMED, chance, evidence};
use preslide_fit::statistics::{Estimate, jackknife};
use std::ops::Range;

/// Standard deviations from which the simulation has a term itself.
const SURE: f64 = 3.0;
/// What it has of a term, over what it lacks of it, from which the difference is one of its own parameters: the machine may have five times as
/// much.
const SOME: f64 = 0.25;
/// The same where it has too much of a term, of which it then has no less than that, but for how well its own is told: a machine of `cases/twins`
/// whose drive is stiffer than its simulation's has 0.7.
const ALL_OF_IT: f64 = 0.5;
/// Squares that fewer blocks may leave, over those that all leave.
const NEARLY: f64 = 1.1;

/// A part of the core.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Correction {
    /// Mass or moment of inertia.
    Inertia,
    /// Level and shape of the hysteresis.
    Friction,
}

/// A correction that is stated.
pub struct Corrected {
    /// Which part of the core.
    pub what: Correction,
    /// What it explains, everything else given.
    pub evidence: Evidence,
    /// Held-out NMSE (%) without and with it.
    pub nmse: [f64; 2],
    /// Its force at the rows (N or N·m).
    pub force: Vec<f64>,
    /// Key, value and interval.
    pub parameter: (String, Estimate),
    /// The simulation has it, too, of another size.
    pub in_simulation: bool,
}

impl Correction {
    /// Both.
    const ALL: [Self; 2] = [Self::Inertia, Self::Friction];

    /// Id in JSON.
    pub fn id(self) -> &'static str {
        match self {
            Self::Inertia => "inertia",
            Self::Friction => "friction",
        }
    }

    /// What it is.
    pub fn words(self) -> &'static str {
        match self {
            Self::Inertia => {
                "the recording's inertia less the simulation's, at the recording's scale of the effort"
            }
            Self::Friction => {
                "the recording's friction less the simulation's: its level, and its shape after reversals"
            }
        }
    }

    /// The experiment that decides between it and its rivals.
    pub fn experiment(self) -> &'static str {
        match self {
            Self::Inertia => {
                "strokes at several accelerations, and once more with a known mass added"
            }
            Self::Friction => "slow passes in both directions, and reversals of several sizes",
        }
    }

    /// The coordinate over which it acts.
    pub fn axis(self) -> Axis {
        match self {
            Self::Inertia => Axis::Acceleration,
            Self::Friction => Axis::SinceReversal,
        }
    }

    /// Whether the simulation has another law of it.
    fn is_another_law(self, null: &NullModel) -> bool {
        self == Self::Friction && null.core.simulated_law().is_some()
    }

    /// Its columns among the core's.
    fn columns(self, null: &NullModel) -> Range<usize> {
        let first = null.core.first_of_friction();
        match self {
            Self::Inertia => 0..first,
            Self::Friction => first..null.core.rows.len(),
        }
    }

    /// What the coefficients of the core add: inertia, or force in sliding.
    fn value(self, null: &NullModel, core: &[f64]) -> f64 {
        let own = &core[self.columns(null)];
        match self {
            Self::Inertia => own[0],
            Self::Friction => {
                let blocks = own.iter().zip(null.core.reaches());
                blocks.map(|(k, d)| k * d).sum()
            }
        }
    }

    /// Judges it beside all else; `None` where the effort does not contain it or the rest does not determine its coefficients.
    fn judged(self, null: &NullModel, extended: &Hypothesis) -> Option<Corrected> {
        let (rows, core) = (&null.rows, &null.core.rows);
        let own = self.columns(null);
        let delay = Term::new(Subject::Effect(ALWAYS_FREE), &[]);
        // A sample of delay between the two columns is no error of the simulation's.
        let delay = Some(&delay).filter(|d| !extended.terms.iter().any(|t| t.is_like(d)));
        let terms = extended.terms.iter().chain(delay);
        let others: Vec<_> = terms.map(|t| null.columns(t)).collect();
        let mut rest: Vec<&[f64]> = (0..core.len())
            .filter(|j| !own.contains(j))
            .map(|j| core[j].as_slice())
            .collect();
        rest.extend(others.iter().flat_map(|c| c.iter()).map(Vec::as_slice));
        let bounds = vec![Bound::Free; rest.len()];
        let folds = &rows.weak.folds;
        let without = Normal::new(&null.noise, folds, &rest, &bounds, &rows.target)?;
        let trial = without.trial(&[&core[own.clone()]], |_, _| true)?;
        let found = evidence(&trial.force, &without.held_out, &rows.blocks);
        let coefficients = &extended.normal.coefficients;
        let columns: Vec<&[f64]> = core[own.clone()].iter().map(Vec::as_slice).collect();
        let coefficients_of_own = &coefficients[own.clone()];
        let force = sum(&columns, coefficients_of_own);
        Some(Corrected {
            what: self,
            // One whose friction follows velocity has none along the path.
            in_simulation: !self.is_another_law(null) && has(null, &rest, &core[own]) >= SOME,
            evidence: found,
            nmse: [
                rows.nmse(&without.held_out_residual(&rest, &rows.target)),
                extended.nmse(rows).test,
            ],
            force,
            parameter: self.parameter(null, extended),
        })
    }

    /// Its value, with an interval from the scatter over folds left out in turn.
    fn parameter(self, null: &NullModel, extended: &Hypothesis) -> (String, Estimate) {
        let key = match self {
            Self::Inertia => "mass_kg",
            Self::Friction => "force_N",
        };
        let folds = null.rows.weak.folds.len();
        let left_out: Vec<f64> = (0..folds)
            .map(|s| self.value(null, &extended.normal.without_fold(s)))
            .collect();
        let value = self.value(null, &extended.normal.coefficients);
        let estimate = Estimate::new(value, Some(jackknife(&left_out)), folds);
        (key.to_owned(), estimate)
    }
}

/// Whether the simulation itself has a term of the hypothesis, of another size: then one of its own parameters is wrong.
pub fn has_its_term(null: &NullModel, state: &Hypothesis, index: usize) -> bool {
    let least = match state.terms[index].admits(state.coefficients(index)) {
        true => SOME,
        false => ALL_OF_IT,
    };
    let own = null.columns(&state.terms[index]);
    let others = (0..state.terms.len()).filter(|i| *i != index);
    let others: Vec<_> = others.map(|i| null.columns(&state.terms[i])).collect();
    let rest = null
        .core
        .rows
        .iter()
        .chain(others.iter().flat_map(|c| c.iter()));
    let rest: Vec<&[f64]> = rest.map(Vec::as_slice).collect();
    has(null, &rest, &own) >= least
}

/// What the simulation's own effort, on the recorded motion, holds of some columns beside the `rest`, over what the mismatch holds of them; 0 where
/// that may be chance.
fn has(null: &NullModel, rest: &[&[f64]], own: &[Vec<f64>]) -> f64 {
    let rows = &null.rows;
    let simulated = rows.force.iter().zip(&rows.target).map(|(f, t)| f - t);
    let simulated: Vec<f64> = simulated.collect();
    let bounds = vec![Bound::Free; rest.len()];
    let beside_the_rest =
        |target: &[f64]| Normal::new(&null.noise, &rows.weak.folds, rest, &bounds, target);
    let found = || {
        let [of_both, without] = [beside_the_rest(&rows.target)?, beside_the_rest(&simulated)?];
        let trial = without.trial(&[own], |_, _| true)?;
        let sure = evidence(&trial.force, &without.held_out, &rows.blocks).z > SURE;
        let [differs, has] = [of_both.reduction(own)?.0, without.reduction(own)?.0];
        sure.then(|| (has / differs.max(1e-300)).sqrt())
    };
    found().unwrap_or(0.0)
}

/// What the friction of a simulation differs by, in few parts.
pub struct Few {
    /// Inertia.
    pub inertia: f64,
    /// Stiffness (N/m or N·m/rad) and yield (m or rad) of blocks.
    pub blocks: Vec<(f64, f64)>,
    /// Level (N or N·m) and speed (m/s or rad/s) of friction that is `level·tanh(v/v₀)`.
    pub smooth: Vec<(f64, f64)>,
}

/// The fewest blocks, and the simulation's own law, that tell the friction's difference about as well as all, with the inertia beside them;
/// `target` is the mismatch at the rows without what else is stated.
pub fn few_blocks(null: &NullModel, target: &[f64]) -> Option<Few> {
    let core = &null.core;
    let first = core.first_of_friction();
    let yields: Vec<f64> = core.reaches().collect();
    let folds = &null.rows.weak.folds;
    let normal = |chosen: &[usize]| {
        let columns: Vec<&[f64]> = chosen.iter().map(|j| core.rows[*j].as_slice()).collect();
        Normal::new(
            &null.noise,
            folds,
            &columns,
            &vec![Bound::Free; columns.len()],
            target,
        )
    };
    let squares = |normal: &Normal| normal.held_out.iter().map(|e| e * e).sum::<f64>();
    let all: Vec<usize> = (0..core.rows.len()).collect();
    let least = squares(&normal(&all)?);
    let mut chosen: Vec<usize> = (0..first).collect();
    let mut shapes: Vec<usize> = (first..core.rows.len()).collect();
    let mut fitted = normal(&chosen)?;
    while squares(&fitted) > NEARLY * least && !shapes.is_empty() {
        let columns: Vec<&[Vec<f64>]> = shapes
            .iter()
            .map(|j| std::slice::from_ref(&core.rows[*j]))
            .collect();
        let best = fitted.trial(&columns, |_, _| true)?.best;
        chosen.push(shapes.remove(best));
        fitted = normal(&chosen)?;
    }
    let inertia = if first > 0 {
        fitted.coefficients[0]
    } else {
        0.0
    };
    let own = chosen[first..].iter().zip(&fitted.coefficients[first..]);
    let (mut blocks, mut smooth) = (Vec::new(), Vec::new());
    for (j, k) in own {
        match core.smooth_of(j - first) {
            Some(slow) => smooth.push((*k, slow)),
            None => blocks.push((*k, yields[j - first])),
        }
    }
    blocks.sort_by(|a: &(f64, f64), b| a.1.total_cmp(&b.1));
    Some(Few {
        inertia,
        blocks,
        smooth,
    })
}

/// Columns times their coefficients.
fn sum(columns: &[&[f64]], coefficients: &[f64]) -> Vec<f64> {
    let mut force = vec![0.0; columns.first().map_or(0, |c| c.len())];
    for (column, c) in columns.iter().zip(coefficients) {
        force.iter_mut().zip(*column).for_each(|(f, v)| *f += c * v);
    }
    force
}

/// Whether a correction is stated: material, no chance, and more than the target itself is off.
fn is_sure(corrected: &Corrected, missed: f64) -> bool {
    let (found, [without, with]) = (&corrected.evidence, corrected.nmse);
    found.share >= NAMED
        && chance(found.z, Correction::ALL.len() as f64) < ALPHA
        && without - with > missed
}

/// Whether the simulation's inertia is wrong by more than `share` of the mismatch: another load swings otherwise on the same spring.
pub fn is_another_load(null: &NullModel, extended: &Hypothesis, share: f64) -> bool {
    let mut sure = corrections(null, extended).into_iter();
    sure.any(|c| c.what == Correction::Inertia && c.evidence.share > share)
}

/// What inertia and friction of the simulation lack or have too much of, where that is material.
pub fn corrections(null: &NullModel, extended: &Hypothesis) -> Vec<Corrected> {
    let judged = Correction::ALL
        .into_iter()
        .filter(|c| !c.columns(null).is_empty())
        .filter_map(|c| c.judged(null, extended));
    judged.filter(|c| is_sure(c, null.rows.missed)).collect()
}
