//! How a text file is laid out: encoding, line ends, separator, where the header, its units and the samples are.

use std::io::{BufRead, BufReader, Read};

use super::error::Problem;
use super::words::{holds_word, quantity, split};
use super::{stated, units};

/// No sensible row is longer; a file without line ends would otherwise be held as one row.
const MAX_LINE_BYTES: usize = 64 * 1024;

/// Bytes that decide the layout: more than the longest line.
const HEAD_BYTES: usize = 2 * MAX_LINE_BYTES;

/// Lines that decide the layout.
const HEAD_LINES: usize = 400;

/// Lines between the last sample line's header and the samples.
const LINES_BETWEEN: usize = 6;

pub(super) struct Line {
    /// Without its end.
    pub(super) text: String,
    /// From 1.
    pub(super) number: u64,
}

/// The lines of a text, which end with `\n`, `\r\n` or `\r`.
pub(super) struct Lines<R> {
    input: R,
    number: u64,
    after_return: bool,
}

/// Reads UTF-8, UTF-16 with its mark, and of any other kind each byte as a character of Latin-1.
pub(super) fn lines(input: impl Read) -> Lines<impl BufRead> {
    let decoded = encoding_rs_io::DecodeReaderBytesBuilder::new()
        .bom_sniffing(true)
        .strip_bom(true)
        .utf8_passthru(true)
        .build(input);
    Lines {
        input: BufReader::new(decoded),
        number: 0,
        after_return: false,
    }
}

/// The mark of UTF-16 that a text begins with or lacks: every other of its first bytes is zero.
pub(super) fn missing_mark(start: &[u8]) -> &'static [u8] {
    let pairs = start.as_chunks::<2>().0;
    let all = |is: fn(&[u8; 2]) -> bool| pairs.len() > 1 && pairs.iter().all(is);
    match () {
        () if all(|[low, high]| *low != 0 && *high == 0) => b"\xff\xfe",
        () if all(|[high, low]| *high == 0 && *low != 0) => b"\xfe\xff",
        () => b"",
    }
}

/// Share of the characters that are control characters from which on it is no text: of random bytes they are a tenth, and a serial line's first row
/// may have some.
const CONTROLS: f64 = 0.03;
/// Fewer of them are a fault at a place, which has a message of its own.
const FEW_CONTROLS: usize = 8;

/// That the head holds characters that are written.
pub(super) fn is_text(head: &[Line]) -> Result<(), Problem> {
    let characters = || head.iter().flat_map(|l| l.text.chars());
    let is_control = |c: &char| c.is_ascii_control() && !matches!(c, '\t' | '\x0c' | '\x1a');
    let controls = characters().filter(is_control).count();
    let share = controls as f64 / characters().count().max(1) as f64;
    match controls > FEW_CONTROLS && share > CONTROLS {
        true => Err(Problem::Other(
            "is a binary file of an unknown kind; export its columns as CSV in UTF-8".into(),
        )),
        false => Ok(()),
    }
}

impl<R: BufRead> Lines<R> {
    /// The lines that decide the layout.
    pub(super) fn head(&mut self) -> Result<Vec<Line>, Problem> {
        let (mut head, mut bytes) = (Vec::new(), 0);
        while head.len() < HEAD_LINES && bytes < HEAD_BYTES {
            let Some(line) = self.line()? else { break };
            bytes += line.text.len();
            head.push(line);
        }
        Ok(head)
    }

    /// The next line; `None` after the last.
    fn line(&mut self) -> Result<Option<Line>, Problem> {
        self.number += 1;
        let mut bytes = Vec::new();
        loop {
            let buffer = self.input.fill_buf()?;
            let Some(&first) = buffer.first() else {
                if bytes.is_empty() {
                    return Ok(None);
                }
                break;
            };
            if std::mem::take(&mut self.after_return) && first == b'\n' {
                self.input.consume(1);
                continue;
            }
            let end = buffer.iter().position(|b| matches!(b, b'\n' | b'\r'));
            let length = end.unwrap_or(buffer.len());
            bytes.extend_from_slice(&buffer[..length]);
            self.after_return = buffer.get(length) == Some(&b'\r');
            self.input.consume(length + usize::from(end.is_some()));
            if bytes.len() > MAX_LINE_BYTES {
                let what = "a line is longer than 64 KiB, which is no row of samples";
                return Err(Problem::not_text(self.number, what));
            }
            if end.is_some() {
                break;
            }
        }
        let latin =
            |e: std::string::FromUtf8Error| e.as_bytes().iter().map(|&b| char::from(b)).collect();
        Ok(Some(Line {
            text: String::from_utf8(bytes).unwrap_or_else(latin),
            number: self.number,
        }))
    }
}

