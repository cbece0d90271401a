//! Predictions for people and for machines.

use super::lift::SEED;
use super::{AHEAD, Prediction, Predictor};
use preslide_fit::model::keys_of;
use preslide_fit::recording::Recording;
use preslide_fit::report::figures::quantity;
use preslide_fit::report::{Page, Section, Table};
use serde_json::{Value, json};

impl Prediction {
    /// Errors at each distance, in the part that nothing has seen.
    pub fn table(&self, recording: &Recording) -> Table {
        let unit = match self.forced {
            true => recording.position_unit(),
            false => recording.effort_unit(),
        };
        let ahead = AHEAD.map(|steps| steps.to_string());
        let head = ["predictor", "states", "delays", "ridge"].map(str::to_owned);
        let row = |p: &Predictor| {
            let [delays, ridge] = match p.lift {
                Some((lift, ridge)) => [lift.delays.to_string(), format!("{ridge:.0e}")],
                None => ["–", "–"].map(str::to_owned),
            };
            let states = match p.states {
                0 => "–".to_owned(),
                n => n.to_string(),
            };
            let errors = p.told.iter().map(|error| quantity(*error, unit));
            [p.name.clone(), states, delays, ridge]
                .into_iter()
                .chain(errors)
                .collect()
        };
        let what = match self.forced {
            true => "position from the recorded force",
            false => "friction from the recorded motion",
        };
        let times = AHEAD.map(|steps| format!("{:.3}", steps as f64 * recording.sample_time_s()));
        Table {
            caption: format!(
                "RMS error of the {what}, so many samples ahead ({} s), on the last fifth",
                times.join(", ")
            ),
            head: head.into_iter().chain(ahead).collect(),
            rows: self.predictors.iter().map(row).collect(),
        }
    }

    /// Which to use.
    pub fn recommendation(&self) -> String {
        let best = &self.predictors[self.best];
        let models = self.predictors.iter().filter(|p| p.lift.is_none());
        let rival = models.min_by(|a, b| a.score().total_cmp(&b.score()));
        let from = |better: bool| {
            let steps = (0..AHEAD.len())
                .filter(|i| rival.is_some_and(|r| (best.told[*i] < r.told[*i]) == better));
            let steps: Vec<String> = steps.map(|i| AHEAD[i].to_string()).collect();
            steps.join(", ")
        };
        let Some(rival) = rival else {
            return format!(
                "Take {}: there is no friction model to compare it with.",
                best.name
            );
        };
        match (from(true).as_str(), from(false).as_str()) {
            ("", _) => format!(
                "Keep {}: the best linear predictor ({}) errs more at every distance.",
                rival.name, best.name
            ),
            (_, "") => format!(
                "Take {} for a controller that looks ahead: it errs less than {} at every distance.",
                best.name, rival.name
            ),
            (near, far) => format!(
                "Take {} for a controller that looks so many samples ahead: {near}. There it errs less than {}, and more at {far}.",
                best.name, rival.name
            ),
        }
    }

    /// `preslide.prediction/1`; errors in m or rad, of friction in N or N·m.
    pub fn to_json(&self, recording: &Recording, seconds: f64) -> Value {
        let (predicted, unit, rms, rms_chosen) = match self.forced {
            true => (
                "position",
                recording.position_unit(),
                "rms_m",
                "rms_where_chosen_m",
            ),
            false => (
                "friction",
                recording.effort_unit(),
                "rms_N",
                "rms_where_chosen_N",
            ),
        };
        let row = |p: &Predictor| {
            json!({
                "name": p.name,
                "states": p.states,
                "delays": p.lift.map(|(lift, _)| lift.delays),
                "blocks": p.lift.map(|(lift, _)| lift.blocks),
                "thin_plates": p.lift.map(|(lift, _)| lift.plates),
                "ridge": p.lift.map(|(_, ridge)| ridge),
                rms_chosen: p.chosen,
                rms: p.told,
            })
        };
        let answer = json!({
            "schema": "preslide.prediction/1",
            "recording": recording.name,
            "predicted": predicted,
            "unit": unit,
            "sample_time_s": recording.sample_time_s(),
            "ahead_samples": AHEAD,
            "seed": SEED,
            "predictors": self.predictors.iter().map(row).collect::<Vec<_>>(),
            "recommended": self.predictors[self.best].name,
            "notes": self.notes,
            "seconds": seconds,
        });
        keys_of(recording.kind, answer)
    }

    /// The report.
    pub fn page(&self, recording: &Recording, command: String) -> Page {
        Page {
            title: format!("Predictors on {}", recording.name),
            lead: self.recommendation(),
            sections: vec![
                Section {
                    heading: "What each says of the next samples".to_owned(),
                    tables: vec![self.table(recording)],
                    ..Section::default()
                },
                Section::notes(self.notes.clone()),
            ],
            command,
        }
    }
}
