//! `cargo xtask qemu`: the firmware in an emulator against the simulated stage.
//!
//! Builds the QEMU board in both arithmetics, in one with the packed kernel (in both with `--long`), shows that its control code has no panic path, prints flash, RAM and
//! stack, runs the same motion twice in QEMU and once on the host, sends a thousand requests (ten thousand with `--long`) under full telemetry, injects the
//! faults, lets the stage wear under a firmware that watches it and its winding be warm under one that follows it, and with `--long` identifies the stage's friction from captured telemetry.
//! `cargo xtask stage` only serves the emulated drive.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::call_graph;
use crate::process::{build_as_tests, free_port, output, released, root, run, run_for, target_of};
use crate::thumb::{TARGET, Toolchain};
use crate::tools::Need;

/// The interrupt of the control task, on either board; nothing that can panic may be reached from it.
const TIMER0: &str = "TIMER0";
const ADC1_2: &str = "ADC1_2";

/// The firmware that learns what the drive spends: it watches that and adapts the friction level.
pub const LEARNING: &str = "qemu-fixed-adaptation";
pub const LEARNING_FEATURES: &[&str] = &["--features", "adaptation"];

/// The end of a run, which only the emulator's control task has.
const QUIT: &str = "preslide_qemu::quit";

/// What `preslide export` writes of a model with all effects that a controller can use; the tests of the tool keep it.
const EXPORTED: &str = "cli/tests/exported/linear.rs";

/// Names the file of an exported model to a build.
pub const MODEL: &str = "PRESLIDE_MODEL";

/// The packed kernel as it writes it for a controller in I16F16 and in `f32`, and the images with it.
pub const PACKED: [(&str, &str); 2] = [
    ("cli/tests/exported/packed_i16f16.rs", "qemu-packed-fixed"),
    ("cli/tests/exported/packed_f32.rs", "qemu-packed-float"),
];

/// What `track -- koopman-firmware` wrote, for a firmware with an outer task.
const KOOPMAN: &str = "cli/tests/exported/koopman.rs";

const GOLDEN: &str = "firmware/boards/qemu/expected";

/// A run of the motion takes 10 s on a slow machine, the faults two minutes.
const LIMIT: Duration = Duration::from_secs(600);

