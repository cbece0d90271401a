//! An identification for people and for machines.

use super::fit::{shown, unit};
use super::plain::Place;
use super::{Identification, Method};
use crate::friction::Path;
use crate::model::{Model, keys_of};
use crate::recording::Recording;
use crate::report::figures::{between, cells, quantity, significant};
use crate::report::units::{name_and_unit, symbol};
use crate::report::{
    Axis, Colour, DisplayUnit, Emphasis, Figure, Page, Section, Series, Style, Table, display_unit,
};
use crate::statistics::Estimate;
use serde_json::{Value, json};

/// Repeats drawn in the loop figure; more would hide each other.
const LOOPS: usize = 2;
/// Points of a model's virgin curve.
const RAMP: i32 = 100;
/// Steps on the way to each of them.
const STEPS: usize = 400;
/// Whose the last columns are.
const PAPERS_METHOD: &str = "The paper's method is that of E. Kamenar and S. Zelenika (Proc. IMechE Part C, JMES-17-1227): blocks read off the mean curve after a reversal.";

impl Identification {
    /// `preslide.identification/1`; `warnings` are the loader's, `seconds` the time it took.
    pub fn to_json(&self, recording: &Recording, seconds: f64) -> Value {
        let friction: Vec<Value> = self
            .candidates
            .iter()
            .map(|c| {
                json!({
                    "kind": c.model.friction.kind(),
                    "blocks": c.size(),
                    "method": c.method.name(),
                    "nmse_train": c.nmse_train,
                    "nmse_test": c.nmse_test,
                    "breakaway_N": breakaway(&c.model),
                    "parameters": c.parameters.iter().map(|(key, e)| ((*key).to_owned(), json!(e))).collect::<serde_json::Map<_, _>>(),
                    "at_edge": c.at_edge,
                    "stiffness_N_per_m": c.blocks.iter().map(|b| b.0).collect::<Vec<_>>(),
                    "yield_displacement_m": c.blocks.iter().map(|b| b.1).collect::<Vec<_>>(),
                })
            })
            .collect();
        let best = self.best();
        let answer = json!({
            "schema": "preslide.identification/1",
            "recording": recording.name,
            "effort_unit": recording.effort_unit(),
            "fit": self.fit_json(recording),
            "parameters": self.parameters_json(recording),
            "band_Hz": self.band_hz,
            "held_out": if self.split.test.is_some() { "test window".to_owned() } else { format!("{} in turn", self.split.units()) },
            "friction": friction,
            "recommended": { "kind": best.model.friction.kind(), "blocks": best.size(), "reason": self.recommendation },
            "warnings": recording.warnings.iter().map(ToString::to_string).chain(self.notes(recording)).collect::<Vec<_>>(),
            "seconds": seconds,
        });
        keys_of(recording.kind, answer)
    }

    /// Rigid body with confidence.
    pub fn rigid_body_table(&self, recording: &Recording) -> Table {
        let rows = self.parameters().map(|(name, e)| {
            let called = match name {
                "coulomb" if self.best().size() > 0 => "coulomb (ΣW)".to_owned(),
                "offset" if self.plain.place == Place::Spring => {
                    "offset (at 0; the spring's)".to_owned()
                }
                name => shown(recording, name),
            };
            (called, unit(recording, name), e)
        });
        let band = quantity(self.band_hz, "Hz");
        Table::parameters(format!("Rigid body, effort low-passed at {band}"), rows)
    }

