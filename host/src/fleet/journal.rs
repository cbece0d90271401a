//! Rows as they are made, a line each, beside the table: what was done before an interruption, yesterday or on another machine is not done again.

use super::{Member, Part, Row};
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

/// The journals of a table: one, or one a part. A row is a file's as long as name, length and time of the file are the same.
pub struct Journal {
    path: PathBuf,
    file: File,
    known: HashMap<Version, Row>,
}

/// A file as it was: its name, its bytes, and when it was written (the bits of s since 1970).
type Version = (String, u64, u64);

/// Whether a file is a journal of a table.
pub fn is_journal(path: &Path, table: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let own = format!(
        "{}.rows",
        table.file_name().unwrap_or_default().to_string_lossy()
    );
    name.starts_with(&own) && name.ends_with(".jsonl")
}

/// The journals of a table that are there.
fn journals(table: &Path) -> Vec<PathBuf> {
    let folder = table.parent().filter(|f| !f.as_os_str().is_empty());
    let beside = std::fs::read_dir(folder.unwrap_or(Path::new(".")));
    let paths = beside
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path());
    paths.filter(|path| is_journal(path, table)).collect()
}

/// Whether a table was begun: what lies there is it, and no recording.
pub fn is_begun(table: &Path) -> bool {
    !journals(table).is_empty()
}

impl Journal {
    /// Opens or begins the journal of a table, or of a part of it, made as `how` says; one that was made otherwise is begun anew. The rows of all
    /// parts are known.
    ///
    /// # Errors
    /// Why it cannot be written.
    pub fn open(table: &Path, how: &str, part: Option<Part>) -> Result<Self, String> {
        let name = table.file_name().unwrap_or_default().to_string_lossy();
        let part = part.map_or(String::new(), |part| {
            format!(".{}-of-{}", part.number, part.of)
        });
        let path = table.with_file_name(format!("{name}.rows{part}.jsonl"));
        let failed = |e: std::io::Error| format!("cannot write {}: {e}", path.display());
        let head = serde_json::json!({ "schema": "preslide.fleet/1", "version": env!("CARGO_PKG_VERSION"), "how": how }).to_string();
        let mut known = HashMap::new();
        for journal in journals(table) {
            known.extend(rows(&journal, &head).unwrap_or_default());
        }
        let is_begun = rows(&path, &head).is_some();
        let mut options = OpenOptions::new();
        let mut file = match is_begun {
            true => options.append(true).open(&path),
            false => options.write(true).create(true).truncate(true).open(&path),
        }
        .map_err(failed)?;
        // A line that was torn ends here.
        let begin = if is_begun {
            "\n".to_owned()
        } else {
            head + "\n"
        };
        file.write_all(begin.as_bytes()).map_err(failed)?;
        Ok(Self { path, file, known })
    }

    /// The row of a recording that was made before.
    pub fn row(&self, member: &Member) -> Option<&Row> {
        let version = (
            member.file.clone(),
            member.bytes,
            member.modified_s.to_bits(),
        );
        self.known.get(&version)
    }

    /// Keeps a row.
    ///
    /// # Errors
    /// Why it cannot.
    pub fn keep(&mut self, row: &Row) -> Result<(), String> {
        let line = serde_json::to_string(row).map_err(|e| e.to_string())?;
        // At once: the line is whole or torn, never mixed with another.
        let written = self.file.write_all(format!("{line}\n").as_bytes());
        written.map_err(|e| format!("cannot write {}: {e}", self.path.display()))
    }
}

/// The rows of a journal that begins so; a line that is torn is one that was being written.
fn rows(path: &Path, head: &str) -> Option<HashMap<Version, Row>> {
    let mut lines = BufReader::new(File::open(path).ok()?)
        .lines()
        .map_while(Result::ok);
    if lines.next()? != head {
        return None;
    }
    let rows = lines.filter_map(|line| serde_json::from_str::<Row>(&line).ok());
    let version = |row: &Row| (row.file.clone(), row.bytes, row.modified_s.to_bits());
    Some(rows.map(|row| (version(&row), row)).collect())
}
