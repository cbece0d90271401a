//! What each term of the hypothesis may be called: rivals in its place.
//!
//! A rival counts against a name only if it is not clearly worse and makes the name needless (*encompasses* it, Mizon and
//! Richard 1986): otherwise every second effect of a machine would be a rival of the first.

use super::axis::Axis;
use super::candidate::{Candidate, WORSE, candidate_of, candidates, refined};
use super::curve::hats;
use super::effect::{ALWAYS_FREE, Class, Effect};
use super::exogenous::is_told;
use super::null_model::{Hypothesis, NullModel};
use super::placebo::over_state;
use super::search::{Found, MATERIAL, beside, simplicity};
use super::term::{Subject, Term};
use preslide_fit::evidence::{Evidence, at_its_largest, evidence};

/// Share of a term's explanation that a rival must reach by itself to be looked at.
const NEAR: f64 = 0.6;
/// Most rivals looked at for one term.
const RIVALS: usize = 6;
/// Share of its explanation that a term keeps beside a rival that makes it needless.
const NEEDLESS: f64 = 0.3;
/// Share of its explanation that a change of its size over a foreign coordinate must add to tell against a name.
const CHANGES: f64 = 0.25;
/// Standard deviations of such a change: as many as a candidate needs to enter.
const MODULATED: f64 = 3.0;
/// Times as many coefficients from which a rival that does as well is no equal.
const MANY: usize = 2;

/// An effect's, a curve's or a change's report in the final hypothesis.
#[derive(Clone)]
pub struct TermReport {
    /// The term.
    pub term: Term,
    /// Its number in the hypothesis.
    pub index: usize,
    /// What it is worth, everything else given.
    pub evidence: Evidence,
    /// Rivals that make it needless and are not clearly worse, best first.
    pub ambiguous: Vec<&'static dyn Effect>,
    /// The rival that belongs in its place, with its explanation over the term's own: simpler, it makes it needless and explains no less.
    pub better: Option<(Term, f64)>,
    /// Explanation of the best rival that makes it needless, over its own; 0 where there is none.
    pub rival: f64,
    /// Its coefficient where its force is largest.
    pub at_its_largest: f64,
    /// The coordinate over which its size changes though the catalogue's does not, and what that change explains over its own.
    pub form: Option<(Axis, f64)>,
    /// Held-out NMSE (%) without it.
    pub left: f64,
    /// Share of that which it takes off, all rows alike.
    pub gain: f64,
    /// It follows the motion as a hysteresis does that was fitted beside it.
    pub law: bool,
    /// No larger than what every recording has.
    pub harmless: bool,
    /// Nothing else than the effect looks like it: a delay may be none.
    pub told: bool,
    /// How it stands out of chance, where it is a line or a narrow place.
    pub placebo: Option<f64>,
    /// What else was tried in its place, with its explanation over the term's own.
    pub tried: Vec<(String, f64)>,
}

/// Judges every term that is not given.
pub fn reports(found: &Found, given: usize, periods: &[f64]) -> Vec<TermReport> {
    (given..found.hypothesis.terms.len())
        .filter_map(|index| report(found, index, periods))
        .collect()
}

fn report(found: &Found, index: usize, periods: &[f64]) -> Option<TermReport> {
    let null = &found.null;
    let term = found.hypothesis.terms[index].clone();
    let rest = null.fit(&beside(&found.hypothesis.terms, index))?;
    let own = candidate_of(null, &rest, std::slice::from_ref(&term), 1.0)?;
    let with = null.fit(&joined(&rest, &term))?;
    let (mut list, _) = candidates(null, &rest, periods);
    list.retain(|o| !o.term.is_like(&term) && o.evidence.share > NEAR * own.evidence.share * 0.8);
    list.truncate(RIVALS);
    for other in own.in_its_place(null, &rest) {
        if !list.iter().any(|o| o.term.is_near(&other.term)) {
            list.push(other);
        }
    }
    let left = rest.nmse(&null.rows).test;
    let mut report = TermReport {
        index,
        evidence: own.evidence,
        ambiguous: Vec::new(),
        better: None,
        rival: 0.0,
        at_its_largest: at_its_largest(&own.trial.force, &rest.normal.held_out),
        form: form(found, index, &own),
        tried: Vec::new(),
        left,
        gain: 1.0 - with.nmse(&null.rows).test / left.max(1e-300),
        law: !null.core.corrects && term.effect().is_some_and(|e| e.is_law()),
        harmless: term
            .effect()
            .is_some_and(|e| e.is_harmless(&null.scene(), found.hypothesis.coefficients(index))),
        told: term.effect().is_none_or(|e| e.id() != ALWAYS_FREE.id())
            || is_told(null, &rest, &own),
        placebo: term
            .effect()
            .filter(|e| e.is_narrow())
            .map(|_| over_state(null, &rest, &term).unwrap_or_default()),
        term,
    };
    for rival in &list {
        let sharp = refined(null, &rest, &rival.term);
        let rival = candidate_of(null, &rest, &[sharp], 1.0)
            .filter(|o| o.evidence.share > rival.evidence.share)
            .unwrap_or_else(|| rival.clone());
        report.meet(null, &rest, &own, &rival);
    }
    Some(report)
}