    /// NMSE against the number of blocks.
    pub fn size_table(&self) -> Table {
        let of = |method: Method, size: usize| {
            self.candidates
                .iter()
                .find(|c| c.method == method && c.size() == size)
                .map_or(["–".to_owned(), "–".to_owned()], |c| {
                    [c.nmse_train, c.nmse_test].map(significant)
                })
        };
        let best = self.best().model.friction.name();
        let marked = |name: &str| format!("{name}{}", if name == best { " *" } else { "" });
        let largest = self.candidates.iter().map(|c| c.size()).max().unwrap_or(0);
        let held_out = if self.split.test.is_some() {
            "test".to_owned()
        } else {
            format!("{} held out", self.split.units())
        };
        let mut rows = vec![{
            let [train, test] = of(Method::LeastSquares, 0);
            vec![
                marked("Coulomb + viscous"),
                train,
                test,
                "–".to_owned(),
                "–".to_owned(),
            ]
        }];
        rows.extend((1..=largest).map(|size| {
            let [train, test] = of(Method::Optimal, size);
            let [paper_train, paper_test] = of(Method::Paper, size);
            vec![
                marked(&format!("GMS, N = {size}")),
                train,
                test,
                paper_train,
                paper_test,
            ]
        }));
        let chosen = self.candidates.iter();
        rows.extend(
            chosen
                .filter(|c| matches!(c.method, Method::Descent(_)))
                .map(|c| {
                    vec![
                        marked(&c.model.friction.name()),
                        significant(c.nmse_train),
                        significant(c.nmse_test),
                        "–".to_owned(),
                        "–".to_owned(),
                    ]
                }),
        );
        Table {
            caption: "Error (NMSE) in % of the effort's variance; * recommended".to_owned(),
            head: [
                "model".to_owned(),
                "best blocks: train".to_owned(),
                held_out.clone(),
                "paper's method: train".to_owned(),
                held_out,
            ]
            .to_vec(),
            rows,
        }
    }

    /// Parameters of a model of the family with confidence; none for Coulomb friction and GMS.
    pub fn parameter_table(&self, recording: &Recording) -> Option<Table> {
        let best = self.best();
        let rows = best.parameters.iter().map(|(key, e)| {
            let (name, unit) = name_and_unit(&best.model.key(key), recording.effort_unit());
            (name, unit, *e)
        });
        let name = best.model.friction.name();
        (!best.parameters.is_empty()).then(|| {
            let caption = format!("{name}; – stands where nothing was fitted");
            Table::parameters(caption, rows)
        })
    }

    /// The recommended model's blocks with confidence; none for models without blocks.
    pub fn block_table(&self, recording: &Recording) -> Option<Table> {
        let best = self.best();
        let total: f64 = best.blocks.iter().map(|(k, d)| k.value * d.value).sum();
        let (x, f) = (recording.position_unit(), force_unit(recording));
        let largest = |of: &dyn Fn(&(Estimate, Estimate)) -> f64, unit: &str| {
            let values = best.blocks.iter().map(of);
            display_unit(unit, values.fold(0.0, f64::max))
        };
        let stiffness = largest(&|b| b.0.value, &format!("{f}/{x}"));
        let length = largest(&|b| b.1.value, x);
        (!best.blocks.is_empty()).then(|| Table {
            caption: format!(
                "Maxwell-slip blocks, breakaway force {}",
                quantity(total, f)
            ),
            head: [
                "block".to_owned(),
                format!("stiffness [{}]", stiffness.unit),
                "95 %".to_owned(),
                format!("yield displacement [{}]", length.unit),
                "95 %".to_owned(),
                "weight".to_owned(),
            ]
            .to_vec(),
            rows: best
                .blocks
                .iter()
                .enumerate()
                .map(|(i, (k, d))| {
                    let told = |e: &Estimate, shown: &DisplayUnit| {
                        let [value, low, high] = cells(e.value, e.ci95, shown.factor);
                        let interval = match e.ci95 {
                            Some(_) => format!("{low} … {high}"),
                            None => low,
                        };
                        [value, interval]
                    };
                    let [[k_value, k_interval], [d_value, d_interval]] =
                        [told(k, &stiffness), told(d, &length)];
                    vec![
                        (i + 1).to_string(),
                        k_value,
                        k_interval,
                        d_value,
                        d_interval,
                        format!("{:.3}", k.value * d.value / total),
                    ]
                })
                .collect(),
        })
    }

    /// The report page.
    pub fn page(&self, recording: &Recording, command: String) -> Page {
        let tables = [
            Some(self.rigid_body_table(recording)),
            self.parameter_table(recording),
            self.block_table(recording),
        ];
        let warnings = recording.warnings.iter().map(|w| w.message.clone());
        Page {
            title: format!("Identification of {}", recording.name),
            lead: self.recommendation.clone(),
            command,
            sections: vec![
                Section {
                    heading: "Parameters".to_owned(),
                    tables: tables.into_iter().flatten().collect(),
                    ..Section::default()
                },
                Section {
                    heading: "Friction model".to_owned(),
                    paragraphs: [self.measure(), PAPERS_METHOD.to_owned()]
                        .into_iter()
                        .chain(self.why_not_the_papers(recording))
                        .collect(),
                    tables: vec![self.size_table()],
                    figures: vec![
                        self.loops_figure(recording),
                        self.sizes_figure(),
                        self.virgin_figure(recording),
                    ],
                },
                Section {
                    heading: "What the model leaves".to_owned(),
                    paragraphs: vec![
                        "Structure in these plots is physics that the model lacks.".to_owned(),
                    ],
                    figures: self.residual_figures(recording),
                    ..Section::default()
                },
                Section::notes(warnings.chain(self.notes(recording))),
            ],
        }
    }

