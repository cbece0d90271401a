//! What the committed tables were counted from: a hash of the sources beside each, so that nothing is counted again while they are the same.
//!
//! The compilers are no part of it: a table names them in its header, and another compiler's counts say nothing about a change.

use std::collections::BTreeMap;
use std::process::Command;

use anyhow::Result;
use fs_err as fs;
use preslide_tools::process::{command, output, output_of, root};

/// Hashes of the sources that each table was counted from, a line a command.
const FILE: &str = "firmware/cycles/inputs.txt";

/// All that is compiled, run or computed on the way to a table. What is counted is built in `firmware`, which has lock files of its own.
const PATHS: [&str; 14] = [
    "src",
    "build.rs",
    "axis",
    "axis.toml",
    "link",
    "store",
    "firmware",
    "sim/src/rig",
    "sim/src/stage",
    "host-tests/examples/kernel_forces.rs",
    "cycles",
    "tools/src/image.rs",
    "tools/src/objdump.rs",
    "tools/src/thumb.rs",
];

/// The tables themselves, and what only tells of them.
fn is_result(path: &str) -> bool {
    path == FILE
        || path.starts_with("firmware/cycles/") && path.ends_with(".csv")
        || path.ends_with(".md")
}

/// One hash of all sources as they stand in the work tree, committed or not.
fn hash() -> Result<String> {
    let listed = output(git("ls-files --cached --others --exclude-standard --").args(PATHS))?;
    let mut sources: Vec<&str> = listed
        .lines()
        .filter(|path| !is_result(path) && root().join(path).is_file())
        .collect();
    sources.sort_unstable();
    sources.dedup();
    let hashes = output_of(&mut git("hash-object --stdin-paths"), sources.join("\n"))?;
    let named: Vec<String> = sources
        .iter()
        .zip(hashes.lines())
        .map(|(path, hash)| format!("{path} {hash}"))
        .collect();
    let all = output_of(&mut git("hash-object --stdin"), named.join("\n"))?;
    Ok(all.trim().to_owned())
}

fn git(line: &str) -> Command {
    let mut git = command(&format!("git {line}"));
    git.current_dir(root());
    git
}

/// The hash of each command.
fn committed() -> BTreeMap<String, String> {
    let text = fs::read_to_string(root().join(FILE)).unwrap_or_default();
    let line = |line: &str| {
        let (command, hash) = line.rsplit_once(' ')?;
        Some((command.to_owned(), hash.to_owned()))
    };
    text.lines().filter_map(line).collect()
}

/// Those of `commands` whose tables were counted from other sources than stand here.
pub fn changed<'a>(commands: &[&'a str]) -> Result<Vec<&'a str>> {
    let (now, committed) = (hash()?, committed());
    let is_same = |command: &&str| committed.get(*command) == Some(&now);
    Ok(commands.iter().copied().filter(|c| !is_same(c)).collect())
}

/// Writes that the tables of `command` were counted from the sources as they stand.
pub fn record(command: &str) -> Result<()> {
    let mut all = committed();
    all.insert(command.to_owned(), hash()?);
    let lines = all
        .iter()
        .map(|(command, hash)| format!("{command} {hash}\n"));
    fs::write(root().join(FILE), lines.collect::<String>())?;
    Ok(())
}
