//! Why a recording cannot be used: file, place, reason, remedy.

use thiserror::Error;

use super::places;

/// A recording that cannot be loaded: the file as the user named it, and what is wrong with it.
#[derive(Debug, Error)]
#[error("{file}: {problem}")]
pub struct RecordingError {
    /// The file as given on the command line.
    pub file: String,
    /// What is wrong, where, and what to do about it.
    pub problem: Problem,
}

/// What is wrong with a recording. Every text says where and what to do.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Problem {
    /// The operating system refused to open or read the file.
    #[error("cannot be read: {0}; check the path and its permissions")]
    Io(#[from] std::io::Error),
    /// More bytes than [`LoadOptions::max_bytes`](super::LoadOptions::max_bytes).
    #[error(
        "{bytes} bytes exceed the limit of {limit} bytes; split the recording, or record fewer columns"
    )]
    TooLarge {
        /// Size of the file (bytes).
        bytes: u64,
        /// The limit (bytes).
        limit: u64,
    },
    /// More samples than [`LoadOptions::max_samples`](super::LoadOptions::max_samples).
    #[error(
        "more than {limit} samples (reached at {at}); split the recording, or keep every n-th sample"
    )]
    TooManySamples {
        /// Where the limit was passed.
        at: String,
        /// The limit (samples).
        limit: usize,
    },
    /// No byte, or nothing but blank and `#` lines.
    #[error("is empty; expected a CSV header such as `t_s,x_m,force_N` and samples below it")]
    Empty,
    /// A header without samples, or too few samples to have a sample time.
    #[error("holds {samples} samples; at least {needed} are needed")]
    TooShort {
        /// Samples found.
        samples: usize,
        /// Samples needed.
        needed: usize,
    },
    /// The first line holds numbers.
    #[error(
        "line {line}: `{first}` is a number where the header should be; put the column names with their SI units in front, such as `t_s,x_m,force_N`{}",
        by_place(*columns, maps)
    )]
    NoHeader {
        /// Line of the file, from 1.
        line: u64,
        /// The first cell.
        first: String,
        /// How many columns there are.
        columns: usize,
        /// The options that would read the file, if its numbers are what they look like.
        maps: Vec<String>,
    },
    /// Not separated by commas.
    #[error(
        "line {line}: the columns are separated by {found}; export with commas between columns and points in numbers"
    )]
    Separator {
        /// Line of the file, from 1.
        line: u64,
        /// The separator found, in words.
        found: &'static str,
    },
    /// Not text, or not in UTF-8.
    #[error("line {line}: {what}; export as plain CSV in UTF-8")]
    NotText {
        /// Line of the file, from 1.
        line: u64,
        /// What was met.
        what: String,
    },
    /// A row with another number of cells than the header.
    #[error("line {line}: {cells} cells where the header has {columns}; {hint}")]
    Ragged {
        /// Line of the file, from 1.
        line: u64,
        /// Cells in the row.
        cells: usize,
        /// Columns in the header.
        columns: usize,
        /// What to look at.
        hint: &'static str,
    },
    /// A cell that is empty, text, NaN or infinite.
    #[error("{at}, column `{column}`: {what}; correct it, or cut the recording there")]
    Cell {
        /// Line (CSV) or element (`.mat`), in words.
        at: String,
        /// Name of the column.
        column: String,
        /// What the cell holds.
        what: String,
    },
    /// Roles without a column, or with two, or with one of another axis: everything at once.
    #[error("{complaints}; the file has {listing}{}", proposal(maps))]
    Columns {
        /// What is missing or ambiguous.
        complaints: String,
        /// What the file has.
        listing: String,
        /// The options that would read the file, as far as its names let them be guessed.
        maps: Vec<String>,
    },
    /// A `--map` that cannot be followed.
    #[error("--map {map}: {reason}")]
    Map {
        /// The mapping as given.
        map: String,
        /// Why not, and what would work.
        reason: String,
    },
    /// An `--ignore` of a column that is not there.
    #[error("--ignore {name}: there is no such column; the file has {listing}")]
    Ignore {
        /// The name as given.
        name: String,
        /// What the file has.
        listing: String,
    },
    /// A `--sign` other than 1 and -1.
    #[error(
        "--sign {0} is neither 1 nor -1; give `--sign -1` where the effort opposes the model's convention (positive against motion in +x)"
    )]
    Sign(f64),
    /// Time that does not advance.
    #[error("{at}: time {how} (from {from} s to {to} s); {remedy}")]
    Time {
        /// Line or sample.
        at: String,
        /// "runs backwards" or "stands still".
        how: &'static str,
        /// The time before (s).
        from: f64,
        /// The time there (s).
        to: f64,
        /// What to do.
        remedy: String,
    },
    /// A `.mat` file that is truncated, corrupt or of another version.
    #[error("at byte {offset}: {reason}")]
    Mat {
        /// Byte of the file where the trouble starts.
        offset: usize,
        /// What is wrong and what to do.
        reason: String,
    },
    /// A file of a kind that this build does not read.
    #[error("is {what}; to read it, {remedy}")]
    Format {
        /// What it is.
        what: &'static str,
        /// What would read it.
        remedy: String,
    },
    /// A file of columns by name that is damaged, or holds none.
    #[error("is {reason}")]
    Container {
        /// What it is and what to do.
        reason: String,
    },
    /// Variables of one recording with different lengths.
    #[error(
        "`{first}` has {first_len} samples, `{second}` {second_len}; map variables of equal length"
    )]
    Lengths {
        /// A variable.
        first: String,
        /// Its length.
        first_len: usize,
        /// Another one.
        second: String,
        /// Its length.
        second_len: usize,
    },
    /// A time window that holds no samples.
    #[error("no samples between {from} s and {to} s; the recording covers {start} s to {end} s")]
    Window {
        /// Start of the window (s).
        from: f64,
        /// End of the window (s), excluded.
        to: f64,
        /// First time stamp (s).
        start: f64,
        /// Last time stamp (s).
        end: f64,
    },
}

impl Problem {
    /// Place and reason without the remedy.
    pub(super) fn found(&self) -> String {
        match self {
            Problem::Cell { at, column, what } => format!("{at}, column `{column}`: {what}"),
            Problem::Ragged {
                line,
                cells,
                columns,
                ..
            } => format!("line {line}: {cells} cells where the header has {columns}"),
            other => other.to_string(),
        }
    }

    /// There is no such file, or it may not be read: the command is wrong, not what is in the file.
    pub fn is_of_the_system(&self) -> bool {
        matches!(self, Self::Io(_))
    }

    /// The column to ignore that the file has not.
    pub fn not_there(&self) -> Option<&str> {
        match self {
            Self::Ignore { name, .. } => Some(name),
            _ => None,
        }
    }

    /// The options of the command that would read the file, where names and units let them be guessed.
    pub fn maps(&self) -> &[String] {
        match self {
            Problem::Columns { maps, .. } | Problem::NoHeader { maps, .. } => maps,
            _ => &[],
        }
    }
}

fn by_place(columns: usize, maps: &[String]) -> String {
    let like = match maps {
        [] => "NAME=column1".to_owned(),
        maps => format!(
            "by their numbers, if the units are right, {}{}",
            maps.join(" "),
            places::said(maps)
        ),
    };
    match columns {
        0 => String::new(),
        n => format!(", or map column1 to column{n}: {like}"),
    }
}

fn proposal(maps: &[String]) -> String {
    match maps {
        [] => String::new(),
        maps => format!(
            ". Rename the columns with their SI units, or, if the guess is right, give {}{}",
            maps.join(" "),
            places::said(maps)
        ),
    }
}
