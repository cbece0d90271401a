//! One model at one rate on every core: which can run it, and what each takes.

use super::{Budget, Choice, Tuning};
use crate::cost::Core;
use preslide_fit::report::{Axis, Colour, Figure, Page, Section, Series, Table};
use serde_json::{Value, json};

/// The tuning for one core.
pub struct OnCore {
    /// The core.
    pub core: &'static Core,
    /// What fits there.
    pub tuning: Tuning,
}

/// The tunings of one model for several cores.
pub struct Comparison {
    /// In the order of [`crate::cost::CORES`].
    pub cores: Vec<OnCore>,
}

impl OnCore {
    fn chosen(&self) -> Option<&Choice> {
        let (index, _) = self.tuning.recommended.as_ref().ok()?;
        self.tuning.choices.get(*index)
    }

    /// Microseconds of so many cycles.
    fn time(&self, cycles: f64) -> f64 {
        1e6 * cycles / self.tuning.budget.clock
    }
}

impl Comparison {
    /// Whether the model fits on one of them at least.
    pub fn fits(&self) -> bool {
        self.cores.iter().any(|on| on.chosen().is_some())
    }

    /// A row for each core.
    pub fn table(&self) -> Table {
        let head = [
            "core", "MHz", "N", "kernel", "rounding", "NMSE", "cycles", "worst", "µs", "share",
        ];
        let row = |on: &OnCore| {
            let mut cells = vec![
                on.core.title.to_owned(),
                format!("{:.0}", 1e-6 * on.tuning.budget.clock),
            ];
            match on.chosen() {
                Some(c) => cells.extend([
                    c.cost.blocks.to_string(),
                    c.kernel.name().to_owned(),
                    format!("{:.4}", c.arithmetic),
                    c.nmse_test
                        .map_or("–".to_owned(), |nmse| format!("{nmse:.3}")),
                    format!("{:.0}", c.cost.cycles_mean),
                    format!("{:.0}", c.cost.cycles_worst),
                    format!("{:.2}", on.time(c.cost.cycles_worst)),
                    format!("{:.2} %", 100.0 * c.share),
                ]),
                None => {
                    cells.extend(["–", "nothing fits"].map(str::to_owned));
                    cells.resize(head.len(), "–".to_owned());
                }
            }
            cells
        };
        let rate = self.cores.first().map_or(0.0, |on| on.tuning.budget.rate);
        Table {
            caption: format!(
                "What each core should run at {rate:.0} Hz, inlined into a control tick; rounding, % of the breakaway force; NMSE held out, %; µs and share at worst"
            ),
            head: head.map(str::to_owned).to_vec(),
            rows: self.cores.iter().map(row).collect(),
        }
    }

    /// Where the figures come from, and why a core fits nothing.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        for on in &self.cores {
            notes.push(format!("{}: {}", on.core.title, on.tuning.origin));
            if let Err(reason) = &on.tuning.recommended {
                notes.push(format!("{}: {reason}", on.core.title));
            }
        }
        let mut said: Vec<(&str, Vec<&str>)> = Vec::new();
        for on in &self.cores {
            for note in &on.tuning.notes {
                match said.iter_mut().find(|(known, _)| known == note) {
                    Some((_, cores)) => cores.push(on.core.title),
                    None => said.push((note, vec![on.core.title])),
                }
            }
        }
        // What holds on every core is said without them.
        notes.extend(said.into_iter().map(|(note, cores)| {
            if cores.len() == self.cores.len() {
                note.to_owned()
            } else {
                format!("{}: {note}", cores.join(", "))
            }
        }));
        notes
    }

    /// `preslide.tuning-cores/1`: `preslide.tuning/1` for each core.
    pub fn to_json(&self, seconds: f64) -> Value {
        let core = |on: &OnCore| {
            json!({
                "cpu": on.core.names[0],
                "names": on.core.names,
                "title": on.core.title,
                "figures": on.core.standing.word(),
                "tuning": on.tuning.to_json(0.0),
            })
        };
        json!({
            "schema": "preslide.tuning-cores/1",
            "cores": self.cores.iter().map(core).collect::<Vec<_>>(),
            "fits": self.fits(),
            "seconds": seconds,
        })
    }

    /// The page: the comparison, then every core's choices.
    pub fn page(&self, command: String) -> Page {
        let mut sections = vec![Section {
            heading: "The cores beside each other".to_owned(),
            paragraphs: self.notes().iter().map(|note| format!("{note}.")).collect(),
            tables: vec![self.table()],
            figures: vec![self.figure()],
        }];
        for on in &self.cores {
            sections.push(Section {
                heading: on.core.title.to_owned(),
                paragraphs: vec![on.tuning.recommendation()],
                tables: vec![on.tuning.table()],
                figures: vec![on.tuning.figure()],
            });
        }
        Page {
            title: "One model on several cores".to_owned(),
            lead: format!(
                "The model fits its budget on {} of {} cores.",
                self.cores.iter().filter(|on| on.chosen().is_some()).count(),
                self.cores.len()
            ),
            command,
            sections,
        }
    }

    /// Error against time, a mark for every choice and each core's frontier.
    fn figure(&self) -> Figure {
        let recorded = self.cores.iter().any(|on| on.tuning.recorded);
        let y = match recorded {
            true => Axis::new("NMSE held out", "%").log(),
            false => Axis::new("error of the arithmetic", "%").log(),
        };
        let mut figure = Figure::new(
            "Error against time on each core: every choice, and the line of the unbeaten ones",
            Axis::new("time a tick at worst", "µs").log(),
            y,
        );
        for (on, colour) in self.cores.iter().zip(Colour::PALETTE) {
            let error = |c: &Choice| c.nmse_test.unwrap_or(c.arithmetic);
            let mut points: Vec<(f64, f64)> = on
                .tuning
                .choices
                .iter()
                .map(|c| (on.time(c.cost.cycles_worst), error(c)))
                .filter(|(_, error)| *error > 0.0)
                .collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
            let best = frontier(&points);
            let (x, y) = points.into_iter().unzip();
            figure = figure.with(Series::points(on.core.title, x, y).colour(colour));
            if best.len() > 1 {
                let (x, y) = best.into_iter().unzip();
                let line = Series::line(format!("{}, frontier", on.core.title), x, y);
                figure = figure.with(line.colour(colour));
            }
        }
        figure.note("No line where one choice beats all others. Each core has its own clock unless --clock was given.")
    }
}

/// Of points in the order of their time those with less error than all before.
fn frontier(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut best = f64::INFINITY;
    let better = |point: &&(f64, f64)| {
        let is = point.1 < best;
        best = best.min(point.1);
        is
    };
    points.iter().filter(better).copied().collect()
}

/// What a budget is on a core: at its rated clock, unless another is given.
pub fn budget_on(core: &Core, clock: Option<f64>, rate: f64, share: f64) -> Budget {
    Budget {
        clock: clock.unwrap_or(core.clock),
        rate,
        share,
    }
}
