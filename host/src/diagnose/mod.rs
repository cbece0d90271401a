//! What a model left out of a recording: located, named, modelled and shown on stretches that no fit saw.
//!
//! The stages, each immutable once made: [`rows`] (which instants count) → [`mod@core`] and noise in [`null_model`] (what every
//! hypothesis stands on) → [`candidate`] (every candidate on top of one) → [`search`] (which of them the recording asks for) →
//! [`naming`] and [`confidence`] (what each may be called) → [`verdict`], and `unnamed` (what has no name). The catalogue is [`effect`], one file each.

mod account;
mod advice;
pub mod axis;
mod blocks;
mod budget;
pub mod candidate;
pub mod change;
mod channel;
pub mod column;
pub mod confidence;
pub mod core;
pub mod correction;
mod credible;
pub mod curve;
mod drift;
pub mod effect;
mod event;
mod exogenous;
pub mod experiment;
pub mod expr;
mod extend;
pub mod fit;
pub mod given;
mod hysteresis;
pub mod lack;
mod late;
mod measured;
mod merge;
mod modelled;
pub mod named;
pub mod naming;
mod noise;
pub mod normal;
pub mod null_model;
mod page;
mod parameters;
pub mod place;
mod placebo;
mod polish;
mod present;
mod repeats;
mod reproduced;
pub mod rows;
pub mod search;
pub mod second_position;
pub mod shift;
pub mod signals;
mod simulated;
pub mod simulation;
mod smooth;
pub mod term;
#[cfg(test)]
mod tests;
mod unnamed;
pub mod verdict;
pub mod weak;
pub mod words;

use correction::Correction;
use effect::VIBRATION;
use fit::Fit;
use late::lateness;
use named::Named;
use null_model::NullModel;
use preslide_fit::effects::form;
use preslide_fit::identify::tells_nothing;
use preslide_fit::model::Model;
use preslide_fit::progress::Progress;
use preslide_fit::recording::{Recording, Simulated};
use preslide_fit::signal::{Channel, Kinematics, Saturation, StickSlip, Vibration, unknown_starts};
use preslide_fit::statistics::earlier;
use reproduced::Reproduced;
use rows::Rows;
use shift::Shift;
use signals::Signals;
use std::ops::Range;
use std::sync::Arc;
use term::{Subject, Term};
use thiserror::Error;
pub use verdict::Diagnosis;
use verdict::{EXPLAINS_LITTLE, UNEXPLAINED_OF_A_SIMULATION, Verdict};
use weak::Column;

/// Why there is no diagnosis.
#[derive(Debug, Error)]
pub enum Refusal {
    /// The input is wrong.
    #[error("{0}")]
    Input(String),
    /// The data cannot answer.
    #[error("{0}")]
    Data(String),
}

/// Diagnoses a recording against a model; without one against what the fit has, or, without a fit, against rigid body and
/// GMS alone. What the fit cannot explain is not consistent with anything.
///
/// # Errors
/// [`Refusal`], with what to do.
pub fn diagnose(
    recording: &Recording,
    model: Option<&Model>,
    fit: Option<Arc<Fit>>,
    progress: &Progress,
) -> Result<Diagnosis, Refusal> {
    // The weak form has one kernel for all pieces.
    let recording = recording.at_one_rate();
    let mut found = judge(&recording, model, fit.as_deref(), None, progress)?;
    if StickSlip::of(&recording).is_some() {
        found.names_nothing("the axis sticks and slips: such a motion shows breakaway and kinetic level, which the fit has, and nothing else");
    }
    let doubt = fit
        .as_ref()
        .and_then(|fit| fit.doubt(EXPLAINS_LITTLE))
        .filter(|_| found.verdict == Verdict::Consistent);
    if let Some(doubt) = doubt {
        found.names_nothing(&doubt);
    }
    found.fit = fit;
    found.user = model.cloned();
    Ok(found)
}

