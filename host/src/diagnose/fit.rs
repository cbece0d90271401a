//! The fit that every command tells, beside a diagnosis: what `identify` prints of the same recording.

use crate::identify::{Identification, MANY, Options, STEPS, identify, thinned};
use crate::progress::Progress;
use crate::recording::Recording;
use serde_json::Value;

/// What `identify` finds in a recording, or why it finds nothing.
pub struct Fit {
    found: Result<Identification, String>,
    /// Over the same rows as `identify`'s own.
    recording: Recording,
}

impl Fit {
    /// Fits a recording as it was loaded.
    pub fn of(recording: &Recording) -> Self {
        let recording = thinned(recording, MANY).unwrap_or_else(|| recording.clone());
        let progress = Progress::new("fit", STEPS);
        let found = identify(&recording, &Options::default(), &progress);
        progress.finish();
        Self { found, recording }
    }

    /// The object `fit` of every command; null where there is none.
    pub fn to_json(&self) -> Value {
        self.found
            .as_ref()
            .map_or(Value::Null, |found| found.fit_json(&self.recording))
    }

    /// In a sentence without its full stop.
    pub fn words(&self) -> String {
        match &self.found {
            Ok(found) => format!(
                "the fit of `preslide identify`: {}",
                found.in_words(&self.recording)
            ),
            Err(reason) => format!("no fit of `preslide identify`: {reason}"),
        }
    }

    /// Why nothing can be called consistent, if it leaves more than `most` (%) of what is held out.
    pub(super) fn doubt(&self, most: f64) -> Option<String> {
        match &self.found {
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
