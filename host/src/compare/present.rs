//! A comparison for people and for machines.

use super::{Compared, Comparison, NEAR, TICK};
use preslide_fit::friction::FrictionModel;
use preslide_fit::identify::family::bench::SEED;
use preslide_fit::model::keys_of;
use preslide_fit::recording::Recording;
use preslide_fit::report::figures::{quantity, significant};
use preslide_fit::report::units::name_and_unit;
use preslide_fit::report::{Axis, Colour, Emphasis, Figure, Page, Section, Series, Style, Table};
use serde_json::{Value, json};

/// Strokes drawn in the loop figure; more would hide each other.
const STROKES: usize = 2;

impl Compared {
    /// Its name in tables.
    pub fn name(&self) -> String {
        self.candidate.model.friction.name()
    }

    /// The model file as JSON: its keys carry the unit, on linear and rotary axes alike.
    fn file(&self) -> Value {
        toml::from_str(&self.candidate.model.to_toml(&[])).unwrap_or(Value::Null)
    }

    /// `name value, name value, …`, for an effort in such a unit.
    pub fn parameters_in_words(&self, effort: &str) -> String {
        fn words(value: &Value, effort: &str) -> String {
            let pairs = value.as_object().into_iter().flatten();
            let id = value.get("id").and_then(Value::as_str);
            let said = pairs.filter_map(|(key, value)| match value {
                Value::Number(number) => {
                    let (name, unit) = name_and_unit(key, effort);
                    Some(format!("{name} {}", quantity(number.as_f64()?, &unit)))
                }
                Value::Array(items) => {
                    let items: Vec<String> = items.iter().map(|i| words(i, effort)).collect();
                    let items = items.join("; ");
                    Some(match key.as_str() {
                        "effects" => items,
                        key => format!("{key} ({items})"),
                    })
                }
                Value::Object(_) => Some(words(value, effort)),
                _ => None,
            });
            let id = id.map(|id| id.replace('_', " "));
            id.into_iter().chain(said).collect::<Vec<_>>().join(", ")
        }
        words(&self.file(), effort)
    }

    fn loops_in_words(&self) -> &'static str {
        match self.memory_in_words() {
            "non-local" => "its inner loops close",
            "local" => "its inner loops do not close",
            _ => "it has no memory",
        }
    }

    fn memory_in_words(&self) -> &'static str {
        match (self.memory.is_nonlocal(), self.memory.remembers) {
            (true, _) => "non-local",
            (false, true) => "local",
            (false, false) => "none",
        }
    }
}

impl Comparison {
    /// What to use and why, as `identify` says it, and what would cost less or leave less.
    pub fn recommendation(&self) -> String {
        let Some(best) = self.models.get(self.recommended) else {
            return String::new();
        };
        let cycles = |m: &Compared| {
            m.cost.as_ref().map_or(String::new(), |c| {
                format!(", {:.0} cycles in a control tick", c.cycles_mean)
            })
        };
        let (loops, cost) = (best.loops_in_words(), cycles(best));
        let use_it = format!(
            "{} With {} {loops}{cost}.",
            self.identification.recommendation,
            best.name()
        );
        let Some(cheapest) = self.cheapest else {
            return use_it;
        };
        let m = &self.models[cheapest];
        let which = match cheapest == self.recommended {
            true => format!("{}, too", m.name()),
            false => format!(
                "{} ({} %, {}{})",
                m.name(),
                significant(m.candidate.nmse_test),
                m.loops_in_words(),
                cycles(m)
            ),
        };
        format!(
            "{use_it} Of all in the table that take up to {TICK:.0} cycles (5 % of 170 MHz at 20 kHz) and have no parameter at the bound of its search, the cheapest within {:.0} % of their lowest error is {which}.",
            100.0 * (NEAR - 1.0),
        )
    }

