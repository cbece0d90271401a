//! What `cargo xtask test` checks, each step with its reason.

use std::time::Duration;

use anyhow::{Result, ensure};
use preslide_cycle_tables as cycles;
use preslide_tools::checked;
use preslide_tools::need::Need;
use preslide_tools::process::{
    cargo, command, output, root, run, run_counting, run_for, target_of, with_folder,
};
use preslide_tools::thumb::{TARGET, Toolchain};

pub struct Step {
    pub name: &'static str,
    pub reason: &'static str,
    pub needs: &'static [Need],
    pub lane: Lane,
    pub run: fn(Tier) -> Result<()>,
}

/// How much of a step runs.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Tier {
    /// What everyone and CI runs: a quarter of an hour is the aim.
    Gate,
    /// With the long studies, before a release.
    All,
}

impl Tier {
    /// One thing in the gate, another with the long studies.
    fn pick<T>(self, gate: T, all: T) -> T {
        match self {
            Self::Gate => gate,
            Self::All => all,
        }
    }
}

/// Steps of two lanes run beside each other: fat link-time optimisation and an emulator keep one core busy, and leave another to the host's tests.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Lane {
    /// What the workspace's crates are checked by; its output is shown as it comes.
    Host,
    /// What is built for microcontrollers and runs in an emulator, one at a time, since all images come from one folder;
    /// its output goes to a file and is shown where it failed.
    Beside,
    /// What needs neither: the lane that has ended runs it, so that no core waits for the longer lane. Its output is that of `Beside`.
    Free,
}

/// In each lane cheap checks first: a formatting slip shows before a minute of compiling.
pub const STEPS: &[Step] = &[
    Step {
        name: "format",
        reason: "one style, so that diffs show only what changed",
        needs: &[Need::Rustfmt],
        lane: Lane::Host,
        run: |_| format(),
    },
    Step {
        name: "imports",
        reason: "no circle of imports, and each room imports only what ARCHITECTURE.md places above it",
        needs: &[],
        lane: Lane::Host,
        run: |_| crate::imports::check(),
    },
    Step {
        name: "clippy",
        reason: "warnings of the compiler and of clippy are errors; clippy's in tests, examples and benches before a release",
        needs: &[Need::Clippy],
        lane: Lane::Host,
        run: clippy,
    },
    Step {
        name: "docs",
        reason: "every public item is documented and no link is broken",
        needs: &[],
        lane: Lane::Host,
        run: |_| {
            let line = "doc --release --workspace --no-deps";
            run(cargo(line).env("RUSTDOCFLAGS", "-D warnings"))
        },
    },
    Step {
        name: "tests",
        reason: "the models against the reference, the host tool on recordings and bad input",
        needs: &[],
        lane: Lane::Host,
        run: host_tests,
    },
    Step {
        name: "formats",
        reason: "the optional readers (HDF5, Parquet, MCAP, …) read files that other tools wrote",
        needs: &[],
        lane: Lane::Host,
        run: |_| {
            let line = "test --release -p preslide-fit --features formats --test formats";
            run(&mut cargo(line))
        },
    },
    Step {
        name: "thumb",
        reason: "the library builds without std for four kinds of microcontrollers",
        needs: &[],
        lane: Lane::Beside,
        run: thumb_build,
    },
    Step {
        name: "example",
        reason: "the example to copy first sets its clock, refuses another, and computes its model's force in QEMU, as that for RISC-V does; before a release the others link",
        needs: &[Need::Qemu, Need::QemuRiscv],
        lane: Lane::Beside,
        run: |tier| {
            preslide_emulated::example::run_in_qemu()?;
            preslide_emulated::example_riscv::run_in_qemu()?;
            match tier {
                Tier::Gate => Ok(()),
                Tier::All => preslide_emulated::example::link_others(),
            }
        },
    },
    Step {
        name: "firmware",
        reason: "the firmware builds and links for every board without a warning (the Pico 2 before a release); no control task can panic, and the boards' common parts pass their tests",
        needs: &[Need::Clippy, Need::ArmGcc],
        lane: Lane::Beside,
        run: firmware,
    },
    Step {
        name: "cycles",
        reason: "no kernel executes more instructions than the committed table says",
        needs: &[Need::Qemu, Need::ArmGcc],
        lane: Lane::Beside,
        run: |tier| cycles::run_command(Some(tier.pick("--check", "--recount"))),
    },
    Step {
        name: "qemu",
        reason: "the firmware in QEMU gives the host's commands, and every fault ends in the safe state",
        needs: &[Need::Qemu, Need::ArmGcc],
        lane: Lane::Beside,
        run: |tier| preslide_emulated::qemu::run_command(tier.pick(None, Some("--long"))),
    },
    Step {
        name: "chain",
        reason: "effects that only the stage knows are named, compiled into the firmware and compensated",
        needs: &[Need::Qemu],
        lane: Lane::Beside,
        run: |tier| {
            // One effect, named and tracked close to what is possible, by the kernel that is recommended for the board's core.
            let short = ["--count", "1", "--kernel", "packed_f32", "--brief"].map(str::to_owned);
            preslide_emulated::chain::run_command(tier.pick(&short, &[]))
        },
    },
    Step {
        name: "miri",
        reason: "an interpreter finds nothing undefined in the library's tests of numbers and kernels",
        needs: &[],
        lane: Lane::Beside,
        run: |_| miri(),
    },
    Step {
        name: "package",
        reason: "the published crate holds the library alone, and builds with the oldest compiler that it promises",
        needs: &[],
        lane: Lane::Host,
        run: |_| crate::package::check(),
    },
    Step {
        name: "python",
        reason: "the Python package installs as its README says, and its functions answer as the tool does",
        needs: &[Need::Python],
        lane: Lane::Free,
        run: |tier| crate::python::check(tier == Tier::All),
    },
    Step {
        name: "trials",
        reason: "the diagnosis on a fixed set of every source: each answer is the committed one",
        needs: &[],
        lane: Lane::Free,
        run: |tier| {
            let set = ["--ci", tier.pick("gate", "whole")].map(str::to_owned);
            crate::judge::judge("sources", &set)
        },
    },
    Step {
        name: "demo",
        reason: "the first command of the README works, and a browser draws its report",
        needs: &[Need::Chromium],
        lane: Lane::Host,
        run: |_| demo(),
    },
    Step {
        name: "book",
        reason: "the book builds without a warning, its commands work and print what it says",
        needs: &[],
        lane: Lane::Host,
        run: |_| crate::book::run_command(false, has_step),
    },
];

