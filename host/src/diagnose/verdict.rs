//! From the hypothesis to what is said: names with their confidence, what has no name, and what the recording cannot show.

use super::axis::Axis;
use super::budget::{self, Finding, Item};
use super::candidate::{Candidate, candidates};
use super::channel;
use super::confidence::{self, confidence};
use super::correction::Correction;
use super::credible::{INCREDIBLE, doubt_harmonics, sieved};
use super::drift::drift;
use super::effect::{self, Effect};
use super::fit::Fit;
use super::given::Given;
use super::hysteresis::{self, Shape};
use super::lack::{Lack, lacks};
use super::measured::{Begun, measured};
use super::named::{CERTAIN, EVEN, Name, Named, source};
use super::naming::TermReport;
use super::null_model::{Hypothesis, Nmse, NullModel};
use super::place::Place;
use super::repeats::unrepeated;
use super::reproduced::Reproduced;
use super::search::{Found, WORTH, is_told};
use super::second_position::SecondPosition;
use super::shift::Shift;
use super::simulation::{self, Corrected};
use super::term::{Subject, Term};
use super::unnamed::{Unknown, is_likely, is_something, likely, unnamed};
use preslide_fit::evidence::NAMED;
use preslide_fit::model::Model;
use preslide_fit::recording::Recording;
use preslide_fit::signal::{Channel, Delay};
use preslide_fit::statistics::Estimate;
use std::sync::{Arc, OnceLock};

/// Least confidence of a confident name. Of the names that the calibration knows, each judged by weights fitted without its source, 164 of 171 on real
/// machines and 165 of 196 on made ones are right from here on.
const LIKELY: f64 = 0.6;
/// NMSE (%) on folds held out from which a model explains too little to be called consistent with anything.
pub(super) const EXPLAINS_LITTLE: f64 = 25.0;
/// NMSE (%) beyond what noise explains from which it is not, either. Chosen after looking at a bench that nothing explains (23.6 % left, none
/// of it noise) and at clean recordings of `drives` 1 and 2, which leave 5.6 % at most.
const UNEXPLAINED: f64 = 10.0;
/// The same against a simulation, whose owner knows what is in it: a tenth of the effort. Near-perfect ones leave up to 0.4 % in `cases/twins`,
/// one that lacks a sloshing load 4.3 %.
pub(super) const UNEXPLAINED_OF_A_SIMULATION: f64 = 1.0;
/// NMSE (%) up to which a simulation differs by nothing that has no name: 3 % of the effort's deviation.
const NO_DIFFERENCE: f64 = 0.1;
/// Share of the mismatch from which a correction of the friction is of its shape, whatever its level.
const MOST_OF_IT: f64 = 0.5;
/// Chance below which a candidate that did not enter is at least suspected.
const SUSPECT: f64 = 0.3;
/// Most suspicions beside what entered.
const HINTS: usize = 3;

/// What is said of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing material is missing.
    Consistent,
    /// No physics is missing, but numbers of the user's model are wrong.
    ParametersDiffer,
    /// Effects of the catalogue are missing.
    MissingPhysics,
    /// Something is missing that has no name.
    UnknownPhysics,
    /// The recording does not say.
    InsufficientData,
}

impl Verdict {
    /// Its name in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Consistent => "consistent",
            Verdict::ParametersDiffer => "parameters-differ",
            Verdict::MissingPhysics => "missing-physics",
            Verdict::UnknownPhysics => "unknown-physics",
            Verdict::InsufficientData => "insufficient-data",
        }
    }
}

/// A model to be written.
pub struct Extended {
    /// The model.
    pub model: Model,
    /// Effects that no model file can hold, with the reason.
    pub refused: Vec<String>,
    /// What of the user's model it replaces, each in a clause.
    pub replaces: Vec<String>,
    /// Its friction is a finer hysteresis, with which its other parameters were fitted.
    pub is_on_the_core: bool,
    /// The user's model as it is, since nothing that was found leaves less.
    pub is_as_given: bool,
    /// The recording's friction reverses with the speed, and the model's law cannot.
    pub is_of_another_law: bool,
}

