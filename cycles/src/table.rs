//! The table of measured costs: as people read it, and as the file that is committed and checked against.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::str::FromStr;

use anyhow::{Context as _, Result, bail};

/// What one kernel at one N costs for each update.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    pub kernel: String,
    pub blocks: u32,
    pub instructions_mean: f64,
    pub instructions_max: u32,
    pub cycles_mean: f64,
    pub cycles_worst: u32,
    /// The mean, if every question that the cycle table leaves open had the cheapest answer, and the dearest.
    pub cycles_low: f64,
    pub cycles_high: f64,
    /// By how much the mean control tick grows where the kernel is inlined into it; `None` where it cannot be.
    pub cycles_in_tick: Option<f64>,
    /// [`floor`], on a core that it is about.
    pub floor: Option<f64>,
    pub flash_bytes: u32,
    /// State; `None` where there is none of its own.
    pub ram_bytes: Option<u32>,
    pub paths: u32,
    pub calls: u32,
    /// Rms difference of the force from the ten-block stage's (% of `F_s`), of rows that are a friction model alone.
    pub error: Option<f64>,
}

pub const COLUMNS: &str = "kernel,n,instructions_mean,instructions_max,cycles_mean,cycles_worst,cycles_low,cycles_high,\
                       cycles_in_tick,floor,flash_bytes,ram_bytes,paths,calls,error";

/// A count may grow by this much before the check fails.
const TOLERANCE: f64 = 0.03;

/// The file: `header` as comment lines, column names, one line a row.
pub fn to_csv(header: &[String], rows: &[Row]) -> String {
    let mut text: String = header.iter().map(|line| format!("# {line}\n")).collect();
    text += COLUMNS;
    text.push('\n');
    for row in rows {
        let _ = writeln!(
            text,
            "{},{},{:.1},{},{:.1},{},{:.1},{:.1},{},{},{},{},{},{},{}",
            row.kernel,
            row.blocks,
            row.instructions_mean,
            row.instructions_max,
            row.cycles_mean,
            row.cycles_worst,
            row.cycles_low,
            row.cycles_high,
            decimal(row.cycles_in_tick),
            decimal(row.floor),
            row.flash_bytes,
            whole(row.ram_bytes),
            row.paths,
            row.calls,
            row.error
                .map_or(String::new(), |error| format!("{error:.4}"))
        );
    }
    text
}

/// An empty cell where there is nothing.
fn decimal(value: Option<f64>) -> String {
    value.map_or(String::new(), |value| format!("{value:.1}"))
}

fn whole(value: Option<u32>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}

pub fn from_csv(text: &str) -> Result<Vec<Row>> {
    let mut lines = text
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.starts_with('#'));
    match lines.next() {
        Some((_, COLUMNS)) => {}
        _ => bail!("the column line is not `{COLUMNS}`"),
    }
    lines
        .map(|(index, line)| {
            row(line).with_context(|| format!("line {}: cannot read `{line}`", index + 1))
        })
        .collect()
}

fn row(line: &str) -> Option<Row> {
    let mut cells = line.split(',');
    Some(Row {
        kernel: cells.next()?.to_owned(),
        blocks: number(cells.next())?,
        instructions_mean: number(cells.next())?,
        instructions_max: number(cells.next())?,
        cycles_mean: number(cells.next())?,
        cycles_worst: number(cells.next())?,
        cycles_low: number(cells.next())?,
        cycles_high: number(cells.next())?,
        cycles_in_tick: optional(cells.next())?,
        floor: optional(cells.next())?,
        flash_bytes: number(cells.next())?,
        ram_bytes: optional(cells.next())?,
        paths: number(cells.next())?,
        calls: number(cells.next())?,
        error: optional(cells.next())?,
    })
}

fn number<T: FromStr>(cell: Option<&str>) -> Option<T> {
    cell?.parse().ok()
}

/// `None` in an empty cell.
fn optional<T: FromStr>(cell: Option<&str>) -> Option<Option<T>> {
    match cell? {
        "" => Some(None),
        cell => cell.parse().ok().map(Some),
    }
}

/// The least that the quasi-static law can take on this core in two-block words, inlined: 12 cycles for the displacement,
/// the direction and the force's sign, and per pair of blocks two pipelined loads, a store, a saturating subtraction and
/// a dual multiply-accumulate. An argument, not a measurement.
pub fn floor(row: &Row) -> Option<f64> {
    const QUASI_STATIC: [&str; 3] = ["quasi_static_", "slip_reserve_", "packed_"];
    let blocks = f64::from(row.blocks.next_multiple_of(2));
    QUASI_STATIC
        .iter()
        .any(|kernel| row.kernel.starts_with(kernel))
        .then_some(12.0 + 2.5 * blocks)
}

/// Whether the row's force is a friction model's, and nothing else's.
pub fn is_friction(kernel: &str) -> bool {
    const OTHERS: [&str; 6] = [
        "with_",
        "control_task",
        "koopman_",
        "empty_call",
        "pid_",
        "idsp_",
    ];
    !OTHERS.iter().any(|other| kernel.starts_with(other))
}

/// Cycles in the control tick above its floor.
fn gap(row: &Row) -> Option<f64> {
    Some(row.cycles_in_tick? - row.floor?)
}