impl TermReport {
    /// Share of the mismatch that it takes: weighted, or all rows alike, which is what slow effects are seen in.
    pub fn size(&self) -> f64 {
        self.evidence.share.max(self.gain)
    }

    /// The same as far as it speaks for the name. What the hysteresis misses after a stop is large with all rows alike, too: a law of the motion counts
    /// weighted only. Of 177 such names on made and real machines the weighted share sorts right from false the better (area under the curve 0.73 for
    /// 0.66).
    pub fn size_of_the_name(&self) -> f64 {
        match self.term.effect().is_some_and(|e| e.is_law()) {
            true => self.evidence.share,
            false => self.size(),
        }
    }

    /// Whether a rival is simpler. Plain physics stays, which every machine may have, and a delay, which every recording may have.
    fn gives_way(&self, own: &Candidate, rival: &Candidate) -> bool {
        let stays = |e: &dyn Effect| e.class() == Class::Plain || e.id() == ALWAYS_FREE.id();
        let may = self.term.effect().is_some_and(|e| !stays(e));
        may && simplicity(rival) < simplicity(own)
    }

    /// Compares with one rival in the same place. What has no name is only reported: a curve that contains the effect's own does as well.
    fn meet(&mut self, null: &NullModel, rest: &Hypothesis, own: &Candidate, rival: &Candidate) {
        let ratio = rival.evidence.share / own.evidence.share.max(1e-300);
        self.tried
            .push((rival.term.subject.name(&null.rows.s), ratio));
        let Subject::Effect(effect) = rival.term.subject else {
            return;
        };
        if ratio < NEAR {
            return;
        }
        let left = null
            .fit(&joined(rest, &rival.term))
            .and_then(|with| candidate_of(null, &with, std::slice::from_ref(&self.term), 1.0))
            .map_or(0.0, |o| o.evidence.share);
        // Shares of what is left beside a rival are larger than those of the whole.
        let kept = left * (1.0 - rival.evidence.share).max(0.0);
        if kept > NEEDLESS * own.evidence.share {
            return;
        }
        let best = self.better.as_ref().map_or(1.0, |better| better.1);
        if ratio > best && self.gives_way(own, rival) && effect.lacks(&null.rows.s).is_none() {
            self.better = Some((rival.term.clone(), ratio));
        }
        self.rival = self.rival.max(ratio);
        // A map of many cosines has every ripple in it, and of two laws that do as well the one with fewer numbers is it.
        let [own_numbers, numbers] = [own, rival].map(|c| c.trial.coefficients.len());
        if numbers <= MANY * own_numbers
            && own.leaves_less_than(rival, null, &rest.normal.held_out) < WORSE
        {
            self.ambiguous.push(effect);
        }
    }
}

/// The terms of a hypothesis and one more.
fn joined(rest: &Hypothesis, term: &Term) -> Vec<Term> {
    [rest.terms.as_slice(), std::slice::from_ref(term)].concat()
}

/// The coordinate over which the size of a term changes most, and what the change explains over the term's own. A viscous force that acts
/// at one place looks like a friction spot until one asks whether it grows with speed.
fn form(found: &Found, index: usize, own: &Candidate) -> Option<(Axis, f64)> {
    let (null, hypothesis) = (&found.null, &found.hypothesis);
    let effect = hypothesis.terms[index].effect()?;
    let force = hypothesis.force_of(index);
    let rows = &null.rows;
    let changes = |axis: Axis| {
        let values = rows.weak.at_centres(&axis.values(&rows.s)?);
        let columns: Vec<Vec<f64>> = hats(&values)
            .into_iter()
            .map(|hat| hat.iter().zip(&force).map(|(h, f)| h * f).collect())
            .collect();
        let trial = hypothesis.normal.trial(&[&columns], |_, _| true)?;
        let found = evidence(&trial.force, &hypothesis.normal.held_out, &rows.blocks);
        let ratio = found.share / own.evidence.share.max(1e-300);
        (found.z >= MODULATED && found.share >= MATERIAL && ratio >= CHANGES)
            .then_some((axis, ratio))
    };
    [Axis::Speed, Axis::Time, Axis::Position]
        .into_iter()
        .filter(|axis| !axis.is_akin(effect.axis()))
        .filter_map(changes)
        .max_by(|a, b| a.1.total_cmp(&b.1))
}
