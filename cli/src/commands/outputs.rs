//! The files that a command writes: checked before any work, written beside and renamed, `-` for standard output.

use super::{Failure, OutputArgs};
use crate::heard::{take_stdout, to_stdout};
use std::path::{Path, PathBuf};

/// Whether a path stands for standard output.
pub fn is_stdout(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// One file, whatever it is called: two names of one have the same.
#[derive(PartialEq)]
enum Identity {
    Stdout,
    /// Device and number of a file that is there.
    #[cfg(unix)]
    Inode(u64, u64),
    Path(PathBuf),
}

impl Identity {
    fn of(path: &Path) -> Self {
        if is_stdout(path) {
            return Self::Stdout;
        }
        #[cfg(unix)]
        if let Ok(found) = std::fs::metadata(path) {
            use std::os::unix::fs::MetadataExt;
            return Self::Inode(found.dev(), found.ino());
        }
        let whole = path.canonicalize().ok();
        let beside = || Some(folder(path).canonicalize().ok()?.join(path.file_name()?));
        Self::Path(whole.or_else(beside).unwrap_or_else(|| path.to_owned()))
    }
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

impl OutputArgs {
    /// The outputs with their options.
    fn listed(&self) -> Vec<(&'static str, PathBuf)> {
        let json = self.json.iter().map(|p| ("--json", p.clone()));
        let report = self.report.iter().map(|p| ("--report", p.clone()));
        json.chain(report).collect()
    }
}

/// An option that names a file to write, and the file where it was given.
pub type Output<'a> = (&'static str, Option<&'a PathBuf>);

/// Sees to it that every output can be written and is no input and no other output. All that is wrong is said at once.
///
/// # Errors
/// Each option with its path, the reason and the remedy.
pub fn check(inputs: &[&Path], own: &[Output], others: Option<&OutputArgs>) -> Result<(), Failure> {
    let given = own
        .iter()
        .filter_map(|(option, path)| Some((*option, (*path)?.clone())));
    let mut outputs: Vec<(&str, PathBuf)> = given.collect();
    outputs.extend(others.map(OutputArgs::listed).unwrap_or_default());
    let (mut wrong, mut unwritable) = (Vec::new(), Vec::new());
    for (i, (option, path)) in outputs.iter().enumerate() {
        let named = format!("{option} {}", path.display());
        let own = Identity::of(path);
        let same = |other: &Path| Identity::of(other) == own;
        if let Some(input) = inputs.iter().find(|input| same(input)) {
            wrong.push(format!(
                "{named}: this would overwrite the input {}; name another file",
                input.display()
            ));
        } else if let Some((other, _)) = outputs[..i].iter().find(|(_, other)| same(other)) {
            let page = if option.contains("--report") {
                ", a page .html"
            } else {
                ""
            };
            wrong.push(format!(
                "{named}: {other} already goes there; name another file{page}"
            ));
        } else if *option == "--report" && path.extension().is_some_and(|e| e == "png") {
            wrong.push(format!(
                "{named}: a report is a page; name it .html and save its figures from the browser"
            ));
        } else if let Err(reason) = writable(path) {
            unwritable.push(format!(
                "cannot write {}: {reason}; name a file in a folder that exists and is writable ({option})",
                path.display()
            ));
        }
    }
    if !wrong.is_empty() {
        wrong.extend(unwritable);
        return Err(Failure::Input(wrong.join("\n")));
    }
    if !unwritable.is_empty() {
        return Err(Failure::Tool(unwritable.join("\n")));
    }
    take_stdout(outputs.iter().any(|(_, path)| is_stdout(path)));
    Ok(())
}

fn writable(path: &Path) -> Result<(), String> {
    if is_stdout(path) {
        return Ok(());
    }
    if path.is_dir() {
        return Err("it is a folder".to_owned());
    }
    if path.exists() && !path.is_file() {
        return Ok(());
    }
    let trial = beside(path);
    std::fs::write(&trial, "").map_err(|e| e.to_string())?;
    std::fs::remove_file(&trial).map_err(|e| e.to_string())
}

/// A name in the same folder that no one else has.
fn beside(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.part", std::process::id()))
}

/// Has `write` write a file, which appears under its name when it is whole; and says so.
///
/// # Errors
/// The reason, with the path.
pub fn write_with(
    path: &Path,
    write: impl FnOnce(&Path) -> anyhow::Result<()>,
) -> Result<(), Failure> {
    // A link stays a link, and what is no plain file (`/dev/null`) cannot be replaced.
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let failed = |e: String| {
        Failure::Tool(format!(
            "cannot write {}: {e}; name a file in a folder that exists and is writable",
            path.display()
        ))
    };
    if target.exists() && !target.is_file() {
        write(&target).map_err(|e| failed(format!("{e:#}")))?;
    } else {
        let part = beside(&target);
        let written = write(&part).map_err(|e| failed(format!("{e:#}")));
        let renamed = written
            .and_then(|()| std::fs::rename(&part, &target).map_err(|e| failed(e.to_string())));
        if renamed.is_err() {
            let _ = std::fs::remove_file(&part);
        }
        renamed?;
    }
    tell!("wrote {}", path.display());
    Ok(())
}

/// Writes an answer for machines, as [`write_text`] does.
///
/// # Errors
/// The reason, with the path.
pub fn write_json(path: &Path, answer: &serde_json::Value) -> Result<(), Failure> {
    write_text(path, &format!("{answer:#}\n"))
}

/// Writes a model and says so, and that it is TOML where its name says otherwise.
///
/// # Errors
/// The reason, with the path.
pub fn write_model(path: &Path, text: &str) -> Result<(), Failure> {
    write_text(path, text)?;
    if path.extension().is_some_and(|ending| ending != "toml") {
        tell!(
            "{} is a model in TOML, whatever its name ends in.",
            path.display()
        );
    }
    Ok(())
}

/// Writes a text file and says so; `-` is standard output.
///
/// # Errors
/// The reason, with the path.
pub fn write_text(path: &Path, text: &str) -> Result<(), Failure> {
    if is_stdout(path) {
        return to_stdout(text).map_err(|e| Failure::Tool(format!("standard output: {e}")));
    }
    write_with(path, |path| Ok(std::fs::write(path, text)?))
}
