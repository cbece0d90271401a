//! The Python package as its user installs it: `pip install ./python` in a fresh virtual environment, and its tests.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result};
use preslide_tools::process::{build_as_tests, command, root, run, target_of};

/// Installs the package and runs its tests, the long ones, too, where that is asked.
pub fn check(long: bool) -> Result<()> {
    // What the answers are compared with, in the profile of the package: the host is compiled once.
    build_as_tests("--bin preslide")?;
    let target = target_of(root());
    let python = environment(&target.join("python"))?;
    let package = root().join("python");
    let tests = package.join("tests");
    let mut install = pip_install(&python, &tests.join("requirements.txt"));
    if long {
        install.arg("--requirement").arg(tests.join("long.txt"));
    }
    run(install.arg(&package).env("CARGO_TARGET_DIR", &target)).context(
        "pip needs a registry (its `index-url`), and Python 3.11 or later for the versions in python/tests/requirements.txt",
    )?;
    let mut test = Command::new(&python);
    test.args(["-m", "pytest", "-q", "-rs"]).arg(&tests);
    if long {
        test.env("PRESLIDE_LONG", "1");
    }
    if long && cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        let physx = environment(&target.join("physx"))?;
        run(&mut pip_install(&physx, &tests.join("physx.txt")))?;
        test.env("PRESLIDE_PHYSX", physx);
    }
    run(test.env("CARGO_TARGET_DIR", &target))
}

/// A fresh virtual environment; its interpreter.
fn environment(folder: &Path) -> Result<PathBuf> {
    run(command("python3 -m venv --clear").arg(folder))?;
    Ok(folder.join("bin").join("python"))
}

/// Installs what is listed; what is imported is compiled then.
fn pip_install(python: &Path, listed: &Path) -> Command {
    let mut install = Command::new(python);
    install.args(["-m", "pip", "install", "--quiet", "--no-compile"]);
    install.args(["--disable-pip-version-check", "--requirement"]);
    install.arg(listed);
    install
}