pub fn print(rows: &[Row]) {
    println!(
        "{:<30} {:>3} {:>14} {:>8} {:>6} {:>15} {:>8} {:>6} {:>6} {:>4} {:>6} {:>8}",
        "kernel",
        "N",
        "instructions",
        "cycles",
        "worst",
        "mean's range",
        "in tick",
        "gap",
        "flash",
        "RAM",
        "paths",
        "error %"
    );
    for row in rows {
        println!(
            "{:<30} {:>3} {:>7.1} {:>6} {:>8.1} {:>6} {:>7.1}…{:<7.1} {:>8} {:>6} {:>6} {:>4} {:>6} {:>8}",
            row.kernel,
            row.blocks,
            row.instructions_mean,
            row.instructions_max,
            row.cycles_mean,
            row.cycles_worst,
            row.cycles_low,
            row.cycles_high,
            decimal(row.cycles_in_tick),
            decimal(gap(row)),
            row.flash_bytes,
            whole(row.ram_bytes),
            row.paths,
            row.error
                .map_or(String::new(), |error| format!("{error:.4}"))
        );
    }
}

/// By how much each effect, composed with `Gms<4>`, makes the control tick grow: mean cycles, in `f32` and in I16F16.
pub fn print_effects(rows: &[Row]) {
    let in_tick = |kernel: &str| {
        let row = rows
            .iter()
            .find(|row| row.kernel == kernel && row.blocks == 4);
        row.and_then(|row| row.cycles_in_tick)
    };
    let growth = |effect: &str, arithmetic: &str| {
        Some(
            in_tick(&format!("with_{effect}_{arithmetic}"))?
                - in_tick(&format!("gms_{arithmetic}"))?,
        )
    };
    println!(
        "{:<30} {:>8} {:>8}",
        "effect beside Gms<4>, in tick", "f32", "I16F16"
    );
    for row in rows {
        let name = row.kernel.strip_prefix("with_");
        if let Some(effect) = name.and_then(|name| name.strip_suffix("_f32")) {
            let (float, fixed) = (growth(effect, "f32"), growth(effect, "i16f16"));
            println!("{effect:<30} {:>8} {:>8}", decimal(float), decimal(fixed));
        }
    }
}

/// What is held against the committed table, by kernel and N: each count with what it is of.
pub type Counts = BTreeMap<String, Vec<(&'static str, f64)>>;

/// Every way in which `measured` is worse than, or not covered by, `committed`: instructions.
pub fn regressions(committed: &[Row], measured: &[Row]) -> Vec<String> {
    grown(&counts(committed), &counts(measured), 0.0, "instructions")
}

/// The counts of instructions are the same, as the table prints them.
pub fn same(committed: &[Row], measured: &[Row]) -> bool {
    let printed = from_csv(&to_csv(&[], measured));
    printed.is_ok_and(|measured| counts(committed) == counts(&measured))
}

fn counts(rows: &[Row]) -> Counts {
    let of = |row: &Row| {
        let longest = f64::from(row.instructions_max);
        vec![("mean", row.instructions_mean), ("longest path", longest)]
    };
    rows.iter().map(|row| (name(row), of(row))).collect()
}

fn name(row: &Row) -> String {
    format!("{} N={}", row.kernel, row.blocks)
}

/// Counts that grew by more than 3 % and `slack`, and rows that only one of the two has.
pub fn grown(committed: &Counts, measured: &Counts, slack: f64, unit: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (name, old) in committed {
        let Some(new) = measured.get(name) else {
            found.push(format!("{name}: no longer measured"));
            continue;
        };
        for ((what, old), (_, new)) in old.iter().zip(new) {
            if *new > old * (1.0 + TOLERANCE) + slack {
                found.push(format!("{name}: {what} grew from {old} to {new:.1} {unit}"));
            }
        }
    }
    let added = measured
        .keys()
        .filter(|name| !committed.contains_key(*name));
    found.extend(added.map(|name| format!("{name}: not in the committed table")));
    found
}

#[cfg(test)]
mod tests {
    use super::{Row, from_csv, regressions, to_csv};

    fn row(kernel: &str, instructions: f64) -> Row {
        Row {
            kernel: kernel.to_string(),
            blocks: 6,
            instructions_mean: instructions,
            instructions_max: 120,
            cycles_mean: 139.5,
            cycles_worst: 160,
            cycles_low: 130.0,
            cycles_high: 150.0,
            cycles_in_tick: (kernel == "a").then_some(110.0),
            floor: (kernel == "a").then_some(27.0),
            flash_bytes: 400,
            ram_bytes: (kernel == "a").then_some(24),
            paths: 17,
            calls: 10_000,
            error: (kernel == "b").then_some(0.25),
        }
    }

    #[test]
    fn a_table_survives_its_file() {
        let rows = vec![row("a", 100.0), row("b", 50.5)];
        assert_eq!(
            from_csv(&to_csv(&["made by a test".to_string()], &rows)).unwrap(),
            rows
        );
        assert!(
            from_csv("kernel,n\n")
                .unwrap_err()
                .to_string()
                .contains("column line")
        );
        let torn = to_csv(&[], &rows).replace(",17,", ",,");
        assert!(from_csv(&torn).unwrap_err().to_string().contains("line 2"));
    }

    #[test]
    fn three_percent_more_instructions_pass_and_four_do_not() {
        let old = [row("a", 100.0)];
        assert!(regressions(&old, &[row("a", 103.0)]).is_empty());
        assert!(regressions(&old, &[row("a", 80.0)]).is_empty());
        assert_eq!(regressions(&old, &[row("a", 104.0)]).len(), 1);
        assert_eq!(regressions(&old, &[row("b", 100.0)]).len(), 2);
    }
}
