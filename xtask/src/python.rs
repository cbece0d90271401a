//! The Python package as its user installs it: `pip install ./python` in a fresh virtual environment, and its tests.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::process::{build_as_tests, root, run, target_of};

/// Installs the package and runs its tests, the long ones, too, where that is asked.
pub fn check(long: bool) -> Result<(), String> {
    // What the answers are compared with, in the profile of the package: the host is compiled once.
    build_as_tests(&["--bin", "preslide"])?;
    let target = target_of(root());
    let python = environment(&target.join("python"))?;
    let package = root().join("python");
    let tests = package.join("tests");
    let mut install = pip_install(&python);
    install.arg(&package);
    install
        .arg("--requirement")
        .arg(tests.join("requirements.txt"));
    if long {
        install.arg("--requirement").arg(tests.join("long.txt"));
    }
    run(install.env("CARGO_TARGET_DIR", &target)).map_err(|reason| {
        format!(
            "{reason}; pip needs a registry (its `index-url`), and Python 3.11 or later for the versions in python/tests/requirements.txt"
        )
    })?;
    let mut test = Command::new(&python);
    test.args(["-m", "pytest", "-q", "-rs"]).arg(&tests);
    if long {
        test.env("PRESLIDE_LONG", "1");
    }
    if long && cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        let physx = environment(&target.join("physx"))?;
        run(pip_install(&physx)
            .arg("--requirement")
            .arg(tests.join("physx.txt")))?;
        test.env("PRESLIDE_PHYSX", physx);
    }
    run(test.env("CARGO_TARGET_DIR", &target))
}

/// A fresh virtual environment; its interpreter.
fn environment(folder: &Path) -> Result<PathBuf, String> {
    run(Command::new("python3")
        .args(["-m", "venv", "--clear"])
        .arg(folder))?;
    Ok(folder.join("bin").join("python"))
}

fn pip_install(python: &Path) -> Command {
    let mut install = Command::new(python);
    // What is imported is compiled then.
    install.args(["-m", "pip", "install", "--quiet", "--no-compile"]);
    install.arg("--disable-pip-version-check");
    install
}
