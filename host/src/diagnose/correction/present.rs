//! A correction in words and in files.

use super::{Added, Correction};
use crate::diagnose::rows::Rows;
use preslide_fit::recording::Recording;
use preslide_fit::report::figures::{left, quantity};
use serde_json::{Map, Value, json};
use std::fmt::Write as _;

impl Added {
    fn to_json(&self) -> Value {
        let parameters = self.parameters.iter();
        let parameters: Map<String, Value> = parameters
            .map(|(key, estimate)| ((*key).to_owned(), json!(estimate)))
            .collect();
        json!({
            "id": self.id, "what": self.words, "certainty": self.certainty, "parameters": parameters,
            "formula": self.formula.as_ref().map(ToString::to_string),
        })
    }
}

impl Correction {
    /// `preslide.correction/1`: the deltas, in absolute units.
    pub fn to_json(&self, recording: &Recording) -> Value {
        let blocks: Vec<Value> = (self.blocks.iter())
            .map(|(k, d)| json!({ "stiffness_N_per_m": k, "yield_displacement_m": d }))
            .collect();
        let direction: Vec<Value> = (self.direction.iter())
            .map(|(k, d)| json!({ "share": k * d, "yield_displacement_m": d }))
            .collect();
        json!({
            "schema": "preslide.correction/1", "recording": recording.name, "unit": recording.effort_unit(),
            "nmse_simulation": self.left[0], "nmse_corrected": self.left[1],
            "terms": self.terms.iter().map(Added::to_json).collect::<Vec<_>>(),
            "left_out": self.left_out, "blocks": blocks, "direction": direction,
        })
    }

    /// What simulation and correction leave, in a sentence without its full stop.
    pub fn words(&self, rows: &Rows, recording: &Recording) -> String {
        let force = |nmse: f64| quantity(rows.rms_of(nmse), recording.effort_unit());
        let [before, after] = self.left;
        let mut words = format!(
            "your simulation plus this correction leaves {} of the variance ({} RMS) at all samples of {}, your simulation alone {} ({})",
            left(after),
            force(after),
            recording.name,
            left(before),
            force(before)
        );
        if !self.left_out.is_empty() {
            let _ = write!(
                words,
                "; it leaves out {}, with which it would leave more",
                self.left_out.join(", ")
            );
        }
        words
    }

    /// A table of the recording, the simulation, every term, and their sum; the columns' names have the units.
    pub fn csv(&self, recording: &Recording) -> String {
        let (effort, unit) = (recording.role.name(), recording.effort_unit());
        let length = recording.position_unit();
        let position = recording.kind.column();
        let mut names = vec![
            "t_s".to_owned(),
            position.to_owned(),
            format!("{effort}_{unit}"),
        ];
        names.push(format!("{effort}_sim_{unit}"));
        names.push(format!("{effort}_sim_corrected_{unit}"));
        names.extend([
            format!("velocity_{length}_s"),
            format!("acceleration_{length}_s2"),
        ]);
        names.extend(self.terms.iter().map(|t| format!("{}_{unit}", t.id)));
        let [velocity, acceleration] = &self.motion;
        let mut columns = vec![
            &recording.t_s,
            &recording.position,
            &recording.effort,
            &self.simulated,
        ];
        columns.extend([velocity, acceleration]);
        columns.extend(self.terms.iter().map(|t| &t.force));
        let mut text = names.join(",");
        for i in 0..recording.t_s.len() {
            text.push('\n');
            let corrected = self.simulated[i] + self.terms.iter().map(|t| t.force[i]).sum::<f64>();
            for (place, column) in columns.iter().enumerate() {
                let comma = if place == 0 { "" } else { "," };
                let _ = write!(text, "{comma}{}", column[i]);
                if place == 3 {
                    let _ = write!(text, ",{corrected}");
                }
            }
        }
        text.push('\n');
        text
    }
}
