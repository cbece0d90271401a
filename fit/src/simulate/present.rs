//! A simulation for people and for machines.

use super::Simulation;
use crate::model::{Model, keys_of};
use crate::recording::MotionKind;
use crate::report::figures::{capital, ends, left, quantity, range as range_of};
use crate::report::units::symbol;
use crate::report::{Axis, Colour, Emphasis, Figure, Page, Section, Series, Table};
use serde_json::{Value, json};
use std::fmt::Write as _;

impl Simulation {
    fn units(&self) -> (&'static str, &'static str) {
        (self.kind.unit(), symbol(self.effort.unit()))
    }

    /// The simulated recording, in the recording format; every number reads back as it is.
    pub fn to_csv(&self) -> String {
        let (x, force) = (self.kind.column(), self.effort.column());
        let v = match self.kind {
            MotionKind::Linear => "v_m_s",
            MotionKind::Rotary => "qd_rad_s",
        };
        let mut text = match self.velocity {
            Some(_) => format!("t_s,{x},{v},{force}\n"),
            None => format!("t_s,{x},{force}\n"),
        };
        for (i, (t, (position, force))) in self
            .t_s
            .iter()
            .zip(self.position.iter().zip(&self.force))
            .enumerate()
        {
            let _ = write!(text, "{t},{position:e},");
            if let Some(velocity) = self.velocity.as_ref().and_then(|v| v.get(i)) {
                let _ = write!(text, "{velocity:e},");
            }
            let _ = writeln!(text, "{force}");
        }
        text
    }

    /// `preslide.simulation/1`; `seconds` is the time it took.
    pub fn to_json(&self, model: &Model, seconds: f64) -> Value {
        let answer = json!({
            "schema": "preslide.simulation/1",
            "motion": self.kind.name(),
            "kind": model.friction.kind(),
            "effort_unit": self.effort.unit(),
            "input": match (self.following, self.from_force) {
                (Some(_), _) => "reference",
                (None, true) => "force",
                (None, false) => "motion",
            },
            "samples": self.t_s.len(),
            "nmse": self.agreement.as_ref().map(|a| a.nmse),
            "rms_N": self.agreement.as_ref().map(|a| a.rms),
            "following_rms_m": self.following.map(|f| f.rms),
            "following_max_m": self.following.map(|f| f.max),
            "position_rmse_m": self.position_error.map(|e| e.rmse),
            "position_mean_abs_m": self.position_error.map(|e| e.mean_abs),
            "position_nmse": self.position_error.map(|e| e.nmse),
            "position_range_m": range(&self.position),
            "force_range_N": range(&self.force),
            "breakaway": self.breakaway.map(|b| json!({ "time_s": b.time_s, "force_N": b.force })),
            "notes": self.notes,
            "seconds": seconds,
        });
        keys_of(self.kind, answer)
    }

    /// The columns' ranges and, where there is one, the agreement with the measurement.
    pub fn table(&self) -> Table {
        let (x, f) = self.units();
        let row = |name: &str, values: &[f64], unit: &str| {
            let [low, high] = range(values);
            let (low, high, unit) = ends(low, high, unit);
            vec![name.to_owned(), low, high, unit]
        };
        let mut rows = vec![
            row("time", &self.t_s, "s"),
            row("position", &self.position, x),
        ];
        if let Some(velocity) = &self.velocity {
            rows.push(row("velocity", velocity, &format!("{x}/s")));
        }
        rows.push(row(self.effort.name(), &self.force, f));
        Table {
            caption: format!("{} samples", self.t_s.len()),
            head: ["", "lowest", "highest", "unit"]
                .map(str::to_owned)
                .to_vec(),
            rows,
        }
    }

