//! What a step needs beside cargo, and how it gets there on a fresh machine.

use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

use anyhow::{Context as _, Result, bail};

use crate::process::{cargo, command, find, output, output_of, root, run_for};

/// Long enough for a slow mirror, short enough that a hanging one ends in a message.
const INSTALL_LIMIT: Duration = Duration::from_secs(15 * 60);

const RISCV_GCC: &str = "riscv64-unknown-elf-gcc";

/// Something a step needs beside cargo and a host C linker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// `cargo fmt`.
    Rustfmt,
    /// `cargo clippy`.
    Clippy,
    /// The emulator, with the plugin interface that Debian's build has.
    Qemu,
    /// The emulator of RISC-V cores.
    QemuRiscv,
    /// Cross compiler, C library and binary utilities.
    ArmGcc,
    /// Makes a program of a circuit's description.
    Verilator,
    /// Cross compiler and C library.
    RiscvGcc,
    /// The browser that opens the report.
    Chromium,
    /// An interpreter that makes virtual environments.
    Python,
}

impl Need {
    /// Makes sure that it is there; installs it if it is not.
    pub fn ensure(self) -> Result<()> {
        match self {
            Need::Rustfmt => component("fmt", "rustfmt"),
            Need::Clippy => component("clippy", "clippy"),
            Need::Qemu => program(
                "qemu-system-arm",
                "qemu-system-arm",
                "the kernels' instruction paths are recorded in an emulated Cortex-M4",
                "  Fedora: sudo dnf install qemu-system-arm\n  Arch: sudo pacman -S qemu-system-arm\n  \
                 macOS: brew install qemu",
            ),
            Need::QemuRiscv => program(
                "qemu-system-riscv32",
                "qemu-system-misc",
                "the RISC-V example runs in an emulated core",
                "  Fedora: sudo dnf install qemu-system-riscv\n  Arch: sudo pacman -S qemu-system-riscv\n  \
                 macOS: brew install qemu",
            ),
            Need::ArmGcc => program(
                "arm-none-eabi-gcc",
                "gcc-arm-none-eabi libnewlib-arm-none-eabi",
                "the C peers and the disassembly of the kernels need the cross compiler",
                "  Fedora: sudo dnf install arm-none-eabi-gcc-cs arm-none-eabi-newlib\n  \
                 Arch: sudo pacman -S arm-none-eabi-gcc arm-none-eabi-newlib\n  \
                 macOS: brew install --cask gcc-arm-embedded",
            ),
            Need::Verilator => program(
                "verilator",
                "verilator",
                "the RTL of a core is simulated",
                "  Fedora: sudo dnf install verilator\n  Arch: sudo pacman -S verilator\n  macOS: brew install verilator",
            ),
            Need::RiscvGcc => {
                let reason = "the textbook model in C is built for the RISC-V core";
                let elsewhere = "  build riscv-gnu-toolchain with picolibc for rv32imac/ilp32";
                program(RISCV_GCC, "gcc-riscv64-unknown-elf", reason, elsewhere)?;
                // A package of its own, without which the compiler starts and finds no header.
                let mut compile = Command::new(RISCV_GCC);
                compile.args(["--specs=picolibc.specs", "-E", "-x", "c", "-"]);
                if output_of(&mut compile, "#include <math.h>\n").is_ok() {
                    return Ok(());
                }
                let reason = "the C library of the RISC-V core, picolibc, is missing";
                install("picolibc-riscv64-unknown-elf", reason, elsewhere)
            }
            Need::Python => {
                let reason = "the Python package is installed and tested";
                let elsewhere = "  Fedora: sudo dnf install python3\n  Arch: sudo pacman -S python\n  macOS: brew install python";
                program("python3", "python3", reason, elsewhere)?;
                // Debian's makes no environment without a package of its own.
                let mut venv = Command::new("python3");
                if output(venv.args(["-c", "import ensurepip, venv"])).is_ok() {
                    return Ok(());
                }
                install("python3-venv", reason, elsewhere)
            }
            Need::Chromium => program(
                "chromium",
                "chromium",
                "the report page is opened in a real browser",
                "  Fedora: sudo dnf install chromium\n  Arch: sudo pacman -S chromium",
            ),
        }
    }
}

/// mdBook, of the release that makes the book: without its server and search it takes a minute.
pub fn mdbook() -> Result<PathBuf> {
    let reason = "it turns docs/ into pages";
    installed("mdbook", "0.5.4", "--no-default-features", reason)
}

/// defmt's own decoder, of the release of defmt that the firmware has.
pub fn defmt_print() -> Result<PathBuf> {
    let reason = "it decodes what a firmware logs";
    installed("defmt-print", "1.2.0", "", reason)
}

/// A program of this version: one on the path, or one built from the registry into a folder of cargo's home, once for all clones.
fn installed(name: &str, version: &str, more: &str, reason: &str) -> Result<PathBuf> {
    let is_there = |program: &PathBuf| {
        output(Command::new(program).arg("--version")).is_ok_and(|said| said.contains(version))
    };
    if let Some(found) = find(name).filter(is_there) {
        return Ok(found);
    }
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| Some(std::env::home_dir()?.join(".cargo")));
    let folder = home.context("no home folder")?.join("preslide");
    let program = folder.join("bin").join(name);
    if !is_there(&program) {
        println!(
            "installing {name} {version} into {}: {reason}",
            folder.display()
        );
        let line = format!("install {name} --version {version} {more} --locked --debug --force");
        let mut install = cargo(&line);
        install.arg("--root").arg(&folder);
        install.arg("--target-dir").arg(root().join("target/tools"));
        run_for(&mut install, INSTALL_LIMIT)?;
    }
    Ok(program)
}

/// A program from Debian's packages.
fn program(name: &str, packages: &str, reason: &str, elsewhere: &str) -> Result<()> {
    match find(name) {
        Some(_) => Ok(()),
        None => install(packages, reason, elsewhere),
    }
}

/// A cargo subcommand that rustup ships as a component.
fn component(subcommand: &str, name: &str) -> Result<()> {
    if output(cargo(subcommand).arg("--version")).is_ok() {
        return Ok(());
    }
    if find("rustup").is_none() {
        bail!(
            "`cargo {subcommand}` is missing and there is no rustup to add it; install the Rust toolchain \
             with rustup, then: rustup component add {name}"
        );
    }
    println!("installing {name}: `cargo {subcommand}` is missing");
    let line = format!("rustup component add {name}");
    run_for(&mut command(&line), INSTALL_LIMIT)
}

/// Installs Debian packages as root or through sudo; elsewhere says what to install.
pub(crate) fn install(packages: &str, reason: &str, elsewhere: &str) -> Result<()> {
    if find("apt-get").is_none() {
        bail!("{reason}; this is no Debian or Ubuntu, so install it by hand:\n{elsewhere}");
    }
    let is_root = output(&mut command("id -u"))?.trim() == "0";
    if !is_root && find("sudo").is_none() {
        bail!(
            "{reason}; neither root nor sudo here, so run as root:\n  \
             apt-get update && apt-get install -y --no-install-recommends {packages}"
        );
    }
    println!("installing {packages}: {reason}");
    let become_root = if is_root { "" } else { "sudo " };
    let install = format!("install -y --no-install-recommends {packages}");
    ["update", &install].into_iter().try_for_each(|what| {
        let apt = format!("{become_root}env DEBIAN_FRONTEND=noninteractive apt-get -q {what}");
        run_for(&mut command(&apt), INSTALL_LIMIT)
    })
}