/// Steps that run where they are named, and not with the whole: the optional readers take ten minutes of one core to compile, and the
/// interpreter is a nightly compiler's.
pub const APART: &[&str] = &["formats", "miri"];

/// Whether CI has a step of this name.
pub fn has_step(name: &str) -> bool {
    STEPS.iter().any(|step| step.name == name)
}

fn format() -> Result<()> {
    let firmware = FIRMWARE.iter().map(|(folder, _)| *folder);
    let mut folders = ["", "examples"].into_iter().chain(firmware);
    folders.try_for_each(|folder| run(cargo("fmt --all --check").current_dir(root().join(folder))))
}

/// Without the benchmarks but in the long tier: nothing else needs their nineteen crates, which have features of serde that no other step has.
/// Nor the tests, which would type-check each crate a second time: the compiler's warnings on them fail the step that builds them.
fn clippy(tier: Tier) -> Result<()> {
    let what = tier.pick("--exclude preslide-bench", "--all-targets");
    let line = format!("clippy --release --workspace {what} -- -D warnings");
    run(&mut cargo(&line))
}

/// In the profile of demo and judges, so that the host is compiled once. A test whose data is absent says so in a line of its own, past the
/// harness that keeps what passing tests print.
fn host_tests(tier: Tier) -> Result<()> {
    // Without the benchmarks: with the features that their crates ask of serde, all that stands on it is compiled again.
    let tests = "test --release --workspace --exclude preslide-bench";
    // Not `--bins`, which makes a test of every program that has none. By itself, so that its minutes are seen.
    let mut build = cargo(&format!("{tests} --tests --no-run"));
    let warnings = run_counting(&mut build, "warning: ")?;
    ensure!(warnings == 0, "{warnings} warnings of the compiler");
    let more = tier.pick("", "-- --include-ignored");
    let mut programs = cargo(&format!("{tests} --tests --no-fail-fast {more}"));
    let skipped = run_counting(&mut programs, "SKIPPED");
    run(&mut cargo(&format!("{tests} --doc")))?;
    println!("{} tests skipped for want of data", skipped?);
    Ok(())
}

