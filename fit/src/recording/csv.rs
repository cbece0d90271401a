//! CSV as a stream: memory grows with the samples kept, never with the file.

use std::io::Read;

use super::LoadOptions;
use super::clock::{self, Clock};
use super::columns::{self, Plan};
use super::error::Problem;
use super::extra::Reading;
use super::known::Slot;
use super::labels::{self, Labels};
use super::layout::{self, Commas, Layout, Squeezed, io_problem};
use super::names::{Names, Source, plausible};
use super::table::{Data, Location, Table};
use super::{labelled, lost};

/// Reads every sample of a text of that layout.
pub(super) fn read(
    layout: Layout,
    samples: impl Read,
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
    let table = Rows::new(plan, layout);
    // Quotes are taken off cell by cell: an unclosed one must not swallow the rest of the file.
    let mut builder = ::csv::ReaderBuilder::new();
    builder.has_headers(false).flexible(true).quoting(false);
    builder
        .comment(Some(b'#'))
        .delimiter(table.layout.separator);
    if table.layout.separator == b' ' {
        let squeezed = Squeezed {
            inner: samples,
            blank: false,
            line_start: true,
            held: None,
        };
        table.read(builder.from_reader(squeezed), options)
    } else {
        table.read(builder.from_reader(samples), options)
    }
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
    constant: Vec<(usize, Vec<u8>)>,
    first_change: Vec<(String, usize)>,
    breaks: Vec<(usize, u64)>,
    samples: usize,
    /// What is wrong with the first row that holds no sample, and all of them.
    broken: (Option<Problem>, Vec<Broken>),
    /// For stamps that are dates or times of day.
    clock: Clock,
    /// What the first stamp shows of those since 1970.
    since_1970: Option<Option<f64>>,
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
            samples: 0,
            broken: (None, Vec::new()),
            clock: Clock::default(),
            since_1970: None,
            plan,
            layout,
        }
    }

    fn read<R: Read>(
        mut self,
        mut reader: ::csv::Reader<R>,
        options: &LoadOptions,
    ) -> Result<Table, Problem> {
        let mut record = ::csv::ByteRecord::new();
        let mut line = self.layout.first_line;
        let mut expected = 0;
        while reader
            .read_byte_record(&mut record)
            .map_err(|e| csv_problem(e, line))?
        {
            line = self.layout.first_line - 1 + record.position().map_or(0, ::csv::Position::line);
            if self.layout.labelled {
                record = labelled::bare(&record, &self.layout.names);
            }
            if record.len() > self.layout.names.len() {
                record = requoted(&record, self.layout.separator);
            }
            if let Err(problem) = self.row(&record, line, &mut expected, options) {
                self.hold(problem, &record, line)?;
            }
        }
        self.finish()
    }

    /// Takes a row, all of it or nothing.
    fn row(
        &mut self,
        record: &::csv::ByteRecord,
        line: u64,
        expected: &mut u64,
        options: &LoadOptions,
    ) -> Result<(), Problem> {
        let columns = self.layout.names.len();
        let surplus_blank = record.len() == columns + 1 && cell(record, columns).is_empty();
        if record.len() != columns && !surplus_blank {
            return Err(ragged(line, record, columns, self.layout.separator));
        }
        let commas = self.layout.commas;
        for (k, source) in self.plan.sources.iter().enumerate() {
            let column = source.columns().next().unwrap_or(0);
            let refused = match &mut self.data[k] {
                Data::Labels(labels) => label(cell(record, column), labels, source.mapped)
                    .map_err(|what| (column, what)),
                Data::Numbers(values)
                    if source.known.slot == Slot::Time
                        && let Some(seconds) = stamp(&mut self.clock, cell(record, column)) =>
                {
                    values.push(seconds);
                    Ok(())
                }
                Data::Numbers(values) => {
                    let since_1970 = &mut self.since_1970;
                    source
                        .value(|column| {
                            let value = number(cell(record, column), commas)?;
                            let unit = match source.is_bare_time() {
                                true => *since_1970.get_or_insert(clock::since_1970(value)),
                                false => None,
                            };
                            Ok(value * unit.unwrap_or(1.0))
                        })
                        .map(|value| values.push(value))
                }
            };
            if let Err((column, what)) = refused {
                for data in &mut self.data[..k] {
                    data.pop();
                }
                return Err(bad_cell(line, &self.layout.names, column, what));
            }
        }
        if self.samples >= options.max_samples {
            return Err(Problem::TooManySamples {
                at: format!("line {line}"),
                limit: options.max_samples,
            });
        }
        if self.breaks.is_empty() || line != *expected {
            self.breaks.push((self.samples, line));
        }
        *expected = line + 1;
        self.further(record, line, commas);
        self.samples += 1;
        Ok(())
    }

    /// The columns without a role.
    fn further(&mut self, record: &::csv::ByteRecord, line: u64, commas: Commas) {
        for (reading, &column) in self.extra.iter_mut().zip(&self.plan.unused) {
            let value = number(cell(record, column), commas).and_then(plausible);
            reading.push(value.map_err(|what| format!("line {line}: {what}")));
        }
        if self.samples == 0 {
            let first = |&c: &usize| (c, cell(record, c).to_vec());
            self.constant = self.plan.unused.iter().map(first).collect();
            return;
        }
        let (names, samples, changed) = (&self.layout.names, self.samples, &mut self.first_change);
        self.constant.retain(|(column, first)| {
            let same = cell(record, *column) == first.as_slice();
            if !same && let Some(name) = names.get(*column) {
                changed.push((name.clone(), samples));
            }
            same
        });
    }

    /// Keeps what is wrong with a row until all of them are known.
    fn hold(
        &mut self,
        problem: Problem,
        record: &::csv::ByteRecord,
        line: u64,
    ) -> Result<(), Problem> {
        if matches!(problem, Problem::TooManySamples { .. }) {
            return Err(problem);
        }
        let time = self.plan.sources.iter();
        let time = time.filter(|s| s.known.slot == Slot::Time);
        let time = cell(record, time.flat_map(Source::columns).next().unwrap_or(0));
        let has_time =
            number(time, Commas::Decimals).is_ok() || stamp(&mut Clock::default(), time).is_some();
        let (first, rows) = &mut self.broken;
        rows.push(Broken {
            line,
            samples: self.samples,
            has_time,
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
                self.plan.warnings.push(super::Warning::new(
                    "footer",
                    format!(
                        "{} lines from line {} to the end hold no time and were left out",
                        footer.len(),
                        row.line
                    ),
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
    if let (Problem::Cell { what, .. }, Some(next)) = (&mut problem, rows.get(1)) {
        *what = format!(
            "{what} (and {} more such rows, the next in line {})",
            rows.len() - 1,
            next.line
        );
    }
    problem
}

/// The seconds of a cell that holds a date or a time of day.
fn stamp(clock: &mut Clock, cell: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(cell).ok().filter(|t| t.contains(':'))?;
    clock.seconds(text)
}

/// Takes the number of a part; words only where the column was `mapped`.
fn label(cell: &[u8], labels: &mut Labels, mapped: bool) -> Result<(), String> {
    let text = String::from_utf8_lossy(cell);
    if text.is_empty() {
        return Err("the cell is empty".into());
    }
    if text.eq_ignore_ascii_case("nan") || !mapped && labels::whole(&text).is_none() {
        return Err(format!(
            "`{}` is not a whole number from 0",
            shortened(&text)
        ));
    }
    match labels.push(&text) {
        true => Ok(()),
        false => Err("holds over a million different parts".into()),
    }
}

fn cell(record: &::csv::ByteRecord, column: usize) -> &[u8] {
    let cell = record.get(column).unwrap_or_default().trim_ascii();
    let inside = cell.strip_prefix(b"\"").and_then(|c| c.strip_suffix(b"\""));
    inside.unwrap_or(cell).trim_ascii()
}

/// The row with what stands in quotes in one cell, whatever it holds.
fn requoted(record: &::csv::ByteRecord, separator: u8) -> ::csv::ByteRecord {
    let mut cells = ::csv::ByteRecord::new();
    let mut open: Option<Vec<u8>> = None;
    for cell in record {
        let whole = match open.take() {
            Some(before) => [&before[..], &[separator], cell].concat(),
            None => cell.to_vec(),
        };
        let text = whole.trim_ascii();
        match text.starts_with(b"\"") && (text.len() < 2 || !text.ends_with(b"\"")) {
            true => open = Some(whole),
            false => cells.push_field(&whole),
        }
    }
    open.iter().for_each(|cell| cells.push_field(cell));
    cells
}

/// The number in a cell, or what it is instead.
pub(super) fn number(cell: &[u8], commas: Commas) -> Result<f64, String> {
    if cell.is_empty() {
        return Err("the cell is empty".into());
    }
    if commas == Commas::Unsure && cell.contains(&b',') {
        return Err(format!(
            "the comma of `{}` may be one of thousands or of decimals, and no number in the file has a point; write numbers without it",
            shortened(&String::from_utf8_lossy(cell))
        ));
    }
    let parsed = std::str::from_utf8(cell).ok();
    match parsed.and_then(|text| layout::parse(text, commas == Commas::Decimals)) {
        // Some tools write the first time stamp as -0.
        Some(value) if value.is_finite() => Ok(value + 0.0),
        Some(_) => Err(format!(
            "`{}` is not finite",
            shortened(&String::from_utf8_lossy(cell))
        )),
        None => Err(format!(
            "`{}` is not a number",
            shortened(&String::from_utf8_lossy(cell))
        )),
    }
}

fn bad_cell(line: u64, names: &[String], column: usize, what: String) -> Problem {
    Problem::Cell {
        at: format!("line {line}"),
        column: names.get(column).cloned().unwrap_or_default(),
        what,
    }
}

fn ragged(line: u64, record: &::csv::ByteRecord, columns: usize, separator: u8) -> Problem {
    let text = String::from_utf8_lossy(record.as_slice()).into_owned();
    if record.len() == 1 && columns > 1 && separator != b';' && text.contains(';') {
        return Problem::Separator {
            line,
            found: "semicolons",
        };
    }
    let hint = if record.len() == 2 * columns || record.len() + 1 == 2 * columns {
        "if the numbers have decimal commas, separate the cells with semicolons"
    } else if record.len() < columns {
        "the row is cut short; complete it or remove it"
    } else {
        "remove the surplus cells or name their columns in the header"
    };
    Problem::Ragged {
        line,
        cells: record.len(),
        columns,
        hint,
    }
}

/// What is wrong with reading the text.
pub(super) fn csv_problem(error: ::csv::Error, line: u64) -> Problem {
    match error.into_kind() {
        ::csv::ErrorKind::Io(e) => io_problem(e, line),
        // The reader is flexible and takes bytes: it has no other kinds of error to give.
        other => Problem::Io(std::io::Error::other(format!("{other:?}"))),
    }
}

fn shortened(text: &str) -> String {
    let mut short: String = text.chars().take(40).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short
}
