//! Which terms a recording asks for: forward and backward, by what they explain of rows that their fit has not seen.

use super::candidate::{Candidate, WORSE, candidate_of, candidates, refined};
use super::change::Change;
use super::effect::{self, Class, Effect};
use super::fit::Known;
use super::merge::merged;
use super::null_model::{Hypothesis, NullModel};
use super::polish::polished;
use super::signals::Signals;
use super::term::{Subject, Term};
use preslide_fit::progress::Progress;
use rayon::prelude::*;

/// Chance of entering anything into the hypothesis of a recording that lacks nothing.
pub const ALPHA: f64 = 0.05;
/// Least share of the mismatch that a term must explain to enter: what has nothing to gain is no finding.
pub const MATERIAL: f64 = 0.01;
/// The same share of the mismatch that the recording began with, but not more than this (% of the effort's variance): what is left of a
/// large mismatch is as small to the machine's user as it is sure.
const SEEN: f64 = 0.05;
/// Least deviation of a candidate's force, of the measured effort's: below it nothing is to be gained on a machine, however repeatable the recording.
pub const WORTH: f64 = 0.002;
/// Share of the best candidate's explanation that plain physics needs to be taken first: every machine may have it, and a free
/// curve that bends to two effects at once would hide both.
const PLAIN: f64 = 0.15;
/// Share of a free curve's explanation that a name must reach.
const MATCH: f64 = 0.9;
/// The same over the name's own coordinate, where two effects may share one curve, and for changes of the core, which bend to
/// whatever is there.
const OWN: f64 = 0.5;
/// Share of the leader's explanation from which a simpler effect is taken in its place.
const TIE: f64 = 0.93;
/// Share of a term's entry that it must keep beside later ones.
const KEEP: f64 = 0.5;
/// Standard deviations that a term must keep beside later ones.
const SURE: f64 = 2.0;
/// Most terms.
const MOST: usize = 10;
/// Candidates whose shape is refined before they are compared.
const LEADERS: usize = 6;
/// A term that takes more than this share of the mismatch changes what the others act through, and the noise.
const LARGE: f64 = 0.1;

/// Most turns of a simulated term's shape and the friction and inertia that it acts on, and the gain below which both are settled. Made belts and
/// servos with play took three to eight.
const TURNS: usize = 8;
/// See [`TURNS`].
const SETTLED: f64 = 0.01;

/// What a simpler simulated effect may leave of what its rival does.
const NEARLY: f64 = 1.25;

/// What the search ends in.
pub struct Found {
    /// Rows, friction and noise beside all terms.
    pub null: NullModel,
    /// The hypothesis.
    pub hypothesis: Hypothesis,
    /// What would come next, best first.
    pub rest: Vec<Candidate>,
    /// Number of candidates, among which chance picks.
    pub families: usize,
    /// What the fit has.
    pub known: Known,
}

