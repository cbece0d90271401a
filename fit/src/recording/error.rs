//! Why a recording cannot be used: file, place, reason, remedy.

use std::fmt::Display;

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
    /// A row without a sample: a cell of it is no number, or its cells are not those of the header.
    #[error("{found}; {remedy}")]
    Row {
        /// Place and reason.
        found: String,
        /// What to do about it.
        remedy: &'static str,
    },
    /// Columns whose names say too little: a role without one, or with two, or with one of another axis.
    #[error("{found}")]
    Columns {
        /// Everything that is missing or ambiguous at once, and what the file has.
        found: String,
        /// The options that would read the file, as far as names and numbers let them be guessed.
        maps: Vec<String>,
    },
    /// An `--ignore` of a column that is not there.
    #[error("--ignore {name}: there is no such column; the file has {listing}")]
    Ignore {
        /// The name as given.
        name: String,
        /// What the file has.
        listing: String,
    },
    /// Anything else, which nobody needs to tell apart.
    #[error("{0}")]
    Other(String),
}

impl Problem {
    /// A cell that is empty, text, NaN or infinite.
    pub(super) fn cell(at: impl Display, column: &str, what: impl Display) -> Self {
        Self::Row {
            found: format!("{at}, column `{column}`: {what}"),
            remedy: "correct it, or cut the recording there",
        }
    }

    /// More bytes than [`LoadOptions::max_bytes`](super::LoadOptions::max_bytes) allow.
    pub(super) fn too_large(bytes: u64, limit: u64) -> Self {
        Self::Other(format!(
            "{bytes} bytes exceed the limit of {limit} bytes; split the recording, or record fewer columns"
        ))
    }

    /// More samples than [`LoadOptions::max_samples`](super::LoadOptions::max_samples).
    pub(super) fn too_many_samples(at: impl Display, limit: usize) -> Self {
        Self::Other(format!(
            "more than {limit} samples (reached at {at}); split the recording, or keep every n-th sample"
        ))
    }

    /// Too few samples to have a sample time.
    pub(super) fn too_short(samples: usize) -> Self {
        let samples = match samples {
            0 => "no sample",
            _ => "one sample",
        };
        Self::Other(format!("holds {samples}; at least 2 are needed"))
    }

    /// Nothing but blank lines and remarks.
    pub(super) fn empty() -> Self {
        Self::Other(
            "is empty; expected a CSV header such as `t_s,x_m,force_N` and samples below it".into(),
        )
    }

    /// No text.
    pub(super) fn not_text(line: u64, what: &str) -> Self {
        Self::Other(format!("line {line}: {what}; export as plain CSV in UTF-8"))
    }

    /// A `--map` that cannot be followed, and what would work.
    pub(super) fn map(map: impl Display, reason: impl Display) -> Self {
        Self::Other(format!("--map {map}: {reason}"))
    }

    /// A row of numbers where the header should be, over so many columns.
    pub(super) fn no_header(line: u64, first: &str, columns: usize, maps: Vec<String>) -> Self {
        let like = match maps.as_slice() {
            [] => "NAME=column1".to_owned(),
            maps => format!(
                "by their numbers, if the units are right, {}",
                places::offered(maps)
            ),
        };
        Self::Columns {
            found: format!(
                "line {line}: `{first}` is a number where the header should be; put the column names with their SI units in front, such as `t_s,x_m,force_N`, or map column1 to column{columns}: {like}"
            ),
            maps,
        }
    }

    /// What is missing or ambiguous in what the file has, with the options that would read it.
    pub(super) fn columns(complaints: &str, listing: &str, maps: Vec<String>) -> Self {
        let proposal = match maps.as_slice() {
            [] => String::new(),
            maps => format!(
                ". Rename the columns with their SI units, or, if the guess is right, give {}",
                places::offered(maps)
            ),
        };
        Self::Columns {
            found: format!("{complaints}; the file has {listing}{proposal}"),
            maps,
        }
    }

    /// Place and reason without the remedy.
    pub(super) fn found(&self) -> String {
        match self {
            Problem::Row { found, .. } => found.clone(),
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
            Self::Columns { maps, .. } => maps,
            _ => &[],
        }
    }
}
