//! What a table of speed and effort tells, for people and for machines.

use super::SpeedTable;
use crate::identify::fit::key;
use crate::report::figures::{left, range};
use crate::report::units::symbol;
use crate::report::{Axis, Emphasis, Figure, Page, Section, Series, Table};
use crate::statistics::Estimate;
use serde_json::{Value, json};

impl SpeedTable {
    /// What the law is called.
    fn law(&self) -> &'static str {
        match self.get("static") {
            Some(_) => "Coulomb + viscous + Stribeck",
            None => "Coulomb + viscous",
        }
    }

    fn force_unit(&self) -> &'static str {
        symbol(self.speeds.role.unit())
    }

    fn velocity_unit(&self) -> String {
        format!("{}/s", self.speeds.kind.unit())
    }

    /// The parameters with their intervals.
    pub fn table(&self) -> Table {
        let (force, position) = (self.force_unit(), self.speeds.kind.unit());
        let unit = |name: &str| match name {
            "stribeck_velocity" => self.velocity_unit(),
            "stribeck_exponent" => String::new(),
            name if name.starts_with("viscous") => format!("{force}·s/{position}"),
            _ => force.to_owned(),
        };
        let rows = self.parameters.iter();
        Table::parameters(
            format!("{}, {} speeds", self.law(), self.fitted.len()),
            rows.map(|(name, e)| (name.replace('_', " "), unit(name), *e)),
        )
    }

    /// What the user should know.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = self.notes.clone();
        if self.get("coulomb_and_offset").is_some() {
            notes.push("all speeds are in one direction: Coulomb friction and a constant force come out as their sum; measure both directions".to_owned());
        }
        let unsure = |p: &&(&str, Estimate)| {
            p.1.ci95.is_some_and(|[low, high]| low < 0.0 && high > 0.0) && p.0 != "offset"
        };
        for (name, _) in self.parameters.iter().filter(unsure) {
            notes.push(format!("{} may be zero", name.replace('_', " ")));
        }
        notes
    }

    /// One sentence: what the table shows, and what it cannot.
    pub fn recommendation(&self) -> String {
        format!(
            "Use {} friction ({} of the variance left on rows held out). A table without time shows no inertia and no pre-sliding; record a motion with reversals for those.",
            self.law(),
            left(self.nmse_held_out)
        )
    }

    /// What stands at the head of the model's file.
    pub fn remarks(&self) -> Vec<String> {
        vec![
            format!(
                "identified from {}, a table without time: no inertia",
                self.speeds.name
            ),
            format!(
                "NMSE {:.4} % fitted, {:.4} % held out",
                self.nmse_train, self.nmse_held_out
            ),
        ]
    }

    /// `preslide.identification/1`, as for recordings; `seconds` is the time it took.
    pub fn to_json(&self, seconds: f64) -> Value {
        let parameters: serde_json::Map<String, Value> = self
            .parameters
            .iter()
            .map(|(name, e)| (key(self.speeds.kind, name), json!(e)))
            .collect();
        json!({
            "schema": "preslide.identification/1",
            "recording": self.speeds.name,
            "effort_unit": self.speeds.role.unit(),
            "fit": {
                "law": self.law(),
                "kind": "coulomb",
                "blocks": 0,
                "nmse_held_out": self.nmse_held_out,
                "parameters": parameters,
                "rows": self.fitted.len(),
                "stick_slip": null,
                "saturation": null,
                "delay": null,
                "between": [],
            },
            "parameters": parameters,
            "band_Hz": null,
            "held_out": "rows in turn",
            "friction": [{
                "kind": "coulomb",
                "blocks": 0,
                "method": "least squares",
                "nmse_train": self.nmse_train,
                "nmse_test": self.nmse_held_out,
            }],
            "recommended": { "kind": "coulomb", "blocks": 0, "reason": self.recommendation() },
            "warnings": self.warnings().chain(self.notes()).collect::<Vec<_>>(),
            "seconds": seconds,
        })
    }

    /// The report page.
    pub fn page(&self, command: String) -> Page {
        let axis = |label: &str, unit: &str| Axis::new(label, unit);
        let mut order: Vec<usize> = (0..self.fitted.len()).collect();
        order.sort_by(|a, b| self.speeds.velocity[*a].total_cmp(&self.speeds.velocity[*b]));
        let of = |values: &[f64]| order.iter().map(|&i| values[i]).collect::<Vec<_>>();
        let v = of(&self.speeds.velocity);
        let figure = Figure::new(
            "Friction over speed",
            axis("velocity", &self.velocity_unit()),
            axis("effort", self.force_unit()),
        )
        .with(Series::points(
            "measured",
            v.clone(),
            of(&self.speeds.effort),
        ))
        .with(Series::line(self.law(), v, of(&self.fitted)).emphasis(Emphasis::Strong));
        Page {
            title: format!("Identification of {}", self.speeds.name),
            lead: self.recommendation(),
            command,
            sections: vec![
                Section {
                    heading: "Friction".to_owned(),
                    tables: vec![self.table()],
                    figures: vec![figure],
                    ..Section::default()
                },
                Section::notes(self.warnings().chain(self.notes())),
            ],
        }
    }

    /// Rows, speeds and efforts in one line, as for recordings.
    pub fn in_one_line(&self) -> String {
        let [(slow, fast), (low, high)] = self.speeds.ranges();
        format!(
            "{}   {} rows without time · {} · {} {}",
            self.speeds.name,
            self.fitted.len(),
            range(slow, fast, &self.velocity_unit()),
            self.speeds.role.name(),
            range(low, high, self.force_unit())
        )
    }

    /// What the loader noticed.
    pub fn warnings(&self) -> impl Iterator<Item = String> {
        self.speeds.warnings.iter().map(ToString::to_string)
    }
}
