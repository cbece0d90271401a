//! How a text file is laid out: encoding, line ends, separator, where the header, its units and the samples are.

use std::io::{self, Read};

use super::error::Problem;
use super::words::quantity;
use super::{stated, units};

/// No sensible row is longer; a file without line ends would otherwise be held as one row.
const MAX_LINE_BYTES: usize = 64 * 1024;

/// Bytes that decide the layout: more than the longest line.
const HEAD_BYTES: usize = 2 * MAX_LINE_BYTES;

/// Lines that decide the layout.
const HEAD_LINES: usize = 400;

/// Lines between the last sample line's header and the samples.
const LINES_BETWEEN: usize = 6;

/// What is said of a line beyond [`MAX_LINE_BYTES`].
pub(super) const LONG_LINE: &str = "a line is longer than 64 KiB, which is no row of samples";

/// Text in UTF-8 with `\n` at line ends, from UTF-8, from UTF-16 with its mark, and from bytes of any other kind as they are.
pub(super) fn text(input: impl Read) -> impl Read {
    let decoded = encoding_rs_io::DecodeReaderBytesBuilder::new()
        .bom_sniffing(true)
        .strip_bom(true)
        .utf8_passthru(true)
        .build(input);
    Lines {
        inner: decoded,
        in_line: 0,
        after_return: false,
    }
}

/// Ends every line with `\n`, and fails where one exceeds [`MAX_LINE_BYTES`].
struct Lines<R> {
    inner: R,
    in_line: usize,
    after_return: bool,
}

impl<R: Read> Read for Lines<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            let n = self.inner.read(buffer)?;
            let mut kept = 0;
            for i in 0..n {
                let byte = buffer[i];
                if byte == b'\n' && std::mem::take(&mut self.after_return) {
                    continue;
                }
                self.after_return = byte == b'\r';
                let ends = byte == b'\n' || byte == b'\r';
                buffer[kept] = if ends { b'\n' } else { byte };
                kept += 1;
                self.in_line = if ends { 0 } else { self.in_line + 1 };
                if self.in_line > MAX_LINE_BYTES {
                    return Err(io::Error::new(io::ErrorKind::InvalidData, LONG_LINE));
                }
            }
            // Nothing kept of something read is not the end.
            if kept > 0 || n == 0 {
                return Ok(kept);
            }
        }
    }
}

/// One blank for any number of them, none at the ends of lines.
pub(super) struct Squeezed<R> {
    pub(super) inner: R,
    /// A blank was met and not yet passed on; true at the start of a line.
    pub(super) blank: bool,
    pub(super) line_start: bool,
    pub(super) held: Option<u8>,
}

impl<R: Read> Read for Squeezed<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        // Half of the room: every byte read may have a held blank before it.
        let mut raw = vec![0; (buffer.len() / 2).max(1)];
        loop {
            if let Some(byte) = self.held.take() {
                buffer[0] = byte;
                return Ok(1);
            }
            let n = self.inner.read(&mut raw)?;
            let mut out = Vec::with_capacity(2 * n);
            for &byte in &raw[..n] {
                match byte {
                    b' ' | b'\t' => self.blank = true,
                    b'\n' => {
                        (self.blank, self.line_start) = (false, true);
                        out.push(byte);
                    }
                    _ => {
                        if self.blank && !self.line_start {
                            out.push(b' ');
                        }
                        (self.blank, self.line_start) = (false, false);
                        out.push(byte);
                    }
                }
            }
            if out.len() > buffer.len() {
                self.held = out.pop();
            }
            buffer[..out.len()].copy_from_slice(&out);
            if !out.is_empty() || n == 0 {
                return Ok(out.len());
            }
        }
    }
}

/// What a comma within a number stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Commas {
    #[default]
    Decimals,
    /// Thousands: commas are between the cells too, and decimals follow points.
    Thousands,
    /// Commas are between the cells, and no number shows what its decimals follow.
    Unsure,
}

/// Where what is in the file.
#[derive(Debug, Default)]
pub(super) struct Layout {
    /// Between cells; a blank stands for any number of them.
    pub(super) separator: u8,
    pub(super) names: Vec<String>,
    /// What the row of units says, empty where there is none.
    pub(super) units: Vec<String>,
    /// Bytes of the head before the first sample.
    pub(super) skip: usize,
    /// Line of the first sample, from 1.
    pub(super) first_line: u64,
    /// Nothing names the columns.
    pub(super) headless: bool,
    /// Before each number stands its column's name.
    pub(super) labelled: bool,
    pub(super) commas: Commas,
    /// The sample time (s) in the lines above the samples.
    pub(super) sample_time: Option<f64>,
}

