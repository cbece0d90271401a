//! A Rust toolchain for the Cortex-M4F and other cores, in the order: installed target, rustup, Debian's own compiler.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use crate::process::{IN_ONE_PIECE, find, output, run_for};
use crate::tools::install;

/// Cortex-M4F and M7: Thumb-2 with DSP instructions and a single-precision FPU.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// rustup's download hangs on some networks instead of failing; Debian's packages are then the way.
const RUSTUP_LIMIT: Duration = Duration::from_secs(120);

const DEBIAN_RUSTC: &str = "/usr/bin/rustc";
const DEBIAN_CARGO: &str = "/usr/bin/cargo";

/// Who builds for the target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Toolchain {
    /// The running toolchain has the target's `core`.
    Installed,
    /// Debian's compiler builds `core` from Debian's source of it.
    Debian,
}

impl Toolchain {
    /// Finds a toolchain for the Cortex-M4F, installing one if there is none.
    pub fn ensure() -> Result<Self, String> {
        Self::ensure_for(TARGET)
    }

    /// The same for another target.
    pub fn ensure_for(target: &str) -> Result<Self, String> {
        let tried = match Self::by_rustup(target) {
            Ok(found) => return Ok(found),
            Err(tried) => tried,
        };
        if !has_debian() {
            install(
                &["rustc-web", "cargo-web", "rust-web-src", "lld"],
                &format!("a compiler for {target} ({tried})"),
                &format!("  rustup target add {target}"),
            )?;
        }
        if has_debian() {
            Ok(Self::Debian)
        } else {
            Err(format!(
                "no compiler for {target}: {tried}, and Debian's rustc-web did not install {DEBIAN_RUSTC} and \
                 its source; remedy: rustup target add {target}"
            ))
        }
    }

    /// The same for what is built besides, where rustup has the target: `what` is skipped aloud where it has not.
    pub fn or_skipped(target: &str, what: &str) -> Option<Self> {
        let found = Self::by_rustup(target);
        found
            .map_err(|tried| println!("SKIPPED: {what} was NOT built for {target}: {tried}; remedy: rustup target add {target}"))
            .ok()
    }

    fn by_rustup(target: &str) -> Result<Self, String> {
        if has_target(target) {
            return Ok(Self::Installed);
        }
        let tried = "no installed target";
        if find("rustup").is_none() {
            return Err(tried.to_owned());
        }
        println!(
            "installing the Rust target {target}: the library must build for the microcontroller"
        );
        let add = ["target", "add", target];
        match run_for(Command::new("rustup").args(add), RUSTUP_LIMIT) {
            Ok(()) if has_target(target) => Ok(Self::Installed),
            Ok(()) => Err(format!(
                "{tried}, rustup added it but rustc does not see it"
            )),
            Err(error) => Err(format!("{tried}, {error}")),
        }
    }

    /// `cargo` for the Cortex-M4F; the arguments begin with the subcommand.
    pub fn cargo(self, folder: &Path, arguments: &[&str]) -> Command {
        self.cargo_for(TARGET, folder, arguments)
    }

    /// The same for another target.
    pub fn cargo_for(self, target: &str, folder: &Path, arguments: &[&str]) -> Command {
        let mut command = match self {
            Self::Installed => crate::process::cargo(arguments),
            Self::Debian => {
                let mut command = Command::new(DEBIAN_CARGO);
                let name = target.to_uppercase().replace(['-', '.'], "_");
                command
                    .args(arguments)
                    .arg("-Zbuild-std=core")
                    // `build-std` is unstable; Debian ships no nightly.
                    .env("RUSTC", DEBIAN_RUSTC)
                    .env("RUSTC_BOOTSTRAP", "1")
                    // rustc asks for `rust-lld`, which Debian's package does not hold.
                    .env(format!("CARGO_TARGET_{name}_LINKER"), "ld.lld");
                command
            }
        };
        command.args(["--target", target]).current_dir(folder);
        command.envs([IN_ONE_PIECE]);
        command
    }

    /// The compiler's version, for the header of measured data.
    pub fn version(self) -> Result<String, String> {
        let rustc = match self {
            Self::Installed => "rustc",
            Self::Debian => DEBIAN_RUSTC,
        };
        Ok(output(Command::new(rustc).arg("--version"))?
            .trim()
            .to_string())
    }
}

fn has_target(target: &str) -> bool {
    let query =
        output(Command::new("rustc").args(["--print", "target-libdir", "--target", target]));
    query.is_ok_and(|folder| Path::new(folder.trim()).is_dir())
}

fn has_debian() -> bool {
    let sysroot = output(Command::new(DEBIAN_RUSTC).args(["--print", "sysroot"]));
    sysroot.is_ok_and(|folder| {
        Path::new(folder.trim())
            .join("lib/rustlib/src/rust/library/core")
            .is_dir()
    }) && Path::new(DEBIAN_CARGO).is_file()
}
