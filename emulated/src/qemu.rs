//! `cargo xtask qemu`: the firmware in an emulator against the simulated stage.
//!
//! Builds the QEMU board in both arithmetics, in one with the packed kernel (in both with `--long`), shows that its control code has no panic path, prints flash, RAM and
//! stack, runs the same motion twice in QEMU and once on the host, sends a thousand requests (ten thousand with `--long`) under full telemetry, injects the
//! faults, lets the stage wear under a firmware that watches it and its winding be warm under one that follows it, and with `--long` identifies the stage's friction from captured telemetry.
//! `cargo xtask stage` only serves the emulated drive.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Context as _, Result, bail, ensure};
use preslide_tools::checked::{self, ADC1_2};
use preslide_tools::image::{MODEL, PACKED, build, build_command, build_rig, kept};
use preslide_tools::need::Need;
use preslide_tools::process::{free_port, output_for, released, root, run, run_for, with_folder};
use preslide_tools::thumb::Toolchain;

/// The interrupt of the control task; nothing that can panic may be reached from it, but for the end of a run, which only the emulator's has.
const TIMER0: &str = "TIMER0";
const QUIT: &str = "preslide_qemu::quit";

/// What `preslide export` writes of a model with all effects that a controller can use; the tests of the tool keep it.
const EXPORTED: &str = "cli/tests/exported/linear.rs";

/// What `track -- koopman-firmware` wrote, for a firmware with an outer task.
const KOOPMAN: &str = "cli/tests/exported/koopman.rs";

const GOLDEN: &str = "firmware/boards/qemu/expected";

/// A run of the motion takes 10 s on a slow machine, the faults two minutes.
const LIMIT: Duration = Duration::from_secs(600);

/// With `--bless`, `--long` or neither.
pub fn run_command(flag: Option<&str>) -> Result<()> {
    let (bless, long) = (flag == Some("--bless"), flag == Some("--long"));
    Need::Qemu.ensure()?;
    Need::ArmGcc.ensure()?;
    // Before the rig, which waits for the host's crates where a lane beside compiles them.
    let images = Images::build(long)?;
    boards()?;
    let rig = build_rig()?;
    for (kind, elf) in &images.variants {
        checked::image(kind, elf, TIMER0, &[QUIT])?;
        let once = || output_for(Command::new(&rig).arg(kind).arg(elf), LIMIT);
        let (first, _) = once()?;
        print!("{first}");
        let (second, _) = once()?;
        ensure!(
            first == second,
            "two runs of `{kind}` print different bytes:\n{first}{second}"
        );
        println!("{kind}: the second run printed the same bytes");
    }
    let fixed = &images.fixed;
    // All requests are answered, once each, as many at once as the link allows, under telemetry of every tick.
    let requests = if long { "10000" } else { "1000" };
    at_the_drive("hammer", fixed, requests.as_ref())?;
    crate::logged::decoded(&rig, &images.logging)?;
    // A script that types at `preslide drive`, over a pseudo terminal for the line and in its own terminal; and one that pulls the cable of
    // `preslide commission` in every way, or in every stage.
    let pulled = if long { "pulled-everywhere" } else { "pulled" };
    for script in ["typed", pulled] {
        at_the_drive(script, fixed, &released("preslide"))?;
    }
    crate::commission::run(fixed, long)?;
    let mut faults = Command::new(&rig);
    faults.arg("faults").arg(fixed).arg(root().join(GOLDEN));
    run_for(faults.args(bless.then_some("--bless")), LIMIT)?;
    let with_learning = "fixed with watch and adaptation";
    checked::image(with_learning, &images.learning, TIMER0, &[QUIT])?;
    checked::image("koopman", &images.koopman, TIMER0, &[QUIT])?;
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
    /// It watches what the drive spends and adapts the friction level.
    learning: PathBuf,
    /// With the predictive controller as an outer task.
    koopman: PathBuf,
}

