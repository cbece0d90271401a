//! A motion fit for people and for machines.

use super::super::fit::{key, shown, unit};
use super::search::{SEED, long_pieces};
use super::told::NUDGE;
use super::{Apart, MotionFit};
use crate::model::keys_of;
use crate::recording::Recording;
use crate::report::figures::{duration, quantity, three};
use crate::report::{Axis, Colour, Emphasis, Figure, Page, Section, Series, Table};
use serde_json::{Value, json};

impl MotionFit {
    /// `preslide.motion_fit/1`; `seconds` is the time it took.
    pub fn to_json(&self, recording: &Recording, seconds: f64) -> Value {
        let apart = |a: Apart| json!({ "rms_m": a.rms, "mean_abs_m": a.mean_abs });
        let parameters = self.parameters.iter();
        let answer = json!({
            "schema": "preslide.motion_fit/1",
            "recording": recording.name,
            "effort_unit": recording.effort_unit(),
            "position_unit": recording.position_unit(),
            "closed_loop": self.closed_loop,
            "fit": {
                "parameters": parameters.map(|(name, e)| (key(recording.kind, name), json!(e))).collect::<serde_json::Map<_, _>>(),
                "motion_error": apart(self.errors[1]),
                "motion_error_of_force_fit": apart(self.errors[0]),
                "motion_error_held_out": self.held_out.map(apart),
            },
            "starts": { "seed": SEED, "losses_m": self.starts, "agree": self.agree, "window_s": self.window_s },
            "tried": self.tried.iter().map(|t| json!({ "id": t.id, "change": t.change, "taken": t.taken })).collect::<Vec<_>>(),
            "moved_by_one_percent": { "drive_gain_m": self.moves[0], "friction_m": self.moves[1] },
            "correlated": self.together,
            "notes": self.notes(recording),
            "seconds": seconds,
        });
        keys_of(recording.kind, answer)
    }

    /// Parameters with their intervals, beside those of the fit of the force.
    pub fn table(&self, recording: &Recording) -> Table {
        let rows = self.parameters.iter();
        let rows = rows.map(|(name, e)| (shown(recording, name), unit(recording, name), *e));
        let mut table = Table::parameters("Parameters from the motion", rows);
        table.head.push("from the force".to_owned());
        let before = self.parameters.iter().zip(&self.before);
        for (row, ((name, _), before)) in table.rows.iter_mut().zip(before) {
            row.push(quantity(*before, &unit(recording, name)));
        }
        table
    }

    /// What a simulation leaves of the motion.
    pub fn error_table(&self, recording: &Recording) -> Table {
        let row = |name: &str, apart: Option<Apart>| {
            let shown = |v: f64| quantity(v, recording.position_unit());
            let figures = apart.map(|a| [shown(a.rms), shown(a.mean_abs)]);
            let [rms, mean] = figures.unwrap_or(["–".to_owned(), "–".to_owned()]);
            vec![name.to_owned(), rms, mean]
        };
        Table {
            caption: format!(
                "Simulated less measured position, {}, each piece from its measured start",
                if self.closed_loop {
                    "closed loop"
                } else {
                    "open loop"
                }
            ),
            head: ["parameters from", "RMS", "mean magnitude"]
                .map(String::from)
                .to_vec(),
            rows: vec![
                row("the force (fitted here)", Some(self.errors[0])),
                row("the motion (fitted here)", Some(self.errors[1])),
                row("the motion (each quarter, from the others)", self.held_out),
            ],
        }
    }