    /// `preslide.comparison/1`; `seconds` is the time it took.
    pub fn to_json(&self, recording: &Recording, seconds: f64) -> Value {
        let models: Vec<Value> = self
            .models
            .iter()
            .map(|m| {
                let blocks = match &m.candidate.model.friction {
                    FrictionModel::Gms { blocks, .. } => Some(blocks.len()),
                    _ => None,
                };
                json!({
                    "kind": m.candidate.model.friction.kind(),
                    "blocks": blocks,
                    "nmse_train": m.candidate.nmse_train,
                    "nmse_test": m.candidate.nmse_test,
                    "loop_closure_N": m.memory.largest,
                    "loop_closure_share": m.memory.largest / m.memory.range,
                    "nonlocal_memory": m.memory.is_nonlocal(),
                    "cycles_mean": m.cost.as_ref().map(|c| c.cycles_mean),
                    "cycles_worst": m.cost.as_ref().map(|c| c.cycles_worst),
                    "fitted_parameters": m.candidate.fitted_parameters(),
                    "at_edge": m.candidate.at_edge,
                    "model": m.file(),
                })
            })
            .collect();
        let answer = json!({
            "schema": "preslide.comparison/1",
            "recording": recording.name,
            "effort_unit": recording.effort_unit(),
            "held_out": self.held_out(),
            "fit": self.identification.fit_json(recording),
            "band_Hz": self.identification.filtered.then_some(self.identification.band_hz),
            "seed": SEED,
            "models": models,
            "recommended": self.models.get(self.recommended).map(|m| json!({
                "kind": m.candidate.model.friction.kind(),
                "index": self.recommended,
                "reason": self.recommendation(),
            })),
            "cheapest": self.cheapest,
            "warnings": recording.warnings.iter().map(ToString::to_string).chain(self.notes.iter().cloned()).collect::<Vec<_>>(),
            "seconds": seconds,
        });
        keys_of(recording.kind, answer)
    }

    fn held_out(&self) -> String {
        let split = &self.identification.split;
        match &split.test {
            Some(_) => "test window".to_owned(),
            None => format!("{} in turn", split.units()),
        }
    }

    /// Error, memory and cost of every model.
    pub fn table(&self, recording: &Recording) -> Table {
        let unit = recording.effort_unit();
        let mark = |i: usize| if i == self.recommended { " *" } else { "" };
        Table::of(
            format!(
                "Error (NMSE), %; held out: {}; cycles on a Cortex-M4F; seed {SEED}; * recommended",
                self.held_out()
            ),
            self.models.iter().enumerate(),
        )
        .column("model", |(i, m)| format!("{}{}", m.name(), mark(*i)))
        .column("train", |(_, m)| significant(m.candidate.nmse_train))
        .column("held out", |(_, m)| significant(m.candidate.nmse_test))
        .column("parameters", |(_, m)| {
            m.candidate.fitted_parameters().to_string()
        })
        .column("loop closure", |(_, m)| quantity(m.memory.largest, unit))
        .column("of range", |(_, m)| match m.memory.range > 0.0 {
            true => format!(
                "{} %",
                significant(100.0 * m.memory.largest / m.memory.range)
            ),
            false => "–".to_owned(),
        })
        .column("memory", |(_, m)| m.memory_in_words().to_owned())
        .column("cycles", |(_, m)| {
            let cost = m.cost.as_ref();
            cost.map_or("not measured".to_owned(), |c| {
                format!("{:.0}", c.cycles_mean)
            })
        })
        .table()
    }

    /// The parameters of every model.
    fn parameter_table(&self, recording: &Recording) -> Table {
        let effort = recording.effort_unit();
        Table::of("Parameters", &self.models)
            .column("model", |m| m.name())
            .column("parameters", |m| m.parameters_in_words(effort))
            .table()
    }

    /// How far each nested loop is from closing.
    fn memory_table(&self, recording: &Recording) -> Table {
        let force = |e: f64| quantity(e, recording.effort_unit());
        Table::of("|force on return − force at the reversal|, the widest inner loop first, each half as wide as the one before", &self.models).column("model", |m| m.name()).column("widest", |m| {
                    let widest = m.memory.widths.first();
                    widest.map_or(String::new(), |w| quantity(*w, recording.position_unit()))
                }).column("errors", |m| {
                    let errors = m.memory.errors.iter().map(|e| force(*e));
                    errors.collect::<Vec<_>>().join(", ")
                }).column("worst at a hundredth of the speed", |m| force(m.memory.largest_slow)).table()
    }

    /// The report page.
    pub fn page(&self, recording: &Recording, command: String) -> Page {
        let [loops, nested, residuals] = self.curves(recording);
        let [sizes, costs] = self.errors();
        let section = |heading: &str, tables, figures, paragraphs| Section {
            heading: heading.to_owned(),
            paragraphs,
            tables,
            figures,
        };
        let measure = format!(
            "{} Inertia, viscous part and offset are fitted beside every model.",
            self.identification.measure()
        );
        let warnings = recording.warnings.iter().map(|w| w.message.clone());
        Page {
            title: format!("Friction models on {}", recording.name),
            lead: self.recommendation(),
            command,
            sections: vec![
                section(
                    "Models",
                    vec![self.table(recording), self.parameter_table(recording)],
                    vec![loops, sizes, costs],
                    vec![measure],
                ),
                section(
                    "Non-local memory",
                    vec![self.memory_table(recording)],
                    vec![nested],
                    vec!["A model has non-local memory when every inner loop closes to rounding (1e-9 of the force's range). Coulomb friction has nothing to remember, hence its zeros.".to_owned()],
                ),
                section("What the models leave", Vec::new(), vec![residuals], Vec::new()),
                Section::notes(warnings.chain(self.notes.iter().cloned())),
            ],
        }
    }