impl Images {
    fn build(long: bool) -> Result<Self> {
        let packed = |(file, name)| build(name, "", Some((MODEL, file)));
        let [packed_fixed, packed_float] = PACKED;
        let fixed = build("qemu-fixed", "", None)?;
        let mut variants = vec![
            ("fixed", fixed.clone()),
            ("packed-float", packed(packed_float)?),
        ];
        if long {
            let float = build("qemu-float", "--features float", None)?;
            variants.extend([("float", float), ("packed-fixed", packed(packed_fixed)?)]);
        }
        let (mut logging, built) = build_command("preslide-qemu")?;
        // Without it defmt compiles in errors alone.
        run(logging.env("DEFMT_LOG", "info").args(["--features", "log"]))?;
        let logging = kept(&built, "qemu-log")?;
        Ok(Self {
            fixed,
            variants,
            logging,
            learning: build("qemu-fixed-adaptation", "--features adaptation", None)?,
            koopman: build("qemu-koopman", "", Some(("PRESLIDE_KOOPMAN", KOOPMAN)))?,
        })
    }
}

/// What cannot be run here, but must build, fit and not panic.
fn boards() -> Result<()> {
    let logging = "check --release --locked --features log --package preslide-stm32g474";
    run(&mut Toolchain::ensure()?.cargo(&root().join("firmware"), logging))?;
    // And with a model compiled in that has every effect.
    for (kind, model) in [
        ("stm32g474", None),
        ("stm32g474 with an exported model", Some(EXPORTED)),
    ] {
        let (mut build, board) = build_command("preslide-stm32g474")?;
        run(build.envs(model.map(|file| (MODEL, root().join(file)))))?;
        checked::image(kind, &board, ADC1_2, &[])?;
        checked::ccm(&board)?;
    }
    Ok(())
}

/// Does something, told more, beside an emulated drive.
fn at_the_drive(what: &str, elf: &Path, more: &Path) -> Result<()> {
    let mut script = Command::new(released("examples/drive"));
    script.arg(what).arg(elf).arg(free_port()?);
    run_for(script.arg(more), LIMIT)
}

/// Serves an emulated drive, the firmware on the simulated stage, to one client after the other.
pub fn serve_command(arguments: &[String]) -> Result<()> {
    let port = match arguments {
        [] => "7700",
        [port] if port.parse::<u16>().is_ok() => port,
        _ => bail!("it takes a port or nothing, got `{}`", arguments.join(" ")),
    };
    Need::Qemu.ensure()?;
    build_rig()?;
    let fixed = build("qemu-fixed", "", None)?;
    let mut serve = Command::new(released("examples/drive"));
    run(serve.arg("serve").arg(fixed).arg(port))
}

/// Captures the telemetry of a motion in QEMU with the tool, identifies it, and compares with the stage's friction.
fn identified(rig: &Path, elf: &Path) -> Result<()> {
    with_folder("capture", |folder| {
        let port = free_port()?;
        let (recording, truth) = (folder.join("capture.csv"), folder.join("truth.json"));
        let mut serve = Command::new(rig);
        serve.arg("serve").arg(elf).arg(&port).arg(&truth);
        capture(&mut serve, &port, |tool| {
            run_for(tool.arg("-o").arg(&recording), LIMIT)
        })?;
        let mut judge = Command::new(rig);
        run_for(judge.arg("judge").arg(recording).arg(truth), LIMIT)
    })
}

/// Starts what serves telemetry at that port, and has `run` finish and run the tool's command that captures it.
pub fn capture(
    serve: &mut Command,
    port: &str,
    run: impl FnOnce(&mut Command) -> Result<()>,
) -> Result<()> {
    let mut serving = serve.spawn().context("the rig did not start")?;
    let mut tool = Command::new(released("preslide"));
    tool.args(["capture", &format!("tcp:127.0.0.1:{port}"), "--wait", "20"]);
    let captured = run(&mut tool);
    if captured.is_err() {
        // It has nobody to talk to any more.
        let _ = serving.kill();
    }
    let served = serving.wait()?;
    captured?;
    ensure!(served.success(), "the rig failed ({served})");
    Ok(())
}
