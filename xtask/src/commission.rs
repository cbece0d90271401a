//! The book's commissioning chapter, run as a user would: its commands, in order, against an emulated drive. Then the one command that
//! does all of it, stopped in the middle and asked again.

use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::process::{free_port, released, root, run_for, words};

/// The chapter, and the port that it names.
const CHAPTER: &str = "docs/src/commissioning.md";
const PORT: &str = "7700";

/// Twice a motion of 46 s, on an emulator that may run at a third of a real drive's speed.
const LIMIT: Duration = Duration::from_secs(900);

/// The travel of the chapter's motion of 46 s, and that of one of 6.5 s: an emulated second costs more than three of a core.
const TRAVEL: &str = "--travel 1mm";
const SHORT: &str = "--travel 0.05mm";

/// Runs the chapter on the firmware `elf`, its motion over a shorter travel unless `whole`.
pub fn run(elf: &Path, whole: bool) -> Result<(), String> {
    let text =
        std::fs::read_to_string(root().join(CHAPTER)).map_err(|e| format!("{CHAPTER}: {e}"))?;
    let port = free_port()?;
    let commands: Vec<String> = text
        .lines()
        .filter(|line| line.starts_with("preslide "))
        // What moves of the one command comes last, over a shorter motion.
        .filter(|line| !line.starts_with("preslide commission") || line.contains("--dry"))
        .map(|line| line.replace(PORT, &port))
        .map(|line| match whole {
            true => line,
            false => line.replace(TRAVEL, SHORT),
        })
        .collect();
    if !whole && !commands.iter().any(|line| line.contains(SHORT)) {
        return Err(format!("{CHAPTER}: no command says `{TRAVEL}`"));
    }
    if commands.len() < 10 {
        return Err(format!("{CHAPTER}: only {} commands found", commands.len()));
    }
    let folder = std::env::temp_dir().join(format!("preslide-commission-{}", std::process::id()));
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut serve = Command::new(released("examples/drive"));
    // In a group of its own, with the emulator that it starts: one signal ends both.
    let serving = serve
        .arg("serve")
        .arg(elf)
        .arg(&port)
        .process_group(0)
        .spawn();
    let mut serving = serving.map_err(|error| format!("the drive did not start: {error}"))?;
    let script = format!("set -euxo pipefail\n{}\n", commands.join("\n"));
    let path = format!(
        "{}:{}",
        released("").display(),
        std::env::var("PATH").unwrap_or_default()
    );
    let mut bash = Command::new("bash");
    bash.args(["-c", &script])
        .env("PATH", path)
        .current_dir(&folder);
    let commissioned = run_for(&mut bash, LIMIT)
        .and_then(|()| in_one_command(&format!("tcp:127.0.0.1:{port}"), &folder, whole));
    // It serves for ever.
    let group = format!("-{}", serving.id());
    let _ = Command::new("kill").args(["-KILL", "--", &group]).status();
    let _ = serving.wait();
    if commissioned.is_ok() {
        // What stays of a failed run is there to be looked at.
        let _ = std::fs::remove_dir_all(&folder);
    }
    commissioned.map_err(|reason| format!("{CHAPTER}: {reason}"))
}

/// The motion of `preslide commission` here, over the short travel.
const WISH: &str =
    "--travel 0.05mm --speed 4mm/s --acceleration 0.5m/s2 --smallest 2um --repeats 2";

/// Commissions in one command: interrupted while it records, it leaves the axis disabled and says how to go on; asked again, it goes on and shows
/// that the model halves the error, at least, of a motion that no fit saw.
fn in_one_command(port: &str, folder: &Path, whole: bool) -> Result<(), String> {
    let experiments = if whole { "1" } else { "0" };
    let command = || {
        let mut command = Command::new(released("preslide"));
        command
            .args(["commission", port, "--save", "-o", "commission"])
            .args(["--experiments", experiments])
            .args(words(WISH))
            .current_dir(folder)
            .stdin(Stdio::null());
        command
    };
    let failed = |error: std::io::Error| format!("preslide commission: {error}");
    let first = command().stderr(Stdio::piped()).spawn().map_err(failed)?;
    let begun = Instant::now();
    while !folder.join("commission/before.csv").exists() && begun.elapsed() < LIMIT {
        std::thread::sleep(Duration::from_millis(50));
    }
    let id = first.id().to_string();
    Command::new("kill")
        .args(["-INT", &id])
        .status()
        .map_err(failed)?;
    let stopped = first.wait_with_output().map_err(failed)?;
    let said = String::from_utf8_lossy(&stopped.stderr);
    if stopped.status.code() != Some(3) || !said.contains("the same command goes on from there") {
        return Err(format!(
            "preslide commission, interrupted, ended with {} and said: {said}",
            stopped.status
        ));
    }
    let again = command()
        .stderr(Stdio::inherit())
        .output()
        .map_err(failed)?;
    let said = String::from_utf8_lossy(&again.stdout);
    println!("{said}");
    let error = |before: &str| {
        let rest = said.split(before).nth(1)?;
        rest.split(" nm").next()?.trim().parse::<f64>().ok()
    };
    let errors = error("saw: following error").zip(error("with the feedback alone,"));
    let is_whole = folder.join("commission/report.html").exists();
    match (again.status.success(), errors) {
        (true, Some((without, with))) if is_whole && with < 0.5 * without => Ok(()),
        _ => Err(format!(
            "preslide commission, asked again, ended with {}; errors {errors:?}",
            again.status
        )),
    }
}
