//! The study for people and for machines: all models on Figure 6, the experiment, and errors against cycles.

use super::Reproduction;
use super::experiment::{Experiment, Interval, REPEATS, VARIABILITY};
use super::figure_6::{Figure6, Origin, Row};
use preslide_fit::friction::FrictionModel;
use preslide_fit::report::figures::{quantity, significant};
use preslide_fit::report::{Axis, Colour, Emphasis, Figure, Section, Series, Style, Table};
use preslide_host::compare::cost::cost;
use serde_json::{Value, json};

/// Ramps drawn; more would hide the average.
const DRAWN: usize = 12;

/// Cycles in the tick of the quasi-static law in `f32`, or that they were not measured.
pub(super) fn cycles(n: usize) -> Option<f64> {
    let model = FrictionModel::maxwell_slip(&vec![1.0; n], &vec![1.0; n]);
    cost(&model).map(|cost| cost.cycles_mean)
}

pub(super) fn cycles_text(cycles: Option<f64>) -> String {
    cycles.map_or("not measured".to_owned(), |c| format!("{c:.0}"))
}

fn interval_text(interval: &Interval) -> String {
    let [low, high] = interval.ci95;
    format!(
        "{} ({}…{})",
        significant(interval.mean),
        significant(low),
        significant(high)
    )
}

fn interval_json(interval: &Interval) -> Value {
    json!({ "value": interval.mean, "ci95": interval.ci95 })
}

impl Figure6 {
    /// All models by what the paper asks of them.
    pub fn tables(&self) -> [Table; 2] {
        let origin = |row: &Row| match row.origin {
            Origin::Paper => "paper".to_owned(),
            Origin::Fitted => "fitted here".to_owned(),
        };
        let errors = Table::of("All models on the ten-block curve with inner loops (Figure 6): NMSE, %, on the virgin curve, with inner loops, and of the best of its form; cycles of a step in the tick of a Cortex-M4F in f32", &self.rows)
            .column("model", |row| row.name.clone())
            .column("parameters", |row| origin(row))
            .column("virgin", |row| significant(row.nmse_virgin))
            .column("NMSE", |row| significant(row.nmse))
            .column("best of form", |row| {
                row.nmse_best.map_or("–".to_owned(), significant)
            })
            .column("to identify", |row| row.parameters.to_string())
            .column("cycles", |row| {
                cycles_text(row.cost.as_ref().map(|c| c.cycles_mean))
            });
        let loops = Table::of(
            "How the same close their loops: closure error, and drift under 0.45 ± 0.05 N",
            &self.rows,
        )
        .column("model", |row| row.name.clone())
        .column("parameters", |row| origin(row))
        .column("closure", |row| quantity(row.closure.largest, "N"))
        .column("inner loops", |row| {
            let closure = &row.closure;
            match (closure.is_nonlocal(), closure.remembers) {
                (true, _) => "closes".to_owned(),
                (false, true) => {
                    format!("open, {:.2} %", 100.0 * closure.largest / closure.range)
                }
                (false, false) => "no loops".to_owned(),
            }
        })
        .column("drift [nm/cycle]", |row| {
            row.drift.map_or("slides away".to_owned(), |d| {
                format!("{:.3}", (1e9 * d).abs())
            })
        })
        .column("stick-slip", |row| match row.stick_slip {
            Some(true) => "yes".to_owned(),
            Some(false) => "no".to_owned(),
            None => "no (no Stribeck curve)".to_owned(),
        });
        [errors.table(), loops.table()]
    }

    fn to_json(&self) -> Value {
        let rows: Vec<Value> = self
            .rows
            .iter()
            .map(|row| {
                json!({
                    "model": row.name,
                    "kind": row.model.kind(),
                    "published": row.origin == Origin::Paper,
                    "nmse": row.nmse,
                    "nmse_virgin": row.nmse_virgin,
                    "nmse_best": row.nmse_best,
                    "loop_closure_N": row.closure.largest,
                    "nonlocal_memory": row.closure.is_nonlocal(),
                    "drift_m_per_cycle": row.drift,
                    "stick_slip": row.stick_slip,
                    "parameters": row.parameters,
                    "cycles": row.cost.as_ref().map(|c| c.cycles_mean),
                })
            })
            .collect();
        json!(rows)
    }

