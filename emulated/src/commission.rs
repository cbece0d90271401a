//! The book's commissioning chapter, run as a user would: its commands, in order, against an emulated drive. Then the one command that
//! does all of it, stopped in the middle and asked again.

use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail, ensure};
use fs_err as fs;
use preslide_tools::process::{command, free_port, released, root, run_for, with_folder};

/// The chapter, and the port that it names.
const CHAPTER: &str = "docs/src/commissioning.md";
const PORT: &str = "7700";

/// Twice a motion of 46 s, on an emulator that may run at a third of a real drive's speed.
const LIMIT: Duration = Duration::from_secs(900);

/// The travel of the chapter's motion of 46 s, and that of one of 6.5 s: an emulated second costs more than three of a core.
const TRAVEL: &str = "--travel 1mm";
const SHORT: &str = "--travel 0.05mm";

/// Runs the chapter on the firmware `elf`, its motion over a shorter travel unless `whole`.
pub fn run(elf: &Path, whole: bool) -> Result<()> {
    let text = fs::read_to_string(root().join(CHAPTER))?;
    let port = free_port()?;
    let travel = if whole { TRAVEL } else { SHORT };
    let commands: Vec<String> = text
        .lines()
        .filter(|line| line.starts_with("preslide "))
        // What moves of the one command comes last, over a shorter motion.
        .filter(|line| !line.starts_with("preslide commission") || line.contains("--dry"))
        .map(|line| line.replace(PORT, &port).replace(TRAVEL, travel))
        .collect();
    ensure!(
        commands.iter().any(|line| line.contains(travel)),
        "{CHAPTER}: no command says `{TRAVEL}`"
    );
    ensure!(
        commands.len() >= 10,
        "{CHAPTER}: only {} commands found",
        commands.len()
    );
    let script = format!("set -euxo pipefail\n{}\n", commands.join("\n"));
    with_folder("commission", |folder| {
        let mut serve = Command::new(released("examples/drive"));
        serve.arg("serve").arg(elf).arg(&port);
        // In a group of its own, with the emulator that it starts: one signal ends both.
        let serving = serve.process_group(0).spawn();
        let mut serving = serving.context("the drive did not start")?;
        let path = std::env::var("PATH").unwrap_or_default();
        let path = format!("{}:{path}", released("").display());
        let mut bash = Command::new("bash");
        bash.args(["-c", &script]).env("PATH", path);
        let commissioned = run_for(bash.current_dir(folder), LIMIT)
            .and_then(|()| in_one_command(&format!("tcp:127.0.0.1:{port}"), folder, whole));
        // It serves for ever.
        let _ = command(&format!("kill -KILL -- -{}", serving.id())).status();
        let _ = serving.wait();
        commissioned.context(CHAPTER)
    })
}

/// The motion of `preslide commission` here, over the short travel.
const WISH: &str =
    "--travel 0.05mm --speed 4mm/s --acceleration 0.5m/s2 --smallest 2um --repeats 2";

/// Commissions in one command: interrupted while it records, it leaves the axis disabled and says how to go on; asked again, it goes on and shows
/// that the model halves the error, at least, of a motion that no fit saw.
fn in_one_command(port: &str, folder: &Path, whole: bool) -> Result<()> {
    let line = format!(
        "commission {port} --save -o commission --experiments {} {WISH}",
        u8::from(whole)
    );
    let tool = || {
        let mut tool = Command::new(released("preslide"));
        tool.args(line.split_whitespace()).current_dir(folder);
        tool.stdin(Stdio::null());
        tool
    };
    let first = tool().stderr(Stdio::piped()).spawn()?;
    let begun = Instant::now();
    while !folder.join("commission/before.csv").exists() && begun.elapsed() < LIMIT {
        std::thread::sleep(Duration::from_millis(50));
    }
    command(&format!("kill -INT {}", first.id())).status()?;
    let stopped = first.wait_with_output()?;
    let said = String::from_utf8_lossy(&stopped.stderr);
    if stopped.status.code() != Some(3) || !said.contains("the same command goes on from there") {
        let status = stopped.status;
        bail!("preslide commission, interrupted, ended with {status} and said: {said}");
    }
    let again = tool().stderr(Stdio::inherit()).output()?;
    println!("{}", String::from_utf8_lossy(&again.stdout));
    let journal = fs_err::read_to_string(folder.join("commission/commission.json"))?;
    let journal: serde_json::Value = serde_json::from_str(&journal)?;
    let error = |motion: &str| journal["played"][motion]["rms"].as_f64();
    let errors = error("unseen-without").zip(error("unseen-with"));
    let is_whole = folder.join("commission/report.html").exists();
    match (again.status.success(), errors) {
        (true, Some((without, with))) if is_whole && with < 0.5 * without => Ok(()),
        _ => bail!(
            "preslide commission, asked again, ended with {}; errors {errors:?}",
            again.status
        ),
    }
}
