//! `diagnose` on the real recordings in `../shared/recordings`: `cargo run --release --example real [table [NAME]|conceal]`.
//!
//! The table is what it says of each recording, or of those with NAME in their names. `conceal` takes a term out of the model that the data need,
//! and asks whether the tool names it. Without an argument both are printed. Effects added to measured forces: `cargo xtask inject`.

mod conceal;
mod screw;

use preslide_host::diagnose::verdict::Named as Effect;
use preslide_host::diagnose::{Diagnosis, Refusal, diagnose};
use preslide_host::friction::FrictionModel;
use preslide_host::model::Model;
use preslide_host::progress::Progress;
use preslide_host::recording::{self, LoadOptions, Recording};
use preslide_host::report::Table;
use std::path::PathBuf;
use std::time::Instant;

/// Where the recordings are.
fn root() -> PathBuf {
    PathBuf::from(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../shared/recordings"
    ))
}

/// Torque per current of the gimbal motor is not published: its effort is read as if 1 A were 1 N·m, and its figures are amperes.
const CURRENT: [(&str, &str); 1] = [("torque_Nm", "1*current_iq_A")];
/// The clock of a steady-state file starts again at each run.
const RUNS: [(&str, &str); 1] = [("segment", "run")];
/// Original MATLAB files.
const MATLAB: [(&str, &str); 3] = [("t_s", "t"), ("x_m", "qm"), ("force_N", "gtau*vir")];

/// A file of the recordings, read as their page says.
pub fn load(name: &str) -> Result<Recording, String> {
    let map: &[(&str, &str)] = match name {
        _ if name.ends_with(".mat") => &MATLAB,
        _ if name.starts_with("laas_cogging") => &CURRENT,
        _ if name.ends_with("steady_state.csv") => &RUNS,
        _ => &[],
    };
    let options = LoadOptions {
        map: map
            .iter()
            .map(|(a, b)| (a.to_string(), b.to_string()))
            .collect(),
        // The friction of the tribometer is negative while x increases.
        sign: name.starts_with("tribometer").then_some(-1.0),
        ..LoadOptions::default()
    };
    recording::load(&root().join(name), &options).map_err(|e| e.to_string())
}

/// A diagnosis with its time, or why there is none.
pub fn run(
    what: &str,
    recording: &Recording,
    model: Option<&Model>,
) -> Result<(Diagnosis, f64), String> {
    let start = Instant::now();
    eprint!("{what}: ");
    let found = diagnose(recording, model, &Progress::new(what, 0));
    let seconds = start.elapsed().as_secs_f64();
    eprintln!("{seconds:.1} s");
    match found {
        Ok(diagnosis) => Ok((diagnosis, seconds)),
        Err(Refusal::Input(reason)) => Err(format!("exit 2: {reason}")),
        Err(Refusal::Data(reason)) => Err(format!("exit 3: {reason}")),
    }
}

/// A figure with three digits.
pub fn figure(value: f64) -> String {
    if value == 0.0 || (1e-2..1e4).contains(&value.abs()) {
        let digits = (2.0 - value.abs().max(1e-2).log10().floor()).clamp(0.0, 4.0) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.2e}")
    }
}

/// One effect in a few words: name, share of the mismatch, confidence and level.
pub fn words(effect: &Effect) -> String {
    let level = if effect.confident {
        "confident"
    } else {
        "suspected"
    };
    let or: Vec<&str> = effect.ambiguous.iter().map(|e| e.id()).collect();
    let or = if or.is_empty() {
        String::new()
    } else {
        format!(" (or {})", or.join(", "))
    };
    format!(
        "{} {:.1} % {:.2} {level}{or}",
        effect.id(),
        100.0 * effect.evidence.share,
        effect.confidence
    )
}