/// Diagnoses a recording against a simulation of the user's own: what lies between the two is inertia, friction and effects, each of
/// either sign. One that moved by itself is reproduced by a model first.
///
/// # Errors
/// [`Refusal`], with what to do.
pub fn diagnose_simulation(
    recording: &Recording,
    simulated: Simulated,
    progress: &Progress,
) -> Result<Diagnosis, Refusal> {
    check(recording, None)?;
    let (position, effort) = match simulated {
        Simulated::Effort(effort) => {
            let s = Signals::of(recording);
            let late = lateness(&s, &recording.effort, &effort);
            let effort = late.map_or_else(|| effort.clone(), |late| earlier(&effort, late));
            let simulated = Some((&Column::of(effort.clone()), 0.0));
            let mut found = judge(recording, None, None, simulated, progress)?;
            found.simulated_late = late.map(|samples| samples * s.dt);
            found.take_correction(recording, effort);
            return Ok(found);
        }
        Simulated::Motion { position, effort } => (position, effort),
    };
    let own = recording.of_simulation(&position, effort.as_deref());
    let reproduced = Reproduced::of(&own, progress)?;
    let effort = reproduced.effort(recording)?;
    let simulated = Some((&effort, reproduced.nmse));
    let mut found = judge(recording, None, None, simulated, progress)?;
    let missed = reproduced.misses_too_much(found.baseline.test);
    if missed && found.baseline.test <= UNEXPLAINED_OF_A_SIMULATION {
        found.tells_no_difference();
    }
    if found.verdict != Verdict::Consistent && missed {
        return Err(Refusal::Data(format!(
            "{}: {}; the mismatch is {:.3} % and may be that. Prescribe the recorded motion in the simulation instead (inverse dynamics: a motion-actuated joint of Simscape, `mj_inverse` of MuJoCo, a stiff position controller in any other) and log the {} that it takes",
            recording.name,
            reproduced.words(recording),
            found.baseline.test,
            recording.role.name()
        )));
    }
    let s = &found.null.rows.s;
    let slope = |values: &[f64]| s.smooth_slope(values);
    let (viscous, inertia) = (slope(&effort.sloped), slope(&slope(&effort.curved)));
    let parts = effort.value.iter().zip(viscous).zip(inertia);
    let simulated = parts.map(|((f, v), i)| f + v + i).collect();
    found.reproduced = Some(reproduced);
    found.take_correction(recording, simulated);
    Ok(found)
}

impl Diagnosis {
    /// Takes down what a simulation of this effort for the recorded motion (N or N·m) lacks.
    fn take_correction(&mut self, recording: &Recording, simulated: Vec<f64>) {
        let state = (&self.null, &self.states[1]);
        let is_reproduced = self.reproduced.is_some();
        let of_simulation = (simulated, is_reproduced);
        self.correction = Correction::of(state, &self.effects, recording, of_simulation);
    }

    /// The mismatch is no larger than what is not known of the simulation.
    fn tells_no_difference(&mut self) {
        self.verdict = Verdict::Consistent;
        self.effects.iter_mut().for_each(Named::doubt);
        self.unnamed.clear();
        self.budget.clear();
        self.extended = self.baseline;
        self.mismatch[1] = self.mismatch[0].clone();
    }

    /// The recording does not say, for this reason.
    fn names_nothing(&mut self, why: &str) {
        self.verdict = Verdict::InsufficientData;
        self.doubt = Some(why.to_owned());
        let names = self.effects.iter_mut().filter(|e| !e.in_fit);
        names.for_each(Named::doubt);
        self.budget.clear();
    }
}

