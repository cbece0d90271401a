//! Recordings as columns of numbers, read from CSV and written as CSV, apart from the tool's own reader.

use std::fmt::Write as _;
use std::path::Path;

/// Names that a position, an effort can have; a table of [`super::real`] or of the trials has one of each.
const POSITIONS: [&str; 2] = ["x_m", "q_rad"];
const EFFORTS: [&str; 2] = ["force_N", "torque_Nm"];

/// Columns of equal length under their names; what is not a number is NaN.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// One name a column.
    pub names: Vec<String>,
    /// The columns.
    pub columns: Vec<Vec<f64>>,
}

impl Table {
    /// From the text of a CSV file with one line of names.
    ///
    /// # Errors
    /// Without such a line.
    pub fn parse(text: &str) -> Result<Self, String> {
        let cells = |line: &str| -> Vec<String> {
            line.split(',')
                .map(|cell| cell.trim().trim_matches('"').to_owned())
                .collect()
        };
        let mut lines = text.lines();
        let names = cells(lines.next().ok_or("an empty file")?);
        let mut columns = vec![Vec::new(); names.len()];
        for line in lines.filter(|line| !line.trim().is_empty()) {
            let row = cells(line);
            for (i, column) in columns.iter_mut().enumerate() {
                let value = row.get(i).and_then(|cell| cell.parse().ok());
                column.push(value.unwrap_or(f64::NAN));
            }
        }
        Ok(Self { names, columns })
    }

    /// From a CSV file.
    ///
    /// # Errors
    /// Where the file cannot be read.
    pub fn read(path: &Path) -> Result<Self, String> {
        let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
        Self::parse(&text).map_err(|e| format!("{}: {e}", path.display()))
    }

    /// As CSV; NaN is an empty cell.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), String> {
        let mut text = self.names.join(",");
        text.push('\n');
        for row in 0..self.len() {
            for (i, column) in self.columns.iter().enumerate() {
                let comma = if i == 0 { "" } else { "," };
                let _ = match column[row] {
                    value if value.is_nan() => write!(text, "{comma}"),
                    value => write!(text, "{comma}{value}"),
                };
            }
            text.push('\n');
        }
        std::fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Where a column stands.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|n| n == name)
    }

    fn role(&self, names: &[&str]) -> usize {
        let found = names.iter().find_map(|name| self.find(name));
        found.unwrap_or_else(|| panic!("a recording without any of {}", names.join(", ")))
    }

    /// The clock (s), in column 0 where it has no name of its own.
    pub fn time(&self) -> usize {
        self.find("t_s").unwrap_or(0)
    }

    /// Which column is the position (m or rad).
    pub fn position(&self) -> usize {
        self.role(&POSITIONS)
    }

    /// Which column is the effort (N or N·m).
    pub fn effort(&self) -> usize {
        self.role(&EFFORTS)
    }

    /// Whether the axis turns.
    pub fn rotary(&self) -> bool {
        self.find(POSITIONS[1]).is_some()
    }

    /// Changes every value of a column.
    pub fn change(&mut self, column: usize, change: impl Fn(f64) -> f64) {
        self.columns[column]
            .iter_mut()
            .for_each(|value| *value = change(*value));
    }

    /// Only the rows that `keeps` takes, by number.
    #[must_use]
    pub fn kept(&self, mut keeps: impl FnMut(usize) -> bool) -> Self {
        let rows: Vec<usize> = (0..self.len()).filter(|&row| keeps(row)).collect();
        let columns = self.columns.iter();
        Self {
            names: self.names.clone(),
            columns: columns
                .map(|c| rows.iter().map(|&row| c[row]).collect())
                .collect(),
        }
    }

    /// Adds a column.
    pub fn push(&mut self, name: &str, column: Vec<f64>) {
        assert_eq!(column.len(), self.len(), "{name}");
        self.names.push(name.to_owned());
        self.columns.push(column);
    }

    /// Median step of the clock (s).
    pub fn sample_time(&self) -> f64 {
        let time = &self.columns[self.time()];
        let mut steps: Vec<f64> = time.windows(2).map(|t| t[1] - t[0]).collect();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len() / 2).copied().unwrap_or(f64::NAN)
    }
}

/// What the tool is given: one recording in one or more files, and a model.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Name in tables.
    pub name: String,
    /// One table a file.
    pub parts: Vec<Table>,
    /// Text of the model file.
    pub model: Option<String>,
    /// Further arguments.
    pub arguments: Vec<String>,
}

impl Recording {
    /// One file, without further arguments.
    pub fn new(name: impl Into<String>, part: Table, model: Option<String>) -> Self {
        Self {
            name: name.into(),
            parts: vec![part],
            model,
            arguments: Vec::new(),
        }
    }
}
