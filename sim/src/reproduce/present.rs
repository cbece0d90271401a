//! A reproduction for people and for machines.

use super::study::{cycles, cycles_text};
use super::{CRITERION, Curve, Reproduction};
use preslide_fit::report::figures::significant;
use preslide_fit::report::{Axis, Colour, Emphasis, Figure, Page, Section, Series, Style, Table};
use preslide_host::paper;
use serde_json::{Value, json};

/// Sizes in the figure that answers to the paper's Figure 7.
const SHOWN: [usize; 4] = [2, 3, 4, 6];

impl Reproduction {
    /// `preslide.reproduction/1`; `seconds` is the time it took.
    pub fn to_json(&self, seconds: f64) -> Value {
        let blocks: Vec<Value> = self
            .sizes
            .iter()
            .map(|size| {
                json!({
                    "n": size.n,
                    "nmse_table3": size.nmse_table3,
                    "nmse_optimal": size.nmse_optimal,
                    "nmse_printed": size.nmse_printed,
                    "nmse_table3_load_steps": size.nmse_load_steps,
                    "cycles": cycles(size.n),
                    "optimal_yield_displacement_m": size.optimal.yields,
                    "optimal_stiffness_N_per_m": size.optimal.stiffness,
                })
            })
            .collect();
        let recovered: Vec<Value> = self
            .recovered
            .iter()
            .map(|recovery| {
                let of = |pick: fn(&super::recovery::RecoveredBlock) -> f64| -> Vec<f64> {
                    recovery.blocks.iter().map(pick).collect()
                };
                json!({
                    "n": recovery.blocks.len(),
                    "stiffness_N_per_m": of(|b| b.stiffness),
                    "stiffness_printed_N_per_m": of(|b| b.stiffness_printed),
                    "weight": of(|b| b.weight),
                    "weight_printed": of(|b| b.weight_printed),
                    "weight_sum_printed": recovery.printed_sum(),
                    "largest_deviation": recovery.largest_deviation(),
                    "largest_deviation_sampled": recovery.sampled_deviation,
                    "explained_by_rounding": recovery.explained_by_rounding(),
                })
            })
            .collect();
        let bounds: Vec<Value> = self
            .bounds
            .iter()
            .map(|b| json!({ "n": b.n, "nmse_printed": b.printed, "nmse_highest": b.highest }))
            .collect();
        let [models, experiment] = self.study_json();
        json!({
            "schema": "preslide.reproduction/1",
            "samples": self.curve.displacement.len(),
            "blocks": blocks,
            "table3": recovered,
            "printed_bounds": bounds,
            "equations_as_printed": super::literal::to_json(&self.literal),
            "models": models,
            "experiment": experiment,
            "recommendation": self.recommendation,
            "seconds": seconds,
        })
    }

    /// NMSE by number of blocks.
    pub fn size_table(&self) -> Table {
        Table::of(format!(
                "NMSE (squared error over the variance of the force), %, on the ten-block column of Table 3 as the virgin curve, {} samples uniform in 0–{:.0} µm: by the paper's parameters, the same with samples uniform in force, as the paper prints it, at optimal breakpoints; cycles in the tick in f32, and the ΣW/F_s and yields of those",
                self.curve.displacement.len(),
                1e6 * paper::RANGE
            ), &self.sizes).column("N", |size| size.n.to_string()).column("paper's", |size| {
                    significant(size.nmse_table3)
                }).column("in force", |size| {
                    significant(size.nmse_load_steps)
                }).column("printed", |size| {
                    size.nmse_printed.map_or("–".to_owned(), |p| p.to_string())
                }).column("optimal", |size| {
                    significant(size.nmse_optimal)
                }).column("cycles", |size| {
                    cycles_text(cycles(size.n))
                }).column("ΣW/F_s", |size| {
                    format!("{:.4}", size.limit() / paper::BREAKAWAY)
                }).column("yields [µm]", |size| {
                    let yields = size.optimal.yields.iter();
                    yields
                        .map(|d| format!("{:.2}", 1e6 * d))
                        .collect::<Vec<_>>()
                        .join(" ")
                }).table()
    }

    /// Table 3 as printed and as (7)–(9) give it back.
    pub fn recovery_table(&self) -> Table {
        let rows = self.recovered.iter().flat_map(|recovery| {
            let blocks = (1..).zip(&recovery.blocks);
            blocks.map(|(i, block)| (recovery.blocks.len(), i, block))
        });
        Table::of("Table 3 recovered by the paper's equations (7)–(9), which read stiffnesses and weights off a curve, from the ten-block curve at each column's own breakpoints", rows).column("N", |(n, _, _)| n.to_string()).column("i", |(_, i, _)| i.to_string()).column("D_i [µm]", |(_, _, b)| {
                    format!("{:.3}", 1e6 * b.yield_displacement)
                }).column("k_i printed [N/m]", |(_, _, b)| {
                    format!("{:.0}", b.stiffness_printed)
                }).column("k_i [N/m]", |(_, _, b)| format!("{:.0}", b.stiffness)).column("α_i printed", |(_, _, b)| {
                    format!("{:.3}", b.weight_printed)
                }).column("α_i", |(_, _, b)| format!("{:.4}", b.weight)).column("deviation [%]", |(_, _, b)| {
                    format!("{:+.2}", 100.0 * b.deviation())
                }).column("digits allow [%]", |(_, _, b)| {
                    format!("{:.2}", 100.0 * b.rounding)
                }).table()
    }

