//! What is there and cannot be named: what only a free curve or a change of the core explains, and names that are too doubtful.

use super::axis::Axis;
use super::change::Change;
use super::confidence::{features_of_presence, presence};
use super::effect::{self, ALWAYS_FREE, Effect};
use super::event::{self, event};
use super::naming::TermReport;
use super::noise::rms;
use super::null_model::{Hypothesis, NullModel};
use super::place::Place;
use super::search::Found;
use super::signals::mean;
use super::term::Subject;
use preslide_fit::evidence::Evidence;
use std::collections::BTreeMap;
use std::ops::Range;

/// Share of the mismatch, weighted or all rows alike, from which what has no name is material.
const UNNAMED: f64 = 0.05;
/// Least part of the effort's variance (%) that it takes off: 1.4 % of the effort's deviation is near what makes a controller better, and
/// about a third of what machines' friction changes by itself. A name below it can be put into a model; what has none cannot. Set after
/// recordings of `axes` and `drives` were seen: 0.01 calls 23 of their 150 clean ones unknown, 0.02 18, 0.05 14; none, and two, of their
/// strangers are lost.
const NOTICEABLE: f64 = 0.02;
/// Share of the friction from which a force is more than any machine's cables, seals and motor add. Set after recordings of `axes` and
/// `drives` were seen: it takes three of their 120 clean machines from the unknown ones, whose motors have a ripple of half as much, and
/// none of their strangers.
const SLIGHT: f64 = 0.01;
/// Share of the friction by which every machine's friction wanders in time, along its path and over its travel, and by which no law follows it over
/// speed and after reversals: that is none of its physics left out.
const WANDERS: f64 = 0.05;
/// Share of the friction that an event must be while it lasts: by a tenth, the level of friction on guideways and screws changes from
/// stroke to stroke. It takes two of those clean machines from the unknown ones, too.
const VARIES: f64 = 0.1;
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
    /// The effect that explains it, where that is too doubtful to be named.
    pub like: Option<&'static dyn Effect>,
    /// What it is worth.
    pub evidence: Evidence,
    /// Share of the mismatch that it holds.
    pub size: f64,
    /// What its probability is computed from, where that is fitted.
    pub features: Option<BTreeMap<&'static str, f64>>,
    /// When it happened, where it is an event.
    pub happened: Option<Happened>,
    /// By what share of itself the friction level rises from the beginning to the end, where it is that.
    pub rises_by: Option<f64>,
    /// Where it is.
    pub place: Option<Place>,
    /// Root mean square (N or N·m) of what it takes off the residual on stretches held out: its own force may be far larger.
    pub rms: f64,
    /// It is friction that wanders in time, along its path or over the travel, or departs from its law, by too little to tell it from an error of the law.
    pub wanders: bool,
}

/// When an event was, and the mismatch that shows it.
#[derive(Clone)]
pub struct Happened {
    /// Stretches of time (s).
    pub times: Vec<[f64; 2]>,
    /// Their samples, which say nothing of anything else.
    pub samples: Vec<Range<usize>>,
    /// Time (s) and mismatch (N or N·m) of all rows, these among them.
    pub mismatch: [Vec<f64>; 2],
}

/// The first that is likely there.
pub fn likely(unnamed: &[Unknown]) -> Option<&Unknown> {
    unnamed.iter().find(|u| is_likely(u))
}

/// Whether it is likely there, and more than friction's own variability.
pub fn is_likely(unknown: &Unknown) -> bool {
    unknown.is_sure() && !unknown.wanders
}

impl Unknown {
    /// Whether it is likely there, however small.
    pub fn is_sure(&self) -> bool {
        self.confidence >= LIKELY
    }
}

/// All that are material, largest first, beside an event and a drift, where `extended`, with the names, leaves `left` (%) of the effort's variance, so
/// much of it of noise; `is_doubtful` says whether an effect is suspected only.
pub fn unnamed(
    found: &Found,
    (null, extended): (&NullModel, &Hypothesis),
    [left, noise]: [f64; 2],
    [event, drift]: [Option<Unknown>; 2],
    reports: &[TermReport],
    is_doubtful: impl Fn(&dyn Effect) -> bool,
) -> Vec<Unknown> {
    if left - noise < NOTICEABLE {
        // Nothing takes off more than is left without it: what looks large stands in for what fits as well. An event was taken out before.
        return event.into_iter().collect();
    }
    let takes = |s: &TermReport| {
        let all = [extended.terms.as_slice(), std::slice::from_ref(&s.term)].concat();
        let with = null.fit(&all).map_or(left, |h| h.nmse(&null.rows).test);
        (left - with).max(s.evidence.share * left)
    };
    let is_unnamed = |s: &&TermReport| match s.term.subject {
        // A delay is none of the machine's physics, and a doubtful one mostly the loop's answer to friction that wanders.
        Subject::Effect(effect) => effect.id() != ALWAYS_FREE.id() && is_doubtful(effect),
        Subject::Change(change) => !change.is_plain(),
        Subject::Curve(_) => true,
    };
    let usual = found.null.usual_friction();
    let material = reports
        .iter()
        .filter(is_unnamed)
        .filter(|s| s.size() >= UNNAMED)
        .filter(|s| rms(&found.hypothesis.force_of(s.index)) >= SLIGHT * usual)
        .map(|s| (s, takes(s)))
        .filter(|(_, takes)| *takes >= NOTICEABLE);
    let mut all: Vec<Unknown> = material
        .map(|(s, takes)| unknown(found, s, usual, [takes, left]))
        .collect();
    if drift.is_some() {
        // Once, by what it does.
        all.retain(|u| !(u.odd && u.axis.is_akin(Axis::Time)));
    }
    all.extend(event.into_iter().chain(drift));
    all.sort_by(|a, b| b.size.total_cmp(&a.size));
    all
}

