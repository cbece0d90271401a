//! Builds that hold no trace of where the tree stands.
//!
//! The paths in panic messages are one; the other is in every symbol. Cargo names a crate by a hash of its source's absolute path
//! where that lies outside the workspace, as the library does for the firmware; the names order functions in memory, and where a function
//! lies decides whether an instruction takes one fetch or two. So a wrapper around rustc names crates by package and version.

use std::ffi::OsString;
use std::process::{Command, ExitCode};

use anyhow::{Context as _, Result};
use preslide_tools::process::root;

/// Set for cargo, and so for the rustc that it starts: this program is rustc's wrapper.
const WRAPS: &str = "PRESLIDE_XTASK_WRAPS_RUSTC";

/// Has cargo call rustc through this program.
pub fn wrap(cargo: &mut Command) -> Result<()> {
    let this = std::env::current_exe().context("where is xtask?")?;
    cargo.env("RUSTC_WRAPPER", this).env(WRAPS, root());
    Ok(())
}

/// As the wrapper, does rustc's work; `None` where this program was not started as one.
pub fn rustc() -> Option<ExitCode> {
    let tree = std::env::var_os(WRAPS)?;
    let mut given = std::env::args_os().skip(1);
    let mut rustc = Command::new(given.next()?);
    let name = |key| std::env::var(key).unwrap_or_default();
    let crate_name = format!(
        "metadata={}-{}",
        name("CARGO_PKG_NAME"),
        name("CARGO_PKG_VERSION")
    );
    rustc.args(given.map(|argument| {
        let names = argument.to_string_lossy().starts_with("metadata=");
        if names {
            OsString::from(&crate_name)
        } else {
            argument
        }
    }));
    let mut remap = OsString::from("--remap-path-prefix=");
    remap.push(&tree);
    remap.push("=.");
    rustc.arg(remap);
    let status = rustc.status();
    let code = status.ok().and_then(|status| status.code());
    Some(ExitCode::from(
        code.and_then(|code| u8::try_from(code).ok()).unwrap_or(1),
    ))
}
