//! `cargo xtask qemu`: the firmware in an emulator against the simulated stage.
//!
//! Builds the QEMU board in both arithmetics, shows that its control code has no panic path, prints flash, RAM and
//! stack, runs the same motion twice in QEMU and once on the host, and injects the faults.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::call_graph;
use crate::process::{cargo, output, root, run, run_for};
use crate::thumb::{TARGET, Toolchain};
use crate::tools::Need;

/// The control code of the release image; nothing that can panic may be reached from it.
const CONTROL: &str = "preslide_app::control::decide";

const GOLDEN: &str = "firmware/boards/qemu/expected";

/// A run of the motion takes 10 s on a slow machine, the faults two minutes.
const LIMIT: Duration = Duration::from_secs(600);

pub fn run_command(arguments: &[String]) -> Result<(), String> {
    let bless = match arguments {
        [] => false,
        [flag] if flag == "--bless" => true,
        _ => {
            return Err(format!(
                "`qemu` takes --bless or nothing, got `{}`",
                arguments.join(" ")
            ));
        }
    };
    Need::Qemu.ensure()?;
    Need::ArmGcc.ensure()?;
    let rig = build_rig()?;
    let fixed = build("preslide-qemu", "qemu-fixed", &[])?;
    let float = build("preslide-qemu", "qemu-float", &["--features", "float"])?;
    for (kind, elf) in [("fixed", &fixed), ("float", &float)] {
        check_image(kind, elf)?;
        let first = agreement(&rig, kind, elf)?;
        print!("{first}");
        let second = agreement(&rig, kind, elf)?;
        if first != second {
            return Err(format!(
                "two runs of `{kind}` print different bytes:\n{first}{second}"
            ));
        }
        println!("{kind}: the second run printed the same bytes");
    }
    // It cannot be run here, but it must build, fit and not panic.
    let board = build("preslide-stm32g474", "stm32g474", &[])?;
    check_image("stm32g474", &board)?;
    let golden = root().join(GOLDEN);
    let mut faults = Command::new(&rig);
    faults.arg("faults").arg(&fixed).arg(&golden);
    if bless {
        faults.arg("--bless");
    }
    run_for(&mut faults, LIMIT)
}

/// Builds the program that runs firmware in QEMU against the simulated stage; where it is.
pub fn build_rig() -> Result<PathBuf, String> {
    run(&mut cargo(&[
        "build",
        "--release",
        "--package",
        "preslide-cli",
        "--example",
        "rig",
    ]))?;
    Ok(root().join("target/release/examples/rig"))
}

/// Builds a firmware package; where the image is. A folder of its own for each variant keeps all of them.
pub fn build(package: &str, folder: &str, more: &[&str]) -> Result<PathBuf, String> {
    let toolchain = Toolchain::ensure()?;
    let target = root().join("firmware/target").join(folder);
    let firmware = root().join("firmware");
    let arguments = [
        &["build", "--release", "--locked", "--package", package][..],
        more,
    ]
    .concat();
    let mut command = toolchain.cargo(&firmware, &arguments);
    run(command.arg("--target-dir").arg(&target))?;
    Ok(target.join(TARGET).join("release").join(package))
}

/// Flash and RAM of an image, and whether its control code can panic.
fn check_image(kind: &str, elf: &Path) -> Result<(), String> {
    let sizes = output(Command::new("arm-none-eabi-size").arg(elf))?;
    let numbers: Vec<u64> = sizes
        .lines()
        .nth(1)
        .unwrap_or_default()
        .split_whitespace()
        .filter_map(|word| word.parse().ok())
        .collect();
    let [text, data, bss, ..] = numbers[..] else {
        return Err(format!(
            "arm-none-eabi-size printed something unknown:\n{sizes}"
        ));
    };
    println!(
        "{kind}: flash {} bytes, static RAM {} bytes",
        text + data,
        data + bss
    );
    let disassembly = output(
        Command::new("arm-none-eabi-objdump")
            .args(["--disassemble", "--demangle", "--no-show-raw-insn"])
            .arg(elf),
    )?;
    let reached = call_graph::reached(&disassembly, CONTROL)?;
    let panics: Vec<&String> = reached
        .iter()
        .filter(|name| name.contains("panic"))
        .collect();
    if !panics.is_empty() {
        return Err(format!("{kind}: {CONTROL} can reach {panics:?}"));
    }
    println!(
        "{kind}: {} functions reached from {CONTROL}, none of them panics",
        reached.len()
    );
    Ok(())
}

/// One run of the motion, under a time limit; what it printed.
fn agreement(rig: &Path, kind: &str, elf: &Path) -> Result<String, String> {
    let file = std::env::temp_dir().join(format!("preslide-qemu-{}.txt", std::process::id()));
    let open =
        std::fs::File::create(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    let mut command = Command::new(rig);
    command.arg(kind).arg(elf).stdout(Stdio::from(open));
    run_for(&mut command, LIMIT)?;
    let text =
        std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    // It is in the way of nothing if it stays.
    let _ = std::fs::remove_file(&file);
    Ok(text)
}