impl<R: BufRead> Iterator for Lines<R> {
    type Item = Result<Line, Problem>;

    fn next(&mut self) -> Option<Self::Item> {
        self.line().transpose()
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

/// The cells of a line, without quotes; with `whole`, what stands in quotes is one cell, whatever it holds.
pub(super) fn cells(line: &str, separator: u8, whole: bool) -> Vec<&str> {
    let blanks = separator == b' ';
    let between = |c: char| c == char::from(separator) || blanks && c == '\t';
    let (mut cells, mut from) = (Vec::new(), 0);
    for (at, end) in line.match_indices(between).chain([(line.len(), "")]) {
        let cell = line[from..at].trim_ascii();
        let is_open = cell.starts_with('"') && (cell.len() < 2 || !cell.ends_with('"'));
        // A blank stands for any number of them.
        if blanks && cell.is_empty() || whole && is_open && at < line.len() {
            continue;
        }
        let inside = cell.strip_prefix('"').and_then(|c| c.strip_suffix('"'));
        cells.push(inside.unwrap_or(cell).trim_ascii());
        from = at + end.len();
    }
    cells
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
    let mut cells = cells(text, separator, true);
    cells.pop_if(|last| last.is_empty());
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
pub(super) fn of(head: &[Line]) -> Result<Layout, Problem> {
    let mut layout = place(head)?;
    let (above, samples) = head.split_at(head.partition_point(|l| l.number < layout.first_line));
    let has_point = |cell: &str| cell.contains('.') && cell.parse::<f64>().is_ok();
    let separator = layout.separator;
    let rows = samples.iter().map(|l| cells(&l.text, separator, true));
    // A separator at the end of the header is no column where nothing stands below it.
    let columns = layout.names.len();
    let is_below = |row: Vec<&str>| row.len() >= columns && !row[columns - 1].is_empty();
    if layout.names.last().is_some_and(String::is_empty) && !rows.clone().any(is_below) {
        layout.names.pop();
    }
    let commas = match separator {
        b',' if rows.flatten().any(has_point) => Commas::Thousands,
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
        return Err(Problem::empty());
    };
    if first.text.contains('\0') {
        let what = "a zero byte, this is no text file";
        return Err(Problem::not_text(first.number, what));
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
    let layout = |names: Vec<String>, first_line: u64| Layout {
        separator,
        names,
        first_line,
        ..Layout::default()
    };
    let of_first = || {
        let names = owned(&cells(&first.text, separator, true));
        layout(names, first.number + 1)
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
            Some((_, names)) if are_units(&header) || are_above(&names, &header) => Layout {
                units: header.clone(),
                ..layout(with_unknown(names, &header), data.number)
            },
            _ => layout(header, data.number),
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
        let names = lines.map(|l| owned(&cells(l, b' ', true)));
        let names = names.filter(|n| n.len() == width && said(n) > 0);
        names.max_by_key(said)
    };
    match remark.max_by_key(said).or_else(between_blanks) {
        Some(header) => Ok(layout(header, data.number)),
        // A row of samples whose cells are one too few or too many belongs to the header above it.
        None if sample > 0 && are_words(&cells(&first.text, separator, true)) => Ok(of_first()),
        None => Ok(Layout {
            headless: true,
            ..layout(Vec::new(), data.number)
        }),
    }
}

/// Names as they are shown and given back: what would command a terminal is no part of one.
fn owned(cells: &[&str]) -> Vec<String> {
    let name = |c: &&str| c.trim().replace(char::is_control, "\u{fffd}");
    cells.iter().map(name).collect()
}

fn are_words(cells: &[&str]) -> bool {
    cells.iter().all(|c| parse(c, true).is_none())
}

fn are_units(cells: &[impl AsRef<str>]) -> bool {
    let mut cells = cells.iter().map(AsRef::as_ref);
    cells.all(|c| c.is_empty() || units::is_unit(c))
}

/// A row of which some cells are units, and the others short words of no quantity: a drive's own units.
fn may_be_units(cells: &[impl AsRef<str>]) -> bool {
    const LONGEST: usize = 10;
    let mut cells = cells.iter().map(AsRef::as_ref).filter(|c| !c.is_empty());
    let own = |c: &str| {
        let said = quantity(c);
        c.chars().count() <= LONGEST && (said.slot.is_none() || said.is_count)
    };
    cells.clone().any(units::is_unit) && cells.all(|c| units::is_unit(c) || own(c))
}

/// Whether a row names columns, of which one is a quantity's, and the row below has their units.
fn are_above(names: &[String], below: &[String]) -> bool {
    use super::known::Slot::{Effort, Position, Time, Velocity};
    let slots = [Time, Position, Velocity, Effort];
    let says = |name: &String| slots.iter().any(|slot| holds_word(name, *slot));
    may_be_units(below) && !may_be_units(names) && names.iter().any(says)
}

/// Names with those of the units below them that no number turns into SI: the question is about both.
fn with_unknown(names: Vec<String>, units: &[String]) -> Vec<String> {
    let units = units
        .iter()
        .map(String::as_str)
        .chain(std::iter::repeat(""));
    let both = names.into_iter().zip(units).map(|(name, unit)| {
        let bare = unit.trim_matches(|c| "[]()".contains(c));
        let is_none = ["", "-", "1"].contains(&bare);
        match is_none || units::unit(unit).is_some() || split(&name).1.is_some() {
            true => name,
            false => format!("{name} [{bare}]"),
        }
    });
    both.collect()
}

/// The names of `width` columns, where the line may hold them: between the separator of the samples, or another one that is no blank.
fn names(text: &str, separator: u8, width: usize) -> Option<Vec<String>> {
    let other = SEPARATORS[..4].iter().find_map(|&other| {
        let found = cells(text, other, true);
        let mixed = separator != b' ' && text.contains(char::from(separator));
        let full = found.len() == width && found.iter().all(|c| !c.is_empty());
        (full && width > 1 && !mixed && are_words(&found)).then(|| owned(&found))
    });
    if other.is_some() {
        return other;
    }
    let found = cells(text, separator, true);
    let named = found.iter().filter(|c| !c.is_empty()).count();
    // Columns without a unit leave their cells of the row of units blank.
    let wide = if are_units(&found) || may_be_units(&found) {
        found.len()
    } else {
        named
    };
    (wide.abs_diff(width) <= 1 && named >= 2 && are_words(&found)).then(|| owned(&found))
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
        let head = lines(text).head().expect("text");
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
                "Time Pos Torque [%]",
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
                "V1 V2",
                "",
                2,
            ),
            (b"V1,V2,\n0.1,0.2\n0.3,0.4\n", b',', "V1 V2", "", 2),
            (b"V1,V2,\n0.1,0.2,7\n0.3,0.4,8\n", b',', "V1 V2 ", "", 2),
            (
                b"Time;Position;Speed;Torque\ns;LU;LU/min;%\n0;1;2;3\n1;2;3;4\n",
                b';',
                "Time Position [LU] Speed [LU/min] Torque [%]",
                "s LU LU/min %",
                3,
            ),
            (
                b"Time;Pos;Iq\nticks;mm;A\n0;1;2\n",
                b';',
                "Time [ticks] Pos Iq",
                "ticks mm A",
                3,
            ),
            (
                b"My recorder;of today\nms;x\n0;1\n1;2\n",
                b';',
                "ms x",
                "",
                3,
            ),
            (b"t_s,x\x1b[2J\n0,1\n1,2\n", b',', "t_s x\u{fffd}[2J", "", 2),
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
    fn lines_end_as_they_like_wherever_a_read_ends() {
        for room in 1..20 {
            let lines = Lines {
                input: BufReader::with_capacity(room, &b"a\nbc\r\n\rd e\r\r\n\nf"[..]),
                number: 0,
                after_return: false,
            };
            let lines = lines.map(|l| l.map(|l| (l.number, l.text)));
            let lines: Vec<_> = lines.collect::<Result<_, _>>().expect("memory");
            let right = ["a", "bc", "", "d e", "", "", "f"].map(str::to_owned);
            assert!(lines.into_iter().eq((1..).zip(right)), "{room}");
        }
    }

    #[test]
    fn cells_are_split_at_blanks_and_around_quotes() {
        for (line, separator, whole, right) in [
            ("  t   x \t y ", b' ', false, &["t", "x", "y"][..]),
            (" 1 \"a  b\"", b' ', true, &["1", "a  b"]),
            ("1,\"a, b\",\"c", b',', true, &["1", "a, b", "\"c"]),
            ("1,\"a, b\", ", b',', false, &["1", "\"a", "b\"", ""]),
        ] {
            assert_eq!(cells(line, separator, whole), right, "{line}");
        }
    }
}