    fn figure(&self) -> Figure {
        let mut figure = Figure::new(
            "All models against the ten-block curve (the paper's Figure 6)",
            Axis::new("displacement", "m"),
            Axis::new("friction", "N"),
        )
        .with(
            Series::line("ten blocks", self.position.clone(), self.force.clone())
                .colour(Colour::Black)
                .emphasis(Emphasis::Strong),
        );
        for row in self
            .rows
            .iter()
            .filter(|row| !row.name.starts_with("GMS, 10"))
        {
            figure = figure.with(Series::line(
                row.name.clone(),
                self.position.clone(),
                row.force.clone(),
            ));
        }
        figure.note("Parameters of Tables 2 and 3 where the paper has them, fitted to this curve otherwise. Click a name in the legend to hide or show a model.")
    }
}

impl Experiment {
    /// The answer to the paper's question, a sentence.
    pub fn answer(&self) -> String {
        let said = |n: Option<usize>| n.map_or("no number".to_owned(), |n| n.to_string());
        let spread = self.spread();
        format!(
            "Experiment ({REPEATS} simulated ramps, blocks varying by ±{:.0} %, seed {}): the repeats spread by {} % of the variance about their average; {} blocks fit the average within that spread, {} within the average's own uncertainty, and beyond {} blocks nothing is gained on repeats that were held out",
            100.0 * VARIABILITY,
            self.seed,
            spread.as_ref().map_or("?".to_owned(), interval_text),
            said(self.within_spread()),
            said(self.within_average()),
            said(self.no_gain_beyond()),
        )
    }

    /// By number of blocks.
    pub fn tables(&self) -> [Table; 2] {
        let percent = |spreads: &[f64]| {
            let each = spreads.iter().map(|s| format!("{:.0}", 100.0 * s));
            each.collect::<Vec<_>>().join(" ")
        };
        let errors = Table::of(format!(
                "The experiment: {REPEATS} ramps in steps of 10 mN, seed {}; NMSE, %, with 95 % intervals: of the average curve, of each repeat by its own blocks, of repeats by the others' average, and the loss against the best N",
                self.seed
            ), &self.sizes)
            .column("N", |size| size.n.to_string())
            .column("average", |size| significant(size.nmse_average))
            .column("by its own", |size| interval_text(&size.nmse_own))
            .column("by the others'", |size| interval_text(&size.nmse_others))
            .column("loss", |size| interval_text(&size.loss))
            .column("identified", |size| size.identified.to_string());
        let spreads = Table::of(
            "Standard deviation over mean of each block's parameter, first to last, %",
            &self.sizes,
        )
        .column("N", |size| size.n.to_string())
        .column("spread of k_i", |size| percent(&size.stiffness_spread))
        .column("spread of D_i", |size| percent(&size.yield_spread));
        [errors.table(), spreads.table()]
    }

    fn to_json(&self) -> Value {
        let sizes: Vec<Value> = self
            .sizes
            .iter()
            .map(|size| {
                json!({
                    "n": size.n,
                    "identified": size.identified,
                    "nmse_average": size.nmse_average,
                    "nmse_own": interval_json(&size.nmse_own),
                    "nmse_others": interval_json(&size.nmse_others),
                    "nmse_loss": interval_json(&size.loss),
                    "stiffness_spread": size.stiffness_spread,
                    "yield_spread": size.yield_spread,
                    "stiffness_N_per_m": size.of_average.stiffness,
                    "yield_displacement_m": size.of_average.yields,
                })
            })
            .collect();
        json!({
            "seed": self.seed,
            "repeats": self.repeats.len(),
            "variability": VARIABILITY,
            "dispersion": self.dispersion,
            "nmse_spread": self.spread().as_ref().map(interval_json),
            "blocks_within_spread": self.within_spread(),
            "blocks_within_average": self.within_average(),
            "blocks_without_further_gain": self.no_gain_beyond(),
            "sizes": sizes,
        })
    }

