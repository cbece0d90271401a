//! A recording as a row: its parameters with intervals, its verdict, what was named; or why there is none.

use super::Member;
use crate::diagnose::{Refusal, diagnose, fit::Fit};
use preslide_fit::identify::thinned;
use preslide_fit::progress::{Progress, heard};
use preslide_fit::recording::Recording;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Instant;

/// A row.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The recording's name.
    pub file: String,
    /// Whose it is.
    pub axis: String,
    /// Bytes of the file.
    pub bytes: u64,
    /// When it was written (s since 1970).
    pub modified_s: f64,
    /// Why the rest is not there.
    pub error: Option<String>,
    /// Length (s).
    pub length_s: Option<f64>,
    /// Samples per second.
    pub rate_hz: Option<f64>,
    /// Unit of the effort, of which a force's or torque's in a name is the place.
    pub effort_unit: Option<String>,
    /// The friction law of the fit.
    pub law: Option<String>,
    /// What it leaves of what was held out (% of the effort's variance).
    pub nmse_held_out: Option<f64>,
    /// The fit's parameters by their keys: value and 95 % interval, which few repeats do not give.
    pub parameters: BTreeMap<String, (f64, Option<[f64; 2]>)>,
    /// The diagnosis in a word.
    pub verdict: Option<String>,
    /// Effects that the fit lacks, by their ids, the surest first.
    pub names: Vec<String>,
    /// Effects that may be there.
    pub possible: Vec<String>,
    /// What the diagnosis leaves (% of the effort's variance), without and with what it named, and what noise would.
    pub nmse: Option<[f64; 3]>,
    /// What the loader noticed, by its codes.
    pub warnings: Vec<String>,
    /// Seconds that it took.
    pub seconds: f64,
}

/// How far each recording is analysed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// The fit alone.
    Fit,
    /// The diagnosis, too.
    Diagnosis,
}

impl Row {
    /// Unit of its effort, where it was read.
    pub fn effort(&self) -> &str {
        self.effort_unit.as_deref().unwrap_or_default()
    }

    /// It has something to compare.
    pub fn is_read(&self) -> bool {
        !self.parameters.is_empty()
    }

    /// Loads and judges a recording. Whatever goes wrong is the row's error: nothing of one recording stops the others.
    pub fn of(
        member: &Member,
        depth: Depth,
        load: impl Fn(&Member) -> Result<Recording, String>,
    ) -> Self {
        let start = Instant::now();
        let blank = || Self {
            file: member.file.clone(),
            axis: member.axis.clone(),
            bytes: member.bytes,
            modified_s: member.modified_s,
            ..Self::default()
        };
        let quiet = Arc::new(|_: &str, _, _| ());
        let judged = catch_unwind(AssertUnwindSafe(|| {
            heard(quiet, || {
                let mut row = blank();
                let judged = load(member).and_then(|recording| row.judge(&recording, depth));
                row.error = judged.err();
                row
            })
        }));
        let mut row = judged.unwrap_or_else(|_| Self {
            error: Some("the tool failed on it; please report this with the file".to_owned()),
            ..blank()
        });
        row.seconds = start.elapsed().as_secs_f64();
        row
    }

    fn judge(&mut self, recording: &Recording, depth: Depth) -> Result<(), String> {
        self.length_s = Some(recording.len() as f64 * recording.sample_time_s());
        self.rate_hz = Some(1.0 / recording.sample_time_s());
        self.effort_unit = Some(recording.effort_unit().to_owned());
        self.warnings = recording
            .warnings
            .iter()
            .map(|w| w.code.to_owned())
            .collect();
        let fit = Arc::new(Fit::of(recording));
        self.take_fit(&fit, recording);
        if depth == Depth::Fit {
            return fit
                .refusal()
                .map_or(Ok(()), |reason| Err(reason.to_owned()));
        }
        let progress = Progress::new("diagnose", 0);
        // However many samples there are, as `preslide diagnose` has it.
        let thinned = thinned(recording, 0);
        match diagnose(
            thinned.as_ref().unwrap_or(recording),
            None,
            Some(fit),
            &progress,
        ) {
            Ok(found) => {
                self.verdict = Some(found.verdict.name().to_owned());
                self.names = found.missing().map(|e| e.id().to_owned()).collect();
                let possible = found.effects.iter().filter(|e| !e.confident && !e.in_fit);
                self.possible = possible.map(|e| e.id().to_owned()).collect();
                self.nmse = Some([found.baseline.test, found.extended.test, found.noise_floor]);
                Ok(())
            }
            Err(Refusal::Data(reason)) => {
                self.verdict = Some("insufficient-data".to_owned());
                Err(reason)
            }
            Err(Refusal::Input(reason)) => Err(reason),
        }
    }

    fn take_fit(&mut self, fit: &Fit, recording: &Recording) {
        let told = fit.to_json(recording);
        self.law = told["law"].as_str().map(str::to_owned);
        self.nmse_held_out = told["nmse_held_out"].as_f64();
        for (key, estimate) in told["parameters"].as_object().into_iter().flatten() {
            let bound = |i: usize| estimate["ci95"][i].as_f64();
            let interval = bound(0).zip(bound(1)).map(|(low, high)| [low, high]);
            if let Some(value) = estimate["value"].as_f64() {
                self.parameters.insert(key.clone(), (value, interval));
            }
        }
    }
}
