//! CSV as TwinCAT Scope exports it: rows of what is known of the channels, and groups of channels, each with a column of times of its own,
//! which need not be the others' and may end earlier.

use std::io::Read;

use super::LoadOptions;
use super::Warning;
use super::error::Problem;
use super::layout::{self, Line};
use super::table::Table;
use super::units;
use super::variables::{self, Variable};

/// The row that marks such a file …
const MARK: &str = "Starttime of export";
/// … or, where only the channels were kept, this one below their names.
const SAMPLE_TIME: &str = "SampleTime[ms]";

/// What stands above each column of times.
const TIME: &str = "Name";

/// A time beyond this is no number of milliseconds but one of 100 ns since 1601, which the export writes if asked to.
const FILETIME: f64 = 1e15;

/// Milliseconds of its unit.
const FILETIME_MS: f64 = 1e-4;

/// Whether the text begins like an export.
pub(super) fn is_export(head: &[u8]) -> bool {
    let mut start = head.split(|&b| b == b'\n').take(12);
    // Between blanks it stands in quotes.
    let begins = |line: &[u8], mark: &str| {
        let line = line.strip_prefix(b"\"").unwrap_or(line);
        line.starts_with(mark.as_bytes())
    };
    let channels = begins(head, TIME);
    start.any(|line| begins(line, MARK) || channels && begins(line, SAMPLE_TIME))
}

/// Channels that share a column of times.
#[derive(Default)]
struct Group {
    /// Place of the column of times; the channels follow it.
    column: usize,
    names: Vec<String>,
    t_ms: Vec<f64>,
    values: Vec<Vec<f64>>,
}

/// Reads an export that begins with `head` and goes on with `rest`.
pub(super) fn read(head: &[u8], rest: impl Read, options: &LoadOptions) -> Result<Table, Problem> {
    let lines = layout::lines(head);
    let separator = lines
        .first()
        .and_then(|l| l.text.strip_prefix(TIME)?.bytes().next());
    let separator = separator.filter(|s| *s != b' ').ok_or_else(|| Problem::NotText {
        line: 1,
        what: "an export of TwinCAT Scope whose separator, a blank, is part of its names too; export it with tabs or semicolons".into(),
    })?;
    let (mut groups, first) = groups(&lines, separator)?;
    let input = head.get(first.start..).unwrap_or_default().chain(rest);
    samples(&mut groups, input, separator, first.number, options)?;
    let (found, words) = merged(groups)?;
    let mut table = variables::table(&found, options)?;
    table
        .plan
        .warnings
        .insert(0, Warning::new("twincat-scope", words));
    Ok(table)
}

/// The groups that the header names, and the first line of samples.
fn groups(lines: &[Line], separator: u8) -> Result<(Vec<Group>, &Line), Problem> {
    // Of two rows that begin with `Name` the first is the chart's.
    let row = |key: &str| {
        let mut cells = lines.iter().map(|l| layout::cells(&l.text, separator));
        cells.rfind(|c| c.first().is_some_and(|c| c == key))
    };
    let sample = |l: &&Line| {
        let first = layout::cells(&l.text, separator).swap_remove(0);
        layout::parse(&first, true).is_some()
    };
    let too_short = Problem::TooShort {
        samples: 0,
        needed: 2,
    };
    let (Some(names), Some(first)) = (row(TIME), lines.iter().find(sample)) else {
        return Err(too_short);
    };
    let units = row("Unit").unwrap_or_default();
    let mut groups: Vec<Group> = Vec::new();
    for (column, name) in names.iter().enumerate() {
        match groups.last_mut() {
            _ if name == TIME => groups.push(Group {
                column,
                ..Group::default()
            }),
            Some(group) if !name.is_empty() => {
                // "V (Voltage)", or "(None)".
                let unit = units.get(column).and_then(|u| u.split_whitespace().next());
                let unit = unit.filter(|u| units::is_unit(u));
                group
                    .names
                    .push(unit.map_or(name.clone(), |u| format!("{name} [{u}]")));
                group.values.push(Vec::new());
            }
            _ => {}
        }
    }
    Ok((groups, first))
}

