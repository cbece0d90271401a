//! The Python package as its user installs it: `pip install ./python` in a fresh virtual environment, and its tests.

use std::path::PathBuf;
use std::process::Command;

use crate::process::{build_as_tests, root, run, target_of};

/// Installs the package and runs its tests, the long ones, too, where that is asked.
pub fn check(long: bool) -> Result<(), String> {
    // What the answers are compared with, in the profile of the package: the host is compiled once.
    build_as_tests(&["--bin", "preslide"])?;
    let target = target_of(root());
    let folder = target.join("python");
    let python = folder.join("bin").join("python");
    run(Command::new("python3")
        .args(["-m", "venv", "--clear"])
        .arg(&folder))?;
    let package: PathBuf = root().join("python");
    let mut install = Command::new(&python);
    install.args([
        "-m",
        "pip",
        "install",
        "--disable-pip-version-check",
        "--quiet",
    ]);
    install.arg(&package).arg("--requirement");
    let tests = package.join("tests");
    install.arg(tests.join("requirements.txt"));
    if long {
        install.arg("--requirement").arg(tests.join("long.txt"));
    }
    run(install.env("CARGO_TARGET_DIR", &target)).map_err(|reason| {
        format!(
            "{reason}; pip needs a registry (its `index-url`), and Python 3.11 or later for the versions in python/tests/requirements.txt"
        )
    })?;
    let mut test = Command::new(&python);
    test.args(["-m", "pytest", "-q", "-rs"]).arg(tests);
    if long {
        test.env("PRESLIDE_LONG", "1");
    }
    run(test.env("CARGO_TARGET_DIR", &target))
}