    /// What the NMSE is of, and what was held out.
    pub fn measure(&self) -> String {
        let filtered = if self.filtered {
            format!(
                " (measured effort after the zero-phase low-pass at {:.1} Hz)",
                self.band_hz
            )
        } else {
            String::new()
        };
        let held_out = if self.split.test.is_some() {
            "the test window, which no fit saw".to_owned()
        } else {
            format!(
                "{} that were left out of the fit in turn",
                self.split.units()
            )
        };
        format!(
            "NMSE is the squared error over the variance of the effort that the model explains{filtered}. Held-out figures come from {held_out}."
        )
    }

    /// Effort over position, measured and modelled.
    fn loops_figure(&self, recording: &Recording) -> Figure {
        let best = self.best();
        let shown = self.shown(recording);
        let position = of_rows(&recording.position, &shown);
        let effort = if self.filtered {
            "effort, low-passed"
        } else {
            "friction"
        };
        let line = |name: &str, values: &[f64]| {
            Series::line(name, position.clone(), of_rows(values, &shown))
        };
        let baseline = line("Coulomb + viscous", &self.candidates[0].fitted);
        let mut loops = Figure::new(
            "Force–displacement loops",
            Axis::new("position", recording.position_unit()),
            Axis::new(effort, force_unit(recording)),
        )
        .with(line("measured", &self.effort).colour(Colour::Black))
        .with(baseline.style(Style::Dashed).colour(Colour::Sky));
        if self.recommended > 0 {
            loops = loops.with(
                line(&best.model.friction.name(), &best.fitted)
                    .emphasis(Emphasis::Strong)
                    .colour(Colour::Vermillion),
            );
        }
        let [from, to] =
            [shown.first(), shown.last()].map(|i| i.map_or(0.0, |&i| recording.t_s[i]));
        loops.note(format!("Measured {}.", between(from, to, "s")))
    }

    /// NMSE over the number of blocks.
    fn sizes_figure(&self) -> Figure {
        let mut sizes = Figure::new(
            "What each block buys",
            Axis::new("Maxwell-slip blocks N", ""),
            Axis::new("error (NMSE)", "%").log(),
        );
        for (method, name, colour) in [
            (Method::Optimal, "best blocks", Colour::Vermillion),
            (Method::Paper, "paper's method", Colour::Blue),
        ] {
            let of_method: Vec<_> = self
                .candidates
                .iter()
                .filter(|c| c.method == method)
                .collect();
            let n: Vec<f64> = of_method.iter().map(|c| c.size() as f64).collect();
            let test = of_method.iter().map(|c| c.nmse_test).collect();
            let train = of_method.iter().map(|c| c.nmse_train).collect();
            let held_out = Series::line(format!("{name}, held out"), n.clone(), test);
            let fitted = Series::line(format!("{name}, train"), n, train);
            sizes = sizes
                .with(held_out.style(Style::LinePoints).colour(colour))
                .with(fitted.style(Style::Dashed).colour(colour));
        }
        sizes
    }

    /// The virgin curve, measured and modelled. Logarithmic: the yields of the blocks lie decades apart. Rest, where all is zero, has
    /// no place there.
    fn virgin_figure(&self, recording: &Recording) -> Figure {
        let best = self.best();
        let mut virgin = Figure::new(
            "Virgin curve (mean branch after a reversal, halved)",
            Axis::new("displacement", recording.position_unit()).log(),
            Axis::new("friction", force_unit(recording)),
        )
        .with(
            Series::line(
                "measured",
                self.virgin.displacement.iter().skip(1).copied().collect(),
                self.virgin.force.iter().skip(1).copied().collect(),
            )
            .colour(Colour::Black),
        );
        if self.recommended > 0 {
            let name = best.model.friction.name();
            let (displacement, force) = self.ramp();
            virgin =
                virgin.with(Series::line(name, displacement, force).colour(Colour::Vermillion));
        }
        if best.size() > 0 {
            let yields: Vec<f64> = best.blocks.iter().map(|(_, d)| d.value).collect();
            let force = yields.iter().map(|d| best.virgin_force(*d).value).collect();
            virgin = virgin.with(
                Series::points("yields of the blocks", yields, force).colour(Colour::Vermillion),
            );
        }
        virgin
    }

