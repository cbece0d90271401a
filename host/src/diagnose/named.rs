//! An effect as it is stated.

use super::confidence;
use super::effect::{Effect, Line};
use super::naming::TermReport;
use super::place::Place;
use super::simulation::Correction;
use super::term::Term;
use preslide_fit::evidence::Evidence;
use preslide_fit::statistics::Estimate;
use std::collections::BTreeMap;

/// Even odds: the most that is stated of a name whose sign its own interval leaves open.
pub(super) const EVEN: f64 = 0.5;
/// Confidence from which a name is certain.
pub(super) const CERTAIN: f64 = 0.9;

/// What an effect is called by: an entry of the catalogue, or the hysteresis itself.
#[derive(Clone, Copy)]
pub enum Name {
    /// An entry.
    Entry(&'static dyn Effect),
    /// The user's hysteresis is wrong.
    Hysteresis,
    /// Inertia or friction of the user's simulation is.
    Correction(Correction),
}

/// An effect that is stated.
#[derive(Clone)]
pub struct Named {
    /// What it is.
    pub name: Name,
    /// Its term, where it has one.
    pub term: Option<Term>,
    /// Enters the extended model; otherwise a hint.
    pub confident: bool,
    /// It entered the hypothesis, and a check of the name failed.
    pub doubted: bool,
    /// The fit has it: it is there, and nothing is missing.
    pub in_fit: bool,
    /// The simulation has it, too, of another size: a parameter of its own is wrong.
    pub in_simulation: bool,
    /// Probability that it is there and so named.
    pub confidence: f64,
    /// What it explains, everything else given.
    pub evidence: Evidence,
    /// What the confidence is computed from; `None` for the hysteresis, corrections, and hints that did not enter.
    pub report: Option<TermReport>,
    /// Held-out NMSE (%) without and with it.
    pub nmse_test: [f64; 2],
    /// Where it acts, over its own coordinate first.
    pub places: Vec<Place>,
    /// Its force at the rows (N or N·m).
    pub force: Vec<f64>,
    /// Key, value and interval.
    pub parameters: Vec<(String, Estimate)>,
    /// What of the mechanics has its period.
    pub source: Option<String>,
    /// Effects that explain it as well.
    pub ambiguous: Vec<&'static dyn Effect>,
}

impl Named {
    /// A check failed: it is a suspicion from now on. Where the confidence is not fitted, the odds are even at most.
    pub(super) fn doubt(&mut self) {
        self.confident = false;
        self.doubted = true;
        self.confidence = match self.report {
            Some(_) => confidence::of_a_hint(Some(&self.evidence)),
            None => self.confidence.min(EVEN),
        };
    }

    /// Whether it is a line or a narrow place, which was held against placebos.
    pub(super) fn is_narrow(&self) -> bool {
        self.report.as_ref().is_some_and(|s| s.placebo.is_some())
    }

    /// Whether it is certain, and no part of the fit.
    pub fn is_missing(&self) -> bool {
        self.confident && !self.in_fit
    }

    /// Whether it lies between the machine and the recorded effort, where no term of the search is it.
    pub fn is_in_the_channel(&self) -> bool {
        self.confident && self.term.is_none() && matches!(self.name, Name::Entry(_))
    }

    /// What its confidence is computed from, where that is fitted.
    pub fn features(&self) -> Option<BTreeMap<&'static str, f64>> {
        match (&self.report, self.name) {
            (Some(report), _) if !self.doubted => Some(confidence::features(report)),
            (None, Name::Correction(_)) => None,
            (None, _) if self.confident => None,
            (None, Name::Hysteresis) => Some(confidence::features_of_a_hint(None)),
            _ => Some(confidence::features_of_a_hint(Some(&self.evidence))),
        }
    }
}

/// What of the mechanics has the period of an effect.
pub(super) fn source(
    effect: &dyn Effect,
    term: &Term,
    mechanics: &[(String, f64)],
) -> Option<String> {
    let in_position = effect.line().is_some_and(|line| line != Line::Time);
    let period = term.shape.first().copied().filter(|_| in_position)?;
    let orders = mechanics
        .iter()
        .flat_map(|(key, length)| [1.0, 2.0, 3.0].map(|order| (key, length / order, order)));
    let near = orders
        .into_iter()
        .find(|(_, length, _)| (period / length - 1.0).abs() < 0.02);
    Some(near.map_or("unknown".to_owned(), |(key, _, order)| {
        if order == 1.0 {
            key.clone()
        } else {
            format!("{key}, order {order}")
        }
    }))
}
