//! Which effects act: forward, swap and backward, with thresholds from the recording's own noise.

use super::catalogue::TESTED;
use super::columns::{ASIDE, parameters, shapes};
use super::score::{Gain, beyond};
use super::shape::{polished, refine, sharpened};
use super::signature::{self, Axis, signatures};
use super::spectra;
use super::study::{State, Study, Term};
use crate::progress::Progress;
use rayon::prelude::*;

/// Most effects named in one recording.
const MOST: usize = 6;
/// Nats that a name must bring in any case: odds of 150 to 1 on the folds held out.
const LEAST: f64 = 5.0;
/// A term that takes off more than this share of the mismatch changes what the others act through.
const LARGE: f64 = 0.1;
/// Standard errors by which the plain held-out error must fall: nats alone trust the noise model, and what no parallel blocks
/// follow of a real hysteresis is not in it.
const PLAIN: f64 = 2.0;
/// Nats beyond which fewer standard errors will do: an effect may be plain to a fit and small beside the friction's wandering.
pub const EVIDENT: f64 = 100.0;
/// Largest level of a Stribeck curve: static friction three times the sliding one.
const STEEPEST: f64 = 2.0;
/// Share of its nats by which an effect must beat a simpler one that it contains.
const NESTED: f64 = 0.03;
/// Share of its nats by which an asymmetry must beat a constant force.
const ALIKE: f64 = 0.15;
/// How often a term may give way to one that takes its sign.
const REPLACED: usize = 3;
/// Share of a larger effect's nats below which an effect may be what the other's form leaves.
const SMALL: f64 = 0.35;
/// Nats by which a rival must be better to take a term's place.
const BETTER: f64 = 3.0;

/// Share of the moving samples below the speed at which the rows must still resolve a line of position.
const SLOW: f64 = 0.2;

/// Whether an improvement is plain enough for its nats.
fn is_plain(certainty: f64, nats: f64) -> bool {
    certainty > PLAIN * (EVIDENT / nats.max(EVIDENT))
}

/// The best shape of an effect, what it would add, and what noise alone adds.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The effect.
    pub term: Term,
    /// What it adds.
    pub gain: Gain,
    /// Nats that noise alone does not reach.
    pub threshold: f64,
}

impl Candidate {
    /// Nats above what noise would give.
    pub fn excess(&self) -> f64 {
        self.gain.total() - self.threshold
    }

    /// Nats that count against rivals: an effect that contains a simpler one has to be clearly better.
    fn rank(&self) -> f64 {
        let handicap = match self.term.id {
            "frictional_lag" | "position_force" | "quadratic_drag" => {
                5.0 + NESTED * self.gain.total()
            }
            // No fit tells it from a constant force; that is the simpler of the two.
            "coulomb_asymmetry" => 5.0 + ALIKE * self.gain.total(),
            _ => 0.0,
        };
        self.excess() - handicap
    }
}

/// Best first; the leaders refined, because the grids of two effects are not equally fine.
fn lead(study: &Study, without: &State, list: &mut [Candidate]) {
    let best = list.first().map_or(0.0, |c| c.gain.total());
    list.par_iter_mut().take(4).for_each(|c| {
        if c.gain.total() > 0.6 * best && !parameters(c.term.id).is_empty() {
            let term = refine(study, without, &c.term);
            if let Some(gain) = study.gain(without, &term) {
                (c.term, c.gain) = (term, gain);
            }
        }
    });
    list.sort_by(|a, b| b.rank().total_cmp(&a.rank()));
}

