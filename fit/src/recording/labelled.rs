//! Rows whose numbers stand behind their columns' names, `t:0.1 pos:2.5`, as Arduino's serial plotter takes them.

use super::layout::{self, Layout, SEPARATORS};

/// The layout of such a text, from its head; the first rows of a serial line may be cut.
pub(super) fn layout(head: &[u8]) -> Option<Layout> {
    let lines = layout::lines(head);
    let lines: Vec<_> = lines.iter().filter(|l| !l.text.trim().is_empty()).collect();
    lines.windows(2).find_map(|pair| {
        let [line, next] = pair else { return None };
        SEPARATORS.into_iter().find_map(|separator| {
            let names = labels(&line.text, separator)?;
            let same = labels(&next.text, separator).is_some_and(|n| n == names);
            same.then(|| Layout {
                separator,
                names,
                skip: line.start,
                first_line: line.number,
                labelled: true,
                ..Layout::default()
            })
        })
    })
}

/// The names in a line that holds nothing but names with numbers, two of them or more.
fn labels(line: &str, separator: u8) -> Option<Vec<String>> {
    let mut cells = layout::cells(line, separator);
    cells.pop_if(|c| c.is_empty());
    let name = |cell: &String| {
        let (name, number) = cell.split_once(':')?;
        let is_name = name.starts_with(|c: char| c.is_alphabetic() || c == '_');
        layout::parse(number.trim(), separator != b',')?;
        is_name.then(|| name.trim().to_owned())
    };
    let names: Vec<String> = cells.iter().map(name).collect::<Option<_>>()?;
    (names.len() > 1).then_some(names)
}

/// The row without the names; a cell that has another one stays, and is no number.
pub(super) fn bare(record: &::csv::ByteRecord, names: &[String]) -> ::csv::ByteRecord {
    let none = String::new();
    let names = names.iter().chain(std::iter::repeat(&none));
    let number = |(cell, name): (_, &String)| {
        let cell: &[u8] = <[u8]>::trim_ascii(cell);
        let after = cell.strip_prefix(name.as_bytes());
        let after = after.and_then(|a| a.trim_ascii_start().strip_prefix(b":"));
        after.unwrap_or(cell).to_vec()
    };
    let cells: Vec<Vec<u8>> = record.iter().zip(names).map(number).collect();
    ::csv::ByteRecord::from(cells)
}