/// Everything found.
pub struct Diagnosis {
    /// In a word.
    pub verdict: Verdict,
    /// The user's model, refitted.
    pub baseline: Nmse,
    /// The user's model as it stands, and with its own parameters refitted.
    pub given_model: Option<Given>,
    /// With the confident effects.
    pub extended: Nmse,
    /// What noise leaves of a perfect model (%), not more than what is left.
    pub noise_floor: f64,
    /// NMSE (%) of what differs from one repeat of a motion to the next beyond noise; `None` where too little was repeated.
    pub unrepeated: Option<f64>,
    /// Confident ones first.
    pub effects: Vec<Named>,
    /// What each missing effect takes off, in turn.
    pub budget: Vec<Item>,
    /// What may be left and has no name, largest first; [`Diagnosis::unknown`] is the one that is stated.
    pub unnamed: Vec<Unknown>,
    /// What the recording lacks.
    pub lacks: Vec<Lack>,
    /// How the baseline's mismatch is organised: free curves, best first.
    pub organised: Vec<Candidate>,
    /// Candidates that did not enter, best first.
    pub rest: Vec<Candidate>,
    /// Number of candidates.
    pub families: usize,
    /// Terms that the user's model already has.
    pub given: usize,
    /// Rows, friction and noise.
    pub null: NullModel,
    /// The hypothesis without and with the confident effects.
    pub states: [Hypothesis; 2],
    /// Measured less modelled effort at the rows (N or N·m), before and after: what the texts have the size of, be it left by another law.
    pub mismatch: [Vec<f64>; 2],
    /// What the user's simulation lacks, where something is stated.
    pub correction: Option<Correction>,
    /// The delay of the effort, where the user's model has one.
    pub allowed: Option<Delay>,
    /// By how much (s) that was late, which is taken off.
    pub simulated_late: Option<f64>,
    /// The model that stands for a simulation which moved by itself.
    pub reproduced: Option<Reproduced>,
    /// What further columns say that measure the position, too.
    pub second_positions: Vec<SecondPosition>,
    /// The fit that every command reports.
    pub fit: Option<Arc<Fit>>,
    /// The user's model.
    pub(super) user: Option<Model>,
    /// What `-o` writes, once it was asked for.
    pub(super) extended_model: OnceLock<Extended>,
    /// Why the fit lets nothing be called consistent.
    pub(super) doubt: Option<String>,
}

impl Diagnosis {
    /// What is left and has no name.
    pub fn unknown(&self) -> Option<&Unknown> {
        likely(&self.unnamed)
    }

    /// What is stated without a name: the largest that follows something, and what happened, which all else is said without.
    pub fn nameless(&self) -> impl Iterator<Item = &Unknown> {
        let (events, others): (Vec<_>, Vec<_>) =
            self.unnamed.iter().partition(|u| u.happened.is_some());
        let first = others.into_iter().find(|u| is_likely(u));
        first.into_iter().chain(events)
    }
}