pub(super) struct Line {
    pub(super) text: String,
    pub(super) number: u64,
    pub(super) start: usize,
    end: usize,
}

/// Reads the beginning of the text: the bytes, and whether there is more.
pub(super) fn head(input: &mut impl Read) -> Result<Vec<u8>, Problem> {
    let mut head = Vec::new();
    match input.take(HEAD_BYTES as u64).read_to_end(&mut head) {
        Ok(_) => Ok(head),
        Err(error) => {
            let line = 1 + head.iter().filter(|&&b| b == b'\n').count() as u64;
            Err(io_problem(error, line))
        }
    }
}

/// What is wrong with the text, or with reading it.
pub(super) fn io_problem(error: io::Error, line: u64) -> Problem {
    if error.kind() == io::ErrorKind::InvalidData && error.to_string() == LONG_LINE {
        Problem::NotText {
            line,
            what: LONG_LINE.into(),
        }
    } else {
        Problem::Io(error)
    }
}

/// The lines of the head, as many as decide the layout.
pub(super) fn lines(head: &[u8]) -> Vec<Line> {
    let mut start = 0;
    let mut found = Vec::new();
    for (number, bytes) in (1..).zip(head.split_inclusive(|&b| b == b'\n').take(HEAD_LINES)) {
        let end = start + bytes.len();
        // What is not UTF-8 is taken for Latin-1, in which every byte is a character.
        let text = match std::str::from_utf8(bytes) {
            Ok(text) => text.to_owned(),
            Err(_) => bytes.iter().map(|&b| char::from(b)).collect(),
        };
        found.push(Line {
            text: text
                .trim_start_matches('\u{feff}')
                .trim_end_matches('\n')
                .to_owned(),
            number,
            start,
            end,
        });
        start = end;
    }
    found
}

/// The cells of a line of the head, without quotes.
pub(super) fn cells(line: &str, separator: u8) -> Vec<String> {
    if separator == b' ' {
        return line.split_whitespace().map(unquoted).collect();
    }
    let mut quoted = false;
    let split = |c: char| {
        quoted ^= c == '"';
        !quoted && c == char::from(separator)
    };
    line.split(split).map(unquoted).collect()
}

fn unquoted(cell: &str) -> String {
    cell.trim().trim_matches('"').trim().to_owned()
}

/// The number in a cell; `comma` allows a decimal comma, without which one comma may be of thousands.
pub(super) fn parse(cell: &str, comma: bool) -> Option<f64> {
    if let Ok(value) = cell.parse::<f64>() {
        return Some(value);
    }
    let grouped = thousands(cell, ',', '.', comma);
    if let Some(value) = grouped.or_else(|| thousands(cell, '.', ',', true).filter(|_| comma)) {
        return Some(value);
    }
    let (whole, part) = cell.split_once(',').filter(|_| comma)?;
    let digit = part.starts_with(|c: char| c.is_ascii_digit());
    let one = digit && !whole.contains('.') && !part.contains(['.', ',']);
    one.then(|| format!("{whole}.{part}").parse().ok())
        .flatten()
}

/// The number of `1,234.5` or `1.234,5`; where `doubtful`, a single mark without decimals is too little.
fn thousands(cell: &str, mark: char, point: char, doubtful: bool) -> Option<f64> {
    let (whole, part) = cell.split_once(point).unwrap_or((cell, ""));
    let digits = |text: &str| text.bytes().all(|b| b.is_ascii_digit());
    let mut groups = whole.trim_start_matches(['+', '-']).split(mark);
    let first = groups.next()?;
    let more: Vec<&str> = groups.collect();
    let is_first = (1..=3).contains(&first.len()) && digits(first) && !first.starts_with('0');
    let are_groups = more.iter().all(|g| g.len() == 3 && digits(g));
    let enough = more.len() > usize::from(doubtful && part.is_empty());
    let told = is_first && are_groups && enough && digits(part);
    told.then(|| format!("{}.{part}", whole.replace(mark, "")).parse().ok())
        .flatten()
}

pub(super) const SEPARATORS: [u8; 5] = [b',', b';', b'\t', b'|', b' '];

/// Cells and numbers of a line, where it looks like a row of samples.
fn row(text: &str, separator: u8) -> Option<(usize, usize)> {
    let mut cells = cells(text, separator);
    if cells.last().is_some_and(String::is_empty) {
        cells.pop();
    }
    let numbers = cells
        .iter()
        .filter(|c| parse(c, separator != b',').is_some())
        .count();
    (numbers >= 2 && 2 * numbers > cells.len()).then_some((cells.len(), numbers))
}