/// Reads the samples from line `first` on into the groups; a group whose cells are blank has none there.
fn samples(
    groups: &mut [Group],
    mut input: impl Read,
    separator: u8,
    first: u64,
    options: &LoadOptions,
) -> Result<(), Problem> {
    let mut reader = ::csv::ReaderBuilder::new();
    reader.has_headers(false).flexible(true).quoting(false);
    let mut reader = reader.delimiter(separator).from_reader(&mut input);
    let mut record = ::csv::ByteRecord::new();
    let commas = match separator {
        b',' => layout::Commas::Unsure,
        _ => layout::Commas::Decimals,
    };
    let columns = groups.last().map_or(0, |g| g.column + 1 + g.names.len());
    loop {
        let line = first - 1 + reader.position().line();
        let more = reader.read_byte_record(&mut record);
        if !more.map_err(|e| super::csv::csv_problem(e, line))? {
            return Ok(());
        }
        if record.get(0) == Some(b"EOF") {
            return Ok(());
        }
        if record
            .iter()
            .skip(columns)
            .any(|c| !c.trim_ascii().is_empty())
        {
            return Err(Problem::Ragged {
                line,
                cells: record.len(),
                columns,
                hint: "if the numbers have decimal commas, export with tabs or semicolons between them",
            });
        }
        let cell = |column: usize| record.get(column).unwrap_or_default().trim_ascii();
        for group in groups.iter_mut().filter(|g| !cell(g.column).is_empty()) {
            let number = |column: usize, name: &str| {
                super::csv::number(cell(column), commas).map_err(|what| Problem::Cell {
                    at: format!("line {line}"),
                    column: name.to_owned(),
                    what,
                })
            };
            let t = number(group.column, "its column of times")?;
            // A slow channel may be written once more for every sample of a fast one.
            if group.t_ms.last() == Some(&t) {
                continue;
            }
            if group.t_ms.len() >= options.max_samples {
                return Err(Problem::TooManySamples {
                    at: format!("line {line}"),
                    limit: options.max_samples,
                });
            }
            for (j, values) in group.values.iter_mut().enumerate() {
                values.push(number(group.column + 1 + j, &group.names[j])?);
            }
            group.t_ms.push(t);
        }
    }
}

/// All channels at the times that most of them share, and what is to be said of it.
fn merged(groups: Vec<Group>) -> Result<(Vec<Variable>, String), Problem> {
    let channels = |t: &[f64]| -> usize {
        let same = groups.iter().filter(|g| g.t_ms == t);
        same.map(|g| g.names.len()).sum()
    };
    let most = groups
        .iter()
        .max_by_key(|g| (channels(&g.t_ms), g.t_ms.len()));
    let times = most.map_or_else(Vec::new, |g| g.t_ms.clone());
    if times.len() < 2 {
        return Err(Problem::TooShort {
            samples: times.len(),
            needed: 2,
        });
    }
    let (mut between, mut left) = (Vec::new(), Vec::new());
    let mut found = vec![Variable::column("Time [ms]", milliseconds(&times))];
    for group in groups {
        let own = group.t_ms == times;
        for (name, values) in group.names.into_iter().zip(group.values) {
            let mut channel = Variable::column(&name, Vec::new());
            channel.dimensions = vec![times.len()];
            channel.values = match own {
                true => Ok(values),
                false => at(&times, &group.t_ms, &values),
            };
            match &channel.values {
                Err(why) => left.push(format!("{name} ({why})")),
                Ok(_) if !own => between.push(name),
                Ok(_) => {}
            }
            found.push(channel);
        }
    }
    let mut words = format!(
        "an export of TwinCAT Scope: {} channels at the times that most of them share",
        found.len() - 1
    );
    if !between.is_empty() {
        words += &format!(", between their own samples {}", between.join(", "));
    }
    if !left.is_empty() {
        words += &format!("; without values there: {}", left.join(", "));
    }
    Ok((found, words))
}

/// Times in ms, from the first one where they are of the calendar.
fn milliseconds(t: &[f64]) -> Vec<f64> {
    match t.first() {
        Some(&first) if first > FILETIME => t.iter().map(|t| (t - first) * FILETIME_MS).collect(),
        _ => t.to_vec(),
    }
}

/// The values at other times, between the samples; its last one stands for a step.
fn at(times: &[f64], own: &[f64], values: &[f64]) -> Result<Vec<f64>, &'static str> {
    let [.., before, last] = own else {
        return Err("a channel of less than two samples");
    };
    let first = own[0];
    if times[0] < first || times[times.len() - 1] > 2.0 * last - before {
        return Err("a channel whose times do not cover those of the others");
    }
    let value = |&t: &f64| {
        let i = own.partition_point(|&o| o <= t).clamp(1, own.len() - 1);
        let u = ((t - own[i - 1]) / (own[i] - own[i - 1])).min(1.0);
        values[i - 1] + u * (values[i] - values[i - 1])
    };
    Ok(times.iter().map(value).collect())
}

#[cfg(test)]
mod tests {
    use super::super::{LoadOptions, Recording, RecordingError, load_csv, parse_map};

    fn load(text: &str, map: &[&str]) -> Result<Recording, RecordingError> {
        let map = map.iter().map(|m| parse_map(m).expect("a map")).collect();
        let options = LoadOptions {
            map,
            ..LoadOptions::default()
        };
        load_csv(text.as_bytes(), "scope.csv", &options)
    }

    const MAP: [&str; 2] = ["x_m=1e-6*fActPos", "force_N=fTorque[A]*2"];

