//! CSV as TwinCAT Scope exports it: rows of what is known of the channels, and groups of channels, each with a column of times of its own,
//! which need not be the others' and may end earlier.

use super::error::Problem;
use super::layout::{self, Line};
use super::table::Table;
use super::variables::{self, Variable};
use super::{LoadOptions, Warning, rows};
use crate::statistics;

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
pub(super) fn is_export(head: &[Line]) -> bool {
    // Between blanks it stands in quotes.
    let begins = |line: &Line, mark: &str| line.text.trim_start_matches('"').starts_with(mark);
    let channels = head.first().is_some_and(|l| begins(l, TIME));
    let mut start = head.iter().take(12);
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
pub(super) fn read(
    head: Vec<Line>,
    rest: impl Iterator<Item = Result<Line, Problem>>,
    options: &LoadOptions,
) -> Result<Table, Problem> {
    let separator = head
        .first()
        .and_then(|l| l.text.strip_prefix(TIME)?.bytes().next());
    let separator = separator.filter(|s| *s != b' ').ok_or_else(|| {
        Problem::not_text(1, "an export of TwinCAT Scope whose separator, a blank, is part of its names too; export it with tabs or semicolons")
    })?;
    let (mut groups, first) = groups(&head, separator)?;
    let samples = head.into_iter().skip(first).map(Ok).chain(rest);
    read_samples(&mut groups, samples, separator, options)?;
    let (found, words) = merged(groups)?;
    let mut table = variables::table(&found, options)?;
    table
        .plan
        .warnings
        .insert(0, Warning::new("twincat-scope", words));
    Ok(table)
}

/// The groups that the header names, and the place of the first line of samples.
fn groups(lines: &[Line], separator: u8) -> Result<(Vec<Group>, usize), Problem> {
    let lines = lines.iter();
    let rows: Vec<Vec<&str>> = lines
        .map(|l| layout::cells(&l.text, separator, true))
        .collect();
    // Of two rows that begin with `Name` the first is the chart's.
    let row = |key: &str| rows.iter().rfind(|row| row[0] == key);
    let sample = |row: &Vec<&str>| layout::parse(row[0], true).is_some();
    let (Some(names), Some(first)) = (row(TIME), rows.iter().position(sample)) else {
        return Err(Problem::too_short(0));
    };
    let units = row("Unit");
    let mut groups: Vec<Group> = Vec::new();
    for (column, name) in names.iter().enumerate() {
        match groups.last_mut() {
            _ if *name == TIME => groups.push(Group {
                column,
                ..Group::default()
            }),
            Some(group) if !name.is_empty() => {
                // "V (Voltage)", or "(None)".
                let unit = units.and_then(|row| row.get(column)?.split_whitespace().next());
                let unit = unit.filter(|u| *u != "(None)" && !u.is_empty());
                let name = unit.map_or((*name).to_owned(), |u| format!("{name} [{u}]"));
                group.names.push(name);
                group.values.push(Vec::new());
            }
            _ => {}
        }
    }
    Ok((groups, first))
}

/// Reads the samples into the groups; a group whose cells are blank has none there.
fn read_samples(
    groups: &mut [Group],
    lines: impl Iterator<Item = Result<Line, Problem>>,
    separator: u8,
    options: &LoadOptions,
) -> Result<(), Problem> {
    let commas = match separator {
        b',' => layout::Commas::Unsure,
        _ => layout::Commas::Decimals,
    };
    let columns = groups.last().map_or(0, |g| g.column + 1 + g.names.len());
    for line in lines {
        let Line { text, number: line } = line?;
        let cells = layout::cells(&text, separator, false);
        if cells[0] == "EOF" {
            break;
        }
        if cells.iter().skip(columns).any(|c| !c.is_empty()) {
            return Err(Problem::Row {
                found: format!(
                    "line {line}: {} cells where the header has {columns}",
                    cells.len()
                ),
                remedy: "if the numbers have decimal commas, export with tabs or semicolons between them",
            });
        }
        let cell = |column: usize| cells.get(column).copied().unwrap_or_default();
        for group in groups.iter_mut().filter(|g| !cell(g.column).is_empty()) {
            let number = |column: usize, name: &str| {
                rows::number(cell(column), commas)
                    .map_err(|what| Problem::cell(format!("line {line}"), name, what))
            };
            let t = number(group.column, "its column of times")?;
            // A slow channel may be written once more for every sample of a fast one.
            if group.t_ms.last() == Some(&t) {
                continue;
            }
            if group.t_ms.len() >= options.max_samples {
                let at = format!("line {line}");
                return Err(Problem::too_many_samples(at, options.max_samples));
            }
            for (j, values) in group.values.iter_mut().enumerate() {
                values.push(number(group.column + 1 + j, &group.names[j])?);
            }
            group.t_ms.push(t);
        }
    }
    Ok(())
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
        return Err(Problem::too_short(times.len()));
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
    let value = |t: &f64| statistics::between(own, values, *t);
    Ok(times.iter().map(value).collect())
}

#[cfg(test)]
mod tests {
    use super::super::tests::{said, text};
    use preslide_host_tests::refusal::refuses;

    const MAP: [(&str, &str); 2] = [("x_m", "1e-6*fActPos"), ("force_N", "fTorque[A]*2")];

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
            let mut cells = vec![key, a, between, b, key, c];
            cells.retain(|c| !c.is_empty());
            text += &join(&cells);
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
        for export in [
            export("\t", "each", milliseconds),
            export(";", "", milliseconds),
            export("\t", "each", calendar).replace("\nEOF", ""),
        ] {
            let found = text(&export, &MAP).unwrap_or_else(|e| panic!("{e}\n{}", &export[..600]));
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
            let scope = said(&found, "twincat-scope");
            for part in ["3 channels", "samples fTemp"] {
                assert!(scope.contains(part), "{scope}");
            }
        }
    }

    #[test]
    fn what_an_export_lacks_is_said() {
        let milliseconds = |i: usize| i.to_string();
        let whole = export("\t", "each", milliseconds);
        let cell = whole.replace("\t0,000\t", "\tx\t");
        let commas = export(",", "each", milliseconds);
        let blanks = export(" ", "each", milliseconds)
            .replace("Starttime of export", "\"Starttime of export\"");
        let short: String = whole.split_inclusive('\n').take(8).collect();
        let own = whole.replacen("(None)", "LU (User)", 1);
        for (export, map, parts) in [
            (
                &own,
                &[][..],
                &["fActPos [LU] 1000", "FACTOR*fActPos [LU]"][..],
            ),
            (&whole, &[][..], &["fActPos 1000", "fTorque [A]"][..]),
            (&cell, &MAP, &["line 11", "fActPos"]),
            (&commas, &MAP, &["tabs or semicolons"]),
            (&blanks, &MAP, &["tabs or semicolons"]),
            (&short, &MAP, &["no sample"]),
        ] {
            refuses(text(export, map), parts);
        }
        // A temperature that ends early is no answer to a question about all of the time.
        let partly = whole.replace("\t400\t420\n", "\t \t \n");
        let cut: String = partly
            .lines()
            .map(|l| match l.split('\t').nth(4) {
                Some(t) if t.trim().parse::<u32>().is_ok_and(|t| t > 400) => {
                    l.rsplitn(3, '\t').last().unwrap_or(l).to_owned() + "\n"
                }
                _ => l.to_owned() + "\n",
            })
            .collect();
        let found = text(&cut, &MAP).unwrap_or_else(|e| panic!("{e}"));
        let scope = said(&found, "twincat-scope");
        assert!(scope.contains("fTemp (a channel whose times"), "{scope}");
        assert!(found.extra.is_empty());
    }
}
