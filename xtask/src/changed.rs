//! Which files differ from a commit, for `cargo xtask test --changed`.

use crate::process::{git, output};

/// What every step depends on: the dependencies, and the steps themselves.
const EVERYTHING: &[&str] = &["Cargo.", "xtask/", ".cargo/", ".ci/", "deny.toml"];

/// Paths of the files that differ from where the branch left `base`, committed or not, and of those that are new.
pub fn files(base: &str) -> Result<Vec<String>, String> {
    let from = output(&mut git(&["merge-base", base, "HEAD"]))
        .map_err(|error| format!("--changed {base}: {error}; name a commit or a branch"))?;
    let changed = output(&mut git(&["diff", "--name-only", from.trim()]))?;
    let new = output(&mut git(&["ls-files", "--others", "--exclude-standard"]))?;
    Ok(changed
        .lines()
        .chain(new.lines())
        .map(str::to_owned)
        .collect())
}

/// Whether a step that depends on the paths that begin with one of `paths` is touched by a change of `files`.
pub fn touches(files: &[String], paths: &[&str]) -> bool {
    let mut prefixes = EVERYTHING.iter().chain(paths);
    prefixes.any(|prefix| files.iter().any(|file| file.starts_with(prefix)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_touched_by_its_paths_and_by_the_dependencies() {
        let files = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
        let paths = &["src/", "host/"];
        assert!(touches(
            &files(&["docs/src/x.md", "host/src/lib.rs"]),
            paths
        ));
        assert!(touches(&files(&["Cargo.lock"]), paths));
        assert!(touches(&files(&["xtask/src/test.rs"]), &[]));
        assert!(!touches(
            &files(&["docs/src/x.md", "host-tests/src/lib.rs"]),
            paths
        ));
        assert!(!touches(&[], paths));
    }
}
