//! Tables: the same rows for the page and for the terminal.

use super::display_unit;
use super::figures::cells;
use crate::statistics::Estimate;

/// Columns of a terminal that a table takes at most, if its words let it.
const WIDEST: usize = 100;

/// A table of text cells. Rows may be ragged; missing cells are empty.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// One line above the table; may be empty.
    pub caption: String,
    /// Column headings, with the unit: "stiffness \[N/m\]".
    pub head: Vec<String>,
    /// Cells, row by row. Columns of numbers are right-aligned.
    pub rows: Vec<Vec<String>>,
}

/// A table under way, column by column: a head beside what each row has there.
pub struct Columns<R> {
    of: Vec<R>,
    table: Table,
}

impl<R> Columns<R> {
    /// The next column.
    #[must_use]
    pub fn column(mut self, head: impl Into<String>, cell: impl Fn(&R) -> String) -> Self {
        self.table.head.push(head.into());
        for (row, cells) in self.of.iter().zip(&mut self.table.rows) {
            cells.push(cell(row));
        }
        self
    }

    /// With its last column.
    pub fn table(self) -> Table {
        self.table
    }
}

impl Table {
    /// A table with a line for each of `rows`.
    pub fn of<R>(caption: impl Into<String>, rows: impl IntoIterator<Item = R>) -> Columns<R> {
        let of: Vec<R> = rows.into_iter().collect();
        let table = Table {
            caption: caption.into(),
            head: Vec::new(),
            rows: vec![Vec::new(); of.len()],
        };
        Columns { of, table }
    }

    /// Parameters by name and unit, each with its interval in the prefix that suits it.
    pub fn parameters(
        caption: impl Into<String>,
        rows: impl IntoIterator<Item = (String, String, Estimate)>,
    ) -> Table {
        let row = |(name, unit, known): (String, String, Estimate)| {
            let reach = known.reach().unwrap_or(0.0);
            let shown = display_unit(&unit, known.value.abs().max(reach));
            let [value, from, to] = cells(known.value, known.ci95, shown.factor);
            vec![name, value, from, to, shown.unit]
        };
        Table {
            caption: caption.into(),
            head: ["parameter", "value", "95 % from", "to", "unit"]
                .map(String::from)
                .to_vec(),
            rows: rows.into_iter().map(row).collect(),
        }
    }

    /// The table aligned for a terminal, each line ended by a newline; cells of the widest columns are broken between words where it would
    /// be wider than 100 characters.
    pub fn to_text(&self) -> String {
        let widths = self.widths();
        let mut text = String::new();
        let mut push = |line: String| {
            text.push_str(line.trim_end());
            text.push('\n');
        };
        if !self.caption.is_empty() {
            push(self.caption.clone());
        }
        let rule: Vec<String> = widths.iter().map(|&width| "─".repeat(width)).collect();
        if !self.head.is_empty() {
            self.aligned(&self.head, &widths).for_each(&mut push);
            push(rule.join("  "));
        }
        for row in &self.rows {
            self.aligned(row, &widths).for_each(&mut push);
        }
        text
    }

    /// Width of each column.
    fn widths(&self) -> Vec<usize> {
        let longest = |of: fn(&str) -> usize| -> Vec<usize> {
            let cell =
                |row: &Vec<String>, c: usize| row.get(c).map_or(0, |cell| of(&one_line(cell)));
            let column = |c| self.lines().map(|row| cell(row, c)).max().unwrap_or(0);
            (0..self.columns()).map(column).collect()
        };
        let mut widths = longest(|cell| cell.chars().count());
        let words = longest(|cell| {
            cell.split(' ')
                .map(|word| word.chars().count())
                .max()
                .unwrap_or(0)
        });
        while widths.iter().map(|width| width + 2).sum::<usize>() > WIDEST + 2 {
            let can_break = (0..widths.len()).filter(|&c| widths[c] > words[c]);
            let Some(widest) = can_break.max_by_key(|&c| widths[c]) else {
                break;
            };
            widths[widest] -= 1;
        }
        widths
    }

