//! A planned motion in words, as a file, for machines and as a page.

use super::Plan;
use preslide_fit::model::keys_of;
use preslide_fit::recording::MotionKind;
use preslide_fit::report::figures::{duration, quantity};
use preslide_fit::report::{Axis, Figure, Page, Section, Series};
use serde_json::{Value, json};
use std::fmt::Write as _;

impl Plan {
    /// Its size, in a sentence.
    pub fn words(&self, kind: MotionKind) -> String {
        format!(
            "{} rows, {}, {} reversals, strokes from {} to {}, in {} repeats.",
            self.rows.len(),
            duration(self.seconds()),
            self.reversals,
            quantity(self.strokes.0, kind.unit()),
            quantity(self.strokes.1, kind.unit()),
            self.repeats()
        )
    }

    fn repeats(&self) -> u32 {
        self.rows.last().map_or(0, |(_, repeat)| *repeat)
    }

    fn times(&self) -> impl Iterator<Item = f64> {
        (0..self.rows.len()).map(|row| row as f64 / self.rate)
    }

    /// As CSV.
    pub fn csv(&self, kind: MotionKind) -> String {
        let column = kind.column();
        let mut text = format!("t_s,{column},repeat\n");
        for (t, (x, repeat)) in self.times().zip(&self.rows) {
            let _ = writeln!(text, "{t:.6},{x:.10e},{repeat}");
        }
        text
    }

    /// `preslide.plan/1`.
    pub fn to_json(&self, kind: MotionKind) -> Value {
        let answer = json!({
            "schema": "preslide.plan/1", "rows": self.rows.len(), "rate_Hz": self.rate, "length_s": self.seconds(),
            "reversals": self.reversals, "strokes_m": [self.strokes.0, self.strokes.1], "repeats": self.repeats(),
        });
        keys_of(kind, answer)
    }

    /// The motion to look at.
    pub fn page(&self, kind: MotionKind, command: String) -> Page {
        let positions = self.rows.iter().map(|(x, _)| *x).collect();
        let [time, position] = [Axis::new("time", "s"), Axis::new("position", kind.unit())];
        Page {
            title: "A motion that shows friction".to_owned(),
            lead: self.words(kind),
            command,
            sections: vec![Section {
                heading: "Motion".to_owned(),
                figures: vec![
                    Figure::new("Position over time", time, position).with(Series::line(
                        "position",
                        self.times().collect(),
                        positions,
                    )),
                ],
                ..Section::default()
            }],
        }
    }
}
