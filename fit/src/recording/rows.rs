//! The rows of a text as they come in: memory grows with the samples kept, never with the file.

use super::clock::{Clock, Since1970};
use super::columns::{self, Plan};
use super::error::Problem;
use super::known::Slot;
use super::layout::{self, Commas, Layout, Line};
use super::names::{Names, Source, plausible};
use super::table::{Builder, Table};
use super::{LoadOptions, labelled, labels};

/// Reads every sample of a text of that layout.
pub(super) fn read(
    layout: Layout,
    lines: impl Iterator<Item = Result<Line, Problem>>,
    options: &LoadOptions,
) -> Result<Table, Problem> {
    let plan = columns::plan(&Names {
        columns: &layout.names,
        units: &layout.units,
        listing: &listed(&layout.names),
        map: &options.map,
        ignore: &options.ignore,
        needs: options.needs,
        sample_time: layout.sample_time,
    })?;
    let times = plan.sources.iter().filter(|s| s.known.slot == Slot::Time);
    let time = times.flat_map(Source::columns).next().unwrap_or(0);
    let mut builder = Builder::new(plan, "line", options.max_samples);
    let mut constant = None;
    let mut clocks = (Clock::default(), Since1970::default());
    for line in lines {
        let Line { text, number: at } = line?;
        let text = text.trim_start_matches(' ');
        if at < layout.first_line || text.is_empty() || text.starts_with('#') {
            continue;
        }
        let cells = layout.row(text);
        if cells.is_empty() {
            continue;
        }
        match sample(&builder.table.plan, &layout, &cells, at, &mut clocks) {
            Ok(values) => {
                let label = |c: usize| cells[c].to_owned();
                let further = |c: usize| number(cells[c], layout.commas).and_then(plausible);
                changes(&mut builder, &cells, &mut constant);
                builder.take(at, &values, label, further)?;
            }
            Err(problem) => {
                let time = cells.get(time).copied().unwrap_or_default();
                let has_time = number(time, Commas::Decimals).is_ok()
                    || stamp(&mut Clock::default(), time).is_some();
                builder.lose(at, problem, has_time)?;
            }
        }
    }
    builder.table.plan.warnings.extend(clocks.1.said());
    builder.finish()
}

/// The columns that have a name; the others are counted.
fn listed(names: &[String]) -> String {
    let named: Vec<&str> = names
        .iter()
        .map(String::as_str)
        .filter(|n| !n.is_empty())
        .collect();
    let without = match names.len() - named.len() {
        0 => String::new(),
        1 => " and a column without a name".to_owned(),
        n => format!(" and {n} columns without names"),
    };
    named.join(", ") + &without
}

impl Layout {
    /// The cells of a row.
    fn row<'a>(&self, text: &'a str) -> Vec<&'a str> {
        let split = |whole| {
            let mut cells = layout::cells(text, self.separator, whole);
            if self.labelled {
                let names = cells.iter_mut().zip(&self.names);
                names.for_each(|(cell, name)| *cell = labelled::bare(cell, name));
            }
            cells
        };
        // An unclosed quotation mark must not swallow a row that is right without any.
        Some(split(false))
            .filter(|cells| cells.len() <= self.names.len())
            .unwrap_or_else(|| split(true))
    }
}

/// The values of a row, 0 for its labels.
fn sample(
    plan: &Plan,
    layout: &Layout,
    cells: &[&str],
    line: u64,
    (clock, since_1970): &mut (Clock, Since1970),
) -> Result<Vec<f64>, Problem> {
    let columns = layout.names.len();
    let surplus_blank = cells.len() == columns + 1 && cells[columns].is_empty();
    if cells.len() != columns && !surplus_blank {
        return Err(ragged(line, cells, columns, layout.separator));
    }
    let mut value = |source: &Source| {
        let column = source.columns().next().unwrap_or(0);
        if source.known.slot.is_label() {
            let label = label(cells[column], source.mapped);
            return label.map(|()| 0.0).map_err(|what| (column, what));
        }
        if source.known.slot == Slot::Time
            && let Some(seconds) = stamp(clock, cells[column])
        {
            return Ok(seconds);
        }
        let cell = |column: usize| number(cells[column], layout.commas);
        source.value(|column| Ok(since_1970.of(source, cell(column)?)))
    };
    let values = plan.sources.iter().map(|source| {
        value(source).map_err(|(column, what)| {
            Problem::cell(format!("line {line}"), &layout.names[column], what)
        })
    });
    values.collect()
}

/// Tells the table where the columns without a role change; `constant` are those that have not, with their first cell.
fn changes(builder: &mut Builder, cells: &[&str], constant: &mut Option<Vec<(usize, String)>>) {
    let Table {
        plan, first_change, ..
    } = &mut builder.table;
    let first = |&c: &usize| (c, cells[c].to_owned());
    let constant = constant.get_or_insert_with(|| plan.unused.iter().map(first).collect());
    constant.retain(|(column, first)| {
        let same = cells[*column] == first;
        if !same {
            first_change.push((plan.names[*column].clone(), builder.samples));
        }
        same
    });
}

/// The seconds of a cell that holds a date or a time of day.
fn stamp(clock: &mut Clock, cell: &str) -> Option<f64> {
    // `20260102T030405.123` has no colon.
    let is_compact = matches!(cell.as_bytes().get(8), Some(b'T' | b't'));
    (is_compact || cell.contains(':'))
        .then(|| clock.seconds(cell))
        .flatten()
}

/// That a cell is the number of a part; words only where the column was `mapped`.
fn label(cell: &str, mapped: bool) -> Result<(), String> {
    if cell.is_empty() {
        return Err("the cell is empty".into());
    }
    if cell.eq_ignore_ascii_case("nan") || !mapped && labels::whole(cell).is_none() {
        return Err(format!(
            "`{}` is not a whole number from 0",
            shortened(cell)
        ));
    }
    Ok(())
}

/// The number in a cell, or what it is instead.
pub(super) fn number(cell: &str, commas: Commas) -> Result<f64, String> {
    if cell.is_empty() {
        return Err("the cell is empty".into());
    }
    if commas == Commas::Unsure && cell.contains(',') {
        return Err(format!(
            "the comma of `{}` may be one of thousands or of decimals, and no number in the file has a point; write numbers without it",
            shortened(cell)
        ));
    }
    match layout::parse(cell, commas == Commas::Decimals) {
        // Some tools write the first time stamp as -0.
        Some(value) if value.is_finite() => Ok(value + 0.0),
        Some(_) => Err(format!("`{}` is not finite", shortened(cell))),
        None => Err(format!("`{}` is not a number", shortened(cell))),
    }
}

/// A row with another number of cells than the header.
fn ragged(line: u64, row: &[&str], columns: usize, separator: u8) -> Problem {
    let cells = row.len();
    if cells == 1 && columns > 1 && separator != b';' && row[0].contains(';') {
        return Problem::Row {
            found: format!("line {line}: the columns are separated by semicolons"),
            remedy: "export with commas between columns and points in numbers",
        };
    }
    Problem::Row {
        found: format!("line {line}: {cells} cells where the header has {columns}"),
        remedy: if cells == 2 * columns || cells + 1 == 2 * columns {
            "if the numbers have decimal commas, separate the cells with semicolons"
        } else if cells < columns {
            "the row is cut short; complete it or remove it"
        } else {
            "remove the surplus cells or name their columns in the header"
        },
    }
}

fn shortened(text: &str) -> String {
    let mut short: String = text.chars().take(40).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short
}
