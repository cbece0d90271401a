//! What the recordings show so far.

use super::super::{Failure, thin};
use preslide_fit::identify::{Options, STEPS, identify};
use preslide_fit::model::Model;
use preslide_fit::progress::Progress;
use preslide_fit::recording::{self, LoadOptions, MotionKind, Recording};
use preslide_fit::report::figures::estimate;
use preslide_host::diagnose::fit::Fit;
use preslide_host::diagnose::{Diagnosis, diagnose, effect};
use preslide_host::drive::MOST_BLOCKS;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Fit and diagnosis of all recordings together.
pub struct Findings {
    pub recording: Recording,
    pub diagnosis: Diagnosis,
    fit: Arc<Fit>,
}

/// Whether the effort drives the axis backward, and what moves, or why that is unknown.
pub fn careful(path: &Path) -> Result<(bool, Result<String, String>), Failure> {
    let recording = recording::load(path, &LoadOptions::default())?;
    let turned = recording
        .warnings
        .iter()
        .any(|w| w.code == "effort-sign-flipped");
    let progress = Progress::new("identify", STEPS);
    let found = identify(&recording, &Options::default(), &progress);
    progress.finish();
    let weight = found.and_then(|found| {
        let mass = found
            .best()
            .rigid_body
            .iter()
            .find(|(name, _)| *name == "mass");
        let unit = match recording.kind {
            MotionKind::Linear => "kg",
            MotionKind::Rotary => "kg·m²",
        };
        let mass = mass.ok_or("the motion was too gentle to show it")?.1;
        Ok(estimate(mass.value, mass.ci95, unit))
    });
    Ok((turned, weight))
}

impl Findings {
    /// Of recordings of one machine.
    pub fn of(paths: &[PathBuf]) -> Result<Self, Failure> {
        let loaded: Result<Vec<Recording>, _> = paths
            .iter()
            .map(|path| recording::load(path, &LoadOptions::default()))
            .collect();
        let whole = Recording::join(loaded?).map_err(Failure::Input)?;
        let fit = Arc::new(Fit::of(&whole));
        if let Some(reason) = fit.refusal() {
            return Err(Failure::Data(reason.to_owned()));
        }
        let recording = thin(whole, 0);
        let progress = Progress::new("diagnose, steps of the search", 0);
        let diagnosis = diagnose(&recording, None, Some(Arc::clone(&fit)), &progress)?;
        progress.finish();
        Ok(Self {
            recording,
            diagnosis,
            fit,
        })
    }

    /// On the terminal, as `preslide diagnose` says it.
    pub fn say(&self) {
        explain!("\n{}\n", self.diagnosis.verdict_lines(&self.recording));
        explain!("{}", self.diagnosis.budget_text(&self.recording));
        if let Some(possible) = self.diagnosis.possible_words(&self.recording) {
            say!("{possible}.\n");
        }
    }

    /// The model with all that is certain.
    pub fn extended(&self) -> Model {
        self.diagnosis.extended_model(&self.recording).model.clone()
    }

    /// The fit with the fewest errors that the link takes: blocks, no more than it has room for.
    pub fn loadable(&self) -> Result<Model, Failure> {
        let fits = self.fit.candidates().iter();
        let fits =
            fits.filter(|c| (1..=MOST_BLOCKS).contains(&c.size()) && c.nmse_test.is_finite());
        let best = fits.min_by(|a, b| a.nmse_test.total_cmp(&b.nmse_test));
        let best = best.ok_or_else(|| {
            Failure::Data("found no Maxwell-slip blocks to send to the controller; record smaller strokes (--smallest)".to_owned())
        })?;
        Ok(best.model.clone())
    }

    fn confidence(&self, id: &str) -> Option<(f64, bool)> {
        let own = self.diagnosis.effects.iter().filter(|e| e.id() == id);
        own.map(|e| (e.confidence, e.confident || e.in_fit))
            .max_by(|a, b| a.0.total_cmp(&b.0))
    }
}

/// What an experiment for some effects changed, in words.
pub fn answer(before: &Findings, after: &Findings, about: &[String]) -> String {
    let words = about.iter().map(|id| {
        let name = effect::by_id(id).map_or(id.as_str(), |effect| effect.name());
        match (before.confidence(id), after.confidence(id)) {
            (_, Some((p, true))) => format!("{name}: there ({p:.2})"),
            (Some((was, false)), Some((is, false))) => {
                format!("{name}: still open ({was:.2} → {is:.2})")
            }
            (_, Some((p, false))) => format!("{name}: possible ({p:.2})"),
            (_, None) => format!("{name}: no sign of it"),
        }
    });
    words.collect::<Vec<_>>().join("; ")
}
