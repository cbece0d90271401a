//! Rows as they are made, a line each, beside the table: what was done before an interruption, or yesterday, is not done again.

use super::{Member, Row};
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

/// The journal of a table. A row is a file's as long as name, length and time of the file are the same.
pub struct Journal {
    path: PathBuf,
    file: File,
    known: HashMap<String, Row>,
}

impl Journal {
    /// Opens or begins the journal of a table made as `how` says; one that was made otherwise is begun anew.
    ///
    /// # Errors
    /// Why it cannot be written.
    pub fn open(table: &Path, how: &str) -> Result<Self, String> {
        let mut name = table.file_name().unwrap_or_default().to_os_string();
        name.push(".rows.jsonl");
        let path = table.with_file_name(name);
        let failed = |e: std::io::Error| format!("cannot write {}: {e}", path.display());
        let head = serde_json::json!({ "schema": "preslide.fleet/1", "version": env!("CARGO_PKG_VERSION"), "how": how }).to_string();
        let mut known = HashMap::new();
        let mut is_ours = false;
        if let Ok(file) = File::open(&path) {
            let mut lines = BufReader::new(file).lines().map_while(Result::ok);
            is_ours = lines.next().is_some_and(|line| line == head);
            // A line that is torn is one that was being written.
            let rows = lines.filter_map(|line| serde_json::from_str::<Row>(&line).ok());
            known = rows
                .filter(|_| is_ours)
                .map(|row| (row.file.clone(), row))
                .collect();
        }
        let mut options = OpenOptions::new();
        let mut file = match is_ours {
            true => options.append(true).open(&path),
            false => options.write(true).create(true).truncate(true).open(&path),
        }
        .map_err(failed)?;
        // The torn line ends here.
        let begin = if is_ours {
            "\n".to_owned()
        } else {
            head + "\n"
        };
        file.write_all(begin.as_bytes()).map_err(failed)?;
        Ok(Self { path, file, known })
    }

    /// The row of a recording that was made before.
    pub fn row(&self, member: &Member) -> Option<&Row> {
        let same = |row: &&Row| row.bytes == member.bytes && row.modified_s == member.modified_s;
        let row = self.known.get(&member.file).filter(same)?;
        Some(row)
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
