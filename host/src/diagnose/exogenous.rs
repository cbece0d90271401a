//! Whether a delay is one. Two things look like it: friction that is damped where it sticks leads, and no inertia with it; and in a closed loop
//! friction that wanders moves the axis, whose motion follows it by a phase. No friction moves what was commanded: it is the instrument
//! of the second (Söderström and Stoica, *Instrumental Variable Methods for System Identification*, 1983).

use super::candidate::{Candidate, candidate_of};
use super::change::Change;
use super::effect::channel_delay::late;
use super::normal::{Bound, Normal, dot};
use super::null_model::{Hypothesis, NullModel};
use super::term::{Subject, Term};
use preslide_fit::signal::Deflection;
use preslide_fit::statistics::jackknife;

/// Share of a lead's explanation from which the lead of friction alone is another explanation: as of any rival of a name. That it does was seen on
/// `axes` 31.
const NEAR: f64 = 0.6;
/// Standard errors by which the commanded motion must show a delay, of the same sign.
const SURE: f64 = 2.0;
/// Share of all that is left from which a delay needs no instrument: friction that wanders leaves more than its phase.
const ALL: f64 = 0.9;

/// Whether a delay is reported, from the candidate on top of what stands `beside` it.
pub fn is_told(null: &NullModel, beside: &Hypothesis, own: &Candidate) -> bool {
    let Some(&delay) = own.trial.coefficients.first() else {
        return true;
    };
    let is_commanded = || commanded(null, beside, own, delay).unwrap_or(true);
    !is_damping(null, beside, own) && (own.evidence.share >= ALL || is_commanded())
}

/// Whether friction alone leads: damping of what sticks adds to its force in proportion to its slope.
fn is_damping(null: &NullModel, beside: &Hypothesis, own: &Candidate) -> bool {
    let damped = Term::new(Subject::Change(Change::Damped), &[]);
    let alone = candidate_of(null, beside, &[damped], 1.0).map_or(0.0, |o| o.evidence.share);
    alone >= NEAR * own.evidence.share
}

/// Whether the commanded motion shows the delay; `None` where no command was recorded.
fn commanded(null: &NullModel, beside: &Hypothesis, own: &Candidate, delay: f64) -> Option<bool> {
    let rows = &null.rows;
    let s = &rows.s;
    let reference = s.reference.as_deref()?;
    let acceleration = s.smooth_slope(&s.smooth_slope(reference));
    let mut effort: Vec<f64> = acceleration
        .iter()
        .map(|a| null.baseline.mass * a)
        .collect();
    for &(stiffness, yields) in &null.baseline.blocks {
        let along = Deflection::along(reference, &s.pieces, yields).z;
        effort
            .iter_mut()
            .zip(along)
            .for_each(|(f, z)| *f += stiffness * z);
    }
    let instrument = rows.weak.rows(&late(&effort));
    // What the columns beside it have in common with the instrument is theirs.
    let columns = beside.columns();
    let free = vec![Bound::Free; columns.len()];
    let fitted = Normal::new(&null.noise, &rows.weak.folds, &columns, &free, &instrument)?;
    let weighed = null.noise.inverse(&fitted.residual(&columns, &instrument));
    let column = null.columns(&own.term);
    let of = |values: &[f64]| -> Vec<f64> {
        let blocks = rows.blocks.iter();
        blocks
            .map(|b| dot(&weighed[b.clone()], &values[b.clone()]))
            .collect()
    };
    let (effort, delayed) = (of(&rows.target), of(column.first()?));
    let all: [f64; 2] = [&effort, &delayed].map(|sums| sums.iter().sum());
    let without: Vec<f64> = (effort.iter().zip(&delayed))
        .map(|(e, d)| (all[0] - e) / (all[1] - d))
        .collect();
    let told = all[0] / all[1];
    Some(told * delay > 0.0 && told.abs() >= SURE * jackknife(&without))
}
