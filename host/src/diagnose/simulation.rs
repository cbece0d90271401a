//! What a simulation of the user's own gets wrong in inertia and friction: the core stands for it, and is judged as every candidate is.

use super::axis::Axis;
use super::effect::ALWAYS_FREE;
use super::evidence::{Evidence, NAMED, chance, evidence};
use super::ground::{Ground, Hypothesis};
use super::normal::{Bound, Normal};
use super::search::ALPHA;
use super::term::{Subject, Term};
use crate::statistics::{Estimate, jackknife};
use std::ops::Range;

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

    /// The experiment that tells it from its rivals.
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

    /// Its columns among the core's.
    fn columns(self, ground: &Ground) -> Range<usize> {
        let first = ground.core.first_of_friction();
        match self {
            Self::Inertia => 0..first,
            Self::Friction => first..ground.core.rows.len(),
        }
    }

    /// What the coefficients of the core add: inertia, or force in sliding.
    fn value(self, ground: &Ground, core: &[f64]) -> f64 {
        let own = &core[self.columns(ground)];
        match self {
            Self::Inertia => own[0],
            Self::Friction => {
                let blocks = own.iter().zip(ground.core.reaches());
                blocks.map(|(k, d)| k * d).sum()
            }
        }
    }

    /// Judges it beside all else; `None` where the effort does not contain it or the rest does not determine its coefficients.
    fn judged(self, ground: &Ground, extended: &Hypothesis) -> Option<Corrected> {
        let (rows, core) = (&ground.rows, &ground.core.rows);
        let own = self.columns(ground);
        let delay = Term::new(Subject::Effect(ALWAYS_FREE), &[]);
        // A sample of delay between the two columns is no error of the simulation's.
        let delay = Some(&delay).filter(|d| !extended.terms.iter().any(|t| t.is_like(d)));
        let terms = extended.terms.iter().chain(delay);
        let others: Vec<_> = terms.map(|t| ground.columns(t)).collect();
        let mut rest: Vec<&[f64]> = (0..core.len())
            .filter(|j| !own.contains(j))
            .map(|j| core[j].as_slice())
            .collect();
        rest.extend(others.iter().flat_map(|c| c.iter()).map(Vec::as_slice));
        let bounds = vec![Bound::Free; rest.len()];
        let folds = &rows.weak.folds;
        let without = Normal::new(&ground.noise, folds, &rest, &bounds, &rows.target)?;
        let trial = without.trial(&[&core[own.clone()]], |_, _| true)?;
        let found = evidence(&trial.force, &without.held_out, &rows.blocks);
        let (coefficients, mut force) =
            (&extended.normal.coefficients, vec![0.0; rows.force.len()]);
        for j in own {
            let added = force.iter_mut().zip(&core[j]);
            added.for_each(|(f, v)| *f += coefficients[j] * v);
        }
        Some(Corrected {
            what: self,
            evidence: found,
            nmse: [
                rows.nmse(&without.held_out_residual(&rest, &rows.target)),
                extended.nmse(rows).test,
            ],
            force,
            parameter: self.parameter(ground, extended),
        })
    }

    /// Its value, with an interval from the scatter over folds left out in turn.
    fn parameter(self, ground: &Ground, extended: &Hypothesis) -> (String, Estimate) {
        let key = match self {
            Self::Inertia => "mass_kg",
            Self::Friction => "force_N",
        };
        let folds = ground.rows.weak.folds.len();
        let left_out: Vec<f64> = (0..folds)
            .map(|s| self.value(ground, &extended.normal.without_fold(s)))
            .collect();
        let value = self.value(ground, &extended.normal.coefficients);
        let estimate = Estimate::new(value, Some(jackknife(&left_out)), folds);
        (key.to_owned(), estimate)
    }
}

/// Whether a correction is stated: material, no chance, and more than the target itself is off.
fn is_sure(corrected: &Corrected, missed: f64) -> bool {
    let (found, [without, with]) = (&corrected.evidence, corrected.nmse);
    found.share >= NAMED
        && chance(found.z, Correction::ALL.len() as f64) < ALPHA
        && without - with > missed
}

/// What inertia and friction of the simulation lack or have too much of, where that is material.
pub fn corrections(ground: &Ground, extended: &Hypothesis) -> Vec<Corrected> {
    let judged = Correction::ALL
        .into_iter()
        .filter(|c| !c.columns(ground).is_empty())
        .filter_map(|c| c.judged(ground, extended));
    judged.filter(|c| is_sure(c, ground.rows.missed)).collect()
}
