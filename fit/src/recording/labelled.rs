//! Rows whose numbers stand behind their columns' names, `t:0.1 pos:2.5`, as Arduino's serial plotter takes them.

use super::layout::{self, Layout, Line, SEPARATORS};

/// The layout of such a text, from its head; the first rows of a serial line may be cut.
pub(super) fn layout(head: &[Line]) -> Option<Layout> {
    let lines: Vec<_> = head.iter().filter(|l| !l.text.trim().is_empty()).collect();
    lines.windows(2).find_map(|pair| {
        let [line, next] = pair else { return None };
        SEPARATORS.into_iter().find_map(|separator| {
            let names = labels(&line.text, separator)?;
            let same = labels(&next.text, separator).is_some_and(|n| n == names);
            same.then(|| Layout {
                separator,
                names,
                first_line: line.number,
                labelled: true,
                ..Layout::default()
            })
        })
    })
}

/// The names in a line that holds nothing but names with numbers, two of them or more.
fn labels(line: &str, separator: u8) -> Option<Vec<String>> {
    let mut cells = layout::cells(line, separator, true);
    cells.pop_if(|c| c.is_empty());
    let name = |cell: &str| {
        let (name, number) = cell.split_once(':')?;
        let is_name = name.starts_with(|c: char| c.is_alphabetic() || c == '_');
        layout::parse(number.trim(), separator != b',')?;
        is_name.then(|| name.trim().to_owned())
    };
    let names: Vec<String> = cells.into_iter().map(name).collect::<Option<_>>()?;
    (names.len() > 1).then_some(names)
}

/// A cell without its column's name; one that has another name stays, and is no number.
pub(super) fn bare<'a>(cell: &'a str, name: &str) -> &'a str {
    let after = cell.strip_prefix(name);
    let after = after.and_then(|a| a.trim_start().strip_prefix(':'));
    after.map_or(cell, str::trim_start)
}
