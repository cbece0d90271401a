//! The search: windows, starts, and the physics that makes windows smaller that it was not fitted to.

use super::beside::Beside;
use super::body::Body;
use super::descent::{self, Valley, descend};
use super::terms::{GROUPS, RIGID, Sizes, Term};
use super::window::{AS_IT_IS, Drive, Driven, Window};
use super::{Apart, MotionFit, Tried};
use crate::progress::Progress;
use crate::recording::{MotionKind, Recording};
use crate::statistics::quantile;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::ops::Range;

/// Starts of the descent: the fit of the force, and others around it.
const STARTS: usize = 6;
/// What scatters them.
pub(super) const SEED: u64 = 1;
/// Draws of a start until it is a machine that can be.
const DRAWS: usize = 1000;
/// Starts end as low where the worst of their losses is within this share of the best.
const AS_LOW: f64 = 0.1;
/// Starts agree where no parameter ends further apart than this, in its scale: a fiftieth of the machine's own size for it.
const AGREE: f64 = 0.2;
/// Into so many parts pieces are cut at most, and so short a window may become: samples, and times of `M/b`, in which a motion forgets its start
/// to a twentieth.
const MOST_PARTS: usize = 64;
const FORGOTTEN: f64 = 3.0;
const SHORTEST: usize = 100;
/// Parts of every piece that are left out in turn.
const FOLDS: usize = 4;
/// Most rounds through what may be taken.
pub(super) const ROUNDS: usize = 3;
/// An error of this share of the travel is not looked into: the steps of simulations bring some of it.
const MATERIAL: f64 = 1e-3;
/// Physics must take this share off the loss of windows that it was not fitted to.
const WORTH: f64 = 0.02;
/// Positions that are compared; a longer recording is thinned to as many.
pub(super) const COMPARED: usize = 4_000;
/// Change of the position on halving the step, relative to the travel, that is small enough, and the most steps to a sample or tick.
const SETTLED: f64 = 3e-4;
const MOST_STEPS: u32 = 16;

/// Pieces long enough to be simulated.
pub(super) fn long_pieces(recording: &Recording) -> Vec<Range<usize>> {
    let pieces = recording.pieces.iter();
    pieces.filter(|p| p.len() >= SHORTEST).cloned().collect()
}

/// A recording, how it is simulated, and the machine's sizes.
pub(super) struct Search<'a> {
    pub(super) driven: Driven<'a>,
    pub(super) sizes: Sizes,
    pub(super) pieces: Vec<Range<usize>>,
    pub(super) steps: u32,
    pub(super) every: usize,
}

/// Where a search stands: a body and which of its terms are free.
#[derive(Clone)]
pub(super) struct Point {
    pub(super) body: Body,
    pub(super) terms: Vec<Term>,
}

impl Point {
    /// With a group, where it begins.
    fn with(&self, group: &[Term], sizes: &Sizes) -> Self {
        let mut point = self.clone();
        for term in group {
            term.set(&mut point.body, term.beginning(sizes));
            point.terms.push(*term);
        }
        // Of gravity a short motion shows the spring: the one stands for the other.
        if group.contains(&Term::Sine) {
            point.body.sine = std::mem::take(&mut point.body.spring);
            point.terms.retain(|term| *term != Term::Spring);
        }
        point
    }

    /// The free terms, in their scales.
    pub(super) fn shares(&self, sizes: &Sizes) -> Vec<f64> {
        let one = |term: &Term| term.of(&self.body) / term.scale(sizes);
        self.terms.iter().map(one).collect()
    }

    /// At other values of the free terms; `None` where no machine is.
    pub(super) fn at(&self, shares: &[f64], sizes: &Sizes) -> Option<Self> {
        let mut point = self.clone();
        for (term, share) in self.terms.iter().zip(shares) {
            term.set(&mut point.body, share * term.scale(sizes));
        }
        point.body.is_possible().then_some(point)
    }
}

/// What the best of several starts found, through which windows, with what counts as rough.
pub(super) struct Settled {
    pub(super) point: Point,
    pub(super) windows: Vec<Window>,
    pub(super) parts: usize,
    rough: f64,
    pub(super) losses: Vec<f64>,
    /// Widest distance between the ends of two starts, in a parameter's scale.
    apart: f64,
}

impl Settled {
    /// All starts ended as low.
    fn is_as_good(&self) -> bool {
        let ends = self.losses.first().zip(self.losses.last());
        ends.is_some_and(|(best, worst)| *worst <= (1.0 + AS_LOW) * best)
    }

    /// All starts ended at one place.
    pub(super) fn agrees(&self) -> bool {
        self.apart <= AGREE
    }
}

