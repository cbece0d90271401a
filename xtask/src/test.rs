//! `cargo xtask test`: the checks of CI in two lanes, each check with its reason, and a summary.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::changed;
use crate::cycles;
use crate::process::{cargo, output, root, run, run_counting};
use crate::thumb::Toolchain;
use crate::tools::Need;

struct Step {
    name: &'static str,
    reason: &'static str,
    needs: &'static [Need],
    /// What it checks: beginnings of paths, for `--changed`.
    paths: &'static [&'static str],
    lane: Lane,
    run: fn() -> Result<(), String>,
}

/// Steps of two lanes run beside each other: fat link-time optimisation and an emulator keep one core busy, and leave another to the host's tests.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Lane {
    /// What the workspace's crates are checked by; its output is shown as it comes.
    Host,
    /// What is built for microcontrollers and runs in an emulator; its output goes to a file and is shown where it failed.
    Emulator,
}

/// The library and what the firmware builds it from.
const LIBRARY: &[&str] = &["src/", "build.rs"];
const FIRMWARE_PATHS: &[&str] = &["src/", "build.rs", "axis", "link/", "store/", "firmware/"];
/// The crates of the workspace.
const WORKSPACE: &[&str] = &[
    "src/",
    "build.rs",
    "axis",
    "link/",
    "store/",
    "drive/",
    "host/",
    "host-tests/",
    "sim/",
    "cli/",
    "examples/",
    "firmware/",
];
/// The program, and what it is made of.
const PROGRAM: &[&str] = &["src/", "axis", "link/", "drive/", "host/", "sim/", "cli/"];
/// What runs the firmware beside the host.
const RIG: &[&str] = &[
    "src/",
    "build.rs",
    "axis",
    "link/",
    "store/",
    "firmware/",
    "host/",
    "sim/",
    "cli/",
];
const JUDGED: &[&str] = &["src/", "host/", "sim/", "cli/", "host-tests/"];