/// What happened at some time and not otherwise.
pub fn happened(found: &Found) -> Option<Unknown> {
    let rows = &found.null.rows;
    let friction = found.null.friction();
    let mismatch = found.hypothesis.held_out_residual(rows);
    let event = event(rows, &friction, &mismatch)?;
    let while_it_lasts = event.stretches.iter().flat_map(|r| &event.force[r.clone()]);
    let size = rms(&while_it_lasts.copied().collect::<Vec<f64>>());
    if size < VARIES * rms(&friction) {
        return None;
    }
    let left = found.hypothesis.nmse(rows).test;
    let reach = (rows.weak.half_width_s / rows.s.dt).ceil() as usize;
    let samples = |r: &Range<usize>| {
        let [first, last] = [r.start, r.end - 1].map(|row| rows.weak.centres[row]);
        let piece = rows.s.pieces.iter().find(|p| p.contains(&first));
        let piece = piece.cloned().unwrap_or(first..last + 1);
        first.saturating_sub(reach).max(piece.start)..(last + reach + 1).min(piece.end)
    };
    let samples: Vec<Range<usize>> = event.stretches.iter().map(samples).collect();
    let time = |s: &Range<usize>| [rows.s.t[s.start], rows.s.t[s.end - 1]];
    let mut times: Vec<[f64; 2]> = samples.iter().map(time).collect();
    times.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let happened = Happened {
        times,
        samples,
        mismatch: [rows.weak.at_centres(&rows.s.t), mismatch],
    };
    (event.share * left >= NOTICEABLE).then(|| Unknown {
        axis: Axis::Time,
        odd: event.odd,
        change: None,
        like: None,
        // Set by hand, no trial has calibrated it, and not said.
        confidence: 1.0 - 0.2 * (event::STANDS_OUT / event.z).powi(2),
        evidence: Evidence {
            share: event.share,
            z: event.z,
            blocks: event.stretches.len() as f64,
            ..Evidence::default()
        },
        size: event.share,
        features: None,
        place: Place::of(rows, Axis::Time, &event.force),
        rms: rows.rms_of(event.share * left),
        wanders: false,
        happened: Some(happened),
        rises_by: None,
    })
}

/// Whether an NMSE (%) that is neither noise nor explained is more than friction that wanders, and so something: whatever it follows.
pub(super) fn is_something(found: &Found, unexplained: f64) -> bool {
    found.null.rows.rms_of(unexplained.max(0.0)) > WANDERS * found.null.usual_friction()
}

/// The one effect of the catalogue that acts over a coordinate, where there is but one.
fn alone_over(axis: Axis) -> Option<&'static dyn Effect> {
    let mut own = effect::ALL.into_iter().filter(|e| e.axis() == axis);
    let one = own.next()?;
    own.next().is_none().then_some(one)
}

/// `usual` is the root mean square of the friction; it takes so much off what is left (%).
fn unknown(found: &Found, report: &TermReport, usual: f64, [takes, left]: [f64; 2]) -> Unknown {
    let rows = &found.null.rows;
    let force = found.hypothesis.force_of(report.index);
    let level = mean(&force);
    let (axis, odd, change) = match report.term.subject {
        Subject::Curve(curve) => (curve.axis, curve.odd, None),
        Subject::Change(change) => (change.axis(), true, Some(change)),
        Subject::Effect(effect) => {
            let direction = rows.weak.at_centres(&rows.s.direction);
            let along: Vec<f64> = force.iter().zip(&direction).map(|(f, d)| f * d).collect();
            let axis = report.form.map_or(effect.axis(), |f| f.0);
            let flips = report.term.is_level(&found.null.scene());
            (axis, flips || mean(&along).abs() > level.abs(), None)
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
        like: (report.term.effect()).or_else(|| alone_over(axis).filter(|_| odd)),
        confidence: presence(report),
        evidence: report.evidence,
        size: takes / left,
        features: Some(features_of_presence(report)),
        happened: None,
        rises_by: None,
        place: Place::of(rows, axis, &varying),
        rms: rows.rms_of(takes),
        wanders: odd && rows.rms_of(takes) <= WANDERS * usual,
    }
}