/// The parameters of an effect with their intervals.
pub fn parameters(effect: &Effect, recording: &Recording) -> String {
    let any = Model::of_friction(recording.kind, FrictionModel::Coulomb { coulomb: 1.0 });
    let list: Vec<String> = effect
        .parameters
        .iter()
        .filter(|(key, _)| !key.starts_with("cosine") && !key.ends_with("phase_rad"))
        .map(|(key, estimate)| {
            let key = any.key(key);
            let reach = estimate.ci95.map_or(String::new(), |[from, to]| {
                format!(" ± {}", figure(0.5 * (to - from)))
            });
            format!("{key} {}{reach}", figure(estimate.value))
        })
        .collect();
    list.join(", ")
}

/// What is left and in no catalogue.
fn unknown(diagnosis: &Diagnosis) -> String {
    diagnosis.unknown.as_ref().map_or("–".to_owned(), |u| {
        let symmetry = if u.odd { "odd" } else { "even" };
        format!("{} ({symmetry})", u.axis.name(&diagnosis.ground.rows.s))
    })
}

/// Every recording, by folder; `.mat` files are the originals of two of them.
fn names() -> std::io::Result<Vec<String>> {
    let mut names = Vec::new();
    for folder in [
        "emps",
        "tribometer_reciprocating",
        "laas_cogging",
        "pneumatic_seal",
        "screw_drives",
    ] {
        for file in std::fs::read_dir(root().join(folder))? {
            names.push(format!("{folder}/{}", file?.file_name().to_string_lossy()));
        }
    }
    // A mean torque for each speed is no recording.
    names.retain(|name| !name.ends_with("stribeck_map.csv"));
    names.sort();
    Ok(names)
}

fn summary(part: &str) -> std::io::Result<Table> {
    let mut rows = Vec::new();
    for name in names()?.into_iter().filter(|name| name.contains(part)) {
        let row = match load(&name).and_then(|recording| run(&name, &recording, None)) {
            Ok((d, seconds)) => {
                let effects: Vec<String> = d.effects.iter().map(words).collect();
                vec![
                    name,
                    d.verdict.name().to_owned(),
                    effects.join("; "),
                    unknown(&d),
                    format!("{} → {}", figure(d.baseline.test), figure(d.extended.test)),
                    figure(d.noise_floor),
                    format!("{seconds:.1}"),
                ]
            }
            Err(reason) => vec![name, "none".to_owned(), reason],
        };
        rows.push(row);
    }
    Ok(Table {
        caption: "Each recording against rigid body and Maxwell-slip friction alone; NMSE in % of the force's variance, held out"
            .to_owned(),
        head: [
            "recording",
            "verdict",
            "effects",
            "unknown follows",
            "NMSE % before → after",
            "noise %",
            "s",
        ]
        .map(String::from)
        .to_vec(),
        rows,
    })
}

/// The table as Markdown.
fn print(table: &Table) {
    let line = |cells: &[String]| {
        let mut cells: Vec<String> = cells.iter().map(|c| c.replace('|', "/")).collect();
        cells.resize(table.head.len(), String::new());
        println!("| {} |", cells.join(" | "));
    };
    println!("{}\n", table.caption);
    line(&table.head);
    println!("|{}", "---|".repeat(table.head.len()));
    table.rows.iter().for_each(|row| line(row));
    println!();
}

fn main() -> Result<(), String> {
    if !root().is_dir() {
        eprintln!("SKIPPED: ../shared/recordings is absent; there is nothing to diagnose");
        return Ok(());
    }
    let mut arguments = std::env::args().skip(1);
    let (chosen, part) = (arguments.next(), arguments.next().unwrap_or_default());
    let wants = |part: &str| chosen.as_deref().is_none_or(|c| c == part);
    if !["table", "conceal"].into_iter().any(wants) {
        return Err("usage: real [table [NAME]|conceal]".to_owned());
    }
    if wants("table") {
        print(&summary(&part).map_err(|e| format!("../shared/recordings: {e}"))?);
    }
    if wants("conceal") {
        print(&conceal::table()?);
    }
    Ok(())
}
