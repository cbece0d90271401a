//! What kernels cost: the committed table, or one measured on the user's own board.
//!
//! Wherever the tool shows cycles they are **in the tick**: by how much a control tick grows where the kernel is
//! inlined into it, which is what a controller pays. A table made on a board has calls only, with the call's own cost in
//! them; [`Cost::inlined`] tells.

mod cores;
mod effects;

pub use cores::{CORES, Core, DEFAULT, Standing};
pub use effects::EffectsCost;

use std::path::Path;

/// Cost of one update of a kernel at one number of blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct Cost {
    /// The kernel's name in the table.
    pub kernel: String,
    /// Number of Maxwell-slip blocks.
    pub blocks: usize,
    /// Instructions, mean; NaN where the table has none (a board cannot count them).
    pub instructions: f64,
    /// Cycles, mean: in the tick, or of a call.
    pub cycles_mean: f64,
    /// The same on the worst path seen.
    pub cycles_worst: f64,
    /// The cycles are in the tick, not of a call.
    pub inlined: bool,
    /// Code and parameters (bytes).
    pub flash_bytes: f64,
    /// State (bytes).
    pub ram_bytes: f64,
}

/// Cycles of the whole interrupt of the control task, exception entry and return included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WholeTick {
    /// Mean.
    pub mean: f64,
    /// On the worst path seen.
    pub worst: f64,
}

/// Rows of whole ticks are named after the kernel in the measured firmware, which is this one in some arithmetic.
const WHOLE_TICK: &str = "rtic_tick_";
const IN_WHOLE_TICK: &str = "quasi_static_";

/// A table of costs.
#[derive(Clone, Debug)]
pub struct CostTable {
    rows: Vec<Cost>,
    /// Where the figures come from, for people.
    pub origin: String,
    /// How well they are known.
    pub standing: Standing,
}

impl CostTable {
    /// The table of a core or of a chip that has it.
    ///
    /// # Errors
    /// Which cores there are.
    pub fn of_cpu(cpu: &str) -> Result<Self, String> {
        Core::named(cpu)?.costs()
    }

    /// The table of a core, or that of the file so named: whatever ends in `.csv`.
    ///
    /// # Errors
    /// As [`CostTable::of_cpu`] and [`CostTable::load`].
    pub fn of_cpu_or_file(name: &str) -> Result<Self, String> {
        let path = Path::new(name);
        if path.extension().is_some_and(|kind| kind == "csv") {
            Self::load(path)
        } else {
            Self::of_cpu(name)
        }
    }

    /// A table in a file.
    ///
    /// # Errors
    /// File, line, reason and remedy.
    pub fn load(path: &Path) -> Result<Self, String> {
        let file = path.display();
        let text = std::fs::read_to_string(path).map_err(|e| format!("{file}: {e}"))?;
        Self::parse(&text, &format!("{file}")).map_err(|reason| format!("{file}: {reason}"))
    }