    /// What the model leaves over time, position and velocity, and how the friction level changes.
    fn residual_figures(&self, recording: &Recording) -> Vec<Figure> {
        let (x, f) = (recording.position_unit(), force_unit(recording));
        let best = self.best();
        let rows: Vec<usize> = match &self.split.test {
            Some(test) => [self.split.train(), test.clone()].concat(),
            None => self.split.train(),
        };
        let residual: Vec<f64> = rows
            .iter()
            .map(|&i| self.effort[i] - best.fitted[i])
            .collect();
        let against = |title: &str, axis: Axis, values: &[f64]| {
            Figure::new(title, axis, Axis::new("measured − model", f)).with(Series::points(
                "residual",
                of_rows(values, &rows),
                residual.clone(),
            ))
        };
        let levels = self.levels(recording);
        let gains = Series::line(
            format!("gain per {}", self.split.unit),
            levels.iter().map(|l| l.start).collect(),
            levels.iter().map(|l| l.gain).collect(),
        );
        let level = Figure::new(
            "Friction level over time",
            Axis::new("time", "s"),
            Axis::new("measured over model", ""),
        );
        vec![
            against(
                "Residual against time",
                Axis::new("time", "s"),
                &recording.t_s,
            ),
            against(
                "Residual against position",
                Axis::new("position", x),
                &recording.position,
            ),
            against(
                "Residual against velocity",
                Axis::new("velocity", format!("{x}/s")),
                &self.velocity,
            ),
            level.with(gains.style(Style::LinePoints)),
        ]
    }

    /// The recommended model's virgin curve at a tenth of the recording's top speed: displacements from a tenth of the shortest
    /// yield to half of the longest stroke, evenly on a logarithmic axis, and the force at the end of each. Nothing where the
    /// library refuses the model.
    fn ramp(&self) -> (Vec<f64>, Vec<f64>) {
        let (shortest, longest) = self.yield_range;
        let speed = 0.1 * self.top_speed();
        let growth = (10.0 * longest / shortest).powf(1.0 / RAMP as f64);
        let displacement: Vec<f64> = (0..=RAMP)
            .map(|i| 0.1 * shortest * growth.powi(i))
            .collect();
        let force = displacement
            .iter()
            .map(|&x| {
                let position: Vec<f64> = (0..=STEPS).map(|i| x * i as f64 / STEPS as f64).collect();
                let whole = 0..position.len();
                let path = Path {
                    position: &position,
                    velocity: &vec![speed; position.len()],
                    pieces: std::slice::from_ref(&whole),
                    sample_time: x / STEPS as f64 / speed,
                };
                self.best().model.friction.force(path).ok()?.pop()
            })
            .collect::<Option<Vec<f64>>>();
        force.map_or_else(Default::default, |force| (displacement, force))
    }

    /// The last whole repeats of the test data, or of the training data.
    fn shown(&self, recording: &Recording) -> Vec<usize> {
        let train = self.split.train();
        let rows = self.split.test.as_ref().unwrap_or(&train);
        let labels = if self.split.unit == "repeat" {
            &recording.repeat
        } else {
            &recording.segment
        };
        let mut last: Vec<u32> = rows.iter().map(|&i| labels[i]).collect();
        last.dedup();
        // The window may cut the last one short.
        let end = last.len().saturating_sub(1).max(1);
        let kept = &last[end.saturating_sub(LOOPS)..end];
        rows.iter()
            .copied()
            .filter(|&i| kept.contains(&labels[i]))
            .collect()
    }
}

/// Breakaway force `ΣW` (N or N·m) of a GMS, Coulomb force of a Coulomb model.
fn breakaway(model: &Model) -> f64 {
    model.friction.scalars().first().map_or(f64::NAN, |s| s.1)
}

fn force_unit(recording: &Recording) -> &'static str {
    symbol(recording.effort_unit())
}

/// The values at some samples.
fn of_rows(values: &[f64], rows: &[usize]) -> Vec<f64> {
    rows.iter().map(|&i| values[i]).collect()
}