/// Without the two tests that try every pair of some hundred numbers: the first of them had not ended after five minutes.
fn miri() -> Result<()> {
    let nightly = |line: &str| {
        let mut command = command(&format!("cargo +nightly miri {line}"));
        command.current_dir(root()).env_remove("RUSTUP_TOOLCHAIN");
        command
    };
    if output(&mut nightly("--version")).is_err() {
        let install =
            "rustup toolchain install nightly --profile minimal --component miri,rust-src";
        if let Err(reason) = run_for(&mut command(install), Duration::from_secs(300)) {
            println!("SKIPPED: Miri has NOT looked at the library: {reason:#}");
            return Ok(());
        }
    }
    let tests = "test --package preslide --lib -- --skip fixed_point_gives --skip halves_give";
    run(&mut nightly(tests))
}

/// Beside the firmware's builds: cargo lets one command at a time into a folder, and the host's are at work in the other.
fn thumb_build(tier: Tier) -> Result<()> {
    let folder = target_of(&root().join("firmware"));
    let checked = tier.pick("check", "build");
    for (target, what) in [
        // Cores that the kernels multiply otherwise on, in assembly.
        (TARGET, "build"),
        ("thumbv8m.main-none-eabihf", "build"),
        // And two of another kind.
        ("thumbv6m-none-eabi", checked),
        ("riscv32imac-unknown-none-elf", checked),
    ] {
        let line = format!("{what} --release --package preslide --all-features");
        if let Some(toolchain) = who_builds("the library", target)? {
            let mut build = toolchain.cargo_for(target, root(), &line);
            run(build.arg("--target-dir").arg(&folder))?;
        }
    }
    Ok(())
}

/// The workspaces of the firmware, and what they are built for: a chip's drivers cannot be built beside another's.
const FIRMWARE: [(&str, &str); 3] = [
    ("firmware", TARGET),
    ("firmware/boards/b_g431b_esc1", TARGET),
    ("firmware/boards/pico2", "thumbv8m.main-none-eabihf"),
];

/// Who builds for a target, if anybody can: the reference's must be built.
fn who_builds(what: &str, target: &str) -> Result<Option<Toolchain>> {
    match target {
        TARGET => Toolchain::ensure().map(Some),
        _ => Ok(Toolchain::or_skipped(target, what)),
    }
}

/// What a board is put together by is tested where the test runs, and each board is built; the Pico 2, whose chip's crates take two minutes, in
/// the long tier. Debian's compiler comes without clippy for the target: it builds, which warns of less.
fn firmware(tier: Tier) -> Result<()> {
    let firmware = root().join("firmware");
    run(cargo("test --locked --package preslide-app").current_dir(&firmware))?;
    let workspaces = &FIRMWARE[..tier.pick(FIRMWARE.len() - 1, FIRMWARE.len())];
    for (folder, target) in workspaces {
        let Some(toolchain) = who_builds(folder, target)? else {
            continue;
        };
        let (what, denied) = match toolchain {
            Toolchain::Installed => ("clippy", "-- -D warnings"),
            Toolchain::Debian => ("build", ""),
        };
        let line = format!("{what} --release --locked --workspace");
        let mut command = toolchain.cargo_for(target, &root().join(folder), &line);
        run(command.args(denied.split_whitespace()))?;
    }
    // Those of no other step are linked, too, which clippy does not: a program may not fit, lack a symbol, or reach a panic.
    let programs = [
        ("preslide-b-g431b-esc1", "ADC1_2"),
        ("preslide-pico2", "PWM_IRQ_WRAP_0"),
    ];
    for ((folder, target), (program, task)) in workspaces[1..].iter().zip(programs) {
        let Some(toolchain) = who_builds(folder, target)? else {
            continue;
        };
        let line = "build --release --locked";
        run(&mut toolchain.cargo_for(target, &root().join(folder), line))?;
        let built = target_of(&firmware).join(target).join("release");
        checked::image(program, &built.join(program), task, &[])?;
    }
    Ok(())
}

fn demo() -> Result<()> {
    with_folder("demo", |folder| {
        run(cargo("run --release -- demo --out").arg(folder))?;
        crate::browser::check(&folder.join("report.html"))
    })
}