/// In each lane cheap checks first: a formatting slip shows before a minute of compiling.
const STEPS: &[Step] = &[
    Step {
        name: "format",
        reason: "one style, so that diffs show only what changed",
        needs: &[Need::Rustfmt],
        paths: WORKSPACE,
        lane: Lane::Host,
        run: format,
    },
    Step {
        name: "imports",
        reason: "no circle of imports, and each room imports only what ARCHITECTURE.md places above it",
        needs: &[],
        paths: &[
            "src/",
            "host/",
            "sim/",
            "drive/",
            "cli/",
            "link/",
            "store/",
            "axis/",
            "host-tests/",
            "firmware/",
            "ARCHITECTURE.md",
        ],
        lane: Lane::Host,
        run: || crate::imports::run_command(&[]),
    },
    Step {
        name: "clippy",
        reason: "the compiler's and clippy's warnings are errors, in tests, examples and benches, too",
        needs: &[Need::Clippy],
        paths: WORKSPACE,
        lane: Lane::Host,
        run: || {
            run(&mut cargo(&[
                "clippy",
                "--workspace",
                "--all-targets",
                "--",
                "-D",
                "warnings",
            ]))
        },
    },
    Step {
        name: "docs",
        reason: "every public item is documented and no link is broken",
        needs: &[],
        paths: WORKSPACE,
        lane: Lane::Host,
        run: || run(cargo(&["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings")),
    },
    Step {
        name: "tests",
        reason: "the models against the reference, the host tool on recordings and bad input",
        needs: &[],
        paths: WORKSPACE,
        lane: Lane::Host,
        run: host_tests,
    },
    Step {
        name: "formats",
        reason: "the optional readers (HDF5, Parquet, MCAP, …) read files that other tools wrote",
        needs: &[],
        paths: &["host/src/recording/", "host/tests/", "host/Cargo.toml"],
        lane: Lane::Host,
        run: || {
            let readers = ["--features", "formats", "--test", "formats"];
            run(cargo(&["test", "-p", "preslide-host"]).args(readers))
        },
    },
    Step {
        name: "thumb",
        reason: "the library builds without std for the microcontroller",
        needs: &[],
        paths: LIBRARY,
        lane: Lane::Emulator,
        run: thumb_build,
    },
    Step {
        name: "firmware",
        reason: "the firmware workspace builds for the microcontroller, warnings denied",
        needs: &[Need::Clippy, Need::ArmGcc],
        paths: FIRMWARE_PATHS,
        lane: Lane::Emulator,
        run: firmware,
    },
    Step {
        name: "cycles",
        reason: "no kernel executes more instructions than the committed table says",
        needs: &[Need::Qemu, Need::ArmGcc],
        paths: &["src/", "build.rs", "firmware/"],
        lane: Lane::Emulator,
        run: || cycles::run_command(&["--check".to_string()]),
    },
    Step {
        name: "qemu",
        reason: "the firmware in QEMU gives the host's commands, and every fault ends in the safe state",
        needs: &[Need::Qemu, Need::ArmGcc],
        paths: RIG,
        lane: Lane::Emulator,
        run: || crate::qemu::run_command(&[]),
    },
    Step {
        name: "chain",
        reason: "effects that only the stage knows of are named, compiled into the firmware and compensated",
        needs: &[Need::Qemu],
        paths: RIG,
        lane: Lane::Emulator,
        run: crate::chain::gate,
    },
    Step {
        name: "trials",
        reason: "the diagnosis on a fixed set of every source: no figure behind the committed ones by more than chance",
        needs: &[],
        paths: JUDGED,
        lane: Lane::Host,
        run: crate::trials::gate,
    },
    Step {
        name: "package",
        reason: "the published crate holds the library and nothing else",
        needs: &[],
        paths: &["src/", "build.rs", "README.md", "CHANGELOG.md", "LICENSE"],
        lane: Lane::Host,
        run: package_list,
    },
    Step {
        name: "demo",
        reason: "the first command of the README works, and a browser draws its report",
        needs: &[Need::Chromium],
        paths: PROGRAM,
        lane: Lane::Host,
        run: demo,
    },
    Step {
        name: "book",
        reason: "the book builds without a warning, its commands work and print what it says",
        needs: &[],
        paths: &[
            "docs/",
            "README.md",
            "src/",
            "axis",
            "link/",
            "drive/",
            "host/",
            "sim/",
            "cli/",
            "firmware/",
        ],
        lane: Lane::Host,
        run: || crate::book::run_command(&[], has_step),
    },
];

/// Steps that run where they are named or touched, and not with the whole: the optional readers take ten minutes of one core to compile.
const APART: &[&str] = &["formats"];

/// Whether CI has a step of this name.
pub fn has_step(name: &str) -> bool {
    STEPS.iter().any(|step| step.name == name)
}

/// Runs every step but those of [`APART`], those named, or those that `--changed [BASE]` touches; behind `--serial` one after the other.
pub fn run_steps(arguments: &[String]) -> Result<(), String> {
    let (serial, arguments) = match arguments {
        [flag, rest @ ..] if flag == "--serial" => (true, rest),
        all => (false, all),
    };
    let names = match arguments {
        [flag, base @ ..] if flag == "--changed" => {
            let base = match base {
                [] => "HEAD",
                [base] => base,
                _ => return Err("--changed takes one commit or branch".to_owned()),
            };
            touched_since(base)?
        }
        _ => arguments.to_vec(),
    };
    if names.is_empty() && !arguments.is_empty() {
        println!("nothing that a step checks has changed");
        return Ok(());
    }
    let chosen = named(&names)?;
    // Packages are installed before anything runs beside something else; what cannot be had fails its step.
    for need in chosen.iter().flat_map(|step| step.needs) {
        let _ = need.ensure();
    }
    summarise(&if serial {
        chosen.iter().map(|step| shown(step)).collect()
    } else {
        in_lanes(&chosen)
    })
}

/// The steps that the changes since `base` touch, said with the files.
fn touched_since(base: &str) -> Result<Vec<String>, String> {
    let files = changed::files(base)?;
    let (chosen, left): (Vec<&Step>, Vec<&Step>) = STEPS
        .iter()
        .partition(|step| changed::touches(&files, step.paths));
    let names = |steps: &[&Step]| steps.iter().map(|s| s.name.to_owned()).collect::<Vec<_>>();
    println!(
        "{} files differ from {base}; left out: {}",
        files.len(),
        names(&left).join(", ")
    );
    Ok(names(&chosen))
}

/// Those named, or all but those of [`APART`] where none is.
fn named(names: &[String]) -> Result<Vec<&'static Step>, String> {
    if let Some(name) = names.iter().find(|name| !has_step(name)) {
        let known: Vec<&str> = STEPS.iter().map(|step| step.name).collect();
        return Err(format!(
            "there is no step `{name}`; the steps are {}",
            known.join(", ")
        ));
    }
    let is_meant = |step: &&Step| match names {
        [] => !APART.contains(&step.name),
        names => names.iter().any(|name| name == step.name),
    };
    Ok(STEPS.iter().filter(is_meant).collect())
}