/// How like samples the lines are with that separator: the sum of the shares of numbers, and the usual number of cells.
fn likeness(lines: &[Line], separator: u8) -> (f64, usize) {
    let rows: Vec<(usize, usize)> = lines
        .iter()
        .filter_map(|l| row(&l.text, separator))
        .collect();
    let mut widths: Vec<usize> = rows.iter().map(|r| r.0).collect();
    widths.sort_unstable();
    let width = widths.get(widths.len() / 2).copied().unwrap_or(0);
    let share = |r: &&(usize, usize)| r.0 == width;
    let sum = rows
        .iter()
        .filter(share)
        .map(|r| r.1 as f64 / r.0 as f64)
        .sum();
    (sum, width)
}

/// Tells the layout from the head of the text.
///
/// # Errors
/// No text.
pub(super) fn of(head: &[u8]) -> Result<Layout, Problem> {
    let all = lines(head);
    let layout = place(&all)?;
    let (above, samples): (Vec<_>, Vec<_>) = all.iter().partition(|l| l.number < layout.first_line);
    let has_point = |cell: String| cell.contains('.') && cell.parse::<f64>().is_ok();
    let mut rows = samples.iter().map(|l| cells(&l.text, layout.separator));
    let commas = match layout.separator {
        b',' if rows.any(|row| row.into_iter().any(has_point)) => Commas::Thousands,
        b',' => Commas::Unsure,
        _ => Commas::Decimals,
    };
    Ok(Layout {
        commas,
        sample_time: above.iter().find_map(|l| stated::sample_time(&l.text)),
        ..layout
    })
}