/// Searches on top of the given terms, and of a delay, which every recording may have; of `known` physics what these rows show stays, too.
pub fn search(
    mut null: NullModel,
    given: &[Term],
    known: &Known,
    periods: &[f64],
    progress: &Progress,
) -> Option<Found> {
    let delay = Term::new(Subject::Effect(effect::ALWAYS_FREE), &[]);
    let first = if given.iter().any(|t| t.is_like(&delay)) {
        given.to_vec()
    } else {
        [given, &[delay]].concat()
    };
    let begun = null.fit(&[first.as_slice(), &known.terms, &known.shaken].concat())?;
    // What they do not show yet may come back beside what they lack.
    let mut hypothesis = sifted(&null, begun, first.len(), &mut Vec::new())?;
    let visible = visible(hypothesis.nmse(&null.rows).test);
    let mut barred: Vec<Term> = Vec::new();
    loop {
        let (mut list, families) = candidates(&null, &hypothesis, periods);
        progress.inc(1);
        lead(&null, &hypothesis, &mut list);
        let left = hypothesis.nmse(&null.rows).test;
        list.retain(|o| {
            let out = barred.iter().any(|b| b.is_near(&o.term));
            !(out || is_harmless(&null, o) || o.keeps_step(&null))
        });
        let full = hypothesis.terms.len() >= first.len() + MOST;
        let least = MATERIAL.max(visible / left);
        let Some(next) = pick(&null, &list, families, least)
            .filter(|_| !full)
            .map(|next| in_its_place(&null, &hypothesis, next))
        else {
            if let Some((one, two)) = merged(&null, &hypothesis, first.len(), periods) {
                barred.extend(two);
                hypothesis = sifted(&null, one, first.len(), &mut barred)?;
                continue;
            }
            // Polished, a term may have lost its sign to another's shape.
            let polished = polished(&null, hypothesis, first.len());
            return Some(Found {
                hypothesis: sifted(&null, polished, first.len(), &mut barred)?,
                null,
                rest: list,
                families,
                known: known.clone(),
            });
        };
        let terms = with(&null, &hypothesis, &next.term)?;
        let replaces = terms.len() <= hypothesis.terms.len();
        let referred = match next.evidence.share > LARGE {
            true => Some(entered(&null, terms.clone())?),
            false => None,
        };
        let (beside, terms) = referred.as_ref().map_or((&null, &terms), |(n, t)| (n, t));
        let fitted = beside.fit(terms)?;
        // What takes the place of others must leave less than they did.
        if replaces && fitted.nmse(&beside.rows).test > left {
            barred.push(next.term);
            continue;
        }
        if let Some((beside, _)) = referred {
            null = beside;
        }
        hypothesis = sifted(&null, fitted, first.len(), &mut barred)?;
    }
}

/// Friction, inertia and noise beside some terms of which the last is new, and the terms, or what is simpler in its place and does nearly as well.
fn entered(null: &NullModel, terms: Vec<Term>) -> Option<(NullModel, Vec<Term>)> {
    let own = settled(null.referred_to(&terms)?, terms)?;
    let last = own
        .1
        .last()
        .and_then(|own| own.effect()?.simpler(&own.shape));
    let Some((effect, shape)) = last else {
        return Some(own);
    };
    let mut terms = own.1.clone();
    *terms.last_mut()? = Term::new(Subject::Effect(effect), &shape);
    let simpler = settled(null.referred_to(&terms)?, terms)?;
    let left =
        |(null, terms): &(NullModel, Vec<Term>)| Some(null.fit(terms)?.nmse(&null.rows).test);
    let does = left(&simpler)? <= NEARLY * left(&own)?;
    Some(if does { simpler } else { own })
}

/// The last of some terms, where it is simulated, on the friction and inertia that are found beside it: before it those were bent to what it does,
/// and its shape to theirs.
fn settled(mut null: NullModel, mut terms: Vec<Term>) -> Option<(NullModel, Vec<Term>)> {
    for _ in 0..TURNS {
        let starts = terms.last().map_or(Vec::new(), |own| starts(&null, own));
        if starts.is_empty() {
            break;
        }
        let own = terms.pop()?;
        let without = null.fit(&terms)?;
        let judged = |term: Term| {
            let reduction = without.normal.reduction(&null.columns(&term));
            let taken = reduction.filter(|(_, c)| null.admits(&term, c));
            (taken.map_or(0.0, |(taken, _)| taken), term)
        };
        let before = judged(own);
        let mut from: Vec<(f64, Term)> = starts.into_par_iter().map(judged).collect();
        from.sort_by(|a, b| b.0.total_cmp(&a.0));
        from.truncate(LEADERS);
        if !from.iter().any(|(_, start)| start.shape == before.1.shape) {
            from.push(before.clone());
        }
        let found = from
            .into_par_iter()
            .map(|(_, term)| judged(refined(&null, &without, &term)));
        let best = found.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let moved = best.0 > (1.0 + SETTLED) * before.0;
        terms.push(if moved { best.1 } else { before.1 });
        if !moved {
            break;
        }
        null = null.referred_to(&terms)?;
    }
    Some((null, terms))
}