/// Draws the conclusions on the model of the user's or of the fit's, beside an event that the search was made without.
pub fn conclude(
    mut found: Found,
    event: Option<Unknown>,
    (channel, shift, allowed): (Channel, Option<Shift>, Option<Delay>),
    given: usize,
    mechanics: &[(String, f64)],
    recording: &Recording,
    [user, of_fit]: [Option<&Model>; 2],
) -> Option<Diagnosis> {
    let periods: Vec<f64> = mechanics.iter().map(|m| m.1).collect();
    let (reports, gone) = sieved(&mut found, given, &periods)?;
    let mut effects: Vec<Named> = reports
        .iter()
        .chain(&gone)
        .filter_map(|s| named(&found, s, mechanics))
        .collect();
    doubt_harmonics(&mut effects, found.null.rows.s.travel());
    let kept: Vec<Term> = found.hypothesis.terms[..given].to_vec();
    // The fit's physics, on the core that names are judged on or on its own law, which predicts better where the core fits what happens once.
    let law = of_fit.filter(|_| user.is_none());
    let left = |null: &NullModel, hypothesis: &Hypothesis| {
        let on_the_core = hypothesis.nmse(&null.rows);
        let own = law.and_then(|m| Given::beside(null, &hypothesis.terms, recording, m, None));
        match own.filter(|own| own.refitted.test < on_the_core.test) {
            Some(Given {
                refitted,
                mismatch: [_, mismatch],
                ..
            }) => (refitted, mismatch),
            None => (on_the_core, hypothesis.residual(&null.rows)),
        }
    };
    let begins = |null: &NullModel| {
        let first = null.fit_as_given(&[kept.as_slice(), &found.known.terms].concat())?;
        let (left, mismatch) = left(null, &first);
        Some(Begun {
            left,
            mismatch,
            first,
        })
    };
    let (mut null, mut begun, mut extended) = measured(&found, &kept, begins, &mut effects)?;
    if of_the_simulation(&null, &extended, &mut effects) {
        (null, begun, extended) = measured(&found, &kept, begins, &mut effects)?;
    }
    let Begun {
        first,
        left: mut baseline,
        mismatch: mut before,
    } = begun;
    let given_model = user.and_then(|m| Given::of(&null, &extended, recording, m, allowed));
    // Where all names together leave much of the effort, none of them is sure but a line that stands out of chance by itself.
    let (reached, with_names) = left(&null, &extended);
    if reached.test > EXPLAINS_LITTLE {
        let is_doubtful = |e: &&mut Named| !(e.is_narrow() && e.confidence >= CERTAIN);
        let doubtful = effects.iter_mut().filter(is_doubtful);
        doubtful.for_each(Named::doubt);
    }
    if null.core.corrects {
        // Nothing of a simulation as it is was fitted.
        let given = null.rows.nmse(&null.rows.target);
        baseline = Nmse {
            train: given,
            test: given,
        };
        before.clone_from(&null.rows.target);
        let corrections = simulation::corrections(&null, &extended);
        effects.extend(corrections.into_iter().map(|c| correction(&null, c)));
    }
    let shape = user.and_then(|m| Shape::of(&null, &extended, &m.friction));
    if let Some(shape) = shape.filter(Shape::is_suspect) {
        let [own, core] = shape.nmse;
        if shape.misleads() {
            baseline.test += own - core;
            baseline.train += own - core;
        }
        effects.push(wrong_shape(&null, shape));
    }
    for own in channel::found(&channel, shift, &null, recording) {
        let own = in_the_channel(&null, own);
        let [without, with] = own.nmse_test;
        baseline.test += without - with;
        baseline.train += without - with;
        let recurs = matches!(own.name, Name::Entry(e) if e.card().recurs);
        effects.retain(|e| recurs || e.id() != own.id());
        effects.push(own);
    }
    if let Some(given) = given_model.as_ref().filter(|g| g.stands < baseline.test) {
        // What the model leaves as it stands nothing takes more than, whatever the core leaves that names are judged on.
        let stands = given.stands;
        (baseline.train, baseline.test) = (stands, stands);
        before.clone_from(&given.mismatch[0]);
        let told = effects.iter_mut().flat_map(|e| &mut e.nmse_test);
        told.filter(|n| **n > stands).for_each(|n| *n = stands);
    }
    effects.sort_by(|a, b| {
        (b.is_missing(), b.confident, b.evidence.share)
            .partial_cmp(&(a.is_missing(), a.confident, a.evidence.share))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    hint(&found, &mut effects);
    let is_doubtful = |effect: &dyn Effect| {
        let own = |n: &&Named| matches!(n.name, Name::Entry(e) if e.id() == effect.id());
        effects.iter().find(own).is_some_and(|n| !n.confident)
    };
    let apart = [event, drift(&found)];
    // Where nothing is missing, nothing is added.
    let adds = effects.iter().any(Named::is_missing);
    let stays = given_model.is_some() || !adds;
    let is_as_before = (!adds && null.core.corrects) || (stays && reached.test > baseline.test);
    let (after, with_names) = match is_as_before {
        true => (baseline, before.clone()),
        false => (reached, with_names),
    };
    // The figures' mismatch is what the text has the size of: of a model that is given, as it stands.
    if let Some(given) = given_model.as_ref().filter(|_| !null.core.corrects) {
        before.clone_from(&given.mismatch[0]);
    }
    // What a suspicion predicts on held-out data is no noise, either.
    let weighed = effects.iter().filter(|e| e.term.is_some());
    let left_beside = weighed.map(|e| e.nmse_test[1]);
    let noise_floor = left_beside.fold(null.noise_floor(&extended).min(after.test), f64::min);
    let mut unnamed = unnamed(
        &found,
        (&null, &extended),
        [after.test, noise_floor],
        apart,
        &reports,
        is_doubtful,
    );
    let between_repeats = unrepeated(&null.rows, &extended.residual(&null.rows));
    let unrepeated = between_repeats.map(|square| {
        let rows = &null.rows;
        let all = 100.0 * square * rows.force.len() as f64 / rows.variation().max(1e-300);
        (all - noise_floor).min(after.test - noise_floor).max(0.0)
    });
    let at_random = noise_floor + unrepeated.unwrap_or(0.0);
    // What the wrong ones are worth (%), where any is.
    let differs = given_model.as_ref().and_then(Given::worth);
    let of_a_simulation = |all: fn(&Named) -> bool| {
        null.core.corrects && effects.iter().filter(|e| e.is_missing()).all(all)
    };
    let unexplained = after.test - at_random;
    let leaves_something = match null.core.corrects {
        true => unexplained - null.rows.missed > UNEXPLAINED_OF_A_SIMULATION,
        false => is_something(&found, unexplained),
    };
    let verdict = match verdict(
        effects.iter().any(Named::is_missing),
        likely(&unnamed),
        [after.test, unexplained],
        differs,
        leaves_something,
    ) {
        Verdict::MissingPhysics if of_a_simulation(|e| e.in_simulation) => {
            Verdict::ParametersDiffer
        }
        Verdict::UnknownPhysics if null.core.corrects && after.test <= NO_DIFFERENCE => {
            unnamed.clear();
            Verdict::Consistent
        }
        other => other,
    };
    let lacks = lacks(&null.rows.s, |id| {
        effects.iter().any(|n| n.confident && n.id() == id)
    });
    let organised = {
        let (mut list, _) = candidates(&null, &first, &[]);
        list.retain(|o| matches!(o.term.subject, Subject::Curve(_)) && o.evidence.share > 0.0);
        list
    };
    let missing = effects.iter().enumerate().filter(|(_, e)| e.is_missing());
    let findings: Vec<Finding> = missing
        .map(|(effect, e)| Finding {
            effect,
            term: e.term.as_ref(),
            force: &e.force,
            nmse: e.nmse_test,
        })
        .collect();
    let whole = [baseline.test, after.test];
    let budget = match null.core.corrects {
        true => budget::of_a_simulation(&null, &extended.residual(&null.rows), &findings, whole),
        false => budget::budget(&null, &first.terms, &findings, whole),
    };
    Some(Diagnosis {
        verdict,
        budget,
        baseline,
        given_model,
        extended: after,
        noise_floor,
        unrepeated,
        effects,
        unnamed,
        lacks,
        organised,
        rest: found.rest,
        families: found.families,
        given,
        null,
        states: [first, extended],
        mismatch: [before, with_names],
        correction: None,
        allowed,
        simulated_late: None,
        reproduced: None,
        second_positions: Vec::new(),
        fit: None,
        user: None,
        extended_model: OnceLock::new(),
        doubt: None,
    })
}

fn verdict(
    is_missing: bool,
    unknown: Option<&Unknown>,
    [left, unexplained]: [f64; 2],
    differs: Option<f64>,
    leaves_something: bool,
) -> Verdict {
    if is_missing {
        Verdict::MissingPhysics
    } else if differs.is_some_and(|worth| worth > left) {
        // More than all that is left, with a name or without.
        Verdict::ParametersDiffer
    } else if unknown.is_some() {
        Verdict::UnknownPhysics
    } else if left > EXPLAINS_LITTLE || unexplained > UNEXPLAINED {
        Verdict::InsufficientData
    } else if leaves_something {
        Verdict::UnknownPhysics
    } else if differs.is_some() {
        Verdict::ParametersDiffer
    } else {
        Verdict::Consistent
    }
}

/// An effect of the hypothesis as it is stated; `None` for curves and changes, and for what every recording may have.
fn named(found: &Found, report: &TermReport, mechanics: &[(String, f64)]) -> Option<Named> {
    let effect = report.term.effect()?;
    if report.harmless {
        return None;
    }
    let confidence = confidence(report);
    if effect.id() == effect::ALWAYS_FREE.id() && confidence < INCREDIBLE {
        return None;
    }
    let mut ambiguous = report.ambiguous.clone();
    let equivalents = effect.equivalents(&found.null.rows.s).into_iter();
    for equivalent in equivalents.filter_map(effect::by_id) {
        if !ambiguous.iter().any(|e| e.id() == equivalent.id())
            && equivalent.lacks(&found.null.rows.s).is_none()
        {
            ambiguous.push(equivalent);
        }
    }
    let mut name = Named {
        name: Name::Entry(effect),
        term: Some(report.term.clone()),
        confident: confidence >= LIKELY,
        doubted: false,
        in_fit: found.known.has(&report.term),
        in_simulation: false,
        confidence,
        evidence: report.evidence,
        report: Some(report.clone()),
        nmse_test: [f64::NAN; 2],
        places: Vec::new(),
        force: Vec::new(),
        parameters: Vec::new(),
        source: source(effect, &report.term, mechanics),
        ambiguous,
    };
    let is_told = report.told && is_told(effect, &found.null.rows.s);
    if !(is_told && is_material(report)) {
        name.doubt();
    }
    Some(name)
}

/// Whether what an effect takes off is as much as its force must be.
fn is_material(report: &TermReport) -> bool {
    0.01 * report.size_of_the_name() * report.left >= WORTH * WORTH
}

/// Tells of each effect whether the simulation has it, too; whether one is doubtful for what it says of the simulation's own.
fn of_the_simulation(null: &NullModel, extended: &Hypothesis, effects: &mut [Named]) -> bool {
    if !null.core.corrects {
        return false;
    }
    let mut doubts = false;
    for effect in effects.iter_mut().filter(|e| e.confident) {
        let Some(term) = &effect.term else {
            continue;
        };
        let by_itself = term.effect().and_then(|e| e.in_simulation(&term.shape));
        effect.in_simulation = by_itself.unwrap_or_else(|| {
            let index = extended.terms.iter().position(|t| term.is_near(t));
            index.is_some_and(|i| simulation::has_its_term(null, extended, i))
        });
        let share = effect.evidence.share;
        if by_itself == Some(true) && simulation::is_another_load(null, extended, share) {
            effect.doubt();
            doubts = true;
        }
    }
    doubts
}

fn wrong_shape(null: &NullModel, shape: Shape) -> Named {
    let [_, core] = shape.nmse;
    let confident = shape.is_wrong();
    let factor = shape.displacement_factor();
    Named {
        name: Name::Hysteresis,
        term: None,
        confident,
        doubted: false,
        in_fit: false,
        in_simulation: false,
        confidence: if confident {
            confidence::of_hysteresis(shape.shorter.1, core)
        } else {
            confidence::of_a_hint(None)
        },
        evidence: shape.evidence,
        report: None,
        nmse_test: shape.nmse,
        places: Place::all(&null.rows, Axis::SinceReversal, &shape.force),
        force: shape.force,
        parameters: factor
            .map(|value| {
                (
                    hysteresis::DISPLACEMENT_FACTOR.to_owned(),
                    Estimate { value, ci95: None },
                )
            })
            .into_iter()
            .collect(),
        source: None,
        // A gap and a spring make it softer, not stiffer.
        ambiguous: match factor {
            Some(_) => Vec::new(),
            None => hysteresis::rivals(&null.rows.s),
        },
    }
}

/// What lies between the machine and the recorded effort, as it is stated.
fn in_the_channel(null: &NullModel, own: channel::Found) -> Named {
    Named {
        name: Name::Entry(own.effect),
        term: None,
        confident: own.confident,
        doubted: false,
        in_fit: false,
        in_simulation: false,
        confidence: confidence::of_evidence(&own.evidence),
        evidence: own.evidence,
        report: None,
        nmse_test: own.nmse,
        places: Place::all(&null.rows, own.effect.axis(), &own.force),
        force: own.force,
        parameters: own.parameters,
        source: None,
        ambiguous: Vec::new(),
    }
}

fn correction(null: &NullModel, corrected: Corrected) -> Named {
    let sure = confidence::of_evidence(&corrected.evidence);
    let holds_zero = |[low, high]: [f64; 2]| low <= 0.0 && 0.0 <= high;
    // A friction of another shape may have the same level.
    let is_shape = corrected.evidence.share >= MOST_OF_IT;
    let doubtful = corrected.parameter.1.ci95.is_some_and(holds_zero) && !is_shape;
    Named {
        name: Name::Correction(corrected.what),
        term: None,
        confident: !doubtful,
        doubted: false,
        in_fit: false,
        in_simulation: corrected.in_simulation,
        confidence: if doubtful { sure.min(EVEN) } else { sure },
        evidence: corrected.evidence,
        report: None,
        nmse_test: corrected.nmse,
        places: Place::all(&null.rows, corrected.what.axis(), &corrected.force),
        force: corrected.force,
        parameters: vec![corrected.parameter],
        source: None,
        ambiguous: Vec::new(),
    }
}

/// Adds effects that nearly entered, as suspicions.
fn hint(found: &Found, effects: &mut Vec<Named>) {
    let near = found
        .rest
        .iter()
        .filter(|o| o.evidence.share >= 0.5 * NAMED && o.chance(found.families) < SUSPECT);
    for candidate in near.take(HINTS) {
        let Some(effect) = candidate.term.effect() else {
            continue;
        };
        if effect.is_harmless(&found.null.scene(), &candidate.trial.coefficients) {
            continue;
        }
        effects.push(Named {
            name: Name::Entry(effect),
            term: Some(candidate.term.clone()),
            confident: false,
            doubted: false,
            in_fit: false,
            in_simulation: false,
            confidence: confidence::of_a_hint(Some(&candidate.evidence)),
            evidence: candidate.evidence,
            report: None,
            nmse_test: [f64::NAN; 2],
            places: Vec::new(),
            force: Vec::new(),
            parameters: Vec::new(),
            source: None,
            ambiguous: Vec::new(),
        });
    }
}