    /// One line a column: how far it is from what (7)–(9) give back.
    pub fn column_table(&self) -> Table {
        Table::of("Table 3 column by column: how far k_i and α_i are off at most, the same from the 2,001 samples, and whether the table's three digits explain it", &self.recovered)
            .column("N", |r| r.blocks.len().to_string())
            .column("Σα printed", |r| format!("{:.3}", r.printed_sum()))
            .column("off by [%]", |r| {
                format!("{:.2}", 100.0 * r.largest_deviation())
            })
            .column("from samples [%]", |r| {
                format!("{:.2}", 100.0 * r.sampled_deviation)
            })
            .column("explained", |r| {
                if r.explained_by_rounding() {
                    "yes"
                } else {
                    "no"
                }
                .to_owned()
            })
            .table()
    }

    /// What is known of the differences from the paper, a sentence each.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = vec![
            "The paper's absolute errors cannot be recomputed: its measured samples are not published, nor how many there are and how they are spread. Here its ten-block column stands for the measurement, which has no scatter and none of the curve's shape that ten blocks miss".to_owned(),
        ];
        let beyond: Vec<String> = self
            .bounds
            .iter()
            .filter(|b| b.highest < b.printed)
            .map(|b| {
                format!(
                    "N = {} at most {:.1} % (printed {})",
                    b.n, b.highest, b.printed
                )
            })
            .collect();
        let best = paper::PRINTED_NMSE
            .iter()
            .min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some(best) = best.filter(|_| !beyond.is_empty()) {
            remarks.push(format!(
                "Missing samples are not the whole reason: against any curve sampled evenly over 0–{:.0} µm that the best printed size, {} blocks, fits to the printed {} %, Table 3 leaves {}. Sampling uniformly in force takes them further down from three blocks on (see the table). The printed figures must come from another range, normalisation or motion (with reversals, say), or from parameters other than those printed; the paper does not say",
                1e6 * paper::RANGE,
                best.0,
                best.1,
                beyond.join(", ")
            ));
        }
        for recovery in self.recovered.iter().filter(|r| !r.explained_by_rounding()) {
            let (place, force) = recovery.furthest;
            remarks.push(format!(
                "The {}-block column deviates by up to {:.1} %, more than its digits allow: at its breakpoint {:.2} µm, which no other column has, it lies {:.1} mN {} the ten-block curve, about one step of the load ({:.0} mN). Perhaps it was read off another measured curve there; taking the curve's own force gives the values above",
                recovery.blocks.len(),
                100.0 * recovery.largest_deviation(),
                1e6 * place,
                1e3 * force.abs(),
                if force > 0.0 { "above" } else { "below" },
                1e3 * paper::LOAD_RESOLUTION,
            ));
        }
        let short: Vec<String> = self
            .recovered
            .iter()
            .filter(|r| (r.printed_sum() - 1.0).abs() > 1e-9)
            .map(|r| r.blocks.len().to_string())
            .collect();
        remarks.push(format!(
            "The printed weights of {} blocks do not sum to 1 (see Σα); used as printed. (9) gives weights that sum to the curve's force at the last breakpoint over F_s",
            short.join(", ")
        ));
        let cut = self
            .recovered
            .iter()
            .map(|r| r.sampled_deviation - r.largest_deviation());
        remarks.push(format!(
            "Straight lines between the {} samples cut the curve's corners: from the samples alone (7)–(9) give stiffnesses up to {:.1} % further off; Table 3 is recovered from the curve itself",
            self.curve.displacement.len(),
            100.0 * cut.fold(0.0, f64::max)
        ));
        if self
            .figure_6
            .rows
            .iter()
            .any(|row| row.name == "Hsieh" && !row.closure.is_nonlocal())
        {
            remarks.push("Hsieh's spring remembers every reversal, but its plastic module (5)–(6) moves under load and is not undone, so with Table 2 its loops do not close".to_owned());
        }
        remarks
    }

    /// The report.
    pub fn page(&self, command: String) -> Page {
        Page {
            title: "Kamenar and Zelenika's paper on pre-sliding friction: Tables 2–3, Figures 6–8, the experiment".to_owned(),
            lead: self.recommendation.clone(),
            command,
            sections: [
                vec![Section {
                    heading: "How many blocks".to_owned(),
                    tables: vec![self.size_table()],
                    figures: vec![
                        self.error_figure(),
                        self.cycles_figure(),
                        self.fit_figure(),
                        self.residual_figure(),
                    ],
                    ..Section::default()
                }],
                self.study_sections().into(),
                vec![
                Section {
                    heading: "What differs from the paper, and why".to_owned(),
                    paragraphs: self.remarks(),
                    ..Section::default()
                },
                Section {
                    heading: "Table 3 by equations (7)–(9)".to_owned(),
                    tables: vec![self.column_table(), self.recovery_table()],
                    ..Section::default()
                },
                Section {
                    heading: "Non-local memory".to_owned(),
                    paragraphs: vec!["The models run from rest through an outer loop of ±40 µm and nested reversals, each half the one before, and back through the same reversals. A model with non-local memory returns to the force that it left.".to_owned()],
                    tables: vec![super::literal::table(&self.literal)],
                    figures: vec![self.loop_figure()],
                }],
            ]
            .concat(),
        }
    }

    /// Figure 8: NMSE against N.
    fn error_figure(&self) -> Figure {
        let sizes = |pick: &dyn Fn(&super::Size) -> Option<f64>| -> (Vec<f64>, Vec<f64>) {
            self.sizes
                .iter()
                .filter_map(|size| Some((size.n as f64, pick(size)?)))
                .unzip()
        };
        let series = |name: &str, (x, y): (Vec<f64>, Vec<f64>), colour| {
            Series::line(name, x, y)
                .style(Style::LinePoints)
                .colour(colour)
        };
        let ends = [2.0, (super::SIZES.end - 1) as f64];
        Figure::new(
            "NMSE against the number of blocks (the paper's Figure 8)",
            Axis::new("blocks N", ""),
            Axis::new("NMSE", "%").log(),
        )
        .with(
            Series::line("the paper's criterion", ends.to_vec(), vec![CRITERION; 2])
                .style(Style::Dashed)
                .emphasis(Emphasis::Faint)
                .colour(Colour::Black),
        )
        .with(
            series("printed in the paper", sizes(&|s| s.nmse_printed), Colour::Black)
                .style(Style::Points),
        )
        .with(series("Table 3", sizes(&|s| Some(s.nmse_table3)), Colour::Vermillion))
        .with(
            series("optimal breakpoints", sizes(&|s| Some(s.nmse_optimal)), Colour::Blue)
                .emphasis(Emphasis::Strong),
        )
        .note("The same number of blocks, placed as in the paper or optimally, on the ten-block column of Table 3 as the curve to be met.")
    }

    fn per_size(&self, mut figure: Figure, y: impl Fn(&[f64]) -> Vec<f64>) -> Figure {
        for (size, colour) in self
            .sizes
            .iter()
            .filter(|size| SHOWN.contains(&size.n))
            .zip(Colour::PALETTE)
        {
            let x = &self.curve.displacement;
            figure = figure
                .with(
                    Series::line(
                        format!("Table 3, N = {}", size.n),
                        x.clone(),
                        y(&size.force_table3),
                    )
                    .style(Style::Dashed)
                    .colour(colour),
                )
                .with(
                    Series::line(
                        format!("optimal, N = {}", size.n),
                        x.clone(),
                        y(&size.force_optimal),
                    )
                    .colour(colour),
                );
        }
        figure
    }

    /// Figure 7: the curve and its approximations.
    fn fit_figure(&self) -> Figure {
        let Curve {
            displacement,
            force,
            ..
        } = &self.curve;
        let figure = Figure::new(
            "Virgin curve and its approximations (the paper's Figure 7)",
            Axis::new("displacement", "m"),
            Axis::new("friction", "N"),
        )
        .with(
            Series::line("ten blocks", displacement.clone(), force.clone())
                .colour(Colour::Black)
                .emphasis(Emphasis::Strong),
        );
        self.per_size(figure, |fitted| fitted.to_vec())
            .note("Dashed: the paper's parameters; solid: optimal breakpoints.")
    }

    fn residual_figure(&self) -> Figure {
        let figure = Figure::new(
            "What the approximations leave",
            Axis::new("displacement", "m"),
            Axis::new("approximation − ten blocks", "N"),
        );
        self.per_size(figure, |fitted| {
            let pairs = fitted.iter().zip(&self.curve.force);
            pairs.map(|(fitted, force)| fitted - force).collect()
        })
        .note("Chords between breakpoints on the curve lie below it throughout; optimal ones balance the error.")
    }

    fn loop_figure(&self) -> Figure {
        let mut figure = Figure::new(
            "Nested reversals",
            Axis::new("displacement", "m"),
            Axis::new("friction", "N"),
        );
        for row in &self.figure_6.rows {
            figure = figure.with(Series::line(
                row.name.clone(),
                row.closure.position.clone(),
                row.closure.force.clone(),
            ));
        }
        figure.note("Click a name in the legend to hide or show a model.")
    }
}
