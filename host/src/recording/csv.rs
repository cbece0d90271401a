//! CSV as a stream: memory grows with the samples kept, never with the file.

use std::io::Read;

use super::LoadOptions;
use super::clock::Clock;
use super::columns::{self, Plan};
use super::error::Problem;
use super::extra::Reading;
use super::known::Slot;
use super::labels::Labels;
use super::layout::{self, Layout, Squeezed, io_problem};
use super::names::Names;
use super::table::{Data, Location, Table};

/// Reads the header and every sample below it, of a text that begins with `head` and goes on with `rest`.
pub(super) fn read(head: &[u8], rest: impl Read, options: &LoadOptions) -> Result<Table, Problem> {
    let layout = layout::of(head)?;
    let plan = columns::plan(&Names {
        columns: &layout.names,
        units: &layout.units,
        listing: &layout.names.join(", "),
        map: &options.map,
        ignore: &options.ignore,
        needs: options.needs,
    })?;
    let samples = head.get(layout.skip..).unwrap_or_default().chain(rest);
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
    /// Rows that may be a footer: the first one's problem, and how many.
    footer: Option<(u64, Problem, usize)>,
    /// The first cell that is no number, and the lines of those after it.
    bad: Option<(Problem, Vec<u64>)>,
    /// For stamps that are dates or times of day.
    clock: Clock,
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
            footer: None,
            bad: None,
            clock: Clock::default(),
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
        let comma = self.layout.separator != b',';
        for (k, source) in self.plan.sources.iter().enumerate() {
            let column = source.columns.first().copied().unwrap_or(0);
            let refused = match &mut self.data[k] {
                Data::Labels(labels) => label(cell(record, column), labels),
                Data::Numbers(values)
                    if source.known.slot == Slot::Time
                        && let Some(seconds) = stamp(&mut self.clock, cell(record, column)) =>
                {
                    values.push(seconds);
                    Ok(())
                }
                Data::Numbers(values) => {
                    let mut product = Ok(source.factor);
                    for &column in &source.columns {
                        product =
                            product.and_then(|p| Ok(p * number(cell(record, column), comma)?));
                    }
                    product
                        .and_then(|p| columns::plausible(p + source.offset))
                        .map(|value| values.push(value))
                }
            };
            if let Err(what) = refused {
                for data in &mut self.data[..k] {
                    data.pop();
                }
                return Err(bad_cell(line, &self.layout.names, column, what));
            }
        }
        if let Some((_, problem, _)) = self.footer.take() {
            return Err(problem);
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
        self.further(record, line, comma);
        self.samples += 1;
        Ok(())
    }

    /// The columns without a role.
    fn further(&mut self, record: &::csv::ByteRecord, line: u64, comma: bool) {
        for (reading, &column) in self.extra.iter_mut().zip(&self.plan.unused) {
            if reading.refused.is_none() {
                match number(cell(record, column), comma).and_then(columns::plausible) {
                    Ok(value) => reading.values.push(value),
                    Err(what) => reading.refuse(format!("line {line}: {what}")),
                }
            }
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

    /// Keeps what is wrong with a row until it is known whether samples follow it.
    fn hold(
        &mut self,
        problem: Problem,
        record: &::csv::ByteRecord,
        line: u64,
    ) -> Result<(), Problem> {
        let time = self
            .plan
            .sources
            .iter()
            .find(|s| s.known.slot == Slot::Time);
        let time = time.and_then(|s| s.columns.first().copied()).unwrap_or(0);
        let time = cell(record, time);
        let has_time = number(time, true).is_ok() || stamp(&mut Clock::default(), time).is_some();
        match (&problem, &mut self.footer, &mut self.bad) {
            (Problem::TooManySamples { .. }, ..) => return Err(problem),
            (Problem::Cell { .. }, _, Some((_, more))) if has_time => more.push(line),
            (Problem::Cell { .. }, _, bad) if has_time => *bad = Some((problem, Vec::new())),
            _ if has_time => return Err(problem),
            (_, Some((_, _, rows)), _) => *rows += 1,
            (_, footer, _) => *footer = Some((line, problem, 1)),
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Table, Problem> {
        if let Some((mut problem, more)) = self.bad {
            if let (Problem::Cell { what, .. }, Some(next)) = (&mut problem, more.first()) {
                *what = format!(
                    "{what} (and {} more such rows, the next in line {next})",
                    more.len()
                );
            }
            return Err(problem);
        }
        match self.footer {
            // One line in place of the samples, or more of it than of them, is no footer.
            Some((_, problem, rows)) if rows > self.samples => return Err(problem),
            Some((line, _, rows)) => self.plan.warnings.push(super::Warning::new(
                "footer",
                format!("{rows} lines from line {line} to the end hold no time and were left"),
            )),
            None => {}
        }
        // Labels that are no numbers show only at the end; `assemble` finishes them.
        Ok(Table {
            plan: self.plan,
            data: self.data,
            extra: self.extra,
            place: Location::Lines(self.breaks),
            first_change: self.first_change,
        })
    }
}

/// The seconds of a cell that holds a date or a time of day.
fn stamp(clock: &mut Clock, cell: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(cell).ok().filter(|t| t.contains(':'))?;
    clock.seconds(text)
}

fn label(cell: &[u8], labels: &mut Labels) -> Result<(), String> {
    let text = String::from_utf8_lossy(cell);
    if text.is_empty() {
        return Err("the cell is empty".into());
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

/// The number in a cell, or what it is instead; `comma` allows a decimal comma.
pub(super) fn number(cell: &[u8], comma: bool) -> Result<f64, String> {
    if cell.is_empty() {
        return Err("the cell is empty".into());
    }
    let parsed = std::str::from_utf8(cell).ok();
    match parsed.and_then(|text| layout::parse(text, comma)) {
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

#[cfg(test)]
mod tests {
    use super::super::{LoadOptions, Recording, RecordingError, load_csv};
    use super::*;
    use std::io;

    fn load(text: &str) -> Result<Recording, RecordingError> {
        load_csv(text.as_bytes(), "test.csv", &LoadOptions::default())
    }
    fn error(text: &str) -> RecordingError {
        match load(text) {
            Ok(_) => panic!("accepted: {text}"),
            Err(error) => error,
        }
    }

    #[test]
    fn bad_cells_name_file_line_and_column() {
        for (cell, reason) in [
            ("nan", "not finite"),
            ("NaN", "not finite"),
            ("inf", "not finite"),
            ("1e999", "not finite"),
            ("", "is empty"),
            ("abc", "not a number"),
            ("1.2.3", "not a number"),
            ("0x10", "not a number"),
        ] {
            let e = error(&format!(
                "# remark\n\nt_s,x_m,force_N\n0,0,1\n1,{cell},1\n2,0,1\n"
            ));
            let text = e.to_string();
            assert!(matches!(e.problem, Problem::Cell { .. }), "{text}");
            for part in ["test.csv", "line 5", "`x_m`", reason] {
                assert!(text.contains(part), "{text} lacks {part}");
            }
        }
    }

    #[test]
    fn rows_of_the_wrong_length_name_the_line() {
        let e = error("t_s,x_m,force_N\n0,0,1\n1,0\n").to_string();
        assert!(e.contains("line 3: 2 cells where the header has 3"), "{e}");
        let e = error("t_s,x_m,force_N\n0,0,0,1,1,5\n").to_string();
        assert!(e.contains("decimal commas") || e.contains("cells"), "{e}");
    }

    #[test]
    fn headers_that_are_none() {
        assert!(matches!(
            error("t_s,x_m,force_N\n0;0;1\n").problem,
            Problem::Separator { .. } | Problem::Columns { .. } | Problem::Ragged { .. }
        ));
        assert!(matches!(
            error("0,0,1\n1,0,1\n").problem,
            Problem::NoHeader { line: 1, .. }
        ));
        for empty in ["", "\n\n", "# only a remark\n", "\u{feff}"] {
            assert!(matches!(error(empty).problem, Problem::Empty), "{empty:?}");
        }
        assert!(matches!(
            error("t_s,x_m,force_N\n").problem,
            Problem::TooShort { samples: 0, .. }
        ));
        assert!(matches!(
            error("t_s,x_m,force_N\n0,0,1\n").problem,
            Problem::TooShort { samples: 1, .. }
        ));
        assert!(matches!(
            error("t_s,x_m\0,force_N\n").problem,
            Problem::NotText { .. }
        ));
    }

    #[test]
    fn what_drives_write_around_the_samples_is_read() {
        let plain = load("t_s,x_m,force_N\n0,0,1\n1,1e-3,1\n2,0,1\n").expect("plain");
        let utf16: Vec<u8> = "\u{feff}t_s;x_m;force_N\r\n0;0;1\r\n1;0,001;1\r\n2;0;1\r\n"
            .encode_utf16()
            .flat_map(u16::to_le_bytes)
            .collect();
        for (name, text) in [
            (
                "semicolons",
                b"t_s;x_m;force_N\n0;0;1\n1;1e-3;1\n2;0;1\n".to_vec(),
            ),
            (
                "decimal commas",
                b"t_s;x_m;force_N\n0,0;0,0;1,0\n1,0;0,001;1,0\n2,0;0,0;1,0\n".to_vec(),
            ),
            (
                "tabs",
                b"t_s\tx_m\tforce_N\n0\t0\t1\n1\t1e-3\t1\n2\t0\t1\n".to_vec(),
            ),
            (
                "blanks",
                b"   t_s x_m  force_N\n 0 0 1\n 1   1e-3 1\n 2 0 1 \n".to_vec(),
            ),
            ("CR", b"t_s,x_m,force_N\r0,0,1\r1,1e-3,1\r2,0,1\r".to_vec()),
            (
                "a units row",
                b"Time,Position,Force\nms,mm,kN\n0,0,0.001\n1000,1,0.001\n2000,0,0.001\n".to_vec(),
            ),
            (
                "metadata",
                b"Scope 4.2\nRate;1000\n\nt_s;x_m;force_N\n0;0;1\n1;1e-3;1\n2;0;1\n".to_vec(),
            ),
            (
                "a footer",
                b"t_s,x_m,force_N\n0,0,1\n1,1e-3,1\n2,0,1\nmean,1,1\nend of file\n".to_vec(),
            ),
            (
                "Latin-1",
                b"t_s,x_m,force_N,Temp_\xb0C,note\n0,0,1,3,\xe4\n1,1e-3,1,4,\xe4\n2,0,1,5,\xe4\n"
                    .to_vec(),
            ),
            ("UTF-16", utf16),
            (
                "a remark for a header",
                b"# t_s x_m force_N\n0 0 1\n1 1e-3 1\n2 0 1\n".to_vec(),
            ),
        ] {
            let read = load_csv(text.as_slice(), name, &LoadOptions::default());
            let read = read.unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(
                (&read.t_s, &read.position, &read.effort),
                (&plain.t_s, &plain.position, &plain.effort),
                "{name}"
            );
            let footer = read
                .warnings
                .iter()
                .any(|w| w.code == "footer" && w.message.contains("line 5"));
            assert_eq!(footer, name == "a footer");
        }
    }

    #[test]
    fn all_bad_cells_are_counted_and_absurd_ones_refused() {
        let e = error("t_s,x_m,force_N\n0,0,1\n1,nan,1\n2,0,1\n3,0,x\n4,0,1\n").to_string();
        assert!(
            e.contains("line 3") && e.contains("1 more") && e.contains("line 5"),
            "{e}"
        );
        let e = error("t_s,x_m,force_N\n0,0,1\n1,0,1e288\n2,0,1\n").to_string();
        assert!(
            e.contains("line 3") && e.contains("force_N") && e.contains("no sensor"),
            "{e}"
        );
        let rows: String = (0..100).map(|i| format!("{i},{},1,{i}\n", i % 7)).collect();
        let e = error(&format!("t_s,x_m,force_N,repeat\n{rows}")).to_string();
        assert!(e.contains("repeat") && e.contains("counts rows"), "{e}");
        let floats =
            load("t_s,x_m,force_N,repeat\n0,0,1,0.0\n1,1,1,1.0\n2,0,1,1.0\n").expect("1.0");
        assert_eq!(floats.repeat, [0, 1, 1]);
    }

    #[test]
    fn bom_crlf_quotes_spaces_and_remarks_are_accepted() {
        let plain = load("t_s,x_m,force_N,note\n-0,0,1,a\n1,1e-3,1,b\n2,0,1,c\n").expect("plain");
        let odd = load("\u{feff}# remark\r\n\r\n\"t_s\", \"x_m\" ,force_N,note\r\n-0, 0,1,a\r\n1,\"1e-3\",1,b\r\n2,0,1,c")
            .expect("odd");
        assert_eq!(
            (&plain.t_s, &plain.position, &plain.effort),
            (&odd.t_s, &odd.position, &odd.effort)
        );
        assert!(plain.t_s.first().is_some_and(|t| t.is_sign_positive()));
        let notes: Vec<_> = odd
            .warnings
            .iter()
            .filter(|w| w.code == "unused-columns")
            .collect();
        assert_eq!(notes.len(), 1);
        assert!(notes.iter().all(|w| w.message.contains("note")));
    }

    /// Rows without end, made on the fly.
    struct Endless {
        row: u64,
        buffer: Vec<u8>,
    }
    impl Read for Endless {
        fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
            if self.buffer.is_empty() {
                self.buffer = format!("{},{},1\n", self.row, self.row % 7).into_bytes();
                self.row += 1;
            }
            let n = out.len().min(self.buffer.len());
            out[..n].copy_from_slice(&self.buffer[..n]);
            self.buffer.drain(..n);
            Ok(n)
        }
    }

    #[test]
    fn a_stream_without_end_is_refused_at_the_sample_limit() {
        let options = LoadOptions {
            max_samples: 50_000,
            ..LoadOptions::default()
        };
        let input = (&b"t_s,x_m,force_N\n"[..]).chain(Endless {
            row: 0,
            buffer: Vec::new(),
        });
        let e = load_csv(input, "endless.csv", &options).expect_err("endless");
        assert!(
            matches!(e.problem, Problem::TooManySamples { limit: 50_000, .. }),
            "{e}"
        );
        assert!(e.to_string().contains("line 50002"), "{e}");
    }

    #[test]
    fn a_line_without_end_is_refused_before_it_fills_memory() {
        for head in ["", "t_s,x_m,force_N\n", "t_s,x_m,force_N\n0,0,\"1\n"] {
            let e = load_csv(
                head.as_bytes().chain(io::repeat(b'1')),
                "long.csv",
                &LoadOptions::default(),
            );
            let e = e.expect_err("endless line").to_string();
            assert!(e.contains("64 KiB") || e.contains("not a number"), "{e}");
        }
    }
}