    /// What came out, in one sentence.
    pub fn conclusion(&self) -> String {
        let (x, f) = self.units();
        if let Some(following) = self.following {
            let measured = self.position_error.map_or(String::new(), |e| {
                format!(
                    "; the simulated motion is {} RMSE from the measured one, {} in mean magnitude",
                    quantity(e.rmse, x),
                    quantity(e.mean_abs, x)
                )
            });
            return format!(
                "The axis follows its reference to {} RMS, {} at most{measured}.",
                quantity(following.rms, x),
                quantity(following.max, x)
            );
        }
        if let Some(error) = self.position_error {
            return format!(
                "The simulated motion is {} RMSE from the measured one ({} of its variance), {} in mean magnitude, from {} given samples on.",
                quantity(error.rmse, x),
                left(error.nmse),
                quantity(error.mean_abs, x),
                error.given
            );
        }
        match (&self.agreement, self.breakaway) {
            (Some(a), _) => format!(
                "The model leaves {} of the measured effort's variance (NMSE), {} RMS.",
                left(a.nmse),
                quantity(a.rms, f)
            ),
            (None, Some(b)) => format!(
                "breakaway: at {} and {} friction no longer holds the force and the body slides away; keep the force below that; --force with a recording and a model that has an inertia simulates the slide too",
                quantity(b.time_s, "s"),
                quantity(b.force, f)
            ),
            (None, None) => {
                let [low, high] = range(&self.position);
                let [least, most] = range(&self.force);
                format!(
                    "The motion covers {}, the {} {}.",
                    range_of(low, high, x),
                    self.effort.name(),
                    range_of(least, most, f)
                )
            }
        }
    }

    /// The report.
    pub fn page(&self, name: &str, command: String) -> Page {
        let mut figures = Vec::from(self.force_figures());
        figures.extend(self.motion_figures());
        figures.extend(self.residual_figure());
        Page {
            title: format!("Simulation of {name}"),
            lead: self.conclusion(),
            command,
            sections: vec![
                Section {
                    heading: "Simulation".to_owned(),
                    tables: vec![self.table()],
                    figures,
                    ..Section::default()
                },
                Section::notes(self.notes.clone()),
            ],
        }
    }

    /// The force over displacement and over time, beside the measured one where there is one.
    fn force_figures(&self) -> [Figure; 2] {
        let (x, f) = self.units();
        let (measured, simulated) = match &self.agreement {
            Some(a) => (Some(&a.measured), &a.simulated),
            None => (None, &self.force),
        };
        let figure = |title: &str, abscissa: Axis, values: &[f64]| {
            let mut figure = Figure::new(title, abscissa, Axis::new(self.effort.name(), f));
            if let Some(measured) = measured {
                figure = figure.with(
                    Series::line("measured", values.to_vec(), measured.clone())
                        .colour(Colour::Black),
                );
            }
            figure.with(
                Series::line("simulated", values.to_vec(), simulated.clone())
                    .colour(Colour::Vermillion)
                    .emphasis(Emphasis::Strong),
            )
        };
        [
            figure(
                &capital(&format!("{} over position", self.effort.name())),
                Axis::new("position", x),
                &self.position,
            ),
            figure(
                &capital(&format!("{} over time", self.effort.name())),
                Axis::new("time", "s"),
                &self.t_s,
            ),
        ]
    }

    /// Position, beside the measured one where there is one, and velocity over time.
    fn motion_figures(&self) -> Vec<Figure> {
        let (x, _) = self.units();
        let over_time = |title: &str, what: &str, unit: String| {
            Figure::new(title, Axis::new("time", "s"), Axis::new(what, unit))
        };
        let line =
            |name: &str, values: &[f64]| Series::line(name, self.t_s.clone(), values.to_vec());
        let position = over_time("Position over time", "position", x.to_owned());
        let position = match &self.measured_position {
            Some(measured) => position
                .with(line("measured", measured).colour(Colour::Black))
                .with(
                    line("simulated", &self.position)
                        .colour(Colour::Vermillion)
                        .emphasis(Emphasis::Strong),
                ),
            None => position.with(line("position", &self.position)),
        };
        let velocity = self.velocity.iter().map(|velocity| {
            over_time("Velocity over time", "velocity", format!("{x}/s"))
                .with(line("velocity", velocity))
        });
        std::iter::once(position).chain(velocity).collect()
    }

    /// What is left of the measured effort.
    fn residual_figure(&self) -> Option<Figure> {
        let a = self.agreement.as_ref()?;
        let residual = a
            .measured
            .iter()
            .zip(&a.simulated)
            .map(|(m, s)| m - s)
            .collect();
        let (_, f) = self.units();
        let figure = Figure::new(
            "What the model leaves",
            Axis::new("time", "s"),
            Axis::new("measured − simulated", f),
        );
        Some(figure.with(Series::line("residual", self.t_s.clone(), residual)))
    }
}

pub(super) fn range(values: &[f64]) -> [f64; 2] {
    values
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &v| {
            [low.min(v), high.max(v)]
        })
}
