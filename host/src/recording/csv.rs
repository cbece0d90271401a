//! CSV as a stream: memory grows with the samples kept, never with the file.

use std::io::{self, BufRead, BufReader, Read};

use super::LoadOptions;
use super::columns;
use super::error::Problem;
use super::extra::Reading;
use super::labels::Labels;
use super::table::{Data, Place, Table};

/// No sensible row is longer; a file without line ends would otherwise be held as one row.
const MAX_LINE_BYTES: usize = 64 * 1024;

/// Passes bytes on until a line exceeds [`MAX_LINE_BYTES`].
struct LineLimit<R> {
    inner: R,
    in_line: usize,
}

impl<R: Read> Read for LineLimit<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(buffer)?;
        for &byte in buffer.iter().take(n) {
            self.in_line = if byte == b'\n' || byte == b'\r' {
                0
            } else {
                self.in_line + 1
            };
            if self.in_line > MAX_LINE_BYTES {
                return Err(io::Error::new(io::ErrorKind::InvalidData, LONG_LINE));
            }
        }
        Ok(n)
    }
}

const LONG_LINE: &str = "a line is longer than 64 KiB, which is no row of samples";

/// Reads the header and every sample below it.
pub(super) fn read(input: impl Read, options: &LoadOptions) -> Result<Table, Problem> {
    let mut input = BufReader::with_capacity(
        64 * 1024,
        LineLimit {
            inner: input,
            in_line: 0,
        },
    );
    let mut line = 0;
    let header = header_line(&mut input, &mut line)?;
    let names = column_names(&header, line)?;
    let plan = columns::plan(
        &names,
        &names.join(", "),
        &options.map,
        options.needs,
        &options.ignore,
    )?;
    let mut data: Vec<Data> = plan
        .sources
        .iter()
        .map(|s| {
            if s.known.slot.is_label() {
                Data::Labels(Labels::default())
            } else {
                Data::Numbers(Vec::new())
            }
        })
        .collect();
    let mut extra: Vec<Reading> = plan
        .unused
        .iter()
        .map(|&c| Reading::new(names.get(c).map_or("", String::as_str)))
        .collect();
    // The first value of each unused column, until it changes.
    let mut constant: Vec<(usize, Vec<u8>)> = Vec::new();
    let mut first_change = Vec::new();
    let mut breaks: Vec<(usize, u64)> = Vec::new();
    let mut expected_line = 0;
    let header_lines = line;

    // Quotes are taken off cell by cell: an unclosed one must not swallow the rest of the file.
    let mut reader = ::csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .quoting(false)
        .from_reader(input);
    let mut record = ::csv::ByteRecord::new();
    let mut samples = 0;
    while reader
        .read_byte_record(&mut record)
        .map_err(|e| csv_problem(e, expected_line))?
    {
        let line = header_lines + record.position().map_or(0, ::csv::Position::line);
        if breaks.is_empty() || line != expected_line {
            breaks.push((samples, line));
        }
        expected_line = line + 1;
        if samples >= options.max_samples {
            return Err(Problem::TooManySamples {
                at: format!("line {line}"),
                limit: options.max_samples,
            });
        }
        if record.len() != names.len() {
            return Err(ragged(line, &record, names.len()));
        }
        for (source, data) in plan.sources.iter().zip(&mut data) {
            match data {
                Data::Numbers(values) => {
                    let mut value = source.factor;
                    for &column in &source.columns {
                        value *= number(cell(&record, column))
                            .map_err(|what| bad_cell(line, &names, column, what))?;
                    }
                    if !value.is_finite() {
                        let column = source.columns.first().copied().unwrap_or(0);
                        return Err(bad_cell(
                            line,
                            &names,
                            column,
                            "times its factor is infinite".into(),
                        ));
                    }
                    values.push(value);
                }
                Data::Labels(labels) => {
                    let column = source.columns.first().copied().unwrap_or(0);
                    let text = String::from_utf8_lossy(cell(&record, column));
                    if text.is_empty() {
                        return Err(bad_cell(line, &names, column, "the cell is empty".into()));
                    }
                    if !labels.push(&text) {
                        return Err(bad_cell(
                            line,
                            &names,
                            column,
                            "holds over a million different parts".into(),
                        ));
                    }
                }
            }
        }
        for (reading, &column) in extra.iter_mut().zip(&plan.unused) {
            if reading.refused.is_none() {
                match number(cell(&record, column)) {
                    Ok(value) => reading.values.push(value),
                    Err(what) => reading.refuse(format!("line {line}: {what}")),
                }
            }
        }
        if samples == 0 {
            constant = plan
                .unused
                .iter()
                .map(|&c| (c, cell(&record, c).to_vec()))
                .collect();
        } else {
            constant.retain(|(column, first)| {
                let same = cell(&record, *column) == first.as_slice();
                if !same && let Some(name) = names.get(*column) {
                    first_change.push((name.clone(), samples));
                }
                same
            });
        }
        samples += 1;
    }
    // Labels that are no numbers show only at the end; `assemble` finishes them.
    Ok(Table {
        plan,
        data,
        extra,
        place: Place::Lines(breaks),
        first_change,
    })
}