    /// What a person must know beside the tables, a sentence without its full stop each.
    pub fn notes(&self, recording: &Recording) -> Vec<String> {
        let error = |v: f64| quantity(v, recording.position_unit());
        let mut notes = Vec::new();
        notes.push(format!(
            "in windows of {}, {} starts (seed {SEED}) {}",
            duration(self.window_s),
            self.starts.len(),
            match self.agree {
                true => "end at one place",
                false => "end at several places: do not trust the intervals",
            },
        ));
        let percent = 100.0 * NUDGE;
        notes.push(format!(
            "{percent} % more drive gain moves the simulation by {} RMS, {percent} % more friction by {}: a machine that changes by as much cannot be simulated better",
            error(self.moves[0]),
            error(self.moves[1]),
        ));
        for (one, other, of) in &self.together {
            let [one, other] = [one, other].map(|name| name.replace('_', " "));
            notes.push(format!(
                "only a combination of {one} and {other} is known (correlation {}): within their intervals both change together",
                three(*of)
            ));
        }
        let list = |taken: bool| {
            let of = self.tried.iter().filter(|t| t.taken == taken);
            let shown = of.map(|t| {
                let (name, change) = (t.id.replace('_', " "), 100.0 * t.change.abs());
                let way = if t.change > 0.0 { "more" } else { "less" };
                format!("{name} ({} % {way})", three(change))
            });
            shown.collect::<Vec<_>>().join(", ")
        };
        let lists = [("Taken", list(true)), ("Tried and left out", list(false))];
        for (verb, list) in lists.into_iter().filter(|l| !l.1.is_empty()) {
            notes.push(format!(
                "{verb}, by how much it changes the loss in windows that it was not fitted to: {list}"
            ));
        }
        notes.push(self.beside.words());
        notes.extend(self.beside.contradictions(&self.parameters, recording));
        notes.extend(recording.per_unit());
        notes
    }

    /// The outcome in one sentence.
    pub fn conclusion(&self, recording: &Recording) -> String {
        let error = |a: Apart| quantity(a.rms, recording.position_unit());
        let held = self
            .held_out
            .map_or(String::new(), |a| format!("; held out {}", error(a)));
        let [force, motion] = self.errors.map(error);
        format!(
            "With these parameters a simulation, left to itself, stays within {motion} RMS of the machine, with those of the force {force}{held}."
        )
    }

    /// The report.
    pub fn page(&self, recording: &Recording, command: String) -> Page {
        Page {
            title: format!("Motion fit of {}", recording.name),
            lead: self.conclusion(recording),
            command,
            sections: vec![
                Section {
                    heading: "Parameters".to_owned(),
                    tables: vec![self.table(recording)],
                    ..Section::default()
                },
                Section {
                    heading: "Motion".to_owned(),
                    tables: vec![self.error_table(recording)],
                    figures: self.figures(recording),
                    ..Section::default()
                },
                Section::notes(self.notes(recording)),
            ],
        }
    }

    /// Measured and simulated position, and what is between them.
    fn figures(&self, recording: &Recording) -> Vec<Figure> {
        let unit = recording.position_unit();
        // Short pieces are not simulated.
        let rows: Vec<usize> = long_pieces(recording).into_iter().flatten().collect();
        let step = recording.sample_time_s();
        let time: Vec<f64> = (0..rows.len()).map(|i| i as f64 * step).collect();
        let measured: Vec<f64> = rows.iter().map(|&i| recording.position[i]).collect();
        let error = |simulated: &[f64]| -> Vec<f64> {
            simulated
                .iter()
                .zip(&measured)
                .map(|(s, m)| s - m)
                .collect()
        };
        let axis = || Axis::new("time, pieces one after the other", "s");
        let [force, motion] = &self.simulated;
        vec![
            Figure::new(
                "What a simulation leaves",
                axis(),
                Axis::new("simulated − measured", unit),
            )
            .with(Series::line("from the force", time.clone(), error(force)))
            .with(
                Series::line("from the motion", time.clone(), error(motion))
                    .colour(Colour::Vermillion)
                    .emphasis(Emphasis::Strong),
            ),
            Figure::new("Position", axis(), Axis::new("position", unit))
                .with(
                    Series::line("measured", time.clone(), measured.clone()).colour(Colour::Black),
                )
                .with(
                    Series::line("simulated", time.clone(), motion.clone())
                        .colour(Colour::Vermillion)
                        .emphasis(Emphasis::Strong),
                ),
        ]
    }
}
