//! `cargo xtask test`: the checks of CI in two lanes, each check with its reason, and a summary.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::changed;
use crate::process::root;
use crate::steps::{APART, Lane, STEPS, Step, Tier, has_step};

/// Runs every step but those of [`APART`], those named, or those that `--changed [BASE]` touches; with `--all` the long studies, too; with
/// `--serial` one after the other.
pub fn run_steps(arguments: &[String]) -> Result<(), String> {
    let given = |flag: &str| arguments.iter().any(|argument| argument == flag);
    let serial = given("--serial");
    let tier = if given("--all") {
        Tier::All
    } else {
        Tier::Gate
    };
    let rest = arguments
        .iter()
        .filter(|a| !["--serial", "--all"].contains(&a.as_str()));
    let arguments: Vec<String> = rest.cloned().collect();
    let names = match arguments.as_slice() {
        [flag, base @ ..] if flag == "--changed" => {
            let base = match base {
                [] => "HEAD",
                [base] => base,
                _ => return Err("--changed takes one commit or branch".to_owned()),
            };
            touched_since(base)?
        }
        names => names.to_vec(),
    };
    if names.is_empty() && !arguments.is_empty() {
        println!("nothing that a step checks has changed");
        return Ok(());
    }
    let chosen = named(&names, tier)?;
    // Packages are installed before anything runs beside something else; what cannot be had fails its step.
    for need in chosen.iter().flat_map(|step| step.needs) {
        let _ = need.ensure();
    }
    summarise(&if serial {
        chosen.iter().map(|step| shown(step, tier)).collect()
    } else {
        in_lanes(&chosen, tier)
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

/// Those named; where none is, all, but those of [`APART`] in the long tier only.
fn named(names: &[String], tier: Tier) -> Result<Vec<&'static Step>, String> {
    if let Some(name) = names.iter().find(|name| !has_step(name)) {
        let known: Vec<&str> = STEPS.iter().map(|step| step.name).collect();
        return Err(format!(
            "there is no step `{name}`; the steps are {}",
            known.join(", ")
        ));
    }
    let is_meant = |step: &&Step| match names {
        [] => tier == Tier::All || !APART.contains(&step.name),
        names => names.iter().any(|name| name == step.name),
    };
    Ok(STEPS.iter().filter(is_meant).collect())
}

/// A step's name, how long it took, and how it ended.
type Ended = (&'static str, Duration, Result<(), String>);

/// Both lanes at a time, each in its order.
fn in_lanes(chosen: &[&'static Step], tier: Tier) -> Vec<Ended> {
    let (host, others): (Vec<&Step>, Vec<&Step>) =
        chosen.iter().partition(|step| step.lane == Lane::Host);
    if host.is_empty() || others.is_empty() {
        return chosen.iter().map(|step| shown(step, tier)).collect();
    }
    std::thread::scope(|scope| {
        let beside = scope.spawn(|| {
            others
                .iter()
                .map(|step| logged(step, tier))
                .collect::<Vec<_>>()
        });
        let mut ended: Vec<Ended> = host.iter().map(|step| shown(step, tier)).collect();
        ended.extend(
            beside
                .join()
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
        );
        ended
    })
}

/// Runs a step with its output as it comes.
fn shown(step: &Step, tier: Tier) -> Ended {
    println!("\n== {}: {}", step.name, step.reason);
    let start = Instant::now();
    let needs = step.needs.iter().try_for_each(|need| need.ensure());
    let result = needs.and_then(|()| (step.run)(tier));
    if let Err(reason) = &result {
        println!("FAILED: {reason}");
    }
    (step.name, start.elapsed(), result)
}

/// Runs a step as a program of its own, whose output goes to a file; all of it is shown where it failed, and else what was skipped.
fn logged(step: &Step, tier: Tier) -> Ended {
    let log = root().join(format!("target/test/{}.log", step.name));
    println!("\n== beside: {}: {}", step.name, step.reason);
    let start = Instant::now();
    let result = into_log(step, tier, &log);
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

fn into_log(step: &Step, tier: Tier, log: &Path) -> Result<(), String> {
    let told = |error: std::io::Error| format!("{}: {error}", log.display());
    std::fs::create_dir_all(root().join("target/test")).map_err(told)?;
    let file = std::fs::File::create(log).map_err(told)?;
    let this = std::env::current_exe().map_err(told)?;
    let mut command = Command::new(this);
    command.args(["test", "--serial", step.name]);
    if tier == Tier::All {
        command.arg("--all");
    }
    command.stdin(Stdio::null());
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
    println!("\n{:<10} {:>8}  result", "step", "minutes");
    for (name, time, result) in results {
        let word = if result.is_ok() { "ok" } else { "FAILED" };
        println!("{name:<10} {:>8.1}  {word}", time.as_secs_f64() / 60.0);
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