/// Separator, names and units of the lines, and where the samples begin.
fn place(all: &[Line]) -> Result<Layout, Problem> {
    let is_remark = |l: &&Line| l.text.trim_start().starts_with(['#', '%']);
    let is_blank = |l: &&Line| l.text.trim().is_empty();
    let plain: Vec<&Line> = all
        .iter()
        .filter(|l| !is_remark(l) && !is_blank(l))
        .collect();
    let Some(&first) = plain.first() else {
        return Err(Problem::Empty);
    };
    if first.text.contains('\0') {
        return Err(Problem::NotText {
            line: first.number,
            what: "a zero byte, this is no text file".into(),
        });
    }
    let best = SEPARATORS
        .map(|separator| (separator, likeness(all, separator)))
        .into_iter()
        .rev()
        .max_by(|(_, a), (_, b)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let (separator, width) = match best {
        Some((separator, (sum, width))) if sum > 0.0 => (separator, width),
        _ => (by_header(&first.text), 0),
    };
    let layout = |names: Vec<String>, skip: usize, first_line: u64| Layout {
        separator,
        names,
        skip,
        first_line,
        ..Layout::default()
    };
    let of_first = || {
        let names = cells(&first.text, separator);
        layout(names, first.end, first.number + 1)
    };
    let sample = plain
        .iter()
        .position(|l| width > 0 && row(&l.text, separator).is_some_and(|r| r.0 == width));
    let Some(sample) = sample else {
        return Ok(of_first());
    };
    let named = |l: &&Line| Some((l.number, names(&l.text, separator, width)?));
    let above = || plain[..sample].iter().rev().take(LINES_BETWEEN);
    let data = plain[sample];
    if let Some((number, header)) = above().find_map(named) {
        let upper = above().skip_while(|l| l.number >= number).find_map(named);
        return Ok(match upper {
            Some((_, names)) if are_units(&header) => Layout {
                units: header,
                ..layout(names, data.start, data.number)
            },
            _ => layout(header, data.start, data.number),
        });
    }
    // Some tools write the header as a remark, of several the one with most names that say what they are; others between blanks.
    let is_said = |name: &&String| quantity(name).slot.is_some();
    let said = |names: &Vec<String>| names.iter().filter(is_said).count();
    let text = |l: &Line| {
        l.text
            .trim_start()
            .trim_start_matches(['#', '%'])
            .to_owned()
    };
    let remarks = all.iter().filter(is_remark);
    let remarks: Vec<String> = remarks
        .filter(|l| l.number < data.number)
        .map(text)
        .collect();
    let remark = remarks.iter().filter_map(|l| names(l, separator, width));
    let between_blanks = || {
        let lines = remarks.iter().chain(above().rev().map(|l| &l.text));
        let lines = lines.filter(|l| !l.contains(char::from(separator)));
        let names = lines.map(|l| cells(l, b' '));
        let names = names.filter(|n| n.len() == width && said(n) > 0);
        names.max_by_key(said)
    };
    match remark.max_by_key(said).or_else(between_blanks) {
        Some(header) => Ok(layout(header, data.start, data.number)),
        // A row of samples whose cells are one too few or too many belongs to the header above it.
        None if sample > 0 && are_words(&cells(&first.text, separator)) => Ok(of_first()),
        None => Ok(Layout {
            headless: true,
            ..layout(Vec::new(), data.start, data.number)
        }),
    }
}

fn are_words(cells: &[String]) -> bool {
    cells.iter().all(|c| parse(c, true).is_none())
}

fn are_units(cells: &[String]) -> bool {
    cells.iter().all(|c| c.is_empty() || units::is_unit(c))
}

/// The names of `width` columns, where the line may hold them: between the separator of the samples, or another one that is no blank.
fn names(text: &str, separator: u8, width: usize) -> Option<Vec<String>> {
    let other = SEPARATORS[..4].iter().find_map(|&other| {
        let found = cells(text, other);
        let mixed = separator != b' ' && text.contains(char::from(separator));
        let full = found.len() == width && found.iter().all(|c| !c.is_empty());
        (full && width > 1 && !mixed && are_words(&found)).then_some(found)
    });
    if other.is_some() {
        return other;
    }
    let found = cells(text, separator);
    let named = found.iter().filter(|c| !c.is_empty()).count();
    // Columns without a unit leave their cells of the row of units blank.
    let wide = if are_units(&found) {
        found.len()
    } else {
        named
    };
    (wide.abs_diff(width) <= 1 && named >= 2 && are_words(&found)).then_some(found)
}

/// The separator of a header without samples to tell it from.
fn by_header(text: &str) -> u8 {
    let count = |s: &u8| text.bytes().filter(|b| b == s).count();
    let most = SEPARATORS[..4].iter().copied().rev().max_by_key(count);
    most.filter(|s| count(s) > 0).unwrap_or(b',')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &[u8]) -> Layout {
        let mut input = super::text(text);
        let head = head(&mut input).expect("text");
        of(&head).unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(text)))
    }

    #[test]
    fn layouts_of_drives_and_tools_are_told() {
        for (text, separator, names, units, line) in [
            (&b"t_s,x_m\n0,1\n1,2\n"[..], b',', "t_s x_m", "", 2),
            (
                b"t_s;x_m;F\n0,5;1,5;2\n1,5;2,5;2\n",
                b';',
                "t_s x_m F",
                "",
                2,
            ),
            (b"t_s;x_m\n0,5;1,5\n1,5;2,5\n", b';', "t_s x_m", "", 2),
            (b"t\tx\n0,5\t1\n", b'\t', "t x", "", 2),
            (
                b"# remark\n\n  t   x  f\n 0   1  2\n 1   2  3\n",
                b' ',
                "t x f",
                "",
                4,
            ),
            (
                b"Scope;1.2\nRate;1000\n\nTime;Pos;Torque\nms;mm;%\n0;1;2\n1;2;3\n2;3;4\n",
                b';',
                "Time Pos Torque",
                "ms mm %",
                6,
            ),
            (
                b"time,position,force,repeat,note\ns,mm,N,,\n0,1,2,1,a\n1,2,3,1,b\n",
                b',',
                "time position force repeat note",
                "s mm N  ",
                3,
            ),
            (b"t_s,x_m\r0,1\r1,2\r", b',', "t_s x_m", "", 2),
            (b"t_s,x_m\r\n0,1\r\n1,2\r\n", b',', "t_s x_m", "", 2),
            (
                b"\xff\xfet\0,\0x\0\n\x000\0,\x001\0\n\0",
                b',',
                "t x",
                "",
                2,
            ),
            (
                b"\"V1\",\"V2\",\n0.1,0.2,\n0.3,0.4,\n",
                b',',
                "V1 V2 ",
                "",
                2,
            ),
            (b"# t x f\n0 1 2\n1 2 3\n", b' ', "t x f", "", 2),
            (
                b"t_s,Temperatur_\xb0C\n0,1\n",
                b',',
                "t_s Temperatur_\u{b0}C",
                "",
                2,
            ),
        ] {
            let found = read(text);
            let told = (
                found.separator,
                found.names.join(" "),
                found.units.join(" "),
                found.first_line,
            );
            assert_eq!(
                told,
                (separator, names.to_owned(), units.to_owned(), line),
                "{}",
                String::from_utf8_lossy(text)
            );
        }
    }

    #[test]
    fn blanks_are_squeezed_wherever_a_read_ends() {
        let text = b"  t   x \n 1\t 2 \n3 4";
        for room in 1..20 {
            let mut squeezed = Squeezed {
                inner: &text[..],
                blank: false,
                line_start: true,
                held: None,
            };
            let (mut all, mut buffer) = (Vec::new(), vec![0; room]);
            loop {
                match squeezed.read(&mut buffer).expect("memory") {
                    0 => break,
                    n => all.extend_from_slice(&buffer[..n]),
                }
            }
            assert_eq!(all, b"t x\n1 2\n3 4", "{room}");
        }
    }
}
