//! `cargo xtask test`: the checks of CI in two lanes, each check with its reason, and a summary.

use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Result, bail, ensure};
use fs_err as fs;
use preslide_tools::process::root;
use wait4::Wait4 as _;

use crate::steps::{APART, Lane, STEPS, Step, Tier, has_step};

/// Runs every step but those of [`APART`], or those named; with `--all` the long studies, too; with `--serial` one after the other.
pub fn run_steps(arguments: &[String]) -> Result<()> {
    let given = |flag: &str| arguments.iter().any(|argument| argument == flag);
    let serial = given("--serial");
    let tier = match given("--all") {
        true => Tier::All,
        false => Tier::Gate,
    };
    let is_name = |argument: &&String| !["--serial", "--all"].contains(&argument.as_str());
    let names: Vec<&String> = arguments.iter().filter(is_name).collect();
    let chosen = named(&names, tier)?;
    // Packages are installed before anything runs beside something else; what cannot be had fails its step.
    for need in chosen.iter().flat_map(|step| step.needs) {
        let _ = need.ensure();
    }
    match chosen.as_slice() {
        [step] => here(step, tier),
        steps if serial => summarise(&one_by_one(steps, tier)),
        steps => summarise(&in_lanes(steps, tier)),
    }
}

/// Those named; where none is, all, but those of [`APART`] in the long tier only.
fn named(names: &[&String], tier: Tier) -> Result<Vec<&'static Step>> {
    if let Some(name) = names.iter().find(|name| !has_step(name)) {
        let known: Vec<&str> = STEPS.iter().map(|step| step.name).collect();
        bail!(
            "there is no step `{name}`; the steps are {}",
            known.join(", ")
        );
    }
    let is_meant = |step: &&Step| match names {
        [] => tier == Tier::All || !APART.contains(&step.name),
        names => names.iter().any(|name| *name == step.name),
    };
    Ok(STEPS.iter().filter(is_meant).collect())
}

/// Runs a step in this process.
fn here(step: &Step, tier: Tier) -> Result<()> {
    println!("\n== {}: {}", step.name, step.reason);
    step.needs.iter().try_for_each(|need| need.ensure())?;
    (step.run)(tier)
}

/// A step that ran as a program of its own.
struct Ended {
    name: &'static str,
    time: Duration,
    /// How long it kept a core busy.
    busy: Duration,
    is_well: bool,
}

/// All with their output as it comes.
fn one_by_one(steps: &[&'static Step], tier: Tier) -> Vec<Ended> {
    let run = |step: &&'static Step| ended(step, own_program(step, tier));
    steps.iter().map(run).collect()
}

/// Both lanes at a time, each in its order; the one that ends first begins with what is of neither.
fn in_lanes(steps: &[&'static Step], tier: Tier) -> Vec<Ended> {
    let of = |lane| -> Vec<&'static Step> {
        let steps = steps.iter().copied();
        steps.filter(|step| step.lane == lane).collect()
    };
    let [host, beside, free] = [Lane::Host, Lane::Beside, Lane::Free].map(of);
    if host.is_empty() {
        return one_by_one(steps, tier);
    }
    let taken = AtomicUsize::new(0);
    let left = || free.get(taken.fetch_add(1, Ordering::Relaxed)).copied();
    let run_free = || std::iter::from_fn(left).map(|step| logged(step, tier));
    std::thread::scope(|scope| {
        let beside = scope.spawn(|| {
            let ended = beside.iter().map(|step| logged(step, tier));
            ended.chain(run_free()).collect::<Vec<Ended>>()
        });
        let mut ended = one_by_one(&host, tier);
        ended.extend(run_free());
        let beside = beside.join();
        ended.extend(beside.unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        ended
    })
}

/// Runs a step with its output in a file; all of it is shown where it failed, and else what was skipped.
fn logged(step: &'static Step, tier: Tier) -> Ended {
    println!("\n== beside: {}: {}", step.name, step.reason);
    let folder = root().join("target/test");
    let log = folder.join(format!("{}.log", step.name));
    let command = fs::create_dir_all(folder).and_then(|()| {
        let file = fs::File::create(&log)?.into_file();
        let mut command = own_program(step, tier)?;
        command.stdout(file.try_clone()?).stderr(file);
        Ok(command)
    });
    let ended = ended(step, command);
    let text = fs::read_to_string(&log).unwrap_or_default();
    let (name, seconds) = (ended.name, ended.time.as_secs());
    if ended.is_well {
        let log = log.display();
        println!("\n== {name} ended well after {seconds} s; {log}");
        for line in text.lines().filter(|line| line.starts_with("SKIPPED")) {
            println!("{line}");
        }
    } else {
        println!("\n== {name} FAILED after {seconds} s:\n{text}\n== end of {name}");
    }
    ended
}

/// This program with that step alone: how long a core was busy is known of whole programs.
fn own_program(step: &Step, tier: Tier) -> std::io::Result<Command> {
    let mut command = Command::new(std::env::current_exe()?);
    command.args(["test", step.name]).stdin(Stdio::null());
    if tier == Tier::All {
        command.arg("--all");
    }
    Ok(command)
}

/// Runs the program of a step to its end.
fn ended(step: &'static Step, command: std::io::Result<Command>) -> Ended {
    let start = Instant::now();
    let used = command.and_then(|mut command| command.spawn()?.wait4());
    let (busy, is_well) = match used {
        Ok(used) => (used.rusage.utime + used.rusage.stime, used.status.success()),
        Err(error) => {
            println!("`{}` did not start: {error}", step.name);
            (Duration::ZERO, false)
        }
    };
    Ended {
        name: step.name,
        time: start.elapsed(),
        busy,
        is_well,
    }
}

/// A later step runs even if an earlier one failed: one run shows everything that is wrong.
fn summarise(steps: &[Ended]) -> Result<()> {
    println!(
        "\n{:<10} {:>8} {:>10}  result",
        "step", "minutes", "of a core"
    );
    for step in steps {
        let [time, busy] = [step.time, step.busy].map(|time| time.as_secs_f64() / 60.0);
        let word = if step.is_well { "ok" } else { "FAILED" };
        println!("{:<10} {time:>8.1} {busy:>10.1}  {word}", step.name);
    }
    say_if_recordings_are_absent();
    let failed = steps.iter().filter(|step| !step.is_well);
    let failed: Vec<&str> = failed.map(|step| step.name).collect();
    ensure!(failed.is_empty(), "failed: {}", failed.join(", "));
    Ok(())
}

/// Printed here as well as by the tests themselves, whose output cargo captures when they pass.
fn say_if_recordings_are_absent() {
    if !root().join("../shared/recordings").is_dir() {
        println!(
            "SKIPPED: ../shared/recordings is absent; the tests on real recordings did not run"
        );
    }
}