    /// A row's lines.
    fn aligned(&self, row: &[String], widths: &[usize]) -> impl Iterator<Item = String> {
        let broken = |(c, &width): (usize, &usize)| -> Vec<String> {
            let cell = row.get(c).map(|cell| one_line(cell)).unwrap_or_default();
            let lines = textwrap::wrap(
                &cell,
                textwrap::Options::new(width.max(1)).break_words(false),
            );
            let right = self.is_numeric(c);
            let align = |line: &str| match right {
                true => format!("{line:>width$}"),
                false => format!("{line:<width$}"),
            };
            lines.iter().map(|line| align(line)).collect()
        };
        let cells: Vec<Vec<String>> = widths.iter().enumerate().map(broken).collect();
        let blank: Vec<String> = widths.iter().map(|&width| " ".repeat(width)).collect();
        let height = cells.iter().map(Vec::len).max().unwrap_or(0);
        (0..height).map(move |line| {
            let of =
                |(cell, blank): (&Vec<String>, &String)| cell.get(line).unwrap_or(blank).clone();
            cells
                .iter()
                .zip(&blank)
                .map(of)
                .collect::<Vec<_>>()
                .join("  ")
        })
    }

    /// Number of columns of the longest line.
    pub(super) fn columns(&self) -> usize {
        self.lines().map(Vec::len).max().unwrap_or(0)
    }

    /// Whether every filled cell of the column starts like a number ("−3.16 ± 0.02", "12 %") or stands for a missing
    /// one ("–"), and at least one is a number.
    pub(super) fn is_numeric(&self, column: usize) -> bool {
        let cells = || {
            self.rows
                .iter()
                .filter_map(|row| row.get(column))
                .map(|c| c.trim())
                .filter(|c| !c.is_empty())
        };
        let number = |cell: &str| {
            let unsigned =
                cell.trim_start_matches(['-', '−', '+', '±', '<', '>', '≤', '≥', '≈', '.', ' ']);
            unsigned.starts_with(|c: char| c.is_ascii_digit())
                || matches!(unsigned, "inf" | "∞" | "NaN")
        };
        cells().any(number)
            && cells().all(|cell| number(cell) || matches!(cell, "-" | "–" | "—" | "n/a"))
    }

    fn lines(&self) -> impl Iterator<Item = &Vec<String>> {
        std::iter::once(&self.head).chain(&self.rows)
    }
}

fn one_line(cell: &str) -> String {
    cell.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(cells: &[&str]) -> Vec<String> {
        cells.iter().map(|c| (*c).to_string()).collect()
    }

    #[test]
    fn text_is_aligned_by_characters_not_bytes() {
        let table = Table {
            caption: "Parameters".into(),
            head: row(&["name", "value [µm]"]),
            rows: vec![
                row(&["σ₀", "−3.16"]),
                row(&["breakaway", "20.39"]),
                row(&["α"]),
            ],
        };
        let expected = "Parameters\n\
                        name       value [µm]\n\
                        ─────────  ──────────\n\
                        σ₀              −3.16\n\
                        breakaway       20.39\n\
                        α\n";
        assert_eq!(table.to_text(), expected);
    }

    #[test]
    fn a_wide_table_is_broken_between_words() {
        let names = "one two three four five six seven eight nine ten ".repeat(4);
        let table = Table {
            head: row(&["name", "what", "value"]),
            rows: vec![row(&["a", &names, "1"]), row(&["b", "short", "2"])],
            ..Table::default()
        };
        let text = table.to_text();
        assert!(
            text.lines().all(|line| line.chars().count() <= WIDEST),
            "{text}"
        );
        // Head, rule, three lines of names, one more row; no word is lost.
        assert_eq!(text.lines().count(), 6, "{text}");
        assert_eq!(text.matches("seven").count(), 4);
        assert!(
            text.lines().nth(2).is_some_and(|line| line.ends_with('1')),
            "{text}"
        );
    }

    #[test]
    fn words_go_left_and_numbers_right() {
        let table = Table {
            rows: vec![
                row(&["dahl", "1.3 %", "no", "–"]),
                row(&["4 blocks", "< 0.1", "2", "1e-3"]),
            ],
            ..Table::default()
        };
        let numeric: Vec<bool> = (0..5).map(|c| table.is_numeric(c)).collect();
        assert_eq!(numeric, [false, true, false, true, false]);
    }

    #[test]
    fn empty_and_ragged_tables_do_not_panic() {
        assert_eq!(Table::default().to_text(), "");
        let ragged = Table {
            rows: vec![row(&["a", "b", "c"]), vec![]],
            ..Table::default()
        };
        assert_eq!(ragged.to_text(), "a  b  c\n\n");
    }
}
