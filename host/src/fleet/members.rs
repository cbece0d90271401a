//! Which recordings there are, and whose they are.

use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

/// Endings of recordings that are looked for in a folder; a file that is named is read whatever it is called.
const ENDINGS: [&str; 12] = [
    "csv", "tsv", "txt", "mat", "npz", "json", "jsonl", "parquet", "h5", "hdf5", "mcap", "db3",
];

/// A recording of a fleet.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// Where it is.
    pub path: PathBuf,
    /// Its name in the table: from the folder that was given on.
    pub file: String,
    /// Whose it is.
    pub axis: String,
    /// Bytes.
    pub bytes: u64,
    /// When it was written (s since 1970).
    pub modified_s: f64,
}

/// The recordings in folders and under patterns (`data/**/*.csv`), each once, by axis and in the order of their names, numbers by value: names that
/// hold a date are in the order of time. An axis is the folder that holds its recordings, from the folder on that holds all that was given; or, of
/// recordings that lie together, the name up to the first number behind `_`, `-` or `.`: `press7_2026-11-26.csv` is of `press7`.
///
/// # Errors
/// What was given that holds no recording, and why.
pub fn members(given: &[String]) -> Result<Vec<Member>, String> {
    let mut paths: Vec<PathBuf> = Vec::new();
    let mut root: Option<PathBuf> = None;
    let mut wrong = Vec::new();
    for text in given {
        match found(text) {
            Ok((_, own)) if own.is_empty() => wrong.push(format!(
                "{text}: no recording there; in a folder it looks for files that end in {}",
                ENDINGS.join(", ")
            )),
            Ok((from, own)) => {
                root = Some(root.map_or(from.clone(), |root| shared(&root, &from)));
                paths.extend(own);
            }
            Err(reason) => wrong.push(format!("{text}: {reason}")),
        }
    }
    if !wrong.is_empty() {
        return Err(wrong.join("\n"));
    }
    let root = root.unwrap_or_default();
    let mut members: Vec<Member> = paths
        .iter()
        .filter_map(|path| member(path, &root))
        .collect();
    members.sort_by_cached_key(|m| (natural(&m.axis), natural(&m.file), m.path.clone()));
    members.dedup_by(|a, b| a.path == b.path);
    Ok(members)
}

/// The folder that holds what was given, and the recordings there.
fn found(text: &str) -> Result<(PathBuf, Vec<PathBuf>), String> {
    let path = Path::new(text);
    if path.is_file() {
        let folder = path.parent().unwrap_or(Path::new(""));
        return Ok((folder.to_owned(), vec![path.to_owned()]));
    }
    let by_ending = path.is_dir();
    let (root, pattern) = if by_ending {
        let root = glob::Pattern::escape(text);
        let pattern = format!("{}/**/*", root.trim_end_matches('/'));
        (path.to_owned(), pattern)
    } else {
        (fixed_part(path), text.to_owned())
    };
    let every = glob::glob(&pattern).map_err(|e| format!("no pattern: {e}"))?;
    let mut paths = Vec::new();
    for file in every {
        let file = file.map_err(|e| e.to_string())?;
        let known = || {
            let ending = file.extension().unwrap_or_default();
            ENDINGS.contains(&ending.to_string_lossy().to_lowercase().as_str())
        };
        if file.is_file() && (!by_ending || known()) {
            paths.push(file);
        }
    }
    Ok((root, paths))
}

/// The folder that two share.
fn shared(a: &Path, b: &Path) -> PathBuf {
    let both = a.components().zip(b.components());
    both.take_while(|(a, b)| a == b).map(|(a, _)| a).collect()
}

/// The folder that a pattern begins with.
fn fixed_part(pattern: &Path) -> PathBuf {
    let is_fixed = |part: &std::path::Component| {
        let text = part.as_os_str().to_string_lossy();
        !text.contains(['*', '?', '['])
    };
    pattern.components().take_while(is_fixed).collect()
}

/// `None` where it is gone meanwhile.
fn member(path: &Path, root: &Path) -> Option<Member> {
    let about = path.metadata().ok()?;
    let written = about
        .modified()
        .ok()
        .and_then(|t| t.duration_since(UNIX_EPOCH).ok());
    let below = path.strip_prefix(root).unwrap_or(path);
    let folder = below.parent().filter(|f| !f.as_os_str().is_empty());
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    Some(Member {
        file: below.to_string_lossy().replace('\\', "/"),
        axis: match folder {
            Some(folder) => folder.to_string_lossy().replace('\\', "/"),
            None => axis_of(&name).to_owned(),
        },
        bytes: about.len(),
        modified_s: written.map_or(0.0, |t| t.as_secs_f64()),
        path: path.to_owned(),
    })
}

/// What of a name is the axis's.
fn axis_of(name: &str) -> &str {
    let at = name.char_indices().find(|(at, c)| {
        let behind = name[at + c.len_utf8()..].starts_with(|d: char| d.is_ascii_digit());
        *at > 0 && matches!(c, '_' | '-' | '.') && behind
    });
    at.map_or(name, |(at, _)| &name[..at])
}

/// A name as text and numbers in turns: `day9` before `day10`.
fn natural(name: &str) -> Vec<(String, u64)> {
    let mut parts: Vec<(String, u64)> = vec![(String::new(), 0)];
    let mut digits = false;
    for c in name.chars() {
        let last = parts.len() - 1;
        match c.to_digit(10) {
            Some(d) => {
                let (_, number) = &mut parts[last];
                *number = number.saturating_mul(10).saturating_add(u64::from(d));
                digits = true;
            }
            None if digits => {
                parts.push((c.to_string(), 0));
                digits = false;
            }
            None => parts[last].0.push(c),
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_is_what_stands_before_the_first_number() {
        for (name, axis) in [
            ("press7_2026-11-26", "press7"),
            ("x-axis-003", "x-axis"),
            ("2026-11-26", "2026"),
            ("spindle", "spindle"),
            ("joint1.12", "joint1"),
        ] {
            assert_eq!(axis_of(name), axis);
        }
    }

    #[test]
    fn numbers_sort_by_value() {
        let mut names = ["day10", "day9", "day9b", "day"];
        names.sort_by_cached_key(|n| natural(n));
        assert_eq!(names, ["day", "day9", "day9b", "day10"]);
    }
}