/// Shapes from which a simulated term may find a better one; empty for others.
fn starts(null: &NullModel, own: &Term) -> Vec<Term> {
    let shapes = own.effect().map_or(Vec::new(), |e| e.valleys(&own.shape));
    let within = |mut shape: Vec<f64>| {
        for j in 0..shape.len() {
            shape[j] = own
                .effect()
                .map_or(shape[j], |e| e.within(&null.scene(), &shape, j));
        }
        Term::new(own.subject, &shape)
    };
    shapes.into_iter().map(within).collect()
}

/// NMSE (%) that a term must take off where a recording begins with so much.
pub fn visible(begun: f64) -> f64 {
    SEEN.min(MATERIAL * begun)
}

/// A candidate, or what leaves clearly less in its place.
fn in_its_place(null: &NullModel, without: &Hypothesis, next: &Candidate) -> Candidate {
    let others = next.in_its_place(null, without).into_iter();
    let by = |o: &Candidate| o.leaves_less_than(next, null, &without.normal.held_out);
    others
        .filter(|o| by(o) >= WORSE)
        .max_by(|a, b| by(a).total_cmp(&by(b)))
        .unwrap_or_else(|| next.clone())
}

/// The terms and one more, in place of those found before that it contains: its shapes were refined beside them, and are without.
pub fn with(null: &NullModel, hypothesis: &Hypothesis, next: &Term) -> Option<Vec<Term>> {
    let contains = next
        .effect()
        .map_or_else(Vec::new, |e| e.excludes(&next.shape));
    let stays = |t: &&Term| {
        let contained = |e: &dyn Effect| contains.contains(&e.id());
        t.given || !t.effect().is_some_and(contained)
    };
    let mut terms: Vec<Term> = hypothesis.terms.iter().filter(stays).cloned().collect();
    let next = if terms.len() < hypothesis.terms.len() {
        refined(null, &null.fit(&terms)?, next)
    } else {
        next.clone()
    };
    terms.push(next);
    Some(terms)
}

/// Without the terms that the later ones make needless; they do not come back, so that the search ends.
fn sifted(
    null: &NullModel,
    mut hypothesis: Hypothesis,
    given: usize,
    barred: &mut Vec<Term>,
) -> Option<Hypothesis> {
    while let Some(index) = needless(null, &hypothesis, given) {
        let mut terms = hypothesis.terms.clone();
        barred.push(terms.remove(index));
        hypothesis = null.fit(&terms)?;
    }
    Some(hypothesis)
}

/// Whether a candidate is no larger than what every recording has.
fn is_harmless(null: &NullModel, candidate: &Candidate) -> bool {
    let effect = candidate.term.effect();
    effect.is_some_and(|e| e.is_harmless(&null.scene(), &candidate.trial.coefficients))
}

/// Refines the shapes of those that explain most: the grids of two effects are not equally fine.
fn lead(null: &NullModel, hypothesis: &Hypothesis, list: &mut [Candidate]) {
    for candidate in list
        .iter_mut()
        .filter(|o| !o.term.shape.is_empty())
        .take(LEADERS)
    {
        let term = refined(null, hypothesis, &candidate.term);
        if let Some(better) = candidate_of(null, hypothesis, &[term], candidate.tries)
            && better.evidence.share > candidate.evidence.share
        {
            *candidate = better;
        }
    }
    list.sort_by(|a, b| b.evidence.share.total_cmp(&a.evidence.share));
}