/// A step's name, how long it took, and how it ended.
type Ended = (&'static str, Duration, Result<(), String>);

/// Both lanes at a time, each in its order.
fn in_lanes(chosen: &[&'static Step]) -> Vec<Ended> {
    let (host, emulator): (Vec<&Step>, Vec<&Step>) =
        chosen.iter().partition(|step| step.lane == Lane::Host);
    if host.is_empty() || emulator.is_empty() {
        return chosen.iter().map(|step| shown(step)).collect();
    }
    std::thread::scope(|scope| {
        let beside = scope.spawn(|| emulator.iter().map(|step| logged(step)).collect::<Vec<_>>());
        let mut ended: Vec<Ended> = host.iter().map(|step| shown(step)).collect();
        ended.extend(
            beside
                .join()
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
        );
        ended
    })
}

/// Runs a step with its output as it comes.
fn shown(step: &Step) -> Ended {
    println!("\n== {}: {}", step.name, step.reason);
    let start = Instant::now();
    let needs = step.needs.iter().try_for_each(|need| need.ensure());
    let result = needs.and_then(|()| (step.run)());
    if let Err(reason) = &result {
        println!("FAILED: {reason}");
    }
    (step.name, start.elapsed(), result)
}

/// Runs a step as a program of its own, whose output goes to a file; all of it is shown where it failed, and else what was skipped.
fn logged(step: &Step) -> Ended {
    let log = root().join(format!("target/test/{}.log", step.name));
    println!("\n== beside: {}: {}", step.name, step.reason);
    let start = Instant::now();
    let result = into_log(step, &log);
    let time = start.elapsed();
    let text = std::fs::read_to_string(&log).unwrap_or_default();
    let seconds = time.as_secs();
    match &result {
        Ok(()) => {
            println!(
                "\n== {} ended well after {seconds} s; {}",
                step.name,
                log.display()
            );
            for line in text.lines().filter(|line| line.starts_with("SKIPPED")) {
                println!("{line}");
            }
        }
        Err(_) => println!(
            "\n== {} FAILED after {seconds} s:\n{text}\n== end of {}",
            step.name, step.name
        ),
    }
    (step.name, time, result)
}

fn into_log(step: &Step, log: &Path) -> Result<(), String> {
    let told = |error: std::io::Error| format!("{}: {error}", log.display());
    std::fs::create_dir_all(root().join("target/test")).map_err(told)?;
    let file = std::fs::File::create(log).map_err(told)?;
    let this = std::env::current_exe().map_err(told)?;
    let mut command = Command::new(this);
    command
        .args(["test", "--serial", step.name])
        .stdin(Stdio::null());
    let status = command
        .stdout(file.try_clone().map_err(told)?)
        .stderr(file)
        .status();
    match status.map_err(told)?.success() {
        true => Ok(()),
        false => Err(format!("see {}", log.display())),
    }
}

/// A later step runs even if an earlier one failed: one run shows everything that is wrong.
fn summarise(results: &[Ended]) -> Result<(), String> {
    println!("\n{:<10} {:>8}  result", "step", "seconds");
    for (name, time, result) in results {
        let word = if result.is_ok() { "ok" } else { "FAILED" };
        println!("{name:<10} {:>8.1}  {word}", time.as_secs_f64());
    }
    say_if_recordings_are_absent();
    let failed: Vec<&str> = results
        .iter()
        .filter(|(_, _, result)| result.is_err())
        .map(|(name, _, _)| *name)
        .collect();
    if failed.is_empty() {
        Ok(())
    } else {
        Err(format!("failed: {}", failed.join(", ")))
    }
}

/// Printed here as well as by the tests themselves, whose output cargo captures when they pass.
fn say_if_recordings_are_absent() {
    if !root().join("../shared/recordings").is_dir() {
        println!(
            "SKIPPED: ../shared/recordings is absent; the tests on real recordings did not run"
        );
    }
}

fn format() -> Result<(), String> {
    let folders = FIRMWARE.map(|folder| root().join(folder));
    for folder in [root().to_path_buf()].into_iter().chain(folders) {
        run(cargo(&["fmt", "--all", "--check"]).current_dir(folder))?;
    }
    Ok(())
}

/// A test whose data is absent says so in a line of its own, past the harness that keeps what passing tests print.
fn host_tests() -> Result<(), String> {
    let skipped = run_counting(
        &mut cargo(&["test", "--workspace", "--no-fail-fast"]),
        "SKIPPED",
    )?;
    println!("{skipped} tests skipped for want of data");
    Ok(())
}

fn thumb_build() -> Result<(), String> {
    let toolchain = Toolchain::ensure()?;
    run(&mut toolchain.cargo(
        root(),
        &[
            "build",
            "--release",
            "--package",
            "preslide",
            "--all-features",
        ],
    ))
}

/// The workspaces of the firmware: a chip's drivers cannot be built beside another's.
const FIRMWARE: [&str; 2] = ["firmware", "firmware/boards/b_g431b_esc1"];

/// Debian's compiler comes without clippy for the target: it builds, which warns of less.
fn firmware() -> Result<(), String> {
    let toolchain = Toolchain::ensure()?;
    let (what, denied): (_, &[&str]) = match toolchain {
        Toolchain::Installed => ("clippy", &["--", "-D", "warnings"]),
        Toolchain::Debian => ("build", &[]),
    };
    for folder in FIRMWARE {
        let arguments = [what, "--release", "--locked", "--workspace"];
        let mut command = toolchain.cargo(&root().join(folder), &arguments);
        run(command.args(denied))?;
    }
    Ok(())
}

fn package_list() -> Result<(), String> {
    // A developer's tree is usually dirty; the list is the same.
    let list = output(&mut cargo(&[
        "package",
        "--list",
        "--allow-dirty",
        "--package",
        "preslide",
    ]))?;
    let made_by_cargo = [
        "Cargo.toml",
        "Cargo.toml.orig",
        "Cargo.lock",
        ".cargo_vcs_info.json",
    ];
    let belongs = |path: &str| {
        path.starts_with("src/")
            || path.starts_with("LICENSE-")
            || path == "build.rs"
            || path == "README.md"
            || path == "CHANGELOG.md"
            || made_by_cargo.contains(&path)
    };
    let strangers: Vec<&str> = list.lines().filter(|path| !belongs(path)).collect();
    if !strangers.is_empty() {
        return Err(format!(
            "the package would hold {}; narrow `include` in the root Cargo.toml",
            strangers.join(", ")
        ));
    }
    for path in ["src/lib.rs", "README.md", "LICENSE-MIT", "LICENSE-APACHE"] {
        if !list.lines().any(|line| line == path) {
            return Err(format!(
                "the package lacks {path}; see `include` in the root Cargo.toml"
            ));
        }
    }
    println!("{} files, all of them the library's", list.lines().count());
    Ok(())
}

fn demo() -> Result<(), String> {
    let folder = std::env::temp_dir().join(format!("preslide-demo-{}", std::process::id()));
    run(cargo(&["run", "--release", "--", "demo", "--out"]).arg(&folder))?;
    crate::browser::check(&folder.join("report.html"))?;
    std::fs::remove_dir_all(&folder)
        .map_err(|error| format!("cannot remove {}: {error}", folder.display()))
}
