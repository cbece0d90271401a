//! Friction that rises or falls from the beginning of a recording to its end, where no temperature was recorded that could say why.

use super::axis::Axis;
use super::candidate::candidate_of;
use super::confidence;
use super::curve::Curve;
use super::effect::thermal_drift::ThermalDrift;
use super::effect::viscous::Viscous;
use super::effect::{Class, Effect};
use super::place::Place;
use super::search::Found;
use super::term::{Subject, Term};
use super::unnamed::Unknown;

/// Change of the friction level from which it is more than friction that wanders: by a tenth, the level on guideways and screws changes from
/// stroke to stroke.
const SHOWN: f64 = 0.15;
/// Standard errors from which it is no chance.
const SURE: f64 = 3.0;
/// First and last part of the rows, whose levels are compared: as short as a level can be found in, since what warms changes most at the beginning.
const PART: f64 = 0.03;

/// What changes the friction level in the course of a recording, unless a temperature shows it or the search has found it.
pub fn drift(found: &Found) -> Option<Unknown> {
    let (null, rows) = (&found.null, &found.null.rows);
    let is_drift = |t: &Term| t.effect().is_some_and(|e| e.class() == Class::Drift);
    let terms = &found.hypothesis.terms;
    if ThermalDrift.lacks(&rows.s).is_none() || terms.iter().any(is_drift) {
        return None;
    }
    let curve = Term::new(
        Subject::Curve(Curve {
            axis: Axis::Time,
            odd: true,
        }),
        &[],
    );
    let viscous = Term::new(Subject::Effect(&Viscous), &[]);
    let others = terms.iter().filter(|t| !t.is_like(&curve));
    let mut terms: Vec<Term> = others.cloned().collect();
    // All rows alike: the noise model takes friction that wanders slowly for its own.
    let without = null.fit_unweighted(&terms)?;
    let candidate = candidate_of(null, &without, std::slice::from_ref(&curve), 1.0)?;
    terms.push(curve);
    let with = null.fit_unweighted(&terms)?;
    let force = with.force_of(terms.len() - 1);
    // What warms thins the oil, too: viscous friction is a part of the level.
    let mut friction = with.friction(null);
    for index in (0..terms.len()).filter(|i| terms[*i].is_like(&viscous)) {
        let own = with.force_of(index);
        friction.iter_mut().zip(own).for_each(|(f, v)| *f += v);
    }
    let part = (PART * force.len() as f64) as usize;
    let level = |rows: std::ops::Range<usize>| {
        let own = &friction[rows.clone()];
        let along: f64 = own.iter().zip(&force[rows]).map(|(f, g)| f * g).sum();
        1.0 + along / own.iter().map(|f| f * f).sum::<f64>().max(1e-300)
    };
    let change = level(force.len() - part..force.len()) / level(0..part) - 1.0;
    let evidence = candidate.evidence;
    (evidence.z >= SURE && change.abs() >= SHOWN).then(|| Unknown {
        axis: Axis::Time,
        odd: true,
        change: None,
        like: Some(&ThermalDrift),
        confidence: confidence::of_evidence(&evidence),
        evidence,
        size: evidence.share,
        features: None,
        happened: None,
        rises_by: Some(change),
        place: Place::of(rows, Axis::Time, &force),
        rms: rows.rms_of(evidence.share * without.nmse(rows).test),
        wanders: false,
    })
}