/// The candidate that enters, of those that take at least a share `least` of the mismatch.
fn pick<'a>(
    null: &NullModel,
    list: &'a [Candidate],
    families: usize,
    least: f64,
) -> Option<&'a Candidate> {
    let fit: Vec<&Candidate> = list
        .iter()
        .filter(|o| o.evidence.share >= least && o.relative >= WORTH && o.chance(families) < ALPHA)
        .collect();
    let best = *fit.first()?;
    // What the recording cannot decide has no better right than what has no name.
    let can = |o: &Candidate| {
        let effect = o.term.effect();
        effect.is_some_and(|e| e.lacks(&null.rows.s).is_none())
    };
    let matching = |o: &Candidate| match (best.term.subject, o.term.effect()) {
        (Subject::Effect(_), _) if !can(best) => MATCH,
        (Subject::Curve(curve), Some(effect)) if effect.axis() == curve.axis => OWN,
        // Friction wanders in time and along the path: a free curve over either takes that as well as the drift.
        (Subject::Curve(curve), Some(effect))
            if effect.class() == Class::Drift && effect.axis().is_akin(curve.axis) =>
        {
            OWN
        }
        (Subject::Curve(_), _) => MATCH,
        (Subject::Change(change), _) if change.is_plain() => MATCH,
        (Subject::Change(_), _) => OWN,
        _ => 0.0,
    };
    let good = |o: &&&Candidate| o.evidence.share >= matching(o) * best.evidence.share;
    // Hysteresis of long displacements is plain, too.
    let ahead = match best.term.subject {
        Subject::Change(Change::LateYields) => MATCH,
        _ => PLAIN,
    };
    let plain = |o: &&&Candidate| {
        o.term.effect().is_some_and(|e| e.class() == Class::Plain)
            && o.evidence.share >= ahead * best.evidence.share
    };
    let first = fit.iter().find(|o| can(o) && plain(o));
    first
        .or_else(|| fit.iter().find(|o| can(o) && good(o)))
        .map(|o| simplest(null, o, &fit))
        .or(Some(best))
}

/// What a candidate is simple by: fewest parameters, then the catalogue's order.
pub fn simplicity(candidate: &Candidate) -> (usize, usize) {
    let parameters = candidate.term.shape.len() + candidate.trial.coefficients.len();
    (
        parameters,
        candidate.term.effect().map_or(usize::MAX, effect::rank),
    )
}

/// Whether a recording can show an effect: what it lacks hides it, but slow change shows before its cause does.
pub fn is_told(effect: &dyn Effect, s: &Signals) -> bool {
    effect.class() == Class::Drift || effect.lacks(s).is_none()
}

/// The simplest effect that the recording can show and that explains nearly as much as `leader`. Plain physics is all as simple: there the order
/// decides between equivalents only, and a drag that explains more is no viscous friction.
fn simplest<'a>(null: &NullModel, leader: &'a Candidate, fit: &[&'a Candidate]) -> &'a Candidate {
    let plain = leader.term.effect().filter(|e| e.class() == Class::Plain);
    let rival = |effect: &dyn Effect| {
        plain.is_none_or(|leader| {
            let equivalents = leader.equivalents(&null.rows.s);
            effect.id() == leader.id() || equivalents.contains(&effect.id())
        })
    };
    let told = |e: &dyn Effect| rival(e) && is_told(e, &null.rows.s);
    let near = |o: &&Candidate| {
        o.term.effect().is_some_and(told) && o.evidence.share >= TIE * leader.evidence.share
    };
    fit.iter()
        .copied()
        .filter(near)
        .min_by_key(|o| simplicity(o))
        .unwrap_or(leader)
}

/// The first term that explains too little beside the others, or has a sign that its physics has not.
fn needless(null: &NullModel, hypothesis: &Hypothesis, given: usize) -> Option<usize> {
    (given..hypothesis.terms.len()).find(|&i| {
        let kept = null
            .fit(&beside(&hypothesis.terms, i))
            .and_then(|without| candidate_of(null, &without, &hypothesis.terms[i..=i], 1.0))
            .is_some_and(|o| o.evidence.share >= KEEP * MATERIAL && o.evidence.z >= SURE);
        !kept
    })
}

/// What term `index` is judged beside: all others, but for what has no name and came after it. A free curve holds the names over its
/// own coordinate, and would take their coefficients from them.
pub fn beside(terms: &[Term], index: usize) -> Vec<Term> {
    let others = terms.iter().enumerate().filter(|(j, other)| {
        let named = other.given || other.effect().is_some();
        *j != index && (named || *j < index)
    });
    others.map(|(_, other)| other.clone()).collect()
}
