//! The fit that every command tells, beside a diagnosis: what `identify` prints of the same recording.

use crate::identify::{Identification, MANY, Options, STEPS, identify, thinned};
use crate::progress::Progress;
use crate::recording::Recording;
use serde_json::Value;

/// What `identify` finds in a recording, or why it finds nothing.
pub struct Fit(Result<Identification, String>);

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

    /// The object `fit` of every command; null where there is none.
    pub fn to_json(&self, recording: &Recording) -> Value {
        let found = self.0.as_ref();
        found.map_or(Value::Null, |found| found.fit_json(recording))
    }

    /// In a sentence without its full stop.
    pub fn words(&self, recording: &Recording) -> String {
        match &self.0 {
            Ok(found) => format!(
                "the fit of `preslide identify`: {}",
                found.in_words(recording)
            ),
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