fn judge(
    recording: &Recording,
    model: Option<&Model>,
    fit: Option<&Fit>,
    simulated: Option<(&Column, f64)>,
    progress: &Progress,
) -> Result<Diagnosis, Refusal> {
    check(recording, model)?;
    if let Some(found) = StickSlip::of(recording).filter(|found| found.hunts) {
        return Err(Refusal::Data(found.refusal(recording)));
    }
    let channel = channel_of(recording, model, fit, simulated.is_some());
    // A delay that the model has is taken off like any other, and the model judged without it.
    let allowed = channel.delay.filter(|_| model.is_some_and(is_late));
    let prompt = model.filter(|_| allowed.is_some()).map(without_delay);
    let given = prompt.as_ref().or(model).map(terms_of).unwrap_or_default();
    let periods: Vec<(String, f64)> = model.iter().flat_map(|m| m.periods()).cloned().collect();
    let lengths: Vec<f64> = periods.iter().map(|p| p.1).collect();
    let unable = || {
        Refusal::Data(format!(
            "{}: the motion does not determine inertia and friction; record both directions at several speeds",
            recording.name
        ))
    };
    // What the user's own model lacks is not what the fit does; how fine a hysteresis the recording resolves is the same for both.
    let begins = fit.filter(|_| model.is_none());
    let mut known = fit.map(|fit| fit.known(recording)).unwrap_or_default();
    if begins.is_none() {
        known.terms.clear();
    }
    if simulated.is_some() {
        known.shaken.clear();
    }
    known
        .shaken
        .retain(|line| !given.iter().any(|g| g.is_near(line)));
    let beside = [given.as_slice(), &known.terms, &known.shaken].concat();
    let null_of = |recording: &Recording, outside: &[Range<usize>]| {
        let rows = Rows::new(recording, outside).map_err(Refusal::Data)?;
        progress.inc(1);
        NullModel::new(rows, &beside, known.yields.as_deref()).ok_or_else(unable)
    };
    let on_time = channel.taken_off(recording);
    let mut unknown = channel.unknown(0);
    unknown.extend(unknown_starts(recording));
    let (recorded, recording) = (recording, on_time.as_ref().unwrap_or(recording));
    let null = null_of(recording, &unknown)?;
    let shift = match channel.delay {
        Some(_) if allowed.is_none() => Shift::of(&null_of(recorded, &unknown)?, &null),
        _ => None,
    };
    let searched = |mut null: NullModel| {
        if let Some((simulated, missed)) = simulated {
            null = null.against(simulated, missed).ok_or_else(unable)?;
        }
        progress.inc(1);
        search::search(null, &given, &known, &lengths, progress).ok_or_else(unable)
    };
    let mut found = searched(null)?;
    let event = unnamed::happened(&found);
    // An event belongs to no effect, and pulls at all of them: all else is said without it, or not at all.
    if let Some(happened) = event.as_ref().and_then(|e| e.happened.as_ref()) {
        let outside = [happened.samples.as_slice(), &unknown].concat();
        let null = null_of(recording, &outside)?;
        found = searched(null)?;
    }
    verdict::conclude(
        found,
        event,
        (channel, shift, allowed),
        given.len(),
        &periods,
        recorded,
        [model, begins.and_then(Fit::model).as_ref()],
    )
    .map(|found| Diagnosis {
        second_positions: second_position::of(recording),
        ..found
    })
    .ok_or_else(unable)
}

/// What lies between the machine and the recorded effort: what the fit took off, and no end or vibration that a model of the user's has already. A
/// simulated effort passed no channel.
fn channel_of(
    recording: &Recording,
    model: Option<&Model>,
    fit: Option<&Fit>,
    is_simulated: bool,
) -> Channel {
    if is_simulated {
        return Channel::default();
    }
    let kinematics = Kinematics::of(recording);
    let mut found = match fit.and_then(Fit::channel) {
        Some(own) => Channel {
            saturation: Saturation::of(recording, &kinematics),
            ..own.clone()
        },
        None => Channel::of(recording, &kinematics),
    };
    // What shakes it within the band of the motion the search finds, beside all else.
    let given = |v: &Vibration| {
        let line = Term::new(Subject::Effect(VIBRATION), &[v.frequency_hz]);
        model.is_some_and(|model| terms_of(model).iter().any(|g| g.is_near(&line)))
    };
    found.vibrations.retain(|v| v.is_above && !given(v));
    let has = |form| model.is_some_and(|model| model.of(form).next().is_some());
    if has(&form::ACTUATOR_SATURATION) {
        found.saturation = None;
    }
    found
}

/// Whether a model has a delay of the effort.
fn is_late(model: &Model) -> bool {
    model.of(&form::CHANNEL_DELAY).next().is_some()
}

/// The model of an effort on time.
fn without_delay(model: &Model) -> Model {
    let mut prompt = model.clone();
    prompt.effects.retain(|e| e.id() != form::CHANNEL_DELAY.id);
    prompt
}

/// Refuses what is no recording of motion and effort, or not the model's kind of axis.
fn check(recording: &Recording, model: Option<&Model>) -> Result<(), Refusal> {
    if let Some(reason) = tells_nothing(recording) {
        return Err(Refusal::Data(reason));
    }
    model
        .map_or(Ok(()), |model| model.check_fits(recording))
        .map_err(Refusal::Input)
}

/// What the user's model already has.
fn terms_of(model: &Model) -> Vec<Term> {
    let own = effect::ALL.into_iter().flat_map(|effect| {
        let shapes = effect.in_model(model);
        shapes.into_iter().map(move |shape| Term {
            given: true,
            ..Term::new(term::Subject::Effect(effect), &shape)
        })
    });
    own.collect()
}