pub fn run_command(arguments: &[String]) -> Result<(), String> {
    let flag = crate::given("qemu", &["--bless", "--long"], arguments)?;
    let (bless, long) = (flag == Some("--bless"), flag == Some("--long"));
    Need::Qemu.ensure()?;
    Need::ArmGcc.ensure()?;
    // Before the rig, which waits for the host's crates where a lane beside compiles them.
    let images = Images::build(long)?;
    boards()?;
    let rig = build_rig()?;
    for (kind, elf) in &images.variants {
        check_image(kind, elf, TIMER0, &[QUIT])?;
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
    let fixed = &images.fixed;
    hammered(fixed, long)?;
    crate::logged::decoded(&rig, &images.logging)?;
    at_the_tool("typed", fixed)?;
    let pulled = if long { "pulled-everywhere" } else { "pulled" };
    at_the_tool(pulled, fixed)?;
    crate::commission::run(fixed, long)?;
    let golden = root().join(GOLDEN);
    let mut faults = Command::new(&rig);
    faults.arg("faults").arg(fixed).arg(&golden);
    if bless {
        faults.arg("--bless");
    }
    run_for(&mut faults, LIMIT)?;
    let with_learning = "fixed with watch and adaptation";
    check_image(with_learning, &images.learning, TIMER0, &[QUIT])?;
    check_image("koopman", &images.koopman, TIMER0, &[QUIT])?;
    for (what, elf) in [
        ("wear", &images.learning),
        ("winding", fixed),
        // The predictive controller as on the host, and where it is late.
        ("guided", &images.koopman),
    ] {
        run_for(Command::new(&rig).arg(what).arg(elf), LIMIT)?;
    }
    // A capture is identified in the chain, too.
    if long {
        identified(&rig, fixed)
    } else {
        Ok(())
    }
}

/// What runs in the emulator.
struct Images {
    fixed: PathBuf,
    /// Each arithmetic and each law once, or all pairs of them.
    variants: Vec<(&'static str, PathBuf)>,
    /// With its log.
    logging: PathBuf,
    learning: PathBuf,
    /// With the predictive controller as an outer task.
    koopman: PathBuf,
}

impl Images {
    fn build(long: bool) -> Result<Self, String> {
        let packed = |(file, name)| build_with(Some((MODEL, file)), "preslide-qemu", name, &[]);
        let [packed_fixed, packed_float] = PACKED;
        let fixed = build("preslide-qemu", "qemu-fixed", &[])?;
        let mut variants = vec![
            ("fixed", fixed.clone()),
            ("packed-float", packed(packed_float)?),
        ];
        if long {
            let float = build("preslide-qemu", "qemu-float", &["--features", "float"])?;
            variants.extend([("float", float), ("packed-fixed", packed(packed_fixed)?)]);
        }
        let (mut logging, built) = build_command("preslide-qemu")?;
        // Without it defmt compiles in errors alone.
        run(logging.env("DEFMT_LOG", "info").args(["--features", "log"]))?;
        let logging = kept(&built, "qemu-log")?;
        let outer = Some(("PRESLIDE_KOOPMAN", KOOPMAN));
        Ok(Self {
            fixed,
            variants,
            logging,
            learning: build("preslide-qemu", LEARNING, LEARNING_FEATURES)?,
            koopman: build_with(outer, "preslide-qemu", "qemu-koopman", &[])?,
        })
    }
}

/// What cannot be run here, but must build, fit and not panic.
fn boards() -> Result<(), String> {
    let logging = ["check", "--release", "--locked", "--features", "log"];
    let mut check = Toolchain::ensure()?.cargo(&root().join("firmware"), &logging);
    run(check.args(["--package", "preslide-stm32g474"]))?;
    let board = build("preslide-stm32g474", "stm32g474", &[])?;
    check_image("stm32g474", &board, ADC1_2, &[])?;
    check_ccm(&board)?;
    // With a model compiled in that has every effect.
    let (mut exported, board) = build_command("preslide-stm32g474")?;
    run(exported.env(MODEL, root().join(EXPORTED)))?;
    check_image("stm32g474 with an exported model", &board, ADC1_2, &[])?;
    check_ccm(&board)
}

/// A thousand requests, or ten thousand in the long tier, as many at once as the link allows, under telemetry of every tick: all answered, once
/// each.
fn hammered(elf: &Path, long: bool) -> Result<(), String> {
    let mut hammer = Command::new(released("examples/drive"));
    hammer.arg("hammer").arg(elf).arg(free_port()?);
    hammer.arg(if long { "10000" } else { "1000" });
    run_for(&mut hammer, LIMIT)
}

/// Beside an emulated drive, a script that types at `preslide drive`, over a pseudo terminal for the line and in its own terminal; or one that
/// pulls the cable of `preslide commission` in every way, or in every stage.
fn at_the_tool(what: &str, elf: &Path) -> Result<(), String> {
    let mut script = Command::new(released("examples/drive"));
    script.arg(what).arg(elf).arg(free_port()?);
    run_for(script.arg(released("preslide")), LIMIT)
}

/// Serves an emulated drive, the firmware on the simulated stage, to one client after the other.
pub fn serve_command(arguments: &[String]) -> Result<(), String> {
    let port = match arguments {
        [] => "7700",
        [port] if port.parse::<u16>().is_ok() => port,
        _ => {
            return Err(format!(
                "`stage` takes a port or nothing, got `{}`",
                arguments.join(" ")
            ));
        }
    };
    Need::Qemu.ensure()?;
    build_rig()?;
    let fixed = build("preslide-qemu", "qemu-fixed", &[])?;
    let mut serve = Command::new(released("examples/drive"));
    run(serve.arg("serve").arg(fixed).arg(port))
}

/// Builds the program that runs firmware in QEMU against the simulated stage, and the tool; where the former is.
pub fn build_rig() -> Result<PathBuf, String> {
    build_as_tests(&[
        "--bin",
        "preslide",
        "--example",
        "rig",
        "--example",
        "drive",
    ])?;
    Ok(released("examples/rig"))
}

/// Captures the telemetry of a motion in QEMU with the tool, identifies it, and compares with the stage's friction.
fn identified(rig: &Path, elf: &Path) -> Result<(), String> {
    let port = free_port()?;
    let folder = std::env::temp_dir().join(format!("preslide-capture-{}", std::process::id()));
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let (recording, truth) = (folder.join("capture.csv"), folder.join("truth.json"));
    let mut serve = Command::new(rig);
    serve.arg("serve").arg(elf).arg(&port).arg(&truth);
    capture(&mut serve, &port, |tool| {
        run_for(tool.arg("-o").arg(&recording), LIMIT)
    })?;
    let mut judge = Command::new(rig);
    let judged = run_for(judge.arg("judge").arg(&recording).arg(&truth), LIMIT);
    // What stays of a failed run is there to be looked at.
    if judged.is_ok() {
        let _ = std::fs::remove_dir_all(&folder);
    }
    judged
}

/// Starts what serves telemetry at that port, and has `run` finish and run the tool's command that captures it.
pub fn capture(
    serve: &mut Command,
    port: &str,
    run: impl FnOnce(&mut Command) -> Result<(), String>,
) -> Result<(), String> {
    let serving = serve.spawn();
    let mut serving = serving.map_err(|error| format!("the rig did not start: {error}"))?;
    let mut tool = Command::new(released("preslide"));
    tool.args(["capture", &format!("tcp:127.0.0.1:{port}"), "--wait", "20"]);
    let captured = run(&mut tool);
    if captured.is_err() {
        // It has nobody to talk to any more.
        let _ = serving.kill();
    }
    let served = serving.wait().map_err(|error| error.to_string())?;
    captured?;
    if served.success() {
        Ok(())
    } else {
        Err(format!("the rig failed ({served})"))
    }
}

/// Builds a variant of a firmware package; where its image is kept. Cargo has one folder for all of them, so that what they have in
/// common is built once, and the image is copied out of it.
pub fn build(package: &str, name: &str, more: &[&str]) -> Result<PathBuf, String> {
    build_with(None, package, name, more)
}

/// The same with a file compiled in, by the variable that names it: a model that `preslide export` wrote, an outer task's input.
pub fn build_with(
    file: Option<(&str, &str)>,
    package: &str,
    name: &str,
    more: &[&str],
) -> Result<PathBuf, String> {
    let (mut command, built) = build_command(package)?;
    command.args(more);
    if let Some((variable, file)) = file {
        command.env(variable, root().join(file));
    }
    run(&mut command)?;
    kept(&built, name)
}

/// A copy of a built image, which the next variant does not overwrite.
fn kept(built: &Path, name: &str) -> Result<PathBuf, String> {
    let images = built.with_file_name("images");
    let image = images.join(name);
    std::fs::create_dir_all(&images)
        .and_then(|()| std::fs::copy(built, &image))
        .map_err(|error| format!("{}: {error}", image.display()))?;
    Ok(image)
}

/// The command that builds a firmware package, and where the image will be until the next variant is built.
pub fn build_command(package: &str) -> Result<(Command, PathBuf), String> {
    let firmware = root().join("firmware");
    let arguments = ["build", "--release", "--locked", "--package", package];
    let command = Toolchain::ensure()?.cargo(&firmware, &arguments);
    let release = target_of(&firmware).join(TARGET).join("release");
    Ok((command, release.join(package)))
}

/// CCM SRAM of the STM32G474.
const CCM: std::ops::Range<u32> = 0x1000_0000..0x1000_8000;
/// Least stack (bytes): the firmware in QEMU uses up to 6936, as `rig wear` prints, and a quarter more.
const LEAST_STACK: u32 = 8670;

/// Whether the control task, all that it calls and the stack are in CCM SRAM. A panic, which ends the task, may be in flash.
fn check_ccm(elf: &Path) -> Result<(), String> {
    let reached = call_graph::reached(&disassembly(elf)?, ADC1_2, &[])?;
    // The linker reaches flash from there through veneers only, which it names.
    let left: Vec<&String> = reached
        .iter()
        .filter(|(at, name)| name.contains("Thunk") || !CCM.contains(at))
        .map(|(_, name)| name)
        .filter(|name| !name.contains("panic"))
        .collect();
    if !left.is_empty() {
        return Err(format!(
            "{ADC1_2} runs in CCM SRAM but calls {left:?} outside; add them to firmware/boards/stm32g474/ccm.x"
        ));
    }
    let symbols = output(Command::new("arm-none-eabi-nm").arg(elf))?;
    let address = |name: &str| {
        let line = symbols.lines().find(|line| line.ends_with(name))?;
        u32::from_str_radix(line.split(' ').next()?, 16).ok()
    };
    let stack = [" _stack_end", " _stack_start"].map(address);
    let left = match stack {
        [Some(low), Some(high)] if high == CCM.end => high.saturating_sub(low),
        _ => {
            return Err(format!(
                "the stack {stack:x?} does not begin at the end of CCM SRAM"
            ));
        }
    };
    if left < LEAST_STACK {
        return Err(format!(
            "{left} bytes of CCM SRAM are left for the stack, fewer than {LEAST_STACK}; take from ccm.x what the interrupt does not reach"
        ));
    }
    println!(
        "stm32g474: {ADC1_2} and the {} functions that it calls are in CCM SRAM, and so is the stack of {} bytes (checked by address; \
         it cannot be run here)",
        reached.len() - 1,
        left
    );
    Ok(())
}

fn disassembly(elf: &Path) -> Result<String, String> {
    output(
        Command::new("arm-none-eabi-objdump")
            .args(["--disassemble", "--demangle"])
            .arg(elf),
    )
}

/// Flash and RAM of an image, and whether its control task, but for what is `beyond`, can panic.
pub fn check_image(kind: &str, elf: &Path, task: &str, beyond: &[&str]) -> Result<(), String> {
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
    let reached = call_graph::reached(&disassembly(elf)?, task, beyond)?;
    let panics = reached.values().filter(|name| name.contains("panic"));
    let panics: Vec<&String> = panics.collect();
    if !panics.is_empty() {
        return Err(format!("{kind}: the interrupt {task} can reach {panics:?}"));
    }
    println!(
        "{kind}: {} functions reached from the interrupt {task}, none of them panics",
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
