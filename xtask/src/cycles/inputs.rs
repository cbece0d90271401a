//! What the committed tables were counted from: a hash of the sources beside each, so that nothing is counted again while they are the same.
//!
//! The compilers are no part of it: a table names them in its header, and another compiler's counts say nothing about a change.

use crate::process::{git, output, output_of, root};

/// Hashes of the sources that each table was counted from, a line a command.
const FILE: &str = "firmware/cycles/inputs.txt";

/// All that is compiled, run or computed on the way to a table. What is counted is built in `firmware`, which has lock files of its own.
const PATHS: [&str; 11] = [
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
    "xtask/src/cycles",
];

/// The tables themselves, and what only tells of them.
fn is_result(path: &str) -> bool {
    path == FILE
        || path.starts_with("firmware/cycles/") && path.ends_with(".csv")
        || path.ends_with(".md")
}

/// One hash of all sources as they stand in the work tree, committed or not.
fn hash() -> Result<String, String> {
    let listed = [
        "ls-files",
        "--cached",
        "--others",
        "--exclude-standard",
        "--",
    ];
    let listed = output(git(&listed).args(PATHS))?;
    let mut sources: Vec<&str> = listed
        .lines()
        .filter(|path| !is_result(path) && root().join(path).is_file())
        .collect();
    sources.sort_unstable();
    sources.dedup();
    let hashes = output_of(
        &mut git(&["hash-object", "--stdin-paths"]),
        &sources.join("\n"),
    )?;
    let named: Vec<String> = sources
        .iter()
        .zip(hashes.lines())
        .map(|(path, hash)| format!("{path} {hash}"))
        .collect();
    let all = output_of(&mut git(&["hash-object", "--stdin"]), &named.join("\n"))?;
    Ok(all.trim().to_owned())
}

fn committed() -> Vec<(String, String)> {
    let text = std::fs::read_to_string(root().join(FILE)).unwrap_or_default();
    let line = |line: &str| {
        let (command, hash) = line.rsplit_once(' ')?;
        Some((command.to_owned(), hash.to_owned()))
    };
    text.lines().filter_map(line).collect()
}

/// Those of `commands` whose tables were counted from other sources than stand here.
pub fn changed<'a>(commands: &[&'a str]) -> Result<Vec<&'a str>, String> {
    let (now, committed) = (hash()?, committed());
    let same = |command: &&str| {
        committed
            .iter()
            .any(|(c, hash)| c == command && *hash == now)
    };
    Ok(commands.iter().copied().filter(|c| !same(c)).collect())
}

/// Writes that the tables of `command` were counted from the sources as they stand.
pub fn record(command: &str) -> Result<(), String> {
    let mut all = committed();
    all.retain(|(other, _)| other != command);
    all.push((command.to_owned(), hash()?));
    all.sort();
    let text: String = all
        .iter()
        .map(|(c, hash)| format!("{c} {hash}\n"))
        .collect();
    std::fs::write(root().join(FILE), text).map_err(|error| format!("cannot write {FILE}: {error}"))
}