    /// A curve of each model: over position, through nested reversals, and what it leaves over time.
    fn curves(&self, recording: &Recording) -> [Figure; 3] {
        let (x, f) = (recording.position_unit(), recording.effort_unit());
        let split = &self.identification.split;
        let train = split.train();
        let judged = split.test.as_ref().unwrap_or(&train);
        let shown = last_strokes(recording, judged);
        let of = |values: &[f64], rows: &[usize]| -> Vec<f64> {
            rows.iter().map(|&i| values[i]).collect()
        };
        let effort = &self.identification.effort;
        let named = if self.identification.filtered {
            "effort, low-passed"
        } else {
            "friction"
        };
        let measured = Series::line(
            "measured",
            of(&recording.position, &shown),
            of(effort, &shown),
        );
        let mut loops = Figure::new(
            "Force–displacement loops",
            Axis::new("position", x),
            Axis::new(named, f),
        )
        .with(measured.colour(Colour::Black).emphasis(Emphasis::Strong));
        let mut residuals = Figure::new(
            "Residual against time, held-out samples",
            Axis::new("time", "s"),
            Axis::new("measured − model", f),
        );
        let mut nested = Figure::new(
            "Nested reversals",
            Axis::new("position", x),
            Axis::new("friction model", f),
        );
        // More kinds of models than colours: the second round is dashed.
        let rounds = [Style::Line, Style::Dashed]
            .into_iter()
            .flat_map(|style| Colour::PALETTE.map(|colour| (colour, style)));
        for (m, (colour, style)) in self.drawn().zip(rounds) {
            let line = |x, y| Series::line(m.name(), x, y).colour(colour).style(style);
            loops = loops.with(line(
                of(&recording.position, &shown),
                of(&m.candidate.fitted, &shown),
            ));
            let residual: Vec<f64> = judged
                .iter()
                .map(|&i| effort[i] - m.candidate.fitted[i])
                .collect();
            residuals = residuals.with(line(of(&recording.t_s, judged), residual));
            nested = nested.with(line(m.memory.position.clone(), m.memory.force.clone()));
        }
        let data = if split.test.is_some() {
            "test"
        } else {
            "training"
        };
        [
            loops.note(format!("The last {STROKES} whole strokes of the {data} data.")),
            nested.note("Each model runs an outer loop over the recording's stroke, then reversals at 1/2, 1/4, … of its half, and back through the same reversals. A model with non-local memory draws each inner branch as a closed loop."),
            residuals,
        ]
    }

    /// The error held out over the number of parameters, and over the cycles of a control tick.
    fn errors(&self) -> [Figure; 2] {
        let mut sizes = Figure::new(
            "Error against number of parameters",
            Axis::new("fitted friction parameters", ""),
            Axis::new("error (NMSE), held out", "%").log(),
        );
        let mut costs = Figure::new(
            "Error against cost",
            Axis::new("cycles in a control tick", ""),
            Axis::new("error (NMSE), held out", "%").log(),
        )
        .note("What a tick in f32 on a Cortex-M4F grows by. Models without a measured kernel are missing here.");
        for m in &self.models {
            let point = |at: f64| {
                Series::line(m.name(), vec![at], vec![m.candidate.nmse_test]).style(Style::Points)
            };
            sizes = sizes.with(point(m.candidate.fitted_parameters() as f64));
            if let Some(cost) = &m.cost {
                costs = costs.with(point(cost.cycles_mean));
            }
        }
        [sizes, costs]
    }

    /// The models worth a curve of their own: one of each kind, for GMS the one that errs least.
    fn drawn(&self) -> impl Iterator<Item = &Compared> {
        self.models.iter().filter(|m| {
            self.models.iter().all(|other| {
                other.candidate.model.friction.kind() != m.candidate.model.friction.kind()
                    || m.candidate.nmse_test <= other.candidate.nmse_test
            })
        })
    }
}

/// Samples of the last whole strokes among `rows`; the last one may be cut by the window.
fn last_strokes(recording: &Recording, rows: &[usize]) -> Vec<usize> {
    let mut strokes: Vec<u32> = rows.iter().map(|&i| recording.segment[i]).collect();
    strokes.dedup();
    let end = strokes.len().saturating_sub(1).max(1).min(strokes.len());
    let kept = &strokes[end.saturating_sub(STROKES)..end];
    rows.iter()
        .copied()
        .filter(|&i| kept.contains(&recording.segment[i]))
        .collect()
}
