//! The rows of a text as they come in: memory grows with the samples kept, never with the file.

use super::clock::{self, Clock};
use super::columns::{self, Plan};
use super::error::Problem;
use super::extra::Reading;
use super::known::Slot;
use super::labels::{self, Labels};
use super::layout::{self, Commas, Layout, Line};
use super::names::{Names, Source, plausible};
use super::table::{Data, Location, Table};
use super::{LoadOptions, labelled, lost};

/// Reads every sample of a text of that layout.
pub(super) fn read(
    layout: Layout,
    lines: impl Iterator<Item = Result<Line, Problem>>,
    options: &LoadOptions,
) -> Result<Table, Problem> {
    let plan = columns::plan(&Names {
        columns: &layout.names,
        units: &layout.units,
        listing: &layout.names.join(", "),
        map: &options.map,
        ignore: &options.ignore,
        needs: options.needs,
        sample_time: layout.sample_time,
    })?;
    let mut rows = Rows::new(plan, layout);
    for line in lines {
        let Line { text, number } = line?;
        let text = text.trim_start_matches(' ');
        if number < rows.layout.first_line || text.is_empty() || text.starts_with('#') {
            continue;
        }
        let cells = rows.layout.row(text);
        if cells.is_empty() {
            continue;
        }
        match rows.sample(&cells, number) {
            Ok(values) => rows.take(&values, &cells, number, options.max_samples)?,
            Err(problem) => rows.hold(problem, &cells, number)?,
        }
    }
    rows.finish()
}

/// Rows without a sample after which a text that has more of them than samples is read no further.
const MOST_BROKEN: usize = 1000;

/// A row that holds no sample.
struct Broken {
    line: u64,
    /// Samples before it.
    samples: usize,
    has_time: bool,
}

/// The samples as they come in.
struct Rows {
    plan: Plan,
    layout: Layout,
    data: Vec<Data>,
    extra: Vec<Reading>,
    /// The first value of each column without a role, until it changes.
    constant: Vec<(usize, String)>,
    first_change: Vec<(String, usize)>,
    breaks: Vec<(usize, u64)>,
    /// The line after the last sample.
    expected: u64,
    samples: usize,
    /// What is wrong with the first row that holds no sample, and all of them.
    broken: (Option<Problem>, Vec<Broken>),
    /// For stamps that are dates or times of day.
    clock: Clock,
    /// What the first stamp shows of those since 1970.
    since_1970: Option<Option<f64>>,
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

impl Rows {
    fn new(plan: Plan, layout: Layout) -> Self {
        let data = plan.sources.iter().map(|s| match s.known.slot.is_label() {
            true => Data::Labels(Labels::default()),
            false => Data::Numbers(Vec::new()),
        });
        let name = |c: &usize| layout.names.get(*c).map_or("", String::as_str);
        Self {
            data: data.collect(),
            extra: plan.unused.iter().map(|c| Reading::new(name(c))).collect(),
            constant: Vec::new(),
            first_change: Vec::new(),
            breaks: Vec::new(),
            expected: 0,
            samples: 0,
            broken: (None, Vec::new()),
            clock: Clock::default(),
            since_1970: None,
            plan,
            layout,
        }
    }

    /// The values of a row, 0 for its labels.
    fn sample(&mut self, cells: &[&str], line: u64) -> Result<Vec<f64>, Problem> {
        let columns = self.layout.names.len();
        let surplus_blank = cells.len() == columns + 1 && cells[columns].is_empty();
        if cells.len() != columns && !surplus_blank {
            return Err(ragged(line, cells, columns, self.layout.separator));
        }
        let (commas, clock, since_1970) =
            (self.layout.commas, &mut self.clock, &mut self.since_1970);
        let mut value = |source: &Source| {
            let column = source.columns().next().unwrap_or(0);
            let cell = cells[column];
            if source.known.slot.is_label() {
                let label = label(cell, source.mapped);
                return label.map(|()| 0.0).map_err(|what| (column, what));
            }
            if source.known.slot == Slot::Time
                && let Some(seconds) = stamp(clock, cell)
            {
                return Ok(seconds);
            }
            source.value(|column| {
                let value = number(cells[column], commas)?;
                let unit = match source.is_bare_time() {
                    true => *since_1970.get_or_insert(clock::since_1970(value)),
                    false => None,
                };
                Ok(value * unit.unwrap_or(1.0))
            })
        };
        let values = self.plan.sources.iter().map(|source| {
            value(source).map_err(|(column, what)| {
                Problem::cell(format!("line {line}"), &self.layout.names[column], what)
            })
        });
        values.collect()
    }

