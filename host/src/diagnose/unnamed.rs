//! What is there and cannot be named: what only a free curve or a change of the core explains, and names that are too doubtful.

use super::axis::Axis;
use super::change::Change;
use super::confidence::presence;
use super::effect::Effect;
use super::naming::Standing;
use super::place::Place;
use super::search::Found;
use super::signals::mean;
use super::term::Subject;

/// Share of the mismatch, weighted or all rows alike, from which what has no name is material.
const UNNAMED: f64 = 0.05;
/// Least part of the effort's variance (%) that it takes off: 1 % of the effort is near what makes a controller better, and a fifth of what
/// machines' friction changes by itself. A name below it can be put into a model; what has none cannot.
const NOTICEABLE: f64 = 0.01;
/// Least probability that it is there at all. More than even: fitted without the other source, the probability is too high, since what a
/// hysteresis that parallel blocks cannot follow leaves looks like it. Set after the second generator's clean machines were seen as a count.
const LIKELY: f64 = 0.8;

/// A mismatch that nothing in the catalogue explains well enough.
#[derive(Clone)]
pub struct Unknown {
    /// The coordinate that organises it.
    pub axis: Axis,
    /// It flips with direction.
    pub odd: bool,
    /// A change of the core, where it is one.
    pub change: Option<Change>,
    /// Probability that something is there.
    pub confidence: f64,
    /// The term that explains it, which may be an effect that is too doubtful to be named.
    pub standing: Standing,
    /// Where it is.
    pub place: Option<Place>,
    /// Root mean square of its force (N or N·m).
    pub rms: f64,
    /// Its force at the rows.
    pub force: Vec<f64>,
}

/// The first that is likely there.
pub fn likely(unnamed: &[Unknown]) -> Option<&Unknown> {
    unnamed.iter().find(|u| u.confidence >= LIKELY)
}

/// All that are material, largest first; `is_doubtful` tells of an effect whether it is suspected only.
pub fn unnamed(
    found: &Found,
    standings: &[Standing],
    is_doubtful: impl Fn(&dyn Effect) -> bool,
) -> Vec<Unknown> {
    let is_unnamed = |s: &&Standing| match s.term.subject {
        Subject::Effect(effect) => is_doubtful(effect),
        // It widens the core, and stays in it.
        Subject::Change(change) => change != Change::LateYields,
        Subject::Curve(_) => true,
    };
    let mut material: Vec<&Standing> = standings
        .iter()
        .filter(is_unnamed)
        .filter(|s| s.size() >= UNNAMED && s.size() * s.left >= NOTICEABLE)
        .collect();
    material.sort_by(|a, b| b.size().total_cmp(&a.size()));
    material.into_iter().map(|s| unknown(found, s)).collect()
}

fn unknown(found: &Found, standing: &Standing) -> Unknown {
    let rows = &found.ground.rows;
    let force = found.hypothesis.force_of(standing.index);
    let level = mean(&force);
    let (axis, odd, change) = match standing.term.subject {
        Subject::Curve(curve) => (curve.axis, curve.odd, None),
        Subject::Change(change) => (change.axis(), true, Some(change)),
        Subject::Effect(effect) => {
            let direction = rows.weak.at_centres(&rows.s.direction);
            let along: Vec<f64> = force.iter().zip(&direction).map(|(f, d)| f * d).collect();
            let axis = standing.form.map_or(effect.axis(), |f| f.0);
            (axis, mean(&along).abs() > level.abs(), None)
        }
    };
    let varying: Vec<f64> = force
        .iter()
        .map(|f| f - if odd { 0.0 } else { level })
        .collect();
    Unknown {
        axis,
        odd,
        change,
        confidence: presence(standing),
        standing: standing.clone(),
        place: Place::of(rows, axis, &varying),
        rms: (varying.iter().map(|f| f * f).sum::<f64>() / varying.len().max(1) as f64).sqrt(),
        force: varying,
    }
}
