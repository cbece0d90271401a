//! Tables: the same rows for the page and for the terminal.

use super::display_unit;
use super::figures::cells;
use crate::statistics::Estimate;

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

    /// The table aligned for a terminal, each line ended by a newline.
    pub fn to_text(&self) -> String {
        let columns = self.columns();
        let numeric: Vec<bool> = (0..columns).map(|c| self.is_numeric(c)).collect();
        let widths: Vec<usize> = (0..columns)
            .map(|c| {
                self.lines()
                    .map(|row| row.get(c).map_or(0, |cell| one_line(cell).chars().count()))
                    .max()
            })
            .map(Option::unwrap_or_default)
            .collect();
        let mut text = String::new();
        let mut push = |line: String| {
            text.push_str(line.trim_end());
            text.push('\n');
        };
        if !self.caption.is_empty() {
            push(self.caption.clone());
        }
        let aligned = |row: &Vec<String>| -> String {
            let cells = widths
                .iter()
                .zip(&numeric)
                .enumerate()
                .map(|(c, (&width, &right))| {
                    let cell = row.get(c).map(|cell| one_line(cell)).unwrap_or_default();
                    if right {
                        format!("{cell:>width$}")
                    } else {
                        format!("{cell:<width$}")
                    }
                });
            cells.collect::<Vec<_>>().join("  ")
        };
        if !self.head.is_empty() {
            push(aligned(&self.head));
            push(
                widths
                    .iter()
                    .map(|&width| "─".repeat(width))
                    .collect::<Vec<_>>()
                    .join("  "),
            );
        }
        self.rows.iter().for_each(|row| push(aligned(row)));
        text
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