    fn parse(text: &str, origin: &str) -> Result<Self, String> {
        let mut lines = text
            .lines()
            .enumerate()
            .filter(|(_, line)| !line.starts_with('#') && !line.trim().is_empty());
        let (_, head) = lines
            .next()
            .ok_or("empty; it needs a line of column names")?;
        let head: Vec<&str> = head.split(',').map(str::trim).collect();
        let column = |name: &str| head.iter().position(|c| *c == name);
        let need = |name: &'static str| {
            column(name).ok_or_else(|| {
                format!("no column {name}; the first line names kernel, n, cycles_mean and cycles_worst at least")
            })
        };
        let (kernel, blocks) = (need("kernel")?, need("n")?);
        let (mean, worst) = (need("cycles_mean")?, need("cycles_worst")?);
        let mut rows = Vec::new();
        for (index, line) in lines {
            let cells: Vec<&str> = line.split(',').map(str::trim).collect();
            let number = |at: usize| -> Result<f64, String> {
                let cell = cells.get(at).copied().unwrap_or("");
                let bad = |_| {
                    format!(
                        "line {}: `{cell}` in column {} is not a number",
                        index + 1,
                        head[at]
                    )
                };
                cell.parse().map_err(bad)
            };
            let optional = |name: &str| match column(name) {
                Some(at) if cells.get(at).is_some_and(|cell| !cell.is_empty()) => number(at),
                _ => Ok(f64::NAN),
            };
            let (mean, worst) = (number(mean)?, number(worst)?);
            if !(mean > 0.0 && mean.is_finite()) {
                return Err(format!(
                    "line {}: {mean} cycles; a cycle counter that stands still, as an emulator's does, measures nothing: run it on a board",
                    index + 1
                ));
            }
            // What the call itself costs falls away from the worst path as from the mean.
            let in_tick = optional("cycles_in_tick")?;
            let call = if in_tick.is_nan() {
                0.0
            } else {
                mean - in_tick
            };
            rows.push(Cost {
                kernel: cells.get(kernel).copied().unwrap_or("").to_owned(),
                blocks: number(blocks)? as usize,
                instructions: optional("instructions_mean")?,
                cycles_mean: mean - call,
                cycles_worst: worst - call,
                inlined: !in_tick.is_nan(),
                flash_bytes: optional("flash_bytes")?,
                ram_bytes: optional("ram_bytes")?,
            });
        }
        Ok(Self {
            rows,
            origin: origin.to_owned(),
            // By the core's own counter.
            standing: Standing::Exact,
        })
    }

    /// The cost of a kernel with so many blocks; between two measured numbers, and beyond the largest, it is on the line through two of
    /// them, since every block adds the same code. `None` below the smallest.
    pub fn cost(&self, kernel: &str, blocks: usize) -> Option<Cost> {
        let rows = || self.rows.iter().filter(|row| row.kernel == kernel);
        let below = rows()
            .filter(|row| row.blocks <= blocks)
            .max_by_key(|row| row.blocks)?;
        let above = rows()
            .filter(|row| row.blocks >= blocks)
            .min_by_key(|row| row.blocks);
        let (below, above) = match above {
            Some(above) => (below, above),
            None => {
                let fewer = rows().filter(|row| row.blocks < below.blocks);
                (fewer.max_by_key(|row| row.blocks)?, below)
            }
        };
        let gap = (above.blocks - below.blocks).max(1) as f64;
        let part = (blocks - below.blocks) as f64 / gap;
        let between = |of: fn(&Cost) -> f64| of(below) + part * (of(above) - of(below));
        Some(Cost {
            kernel: kernel.to_owned(),
            blocks,
            instructions: between(|row| row.instructions),
            cycles_mean: between(|row| row.cycles_mean),
            cycles_worst: between(|row| row.cycles_worst),
            inlined: below.inlined && above.inlined,
            flash_bytes: between(|row| row.flash_bytes).ceil(),
            ram_bytes: between(|row| row.ram_bytes).ceil(),
        })
    }

    /// The whole control tick with a kernel in it: the measured tick of the firmware in the `arithmetic` `f32` or `i16f16`, with the
    /// growth by its own kernel taken out and the growth by `cost` put in. `None` where the table has no such tick.
    pub fn whole_tick(&self, arithmetic: &str, cost: &Cost) -> Option<WholeTick> {
        let kernel = format!("{IN_WHOLE_TICK}{arithmetic}");
        let name = format!("{WHOLE_TICK}{kernel}");
        let tick = self.rows.iter().find(|row| row.kernel == name)?;
        let inside = self.cost(&kernel, tick.blocks)?;
        (cost.inlined && inside.inlined).then_some(WholeTick {
            mean: tick.cycles_mean - inside.cycles_mean + cost.cycles_mean,
            worst: tick.cycles_worst - inside.cycles_worst + cost.cycles_worst,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_table_has_every_kernel_and_interpolates_between_its_rows() {
        let table = CostTable::of_cpu("cortex-m4").unwrap();
        for kernel in preslide_fit::kernel::Kernel::ALL {
            let cycles = |n| table.cost(kernel.name(), n).unwrap().cycles_worst;
            assert!(
                (cycles(5) - (cycles(4) + cycles(6)) / 2.0).abs() < 1e-9,
                "{}",
                kernel.name()
            );
            let beyond = cycles(12) - cycles(10);
            assert!((beyond - (cycles(10) - cycles(8))).abs() < 1e-9);
        }
    }

    #[test]
    fn a_whole_tick_is_the_measured_one_with_the_kernel_exchanged() {
        let table = CostTable::of_cpu("cortex-m4").unwrap();
        let cost = |kernel, n| table.cost(kernel, n).unwrap();
        let like = "quasi_static_f32";
        let measured = cost("rtic_tick_quasi_static_f32", 4);
        let same = table.whole_tick("f32", &cost(like, 4)).unwrap();
        assert!((same.mean - measured.cycles_mean).abs() < 1e-9);
        let dearer = table.whole_tick("f32", &cost("gms_f32", 4)).unwrap();
        let growth = cost("gms_f32", 4).cycles_worst - cost(like, 4).cycles_worst;
        assert!((dearer.worst - same.worst - growth).abs() < 1e-9);
        let board = "kernel,n,cycles_mean,cycles_worst\npacked_f32,6,51.5,70\n";
        let board = CostTable::parse(board, "board").unwrap();
        assert_eq!(
            board.whole_tick("f32", &board.cost("packed_f32", 6).unwrap()),
            None
        );
    }

    #[test]
    fn a_boards_table_may_lack_what_a_board_cannot_know() {
        let text = "kernel,n,instructions_mean,cycles_mean,cycles_worst\npacked_f32,6,,51.5,70\n";
        let table = CostTable::parse(text, "board").unwrap();
        let cost = table.cost("packed_f32", 6).unwrap();
        assert!(cost.instructions.is_nan() && cost.cycles_worst == 70.0);
        let torn = CostTable::parse(
            "kernel,n,cycles_mean,cycles_worst\npacked_f32,6,x,1\n",
            "board",
        );
        assert!(
            torn.unwrap_err()
                .contains("line 2: `x` in column cycles_mean")
        );
        let still = CostTable::parse(
            "kernel,n,cycles_mean,cycles_worst\npacked_f32,6,0.0,0\n",
            "",
        );
        assert!(still.unwrap_err().contains("line 2: 0 cycles"));
        assert!(
            CostTable::parse("kernel,n\n", "")
                .unwrap_err()
                .contains("cycles_mean")
        );
    }
}