/// The first line that is neither blank nor a `#` remark, without its byte order mark.
fn header_line(input: &mut impl BufRead, line: &mut u64) -> Result<String, Problem> {
    let mut bytes = Vec::new();
    loop {
        bytes.clear();
        *line += 1;
        if input
            .read_until(b'\n', &mut bytes)
            .map_err(|e| io_problem(e, *line))?
            == 0
        {
            return Err(Problem::Empty);
        }
        if *line == 1 {
            if bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]) {
                return Err(Problem::NotText {
                    line: 1,
                    what: "the text is in UTF-16".into(),
                });
            }
            if bytes.starts_with(&[0xEF, 0xBB, 0xBF]) {
                bytes.drain(..3);
            }
        }
        if bytes.contains(&0) {
            return Err(Problem::NotText {
                line: *line,
                what: "a zero byte, this is no text file".into(),
            });
        }
        let text = std::str::from_utf8(&bytes)
            .map_err(|_| Problem::NotText {
                line: *line,
                what: "the header is not in UTF-8".into(),
            })?
            .trim();
        if !text.is_empty() && !text.starts_with('#') {
            return Ok(text.to_string());
        }
    }
}

fn column_names(header: &str, line: u64) -> Result<Vec<String>, Problem> {
    if !header.contains(',') {
        let found = [
            (';', "semicolons"),
            ('\t', "tabs"),
            (' ', "spaces"),
            ('|', "bars"),
        ];
        if let Some(&(_, found)) = found.iter().find(|(c, _)| header.contains(*c)) {
            return Err(Problem::Separator { line, found });
        }
    } else if header.matches(';').count() > header.matches(',').count() {
        return Err(Problem::Separator {
            line,
            found: "semicolons",
        });
    }
    let names: Vec<String> = header
        .split(',')
        .map(|n| n.trim().trim_matches('"').trim().to_string())
        .collect();
    match names.iter().find(|n| n.parse::<f64>().is_ok()) {
        Some(first) => Err(Problem::NoHeader {
            line,
            first: shortened(first),
        }),
        None => Ok(names),
    }
}

fn cell(record: &::csv::ByteRecord, column: usize) -> &[u8] {
    let cell = record.get(column).unwrap_or_default().trim_ascii();
    let inside = cell.strip_prefix(b"\"").and_then(|c| c.strip_suffix(b"\""));
    inside.unwrap_or(cell).trim_ascii()
}

fn number(cell: &[u8]) -> Result<f64, String> {
    if cell.is_empty() {
        return Err("the cell is empty".into());
    }
    match std::str::from_utf8(cell)
        .ok()
        .and_then(|text| text.parse::<f64>().ok())
    {
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

fn ragged(line: u64, record: &::csv::ByteRecord, columns: usize) -> Problem {
    let text = String::from_utf8_lossy(record.as_slice()).into_owned();
    if record.len() == 1 && columns > 1 && text.contains(';') {
        return Problem::Separator {
            line,
            found: "semicolons",
        };
    }
    let hint = if record.len() == 2 * columns || record.len() + 1 == 2 * columns {
        "if the numbers have decimal commas, export them with points"
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

fn csv_problem(error: ::csv::Error, line: u64) -> Problem {
    match error.into_kind() {
        ::csv::ErrorKind::Io(e) => io_problem(e, line),
        // The reader is flexible and takes bytes: it has no other kinds of error to give.
        other => Problem::Io(io::Error::other(format!("{other:?}"))),
    }
}

fn io_problem(error: io::Error, line: u64) -> Problem {
    if error.kind() == io::ErrorKind::InvalidData && error.to_string() == LONG_LINE {
        Problem::NotText {
            line,
            what: LONG_LINE.into(),
        }
    } else {
        Problem::Io(error)
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
        assert!(e.contains("decimal commas"), "{e}");
    }

    #[test]
    fn separators_and_headers_that_are_none() {
        assert!(matches!(
            error("t_s;x_m;force_N\n0;0;1\n").problem,
            Problem::Separator {
                found: "semicolons",
                ..
            }
        ));
        assert!(matches!(
            error("t_s\tx_m\tforce_N\n0\t0\t1\n").problem,
            Problem::Separator { found: "tabs", .. }
        ));
        assert!(matches!(
            error("t_s,x_m,force_N\n0;0;1\n").problem,
            Problem::Separator { line: 2, .. }
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
        let utf16 = load_csv(&b"\xff\xfet\0_\0"[..], "u.csv", &LoadOptions::default());
        assert!(matches!(
            utf16.map_err(|e| e.problem),
            Err(Problem::NotText { line: 1, .. })
        ));
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
