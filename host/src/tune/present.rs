//! A tuning for people and for machines.

use super::{Choice, Tuning};
use preslide_fit::kernel::Kernel;
use preslide_fit::report::figures::significant;
use preslide_fit::report::{Axis, Emphasis, Figure, Page, Section, Series, Style, Table};
use serde_json::{Value, json};

impl Tuning {
    /// One sentence: what to use and why, or that nothing fits.
    pub fn recommendation(&self) -> String {
        match &self.recommended {
            Ok((index, reason)) => match self.choices.get(*index) {
                Some(c) => format!(
                    "Use {} with N = {}: {reason}.",
                    c.kernel.name(),
                    c.cost.blocks
                ),
                None => reason.clone(),
            },
            Err(reason) => reason.clone(),
        }
    }

    /// Every choice.
    pub fn table(&self) -> Table {
        let mark = |index: usize, c: &Choice| {
            let chosen = matches!(self.recommended, Ok((best, _)) if best == index);
            match (chosen, c.fits(self.budget)) {
                (true, _) => "use this",
                (_, false) => "over",
                _ => "",
            }
        };
        let how = match self.choices.iter().all(|c| c.cost.inlined) {
            true => "inlined into a control tick",
            false => "with its call",
        };
        let tick_share = |worst: f64| format!("{:.1} %", 100.0 * self.budget.share_of(worst));
        Table::of(format!(
                "Cost of a friction update {how} at {} kHz and {:.0} MHz ({}); NMSE held out, %; rounding, % of the breakaway force; cycles and shares of the processor, the whole tick at worst; flash and RAM, bytes",
                self.budget.rate * 1e-3,
                self.budget.clock * 1e-6,
                self.origin
            ), self.choices.iter().enumerate()).column("N", |(_, c)| c.cost.blocks.to_string()).column("kernel", |(_, c)| c.kernel.name().to_owned()).column("NMSE", |(_, c)| {
                    c.nmse_test.map_or("–".to_owned(), significant)
                }).column("rounding", |(_, c)| format!("{:.4}", c.arithmetic)).column("cycles", |(_, c)| format!("{:.0}", c.cost.cycles_mean)).column("worst", |(_, c)| format!("{:.0}", c.cost.cycles_worst)).column("share", |(_, c)| format!("{:.2} %", 100.0 * c.share)).column("tick", |(_, c)| {
                    whole(c.tick.map_or(f64::NAN, |tick| tick.worst))
                }).column("share", |(_, c)| {
                    c.tick.map_or("–".to_owned(), |tick| tick_share(tick.worst))
                }).column("flash", |(_, c)| whole(c.cost.flash_bytes)).column("RAM", |(_, c)| whole(c.cost.ram_bytes)).column("", |(i, c)| mark(*i, c).to_owned()).table()
    }

    /// `preslide.tuning/1`.
    pub fn to_json(&self, seconds: f64) -> Value {
        let row = |c: &Choice| {
            json!({
                "blocks": c.cost.blocks,
                "kernel": c.kernel.name(),
                "instructions": finite(c.cost.instructions),
                "cycles_mean": c.cost.cycles_mean,
                "cycles_worst": c.cost.cycles_worst,
                "flash_bytes": finite(c.cost.flash_bytes),
                "ram_bytes": finite(c.cost.ram_bytes),
                "budget_share": c.share,
                "inlined": c.cost.inlined,
                "tick_cycles_mean": c.tick.map(|tick| tick.mean),
                "tick_cycles_worst": c.tick.map(|tick| tick.worst),
                "tick_share": c.tick.map(|tick| self.budget.share_of(tick.worst)),
                "fits": c.fits(self.budget),
                "nmse_test": c.nmse_test,
                "arithmetic_percent": c.arithmetic,
            })
        };
        let recommended = match &self.recommended {
            Ok((index, reason)) => self.choices.get(*index).map(
                |c| json!({ "blocks": c.cost.blocks, "kernel": c.kernel.name(), "reason": reason }),
            ),
            Err(_) => None,
        };
        json!({
            "schema": "preslide.tuning/1",
            "rows": self.choices.iter().map(row).collect::<Vec<_>>(),
            "recommended": recommended,
            "fits": self.recommended.is_ok(),
            "reason": self.recommendation(),
            "budget": { "clock_Hz": self.budget.clock, "rate_Hz": self.budget.rate, "share": self.budget.share },
            "cost_table": self.origin,
            "counting_percent": self.counting,
            "warnings": self.notes,
            "seconds": seconds,
        })
    }

    /// The page with the accuracy-versus-cost plot.
    pub fn page(&self, command: String) -> Page {
        let measure = format!(
            "Cycles: {}. A share is that of the worst path seen; the budget is {:.2} % of the processor, for friction alone. The whole tick is the measured interrupt of the QEMU firmware (reading the sensors left out) with its kernel exchanged for this one, its controller in f32 around f32 kernels and in fixed point around the others.",
            self.origin,
            100.0 * self.budget.share
        );
        Page {
            title: "Blocks and arithmetic for a cycle budget".to_owned(),
            lead: self.recommendation(),
            command,
            sections: vec![
                Section {
                    heading: "Accuracy against cost".to_owned(),
                    tables: vec![self.table()],
                    figures: vec![self.figure()],
                    ..Section::default()
                },
                Section::notes([measure].into_iter().chain(self.notes.iter().cloned())),
            ],
        }
    }

    pub(super) fn figure(&self) -> Figure {
        let error = |c: &Choice| c.nmse_test.unwrap_or(c.arithmetic);
        let y = match self.recorded {
            true => Axis::new("NMSE held out", "%").log(),
            false => Axis::new("error of the arithmetic", "%").log(),
        };
        let mut figure = Figure::new(
            "Error against cycles, one mark for each number of blocks",
            Axis::new("cycles a tick at worst", "cycles"),
            y,
        );
        let points = |of: &dyn Fn(&Choice) -> bool| -> (Vec<f64>, Vec<f64>) {
            let chosen = self.choices.iter().filter(|c| of(c));
            chosen.map(|c| (c.cost.cycles_worst, error(c))).unzip()
        };
        for kernel in Kernel::ALL {
            let (x, y) = points(&|c| c.kernel == kernel);
            if !x.is_empty() {
                figure = figure.with(Series::line(kernel.name(), x, y).style(Style::LinePoints));
            }
        }
        let allowed = self.budget.share * self.budget.clock / self.budget.rate;
        let errors = || self.choices.iter().map(error).filter(|e| *e > 0.0);
        let range = [
            errors().fold(f64::INFINITY, f64::min),
            errors().fold(0.0, f64::max),
        ];
        let widest = self
            .choices
            .iter()
            .fold(0.0, |x: f64, c| x.max(c.cost.cycles_worst));
        if allowed < 2.0 * widest {
            figure = figure.with(
                Series::line("budget", vec![allowed; 2], range.to_vec()).style(Style::Dashed),
            );
        }
        if let Some(c) = self
            .recommended
            .as_ref()
            .ok()
            .and_then(|(index, _)| self.choices.get(*index))
        {
            figure = figure.with(
                Series::points("recommended", vec![c.cost.cycles_worst], vec![error(c)])
                    .emphasis(Emphasis::Strong),
            );
        }
        figure.note("What a block buys, and what it costs in a controller.")
    }
}

fn whole(value: f64) -> String {
    if value.is_nan() {
        "–".to_owned()
    } else {
        format!("{value:.0}")
    }
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}
