//! The firmware's images: built in their variants, and the program that runs them in QEMU against the simulated stage.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Result;
use fs_err as fs;

use crate::process::{build_as_tests, released, root, run, target_of};
use crate::thumb::{TARGET, Toolchain};

/// Names the file of an exported model to a build.
pub const MODEL: &str = "PRESLIDE_MODEL";

/// The packed kernel as `preslide export` writes it for a controller in I16F16 and in `f32`, and the images with it.
pub const PACKED: [(&str, &str); 2] = [
    ("cli/tests/exported/packed_i16f16.rs", "qemu-packed-fixed"),
    ("cli/tests/exported/packed_f32.rs", "qemu-packed-float"),
];

/// Builds a variant of the QEMU board's firmware with `more` arguments of cargo, and with a file compiled in that a variable names: a model that
/// `preslide export` wrote, an outer task's input. Where its image is kept: cargo has one folder for all variants, so that what they have
/// in common is built once, and the image is copied out of it.
pub fn build(name: &str, more: &str, file: Option<(&str, &str)>) -> Result<PathBuf> {
    let (mut command, built) = build_command("preslide-qemu")?;
    command.args(more.split_whitespace());
    if let Some((variable, file)) = file {
        command.env(variable, root().join(file));
    }
    run(&mut command)?;
    kept(&built, name)
}

/// A copy of a built image, which the next variant does not overwrite.
pub fn kept(built: &Path, name: &str) -> Result<PathBuf> {
    let images = built.with_file_name("images");
    let image = images.join(name);
    fs::create_dir_all(&images)?;
    fs::copy(built, &image)?;
    Ok(image)
}

/// The command that builds a firmware package, and where the image will be until the next variant is built.
pub fn build_command(package: &str) -> Result<(Command, PathBuf)> {
    let firmware = root().join("firmware");
    let line = format!("build --release --locked --package {package}");
    let command = Toolchain::ensure()?.cargo(&firmware, &line);
    let release = target_of(&firmware).join(TARGET).join("release");
    Ok((command, release.join(package)))
}

/// Builds the program that runs firmware in QEMU against the simulated stage, and the tool; where the former is.
pub fn build_rig() -> Result<PathBuf> {
    build_as_tests("--bin preslide --example rig --example drive")?;
    Ok(released("examples/rig"))
}
