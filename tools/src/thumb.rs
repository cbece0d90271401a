//! A Rust toolchain for the Cortex-M4F and other cores, in the order: installed target, rustup, Debian's own compiler.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use anyhow::{Context as _, Result, bail, ensure};

use crate::need::install;
use crate::process::{IN_ONE_PIECE, cargo, command, find, output, run_for};

/// Cortex-M4F and M7: Thumb-2 with DSP instructions and a single-precision FPU.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// rustup's download hangs on some networks instead of failing; Debian's packages are then the way.
pub const RUSTUP_LIMIT: Duration = Duration::from_secs(120);

const DEBIAN_RUSTC: &str = "/usr/bin/rustc";
const DEBIAN_CARGO: &str = "/usr/bin/cargo";

/// Who builds for a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Toolchain {
    /// The running toolchain has the target's `core`.
    Installed,
    /// Debian's compiler builds `core` from Debian's source of it.
    Debian,
}

impl Toolchain {
    /// Finds a toolchain for the Cortex-M4F, installing one if there is none.
    pub fn ensure() -> Result<Self> {
        let tried = match Self::by_rustup(TARGET) {
            Ok(found) => return Ok(found),
            Err(tried) => format!("{tried:#}"),
        };
        let remedy = format!("rustup target add {TARGET}");
        if !has_debian() {
            install(
                "rustc-web cargo-web rust-web-src lld",
                &format!("a compiler for {TARGET} ({tried})"),
                &format!("  {remedy}"),
            )?;
        }
        ensure!(
            has_debian(),
            "no compiler for {TARGET}: {tried}, and Debian's rustc-web did not install {DEBIAN_RUSTC} and its source; remedy: {remedy}"
        );
        Ok(Self::Debian)
    }

    /// The same for another target, where rustup has it: `what` is skipped aloud where it has not.
    pub fn or_skipped(target: &str, what: &str) -> Option<Self> {
        let found = Self::by_rustup(target);
        found
            .map_err(|tried| println!("SKIPPED: {what} was NOT built for {target}: {tried:#}; remedy: rustup target add {target}"))
            .ok()
    }

    fn by_rustup(target: &str) -> Result<Self> {
        if has_target(target) {
            return Ok(Self::Installed);
        }
        let tried = "no installed target";
        if find("rustup").is_none() {
            bail!(tried);
        }
        println!(
            "installing the Rust target {target}: the library must build for the microcontroller"
        );
        let mut add = command("rustup target add");
        run_for(add.arg(target), RUSTUP_LIMIT).context(tried)?;
        ensure!(
            has_target(target),
            "{tried}, rustup added it but rustc does not see it"
        );
        Ok(Self::Installed)
    }

    /// `cargo` for the Cortex-M4F; the line begins with the subcommand.
    pub fn cargo(self, folder: &Path, line: &str) -> Command {
        self.cargo_for(TARGET, folder, line)
    }

    /// The same for another target.
    pub fn cargo_for(self, target: &str, folder: &Path, line: &str) -> Command {
        let mut cargo = match self {
            Self::Installed => cargo(line),
            Self::Debian => {
                let mut cargo = command(&format!("{DEBIAN_CARGO} {line} -Zbuild-std=core"));
                let name = target.to_uppercase().replace(['-', '.'], "_");
                cargo
                    .env("RUSTC", DEBIAN_RUSTC)
                    // `build-std` is unstable; Debian ships no nightly.
                    .env("RUSTC_BOOTSTRAP", "1")
                    // rustc asks for `rust-lld`, which Debian's package does not hold.
                    .env(format!("CARGO_TARGET_{name}_LINKER"), "ld.lld");
                cargo
            }
        };
        cargo.args(["--target", target]).current_dir(folder);
        cargo.envs([IN_ONE_PIECE]);
        cargo
    }

    /// The compiler's version, for the header of measured data.
    pub fn version(self) -> Result<String> {
        let rustc = match self {
            Self::Installed => "rustc",
            Self::Debian => DEBIAN_RUSTC,
        };
        let version = output(Command::new(rustc).arg("--version"))?;
        Ok(version.trim().to_owned())
    }
}

/// Whether the running toolchain builds for a target.
pub fn has_target(target: &str) -> bool {
    let query = output(command("rustc --print target-libdir --target").arg(target));
    query.is_ok_and(|folder| Path::new(folder.trim()).is_dir())
}

fn has_debian() -> bool {
    let sysroot = output(Command::new(DEBIAN_RUSTC).args(["--print", "sysroot"]));
    let has_core = |sysroot: String| {
        let sysroot = Path::new(sysroot.trim());
        sysroot.join("lib/rustlib/src/rust/library/core").is_dir()
    };
    sysroot.is_ok_and(has_core) && Path::new(DEBIAN_CARGO).is_file()
}