    /// Takes a row that holds a sample.
    fn take(
        &mut self,
        values: &[f64],
        cells: &[&str],
        line: u64,
        max_samples: usize,
    ) -> Result<(), Problem> {
        let at = || format!("line {line}");
        if self.samples >= max_samples {
            return Err(Problem::too_many_samples(at(), max_samples));
        }
        for ((source, data), &value) in self.plan.sources.iter().zip(&mut self.data).zip(values) {
            match data {
                Data::Numbers(values) => values.push(value),
                Data::Labels(labels) => {
                    let column = source.columns().next().unwrap_or(0);
                    let taken = labels.push(cells[column]);
                    taken.map_err(|what| Problem::cell(at(), source.known.name, what))?;
                }
            }
        }
        if self.breaks.is_empty() || line != self.expected {
            self.breaks.push((self.samples, line));
        }
        self.expected = line + 1;
        self.further(cells, line);
        self.samples += 1;
        Ok(())
    }

    /// The columns without a role.
    fn further(&mut self, cells: &[&str], line: u64) {
        for (reading, &column) in self.extra.iter_mut().zip(&self.plan.unused) {
            let value = number(cells[column], self.layout.commas).and_then(plausible);
            reading.push(value.map_err(|what| format!("line {line}: {what}")));
        }
        if self.samples == 0 {
            let first = |&c: &usize| (c, cells[c].to_owned());
            self.constant = self.plan.unused.iter().map(first).collect();
            return;
        }
        let (names, samples, changed) = (&self.layout.names, self.samples, &mut self.first_change);
        self.constant.retain(|(column, first)| {
            let same = cells[*column] == first;
            if !same {
                changed.push((names[*column].clone(), samples));
            }
            same
        });
    }

    /// Keeps what is wrong with a row until all of them are known.
    fn hold(&mut self, problem: Problem, cells: &[&str], line: u64) -> Result<(), Problem> {
        let time = self.plan.sources.iter();
        let time = time.filter(|s| s.known.slot == Slot::Time);
        let time = time.flat_map(Source::columns).next().unwrap_or(0);
        let time = cells.get(time).copied().unwrap_or_default();
        let (first, rows) = &mut self.broken;
        rows.push(Broken {
            line,
            samples: self.samples,
            has_time: number(time, Commas::Decimals).is_ok()
                || stamp(&mut Clock::default(), time).is_some(),
        });
        first.get_or_insert(problem);
        // Nothing that follows could make a recording of it, however long it is.
        match first.take_if(|_| rows.len() > MOST_BROKEN && rows.len() > self.samples) {
            Some(problem) => Err(with_others(problem, rows)),
            None => Ok(()),
        }
    }

    fn finish(mut self) -> Result<Table, Problem> {
        if let Some(Some(unit)) = self.since_1970 {
            self.plan.warnings.push(clock::said(unit));
        }
        if let (Some(problem), mut rows) = self.broken {
            let end = rows.iter().rev();
            let footer = end.take_while(|row| row.samples == self.samples && !row.has_time);
            let footer = rows.split_off(rows.len() - footer.count());
            // One line in place of the samples, or more of it than of them, is no footer.
            if footer.len() > self.samples || lost::too_many(rows.len(), self.samples) {
                return Err(with_others(problem, &rows));
            }
            if let Some(row) = footer.first() {
                self.plan.warnings.push(warning!(
                    "footer",
                    "{} lines from line {} to the end hold no time and were left",
                    footer.len(),
                    row.line
                ));
            }
            if !rows.is_empty() {
                let lines: Vec<u64> = rows.iter().map(|row| row.line).collect();
                let said = lost::said("line", &lines, &problem.found());
                self.plan.warnings.push(said);
            }
        }
        // Labels that are no numbers show only at the end; `assemble` finishes them.
        Ok(Table {
            plan: self.plan,
            data: self.data,
            extra: self.extra,
            place: Location {
                what: "line",
                breaks: self.breaks,
            },
            first_change: self.first_change,
        })
    }
}

/// The problem of the first of these rows, with how many more there are.
fn with_others(mut problem: Problem, rows: &[Broken]) -> Problem {
    if let (Problem::Row { found, .. }, Some(next)) = (&mut problem, rows.get(1)) {
        let (more, line) = (rows.len() - 1, next.line);
        *found += &format!(" (and {more} more such rows, the next in line {line})");
    }
    problem
}

/// The seconds of a cell that holds a date or a time of day.
fn stamp(clock: &mut Clock, cell: &str) -> Option<f64> {
    cell.contains(':').then(|| clock.seconds(cell)).flatten()
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
