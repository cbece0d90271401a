//! The fit that every command reports, beside a diagnosis: what `identify` prints of the same recording.

use super::effect::{
    Effect, VIBRATION, VISCOUS_ASYMMETRY,
    constant_force::ConstantForce,
    gravity::Gravity,
    position_spring::{ASIDE, PositionSpring},
    viscous::Viscous,
};
use super::term::{Subject, Term};
use super::without_delay;
use preslide_fit::effects::form;
use preslide_fit::identify::plain::Place;
use preslide_fit::identify::{Candidate, Identification, MANY, Options, STEPS, identify, thinned};
use preslide_fit::model::Model;
use preslide_fit::progress::Progress;
use preslide_fit::recording::Recording;
use preslide_fit::signal::Channel;
use serde_json::Value;

/// Times the distance of a spring's centre that the diagnosis finds it within.
const FAR: f64 = 1.5;

/// What `identify` finds in a recording, or why it finds nothing.
pub struct Fit(Result<Identification, String>);

/// What a diagnosis without a model begins with, so that it says what the fit lacks.
#[derive(Clone, Default)]
pub struct Known {
    /// Its plain physics.
    pub terms: Vec<Term>,
    /// Yield displacements of its blocks (m or rad).
    pub yields: Option<Vec<f64>>,
    /// What shakes the axis within the band of the motion, which the fit took off: the search begins with it, and it is missing.
    pub shaken: Vec<Term>,
}

impl Known {
    /// Whether a term is of the fit's physics.
    pub fn has(&self, term: &Term) -> bool {
        self.terms.iter().any(|known| known.is_like(term))
    }

    /// Whether a term is what the fit found to shake the axis.
    pub fn has_shaken(&self, term: &Term) -> bool {
        self.shaken.iter().any(|line| line.is_near(term))
    }
}

/// The shape of the spring of a model: within how far of the middle of the travel its centre is found.
fn reach(model: &Model, recording: &Recording) -> f64 {
    let centre = model.of(&form::POSITION_SPRING).next();
    let centre = centre.map_or(0.0, |spring| spring.get("centre_m"));
    let (low, high) = recording.ends();
    let aside = (centre - 0.5 * (low + high)).abs() / (high - low).max(1e-300);
    (FAR * aside / ASIDE).max(1.0)
}

impl Fit {
    /// Fits a recording as it was loaded, over the same rows as `identify`.
    pub fn of(recording: &Recording) -> Self {
        let thinned = thinned(recording, MANY);
        let progress = Progress::new("fit", STEPS);
        let rows = thinned.as_ref().unwrap_or(recording);
        let found = identify(rows, &Options::default(), &progress);
        progress.finish();
        Self(found)
    }

    /// Whether there is one.
    pub fn is_found(&self) -> bool {
        self.0.is_ok()
    }

    /// Why there is none.
    pub fn refusal(&self) -> Option<&str> {
        self.0.as_ref().err().map(String::as_str)
    }

    /// What it has.
    pub(super) fn known(&self, recording: &Recording) -> Known {
        let Ok(found) = &self.0 else {
            return Known::default();
        };
        let plain = found.plain;
        let mut terms: Vec<Term> = Vec::new();
        let mut has = |effect: &'static dyn Effect, shape: &[f64]| {
            terms.push(Term::new(Subject::Effect(effect), shape));
        };
        if plain.viscous {
            has(&Viscous, &[]);
        }
        if plain.by_direction {
            has(&VISCOUS_ASYMMETRY, &[]);
        }
        match plain.place {
            // Its free centre, wherever that is, holds the constant force.
            Place::Spring => has(&PositionSpring, &[reach(&found.best().model, recording)]),
            Place::Gravity => {
                has(&ConstantForce, &[]);
                has(&Gravity, &[]);
            }
            Place::Nowhere => has(&ConstantForce, &[]),
        }
        let blocks = found.best().blocks.iter();
        let line = |hz| Term::new(Subject::Effect(VIBRATION), &[hz]);
        let shaken = found.channel.vibrations.iter();
        let within = shaken.filter(|v| !v.is_above);
        let shaken = within.map(|v| line(v.frequency_hz));
        Known {
            terms,
            yields: Some(blocks.map(|(_, yields)| yields.value).collect()),
            shaken: shaken.collect(),
        }
    }

    /// The model that it recommends, of the effort on time.
    pub(super) fn model(&self) -> Option<Model> {
        Some(without_delay(&self.0.as_ref().ok()?.best().model))
    }

    /// Every law that it tried; none where there is no fit.
    pub fn candidates(&self) -> &[Candidate] {
        self.0.as_ref().map_or(&[], |found| &found.candidates)
    }

    /// What it took off the recorded effort, where there is a fit.
    pub(super) fn channel(&self) -> Option<&Channel> {
        self.0.as_ref().ok().map(|found| &found.channel)
    }

    /// The object `fit` of every command; null where there is none.
    pub fn to_json(&self, recording: &Recording) -> Value {
        let found = self.0.as_ref();
        found.map_or(Value::Null, |found| found.fit_json(recording))
    }

    /// In a sentence without its full stop.
    pub fn words(&self, recording: &Recording) -> String {
        match &self.0 {
            Ok(found) => {
                let changes = found
                    .between
                    .iter()
                    .map(|change| format!("; {}", change.words(recording)));
                format!(
                    "the fit of `preslide identify`: {}{}",
                    found.in_words(recording),
                    changes.collect::<String>()
                )
            }
            Err(reason) => format!("no fit of `preslide identify`: {reason}"),
        }
    }

    /// Why nothing can be called consistent, if it leaves more than `most` (%) of what is held out.
    pub(super) fn doubt(&self, most: f64) -> Option<String> {
        match &self.0 {
            Err(reason) => Some(format!("there is no fit ({reason})")),
            Ok(found) => {
                let left = found.best().nmse_test;
                (left > most).then(|| {
                    format!("the fit leaves {left:.0} % of the effort on stretches held out")
                })
            }
        }
    }
}