/// Whether a gain is spread over the folds: a mean above twice its standard error, or nine folds in ten.
pub fn consistent(by_fold: &[f64]) -> bool {
    let n = by_fold.len() as f64;
    let mean = by_fold.iter().sum::<f64>() / n;
    let variance = by_fold.iter().map(|g| (g - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let positive = by_fold.iter().filter(|g| **g > 0.0).count() as f64;
    mean > 2.0 * (variance / n).sqrt() || positive >= 0.9 * n
}

/// Whether coefficients have the sign, or the value, that the physics has.
pub fn physical(id: &str, coefficients: &[f64]) -> bool {
    match (id, coefficients) {
        (
            "viscous" | "quadratic_drag" | "dwell_aging" | "drive_compliance" | "position_spring"
            | "creep" | "actuator_dead_zone",
            [c],
        ) => *c > 0.0,
        // Its centre lies within the travel's middle.
        ("position_spring", [stiffness, aside]) => *stiffness > aside.abs(),
        // Beyond it the falling curve and a viscous force cancel each other over the speeds recorded.
        ("stribeck" | "frictional_lag", [c]) => (0.0..STEEPEST).contains(c),
        // Friction does not push.
        ("local_friction_spot", [c]) => *c > -1.0,
        ("backlash", [c]) => (0.4..1.6).contains(c),
        // All that is commanded above the limit is lost.
        ("actuator_saturation", [c]) => (0.7..1.3).contains(c),
        _ => true,
    }
}

/// Whether the coefficients of term `index` have the sign, or the value, that the physics has.
pub fn is_physical(state: &State, index: usize) -> bool {
    physical(
        state.terms[index].id,
        &state.fit.coefficients[state.places[index].clone()],
    )
}

/// The best candidate of every effect, best first.
pub fn scan(study: &Study, state: &State, periods: &[f64]) -> Vec<Candidate> {
    let mut tried: Vec<(Term, f64)> = Vec::new();
    for entry in &TESTED {
        let present = state.terms.iter().any(|t| {
            let ids = [t.id, entry.id];
            t.id == entry.id || (ids.contains(&"stribeck") && ids.contains(&"frictional_lag"))
        });
        let repeatable = matches!(
            entry.id,
            "periodic_force" | "periodic_friction" | "external_vibration" | "local_friction_spot"
        );
        if !present || repeatable {
            let shapes = shapes(entry.id, study);
            tried.extend(shapes.iter().map(|s| (Term::new(entry.id, s), 0.0)));
        }
    }
    tried.extend(lines(study, state, periods));
    let gains: Vec<(Term, f64, Gain)> = tried
        .into_par_iter()
        .filter_map(|(term, tries)| {
            let gain = study.gain(state, &term)?;
            physical(term.id, &gain.coefficients).then_some((term, tries, gain))
        })
        .collect();
    let mut best: Vec<Candidate> = Vec::new();
    for entry in &TESTED {
        let own: Vec<_> = gains.iter().filter(|g| g.0.id == entry.id).collect();
        let Some(top) = own
            .iter()
            .max_by(|a, b| a.2.total().total_cmp(&b.2.total()))
        else {
            continue;
        };
        let draws = top.2.null.len();
        let maxima: Vec<f64> = (0..draws)
            .map(|d| {
                own.iter()
                    .map(|g| g.2.null[d])
                    .fold(f64::NEG_INFINITY, f64::max)
            })
            .collect();
        best.push(Candidate {
            term: top.0.clone(),
            gain: top.2.clone(),
            // Lines are looked for among `tries` frequencies, which the draws did not do.
            threshold: beyond(&maxima).max(LEAST) + top.1.max(1.0).ln(),
        });
    }
    best.sort_by(|a, b| b.excess().total_cmp(&a.excess()));
    best
}

/// Lines of the mismatch in position and in time, and the periods of the mechanics, with the frequencies tried for them.
fn lines(study: &Study, state: &State, periods: &[f64]) -> Vec<(Term, f64)> {
    let s = &study.s;
    let x = study.weak.at_centres(&s.x);
    let t = study.weak.at_centres(&s.t);
    let (travel, slow) = (s.travel(), s.moving_speed(SLOW).max(1e-300));
    let row_s = study.weak.half_width_s;
    let finest = 0.5 / (row_s * slow);
    let lowest = 1.5 / travel;
    let (weights, by_friction) = study.weighed_residual(state);
    let mut found = Vec::new();
    let tries = (finest / lowest).max(1.0);
    let duration = t.last().copied().unwrap_or(0.0) - t.first().copied().unwrap_or(0.0);
    // Slower than ten periods in the recording is drift, or the motion itself.
    let (in_time, highest) = (20.0 / duration, 0.45 / row_s);
    let ((force, level), time) = rayon::join(
        || {
            rayon::join(
                || spectra::lines(&x, &weights, lowest, finest),
                || spectra::lines(&x, &by_friction, lowest, finest),
            )
        },
        || spectra::lines(&t, &weights, in_time, highest),
    );
    for nu in &force {
        found.push((Term::new("periodic_force", &[1.0 / nu]), tries));
        found.push((Term::new("encoder_error", &[1.0 / nu]), tries));
    }
    for nu in &level {
        found.push((Term::new("periodic_friction", &[1.0 / nu]), tries));
    }
    for &p in periods.iter().filter(|p| **p < travel / 1.5) {
        for p in [p, p / 2.0] {
            for id in ["periodic_force", "periodic_friction", "encoder_error"] {
                found.push((Term::new(id, &[p]), 1.0));
            }
        }
    }
    for f in &time {
        found.push((
            Term::new("external_vibration", &[*f]),
            (highest * duration).max(1.0),
        ));
    }
    found
}

/// A constant beside a spring or a map of force is the spring's centre or the map's mean, unless it is large beside them.
fn folded(study: &Study, state: State, given: usize) -> Option<State> {
    let mut terms = state.terms.clone();
    let place = |id: &str| (given..terms.len()).find(|&i| state.terms[i].id == id);
    let coefficients = |i: usize| &state.fit.coefficients[state.places[i].clone()];
    let Some(constant) = place("constant_force") else {
        return Some(state);
    };
    let size = coefficients(constant).first().map_or(0.0, |c| c.abs());
    let travel = study.s.travel();
    let spring = place("position_spring").filter(|&i| {
        coefficients(i)
            .first()
            .is_some_and(|k| size < ASIDE * travel * k)
    });
    let map = place("position_force")
        .filter(|&i| size < coefficients(i).iter().map(|c| c.abs()).sum::<f64>());
    let Some(host) = spring.or(map) else {
        return Some(state);
    };
    terms[host].shape.push(1.0);
    terms.remove(constant);
    study.fit_with(&terms, state.noise.clone())
}

/// What the search found.
pub struct Found {
    /// The hypothesis with everything that passed its threshold.
    pub state: State,
    /// The hypothesis without any of it.
    pub first: State,
    /// For each term that is not given: its evidence and its rivals', best first.
    pub evidence: Vec<Evidence>,
    /// What was left when the search ended, best first.
    pub rest: Vec<Candidate>,
}

/// Why one effect is named and not another.
pub struct Evidence {
    /// The effect, its nats given everything else.
    pub candidate: Candidate,
    /// Every other effect in its place, best first.
    pub rivals: Vec<Candidate>,
    /// A free curve over some coordinate explains it better, or it is what another effect's form leaves.
    pub outdone: bool,
    /// Standard errors by which the plain held-out error falls.
    pub certainty: f64,
    /// The coordinate over which its size changes, which the catalogue's effect does not do.
    pub malformed: Option<Axis>,
}

/// Searches from the given terms.
pub fn search(
    study: &mut Study,
    given: &[Term],
    periods: &[f64],
    progress: &Progress,
) -> Option<Found> {
    let mut state = study.fit(given, None)?;
    let mut rest = scan(study, &state, periods);
    progress.inc(1);
    let mut slight: Vec<Candidate> = Vec::new();
    let mut replaced = 0;
    while state.terms.len() < given.len() + MOST {
        rest.retain(|c| c.excess() > 0.0 && !slight.iter().any(|s| s.term.id == c.term.id));
        lead(study, &state, &mut rest);
        let Some(top) = rest.first().cloned() else {
            break;
        };
        let (term, nats) = (top.term.clone(), top.gain.total());
        let terms: Vec<Term> = state.terms.iter().cloned().chain([term]).collect();
        let Some(next) = study.fit(&terms, Some(&state)) else {
            break;
        };
        let (share, certainty) = study.improvement(&state, &next);
        // A term that takes on a sign against its physics beside another only cancels it within the motion recorded.
        let cancelled: Vec<usize> = (0..state.terms.len())
            .filter(|&i| is_physical(&state, i) && !is_physical(&next, i))
            .collect();
        let gives_way = cancelled.iter().all(|i| *i >= given.len()) && replaced < REPLACED;
        if !is_plain(certainty, nats) || !cancelled.is_empty() && !gives_way {
            slight.push(top);
            continue;
        }
        state = next;
        for &i in cancelled.iter().rev() {
            replaced += 1;
            state = study.without(&state, i)?;
        }
        let terms = state.terms.clone();
        if share > LARGE {
            study.refer_to(&terms)?;
            state = sharpened(study, study.fit(&terms, None)?, given.len())?;
        }
        progress.inc(1);
        rest = scan(study, &state, periods);
    }
    rest.extend(slight);
    let state = folded(study, state, given.len())?;
    let state = polished(study, state, given.len())?;
    let (state, evidence) = weigh(study, state, given.len(), periods, progress)?;
    let first = study.fit_with(given, state.noise.clone())?;
    Some(Found {
        state,
        first,
        evidence,
        rest,
    })
}

/// Swap and backward: each effect once more against all others in its place.
fn weigh(
    study: &Study,
    mut state: State,
    given: usize,
    periods: &[f64],
    progress: &Progress,
) -> Option<(State, Vec<Evidence>)> {
    let mut evidence = Vec::new();
    let mut index = given;
    let mut swaps = 0;
    while index < state.terms.len() {
        let term = state.terms[index].clone();
        let without = study.without(&state, index)?;
        let mut rivals = scan(study, &without, periods);
        let threshold = rivals
            .iter()
            .find(|c| c.term.id == term.id)
            .map_or(LEAST, |c| c.threshold);
        let own = study.gain(&without, &term).map(|gain| Candidate {
            term: term.clone(),
            gain,
            threshold,
        });
        let Some(own) = own.filter(|own| own.excess() > 0.0) else {
            state = without;
            evidence.clear();
            index = given;
            continue;
        };
        rivals.retain(|c| c.term.id != term.id);
        lead(study, &without, &mut rivals);
        if let Some(better) = rivals.first().filter(|c| c.rank() > own.rank() + BETTER)
            && swaps < 3
        {
            swaps += 1;
            let mut terms = state.terms.clone();
            terms[index] = better.term.clone();
            state = study.fit_with(&terms, state.noise.clone())?;
            evidence.clear();
            index = given;
            continue;
        }
        let own_nats = own.gain.total();
        let (_, certainty) = study.improvement(&without, &state);
        if !is_plain(certainty, own.gain.total()) {
            state = without;
            evidence.clear();
            index = given;
            continue;
        }
        let curves = signatures(study, &without);
        evidence.push(Evidence {
            outdone: signature::outdone(study, &state, &own, &curves),
            candidate: own,
            rivals,
            certainty,
            malformed: signature::malformed(study, &state, index, own_nats),
        });
        index += 1;
        progress.inc(1);
    }
    let nats: Vec<f64> = evidence.iter().map(|e| e.candidate.gain.total()).collect();
    for (index, own) in evidence.iter_mut().enumerate() {
        let largest = (0..nats.len()).max_by(|a, b| nats[*a].total_cmp(&nats[*b]))?;
        if nats[index] < SMALL * nats[largest] {
            let without = study.without(&state, given + index)?;
            let larger = state.terms[given + largest].id;
            own.outdone |= signature::remainder(study, &without, &own.candidate, larger);
        }
    }
    Some((state, evidence))
}
