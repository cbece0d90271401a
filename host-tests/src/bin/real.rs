//! What `preslide diagnose` says of each file of `../shared/recordings`, read by the tool as the files' page says: a table as Markdown.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use preslide_host_tests::judge::tool::Tool;
use preslide_host_tests::recordings;
use preslide_host_tests::trials::score::{Diagnosis, Named};

/// What the diagnosis says of each real recording, without a model
#[derive(Parser)]
#[command(name = "cargo xtask real")]
struct Options {
    /// Only recordings with this in their names
    name: Option<String>,
    /// The program to judge [default: the one built beside this]
    #[arg(long, value_name = "PROGRAM")]
    preslide: Option<PathBuf>,
}

/// Folders, and how their files are read. Torque per current of the gimbal motor is not published: 1 A is read as 1 N·m.
const FOLDERS: [(&str, &[&str]); 5] = [
    ("emps", &[]),
    // The friction is negative while x increases.
    ("tribometer_reciprocating", &["--sign", "-1"]),
    ("laas_cogging", &["--map", "torque_Nm=1*current_iq_A"]),
    ("pneumatic_seal", &[]),
    ("screw_drives", &[]),
];
/// Original MATLAB files; the clock of a steady-state file starts again at each run.
const ENDINGS: [(&str, &[&str]); 2] = [
    (
        ".mat",
        &[
            "--map",
            "t_s=t",
            "--map",
            "x_m=qm",
            "--map",
            "force_N=gtau*vir",
        ],
    ),
    ("steady_state.csv", &["--map", "segment=run"]),
];

/// Every recording with its arguments.
fn all(root: &Path) -> Result<Vec<(String, Vec<String>)>, String> {
    let mut all = Vec::new();
    for (folder, arguments) in FOLDERS {
        let path = root.join(folder);
        for file in std::fs::read_dir(&path).map_err(|e| format!("{}: {e}", path.display()))? {
            let file = file.map_err(|e| e.to_string())?.file_name();
            let name = format!("{folder}/{}", file.to_string_lossy());
            // A mean torque for each speed is no recording.
            if name.ends_with("stribeck_map.csv") {
                continue;
            }
            let own = ENDINGS
                .iter()
                .filter(|e| name.ends_with(e.0))
                .flat_map(|e| e.1);
            let arguments = arguments
                .iter()
                .chain(own)
                .map(|a| (*a).to_owned())
                .collect();
            all.push((name, arguments));
        }
    }
    all.sort();
    Ok(all)
}

fn words(named: &Named) -> String {
    let level = if named.confident {
        "confident"
    } else {
        "suspected"
    };
    let or = match &named.ambiguous_with[..] {
        [] => String::new(),
        others => format!(" (or {})", others.join(", ")),
    };
    format!("{} {:.2} {level}{or}", named.id, named.confidence)
}

/// Three digits.
fn figure(value: Option<f64>) -> String {
    value.map_or("–".to_owned(), |v| match v.abs() {
        size if size >= 1e4 => format!("{v:.2e}"),
        size if size >= 100.0 => format!("{v:.0}"),
        size => format!(
            "{v:.*}",
            if size >= 10.0 {
                1
            } else if size >= 1.0 {
                2
            } else {
                3
            }
        ),
    })
}

fn row(name: &str, answer: &Result<Diagnosis, String>, seconds: f64) -> String {
    let d = match answer {
        Err(reason) => return format!("| {name} | none | {} | | | | |", reason.replace('|', "/")),
        Ok(d) => d,
    };
    let effects: Vec<String> = d.effects.iter().map(words).collect();
    format!(
        "| {name} | {} | {} | {} | {} → {} | {} | {seconds:.1} |",
        d.verdict,
        effects.join("; "),
        d.unknown_axis.as_deref().unwrap_or("–"),
        figure(d.nmse_test.map(|n| n.0)),
        figure(d.nmse_test.map(|n| n.1)),
        figure(d.noise_floor),
    )
}

fn run(o: &Options) -> Result<(), String> {
    let Some(root) = recordings() else {
        return Ok(());
    };
    let tool = Tool::new(o.preslide.as_deref())?;
    println!(
        "| recording | verdict | effects | unknown follows | NMSE % before → after | noise % | s |\n|---|---|---|---|---|---|---|"
    );
    let folder = std::env::temp_dir().join(format!("preslide-real-{}", std::process::id()));
    for (name, arguments) in all(&root)? {
        if o.name.as_ref().is_some_and(|part| !name.contains(part)) {
            continue;
        }
        std::fs::create_dir_all(&folder).map_err(|e| e.to_string())?;
        let begun = std::time::Instant::now();
        let answer = tool.ask(&folder, &[root.join(&name)], None, &arguments);
        println!("{}", row(&name, &answer, begun.elapsed().as_secs_f64()));
        // The next answer must not be this one.
        let _ = std::fs::remove_dir_all(&folder);
    }
    Ok(())
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("real: {reason}");
            ExitCode::FAILURE
        }
    }
}
