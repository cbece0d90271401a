//! Host checks of Preslide: an independent reference, and the paths and parameters that it is driven with;
//! and the trials that the diagnosis is judged by.

pub mod answer;
pub mod case;
pub mod deviation;
pub mod dice;
pub mod judge;
mod least_squares;
pub mod made;
pub mod path;
pub mod reference;
pub mod refusal;
pub mod table;
pub mod table3;
pub mod trials;

use std::io::Write as _;
use std::path::{Path, PathBuf};

/// The folder of the real recordings; where it is absent, `None` and a loud line.
pub fn recordings() -> Option<PathBuf> {
    shared("recordings")
}

/// A folder of real machines' data, `../shared/NAME`; where it is absent, `None` and one loud line that names the test.
///
/// The line goes past the test harness, which keeps what a passing test prints to itself; `cargo xtask test` counts such lines.
pub fn shared(name: &str) -> Option<PathBuf> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared")).join(name);
    if folder.is_dir() {
        return Some(folder);
    }
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    // Nothing is lost where nobody listens.
    let _ = writeln!(
        std::io::stderr(),
        "SKIPPED: {test}: ../shared/{name} is absent"
    );
    None
}

/// Files and folders of tests beside a package's `tests/main.rs` that it does not name, and which so would never run.
///
/// # Panics
/// Where the folder cannot be read.
pub fn forgotten_tests(package: &str) -> Vec<String> {
    let folder = Path::new(package).join("tests");
    let main = std::fs::read_to_string(folder.join("main.rs")).expect("tests/main.rs");
    let entries = std::fs::read_dir(&folder).expect("the folder of tests");
    let holds_code =
        |path: &Path| path.extension().is_some_and(|e| e == "rs") || path.join("mod.rs").is_file();
    entries
        .filter_map(|entry| Some(entry.ok()?.path()).filter(|path| holds_code(path)))
        .filter_map(|path| Some(path.file_stem()?.to_string_lossy().into_owned()))
        .filter(|name| name != "main" && !main.contains(&format!("mod {name};")))
        .collect()
}