    /// Position and current at 1 ms, a temperature at 4 ms that ends earlier; `time` writes a time of so many ms, `group` stands between channels of one rate.
    fn export(separator: &str, group: &str, time: impl Fn(usize) -> String) -> String {
        let join = |cells: &[&str]| cells.join(separator) + "\n";
        let mut text = join(&["Name", "Achse", ""]);
        text += &join(&["File", r"C:\Achse.csv", ""]);
        text += &join(&[
            "Starttime of export",
            "133500000000000000",
            "Montag, 15. Januar 2024",
            "10:00:00.000",
        ]);
        text += "\n\n";
        let rows = [
            ("Name", ["fActPos", "fTorque", "fTemp"]),
            ("SampleTime[ms]", ["1", "1", "4"]),
            ("Unit", ["(None)", "A (Current)", "(None)"]),
            ("Unit ScaleFactor", ["1", "1", "1"]),
        ];
        for (key, [a, b, c]) in rows {
            let between = if group.is_empty() { "" } else { key };
            let cells = [key, a, between, b, key, c];
            text += &join(
                &cells
                    .into_iter()
                    .filter(|c| !c.is_empty())
                    .collect::<Vec<_>>(),
            );
        }
        text += "\n";
        for i in 0..1000 {
            let t = time(i);
            let phase = i as f64 * 0.02;
            let x = format!("{:.3}", 1e4 * phase.sin()).replace('.', ",");
            let f = format!("{:.3}", 3.0 * phase.cos()).replace('.', ",");
            let slow = (time(4 * i), format!("{}", 20 + 4 * i));
            let slow = if i < 250 {
                [slow.0.as_str(), &slow.1]
            } else {
                [" ", " "]
            };
            let cells = match group {
                "" => vec![&t, &x, &f, slow[0], slow[1]],
                _ => vec![&t, &x, &t, &f, slow[0], slow[1]],
            };
            text += &join(&cells);
        }
        text + "EOF\n"
    }

    #[test]
    fn channels_with_times_of_their_own_become_one_table() {
        let milliseconds = |i: usize| i.to_string();
        let calendar = |i: usize| (133_500_000_000_000_000 + 10_000 * i as u64).to_string();
        for text in [
            export("\t", "each", milliseconds),
            export(";", "", milliseconds),
            export("\t", "each", calendar).replace("\nEOF", ""),
        ] {
            let found = load(&text, &MAP).unwrap_or_else(|e| panic!("{e}\n{}", &text[..600]));
            assert_eq!(found.len(), 1000);
            let worst = |of: &dyn Fn(usize) -> f64| (0..1000).map(of).fold(0.0, f64::max);
            let phase = |i: usize| i as f64 * 0.02;
            let off = [
                worst(&|i| (found.t_s[i] - found.t_s[0] - i as f64 * 1e-3).abs()),
                worst(&|i| (found.position[i] - 1e-2 * phase(i).sin()).abs()),
                worst(&|i| (found.effort[i] - 6.0 * phase(i).cos()).abs()),
                // Held after its last sample, three times 1 ms.
                worst(&|i| (found.extra[0].values[i] - (20.0 + (i as f64).min(996.0))).abs()),
            ];
            // Calendar times are whole multiples of 16 units in f64; the rest is the rounding of the text.
            let most = [2e-6, 6e-10, 1.1e-3, 1e-9];
            assert!(
                off.iter().zip(most).all(|(off, most)| *off <= most),
                "{off:?}"
            );
            let said = found.warnings.iter().find(|w| w.code == "twincat-scope");
            let said = said.map_or("", |w| w.message.as_str());
            assert!(
                said.contains("3 channels") && said.contains("samples fTemp"),
                "{said}"
            );
        }
    }

    #[test]
    fn what_an_export_lacks_is_said() {
        let milliseconds = |i: usize| i.to_string();
        let error = |text: &str, map: &[&str]| load(text, map).expect_err("refused").to_string();
        let text = export("\t", "each", milliseconds);
        let names = error(&text, &[]);
        assert!(
            names.contains("fActPos 1000") && names.contains("fTorque [A]"),
            "{names}"
        );
        let cell = error(&text.replace("\t0,000\t", "\tx\t"), &MAP);
        assert!(
            cell.contains("line 11") && cell.contains("fActPos"),
            "{cell}"
        );
        let commas = error(&export(",", "each", milliseconds), &MAP);
        assert!(commas.contains("tabs or semicolons"), "{commas}");
        let blank = export(" ", "each", milliseconds)
            .replace("Starttime of export", "\"Starttime of export\"");
        let blank = error(&blank, &MAP);
        assert!(blank.contains("tabs or semicolons"), "{blank}");
        let short = text.lines().take(8).collect::<Vec<_>>().join("\n");
        assert!(error(&short, &MAP).contains("0 samples"));
        // A temperature that ends early is no answer to a question about all of the time.
        let partly = text.replace("\t400\t420\n", "\t \t \n");
        let cut: String = partly
            .lines()
            .map(|l| match l.split('\t').nth(4) {
                Some(t) if t.trim().parse::<u32>().is_ok_and(|t| t > 400) => {
                    l.rsplitn(3, '\t').last().unwrap_or(l).to_owned() + "\n"
                }
                _ => l.to_owned() + "\n",
            })
            .collect();
        let found = load(&cut, &MAP).unwrap_or_else(|e| panic!("{e}"));
        let said = &found.warnings[0].message;
        assert!(
            found.extra.is_empty() && said.contains("fTemp (a channel whose times"),
            "{said}"
        );
    }
}