impl Search<'_> {
    pub(super) fn run(
        mut self,
        body: Body,
        beside: Beside,
        progress: &Progress,
    ) -> Result<MotionFit, String> {
        let name = &self.driven.recording.name;
        if self.pieces.is_empty() {
            return Err(format!(
                "{name}: no {SHORTEST} samples follow one another without a gap; record without gaps"
            ));
        }
        let mut terms = RIGID.to_vec();
        let plain = [Term::Slant, Term::Spring, Term::Sine, Term::Cosine];
        terms.extend(plain.iter().filter(|term| term.of(&body) != 0.0));
        let first = Point { body, terms };
        self.steps = self.settled_steps(&first.body);
        progress.set_message("motion: the windows");
        let mut settled = self.settle(&first, Settled::is_as_good)?;
        progress.inc(1);
        let mut tried: Vec<Tried> = Vec::new();
        let mut left = self.loss_across(&settled.point, &settled);
        // What was left may show once something else is taken.
        for _ in 0..ROUNDS {
            let before = settled.point.terms.len();
            let loss = settled.losses.first().copied().unwrap_or(0.0);
            if loss < MATERIAL * self.travel() {
                break;
            }
            for (id, group) in GROUPS {
                progress.set_message(format!("motion: {id}"));
                if self.is_open(&settled.point, group) {
                    let (found, next) = self.tried(&settled, left, id, group);
                    tried.retain(|t| t.id != id);
                    tried.push(found);
                    if let Some(next) = next {
                        left = self.loss_across(&next.point, &next);
                        settled = next;
                    }
                }
                progress.inc(1);
            }
            if settled.point.terms.len() == before {
                break;
            }
        }
        progress.set_message("motion: held out");
        let settled = self.settle(&settled.point, Settled::agrees)?;
        let folds = self.folds(settled.parts);
        let held_out = self.across(&settled.point, &folds, settled.rough);
        let held_out = held_out.map(|errors| Apart::of(&errors));
        progress.inc(1);
        Ok(self.told(&first, settled, tried, held_out, beside))
    }

    /// Whether a group can come in.
    fn is_open(&self, point: &Point, group: &[Term]) -> bool {
        let has = |term: Term| point.terms.contains(&term);
        let is_sensible = match group[0] {
            Term::Sine => self.driven.place.kind == MotionKind::Rotary,
            Term::Spring => !has(Term::Sine),
            _ => true,
        };
        is_sensible && !has(group[0])
    }

    /// Length (m or rad) of the travel.
    fn travel(&self) -> f64 {
        self.sizes.place.travel[1] - self.sizes.place.travel[0]
    }

    /// Steps to a sample (a tick) with which the simulation of a body through the shortest windows no longer changes.
    fn settled_steps(&self, body: &Body) -> u32 {
        let travel = self.travel();
        let windows = self
            .driven
            .windows(&self.pieces, self.lengths().last().unwrap_or(1));
        let motion = |steps: u32| -> Vec<f64> {
            let one = |w: &Window| self.driven.simulate(body, w, steps, AS_IT_IS);
            windows.iter().flat_map(one).collect()
        };
        let mut steps = 1;
        let mut now = motion(steps);
        while steps < MOST_STEPS {
            let finer = motion(2 * steps);
            let apart = now.iter().zip(&finer).map(|(a, b)| (a - b).abs());
            if apart.fold(0.0, f64::max) <= SETTLED * travel {
                break;
            }
            (steps, now) = (2 * steps, finer);
        }
        steps
    }

    pub(super) fn errors(&self, point: &Point, windows: &[Window]) -> Vec<f64> {
        let body = &point.body;
        self.driven.errors(body, windows, self.steps, self.every)
    }

    fn descend(&self, from: &Point, windows: &[Window], rough: f64) -> Option<(Point, f64)> {
        let errors = |shares: &[f64]| {
            let point = from.at(shares, &self.sizes)?;
            let errors = self.errors(&point, windows);
            errors.iter().all(|e| e.is_finite()).then_some(errors)
        };
        let Valley { at, loss } = descend(from.shares(&self.sizes), rough, &errors)?;
        Some((from.at(&at, &self.sizes)?, loss))
    }

    /// The size of a typical error, beyond which errors are rough.
    pub(super) fn rough(&self, point: &Point, windows: &[Window]) -> f64 {
        let mut errors = self.errors(point, windows);
        errors.iter_mut().for_each(|e| *e = e.abs());
        let travel = self.travel();
        let typical = quantile(&mut errors, 0.5).unwrap_or(travel);
        typical.clamp(1e-6 * travel, travel)
    }

    /// The fit through the longest windows in which the starts around a point are as one; where they are in none, through the shortest. What
    /// disturbs a machine adds up in a long window, until parameters make up for one another and the start decides between them.
    fn settle(&self, from: &Point, as_one: fn(&Settled) -> bool) -> Result<Settled, String> {
        let mut found = None;
        for parts in self.lengths() {
            found = self.through(from, parts);
            if found.as_ref().is_some_and(as_one) {
                break;
            }
        }
        found.ok_or_else(|| {
            format!(
                "{}: the simulation with the fit of the force runs away; check gains, units and the sign of the effort",
                self.driven.recording.name
            )
        })
    }

    /// Into so many parts pieces are cut: none shorter than the machine needs to forget where it began, and whole in a loop, which lets nothing
    /// add up.
    pub(super) fn lengths(&self) -> impl Iterator<Item = usize> {
        let seconds = FORGOTTEN * self.sizes.forgets_s;
        let samples = seconds / self.driven.recording.sample_time_s();
        let shortest = self.pieces.iter().map(ExactSizeIterator::len).min();
        let most = match self.driven.drive {
            Drive::Loop { .. } => 1,
            Drive::Open => shortest.unwrap_or(0) / (samples as usize).max(SHORTEST),
        };
        std::iter::successors(Some(1), |parts| Some(2 * parts))
            .take_while(move |parts| *parts <= most.clamp(1, MOST_PARTS))
    }

    /// The best of several starts around a point, through windows of `1/parts` of the pieces; `None` where no simulation comes to an end.
    fn through(&self, from: &Point, parts: usize) -> Option<Settled> {
        let windows = self.driven.windows(&self.pieces, parts);
        // From far away every window is rough: the first descent finds what is typical.
        let (near, _) = self.descend(from, &windows, self.rough(from, &windows))?;
        let rough = self.rough(&near, &windows);
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let mut ends = Vec::new();
        for start in 0..STARTS {
            let from = match start {
                0 => Some(near.clone()),
                _ => self.beside(&near, &mut random),
            };
            ends.extend(from.and_then(|from| self.descend(&from, &windows, rough)));
        }
        ends.sort_by(|a, b| a.1.total_cmp(&b.1));
        let losses = ends.iter().map(|end| end.1).collect();
        let places: Vec<Vec<f64>> = ends.iter().map(|e| e.0.shares(&self.sizes)).collect();
        let apart = (0..from.terms.len()).map(|j| {
            let (low, high) = places
                .iter()
                .map(|place| place[j])
                .fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
            high - low
        });
        let apart = apart.fold(0.0, f64::max);
        let (point, _) = ends.into_iter().next()?;
        Some(Settled {
            point,
            windows,
            parts,
            rough,
            losses,
            apart,
        })
    }

    /// A machine somewhere around a point.
    fn beside(&self, point: &Point, random: &mut ChaCha8Rng) -> Option<Point> {
        let scattered = std::iter::repeat_with(|| {
            let shares = point.shares(&self.sizes).into_iter();
            let shares: Vec<f64> = shares.map(|s| s + random.random_range(-1.0..1.0)).collect();
            point.at(&shares, &self.sizes)
        });
        scattered.take(DRAWS).find_map(|found| found)
    }

    /// For each fold the windows to fit and those to judge: of every piece a part is left out in turn, and what is left on both sides of it is
    /// cut into windows no longer than the pieces' own.
    fn folds(&self, parts: usize) -> Vec<[Vec<Window>; 2]> {
        let of = |fold: usize| {
            let mut windows = [Vec::new(), Vec::new()];
            for piece in &self.pieces {
                let cut = |k: usize| piece.start + k * piece.len() / FOLDS;
                let (from, to) = (cut(fold), cut(fold + 1));
                windows[1].push(self.driven.window(from..to));
                for side in [piece.start..from, to..piece.end] {
                    if side.len() >= SHORTEST.min(piece.len() / FOLDS) {
                        let own = (side.len() * parts).div_ceil(piece.len()).max(1);
                        windows[0].extend(self.driven.windows(&[side], own));
                    }
                }
            }
            windows
        };
        (0..FOLDS).map(of).collect()
    }

    /// What is left of each fold by the fit of the others; `None` where one of them cannot be fitted.
    fn across(&self, from: &Point, folds: &[[Vec<Window>; 2]], rough: f64) -> Option<Vec<f64>> {
        let mut errors = Vec::new();
        for [own, other] in folds {
            let (point, _) = self.descend(from, own, rough)?;
            errors.extend(self.errors(&point, other));
        }
        errors.iter().all(|e| e.is_finite()).then_some(errors)
    }

    /// The loss of each fold by the fit of the others, with a point's physics through the windows of a fit.
    fn loss_across(&self, point: &Point, settled: &Settled) -> Option<f64> {
        let folds = self.folds(settled.parts);
        let errors = self.across(point, &folds, settled.rough)?;
        Some(descent::loss_of(&errors, settled.rough))
    }

    /// Whether a group makes windows smaller that it was not fitted to, of which the fit so far leaves `left`, and the fit with it, whose starts must end as low.
    fn tried(
        &self,
        settled: &Settled,
        left: Option<f64>,
        id: &'static str,
        group: &[Term],
    ) -> (Tried, Option<Settled>) {
        let with = settled.point.with(group, &self.sizes);
        let loss = |point: &Point| self.loss_across(point, settled);
        let change = left.and_then(|left| Some(loss(&with)? / left - 1.0));
        let change = change.unwrap_or(0.0);
        let next = (change < -WORTH).then(|| self.through(&with, settled.parts));
        let next = next.flatten().filter(Settled::is_as_good);
        let taken = next.is_some();
        (Tried { id, change, taken }, next)
    }
}
