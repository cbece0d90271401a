//! What a step needs beside cargo, and how it gets there on a fresh machine.

use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::process::{cargo, find, output, output_of, root, run_for, words};

/// Long enough for a slow mirror, short enough that a hanging one ends in a message.
const INSTALL_LIMIT: Duration = Duration::from_secs(15 * 60);

const RISCV_GCC: &str = "riscv64-unknown-elf-gcc";

/// Something a step needs beside cargo and a host C linker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    Rustfmt,
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
    pub fn ensure(self) -> Result<(), String> {
        match self {
            Need::Rustfmt => component("fmt", "rustfmt"),
            Need::Clippy => component("clippy", "clippy"),
            Need::Qemu => program(
                "qemu-system-arm",
                &["qemu-system-arm"],
                "the kernels' instruction paths are recorded in an emulated Cortex-M4",
                "  Fedora: sudo dnf install qemu-system-arm\n  Arch: sudo pacman -S qemu-system-arm\n  \
                 macOS: brew install qemu",
            ),
            Need::QemuRiscv => program(
                "qemu-system-riscv32",
                &["qemu-system-misc"],
                "the RISC-V example runs in an emulated core",
                "  Fedora: sudo dnf install qemu-system-riscv\n  Arch: sudo pacman -S qemu-system-riscv\n  \
                 macOS: brew install qemu",
            ),
            Need::ArmGcc => program(
                "arm-none-eabi-gcc",
                &["gcc-arm-none-eabi", "libnewlib-arm-none-eabi"],
                "the C peers and the disassembly of the kernels need the cross compiler",
                "  Fedora: sudo dnf install arm-none-eabi-gcc-cs arm-none-eabi-newlib\n  \
                 Arch: sudo pacman -S arm-none-eabi-gcc arm-none-eabi-newlib\n  \
                 macOS: brew install --cask gcc-arm-embedded",
            ),
            Need::Verilator => program(
                "verilator",
                &["verilator"],
                "the RTL of a core is simulated",
                "  Fedora: sudo dnf install verilator\n  Arch: sudo pacman -S verilator\n  macOS: brew install verilator",
            ),
            Need::RiscvGcc => {
                let reason = "the textbook model in C is built for the RISC-V core";
                let elsewhere = "  build riscv-gnu-toolchain with picolibc for rv32imac/ilp32";
                program(RISCV_GCC, &["gcc-riscv64-unknown-elf"], reason, elsewhere)?;
                // A package of its own, without which the compiler starts and finds no header.
                let mut compile = Command::new(RISCV_GCC);
                compile.args(["--specs=picolibc.specs", "-E", "-x", "c", "-"]);
                compile.stderr(Stdio::null());
                if output_of(&mut compile, "#include <math.h>\n").is_ok() {
                    return Ok(());
                }
                let reason = "the C library of the RISC-V core, picolibc, is missing";
                install(&["picolibc-riscv64-unknown-elf"], reason, elsewhere)
            }
            Need::Python => {
                let reason = "the Python package is installed and tested";
                let elsewhere = "  Fedora: sudo dnf install python3\n  Arch: sudo pacman -S python\n  macOS: brew install python";
                program("python3", &["python3"], reason, elsewhere)?;
                // Debian's makes no environment without a package of its own.
                let mut venv = Command::new("python3");
                venv.args(["-c", "import ensurepip, venv"])
                    .stderr(Stdio::null());
                if output_of(&mut venv, "").is_ok() {
                    return Ok(());
                }
                install(&["python3-venv"], reason, elsewhere)
            }
            Need::Chromium => program(
                "chromium",
                &["chromium"],
                "the report page is opened in a real browser",
                "  Fedora: sudo dnf install chromium\n  Arch: sudo pacman -S chromium",
            ),
        }
    }
}

/// The release of mdBook that makes the book.
const MDBOOK: &str = "0.5.4";

/// Reads the log of a firmware; the release of defmt that the firmware has.
const DEFMT_PRINT: &str = "1.2.0";

/// mdBook: without its server and search it takes a minute.
pub fn mdbook() -> Result<PathBuf, String> {
    let reason = "it turns docs/ into pages";
    installed("mdbook", MDBOOK, "--no-default-features", reason)
}

/// defmt's own decoder.
pub fn defmt_print() -> Result<PathBuf, String> {
    installed(
        "defmt-print",
        DEFMT_PRINT,
        "",
        "it decodes what a firmware logs",
    )
}

/// A program of this version: one on the path, or one built from the registry into a folder of cargo's home, once for all clones.
fn installed(name: &str, version: &str, more: &str, reason: &str) -> Result<PathBuf, String> {
    let is_there = |program: &PathBuf| {
        output(Command::new(program).arg("--version")).is_ok_and(|said| said.contains(version))
    };
    if let Some(found) = find(name).filter(is_there) {
        return Ok(found);
    }
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| Some(std::env::home_dir()?.join(".cargo")));
    let folder = home.ok_or("no home folder")?.join("preslide");
    let program = folder.join("bin").join(name);
    if !is_there(&program) {
        println!(
            "installing {name} {version} into {}: {reason}",
            folder.display()
        );
        run_for(
            cargo(&["install", name, "--version", version])
                .args(words(more))
                .args(words("--locked --debug --force --root"))
                .arg(&folder)
                .arg("--target-dir")
                .arg(root().join("target/tools")),
            INSTALL_LIMIT,
        )?;
    }
    Ok(program)
}

/// A program from Debian's packages.
fn program(name: &str, packages: &[&str], reason: &str, elsewhere: &str) -> Result<(), String> {
    if find(name).is_some() {
        Ok(())
    } else {
        install(packages, reason, elsewhere)
    }
}

/// A cargo subcommand that rustup ships as a component.
fn component(subcommand: &str, name: &str) -> Result<(), String> {
    if output(&mut cargo(&[subcommand, "--version"])).is_ok() {
        return Ok(());
    }
    if find("rustup").is_none() {
        return Err(format!(
            "`cargo {subcommand}` is missing and there is no rustup to add it; install the Rust toolchain \
             with rustup, then: rustup component add {name}"
        ));
    }
    println!("installing {name}: `cargo {subcommand}` is missing");
    run_for(
        Command::new("rustup").args(["component", "add", name]),
        INSTALL_LIMIT,
    )
}

/// Installs Debian packages as root or through sudo; elsewhere says what to install.
pub fn install(packages: &[&str], reason: &str, elsewhere: &str) -> Result<(), String> {
    let packages_line = packages.join(" ");
    if find("apt-get").is_none() {
        return Err(format!(
            "{reason}; this is no Debian or Ubuntu, so install it by hand:\n{elsewhere}"
        ));
    }
    let is_root = output(Command::new("id").arg("-u"))?.trim() == "0";
    if !is_root && find("sudo").is_none() {
        return Err(format!(
            "{reason}; neither root nor sudo here, so run as root:\n  \
             apt-get update && apt-get install -y --no-install-recommends {packages_line}"
        ));
    }
    println!("installing {packages_line}: {reason}");
    let apt = |arguments: &[&str]| {
        let mut command = Command::new(if is_root { "env" } else { "sudo" });
        if !is_root {
            command.arg("env");
        }
        command
            .args(["DEBIAN_FRONTEND=noninteractive", "apt-get", "-q"])
            .args(arguments);
        run_for(&mut command, INSTALL_LIMIT)
    };
    apt(&["update"])?;
    apt(&[&["install", "-y", "--no-install-recommends"], packages].concat())
}