    fn ramps_figure(&self) -> Figure {
        let mut figure = Figure::new(
            "Simulated ramps and their average",
            Axis::new("displacement", "m"),
            Axis::new("load", "N"),
        );
        for (i, ramp) in self.repeats.iter().take(DRAWN).enumerate() {
            let name = format!("repeat {}", i + 1);
            figure = figure.with(
                Series::line(name, ramp.position.clone(), ramp.force.clone())
                    .emphasis(Emphasis::Faint)
                    .colour(Colour::Blue),
            );
        }
        let Self { average, .. } = self;
        figure
            .with(
                Series::line("average", average.position.clone(), average.force.clone())
                    .emphasis(Emphasis::Strong)
                    .colour(Colour::Black),
            )
            .note(format!(
                "{DRAWN} of {REPEATS}. At the same load their displacements differ from the average by up to {:.0} %.",
                100.0 * self.dispersion
            ))
    }

    fn error_figure(&self) -> Figure {
        let n: Vec<f64> = self.sizes.iter().map(|s| s.n as f64).collect();
        let series = |name: &str, of: &dyn Fn(&super::experiment::Size) -> f64| {
            let y = self.sizes.iter().map(of).collect();
            Series::line(name, n.clone(), y).style(Style::LinePoints)
        };
        let mut figure = Figure::new(
            "How many blocks the repeats support",
            Axis::new("blocks N", ""),
            Axis::new("NMSE", "%").log(),
        )
        .with(series("average curve", &|s| s.nmse_average).colour(Colour::Blue))
        .with(
            series("repeats by others' average", &|s| s.nmse_others.mean)
                .colour(Colour::Vermillion),
        );
        for end in 0..2 {
            figure = figure.with(
                series(
                    if end == 0 {
                        "95 %, lower"
                    } else {
                        "95 %, upper"
                    },
                    &move |s| s.nmse_others.ci95[end],
                )
                .style(Style::Dashed)
                .emphasis(Emphasis::Faint)
                .colour(Colour::Vermillion),
            );
        }
        figure.note("Where the lower curve passes below the upper one, more blocks describe the average better than any repeat follows it.")
    }
}

impl Reproduction {
    /// `models` and `experiment` of the JSON.
    pub(super) fn study_json(&self) -> [Value; 2] {
        [self.figure_6.to_json(), self.experiment.to_json()]
    }

    /// Sections of the report.
    pub(super) fn study_sections(&self) -> [Section; 2] {
        [
            Section {
                heading: "All models, with inner loops (Figure 6, Table 2)".to_owned(),
                paragraphs: self.figure_6.remarks(),
                tables: self.figure_6.tables().to_vec(),
                figures: vec![self.figure_6.figure()],
            },
            Section {
                heading: "The experiment".to_owned(),
                paragraphs: vec![
                    self.experiment.answer(),
                    "The ten-block column stands for the axis; in every repeat each block's force and yield displacement vary uniformly and independently, the load goes up in steps of 10 mN that the cell resolves to half a step, each is held to rest, with an inner loop, until the axis breaks away. Displacements are averaged at the same load, and blocks placed by the search that gives the optimal breakpoints above.".to_owned(),
                ],
                tables: self.experiment.tables().to_vec(),
                figures: vec![self.experiment.error_figure(), self.experiment.ramps_figure()],
            },
        ]
    }

    /// Figure 8's missing axis: NMSE against cycles.
    pub(super) fn cycles_figure(&self) -> Figure {
        let series = |name: &str, of: fn(&super::Size) -> f64, colour| {
            let (x, y) = self
                .sizes
                .iter()
                .filter_map(|size| Some((cycles(size.n)?, of(size))))
                .unzip();
            Series::line(name, x, y)
                .style(Style::LinePoints)
                .colour(colour)
        };
        Figure::new(
            "NMSE against cycles (Figure 8 with its missing axis)",
            Axis::new("cycles in the tick", ""),
            Axis::new("NMSE", "%").log(),
        )
        .with(series("Table 3", |s| s.nmse_table3, Colour::Vermillion))
        .with(
            series("optimal breakpoints", |s| s.nmse_optimal, Colour::Blue)
                .emphasis(Emphasis::Strong),
        )
        .note("Quasi-static law in f32 on a Cortex-M4F, mean cycles by which a control tick grows (firmware/cycles/cortex-m4.csv; 5, 7 and 9 blocks lie between measured ones).")
    }
}
