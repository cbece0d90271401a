//! What `preslide diagnose` says of each recording below `../shared`, read by the tool as a user would, beside what is known of it: a table as
//! Markdown.

use std::path::{Path, PathBuf};

use clap::Args;
use preslide_host_tests::answer::{Diagnosis, Named};
use preslide_host_tests::judge::real::shared;
use preslide_host_tests::judge::tool::Tool;

/// What the diagnosis says of each real recording, without a model
#[derive(Args)]
pub struct Options {
    /// Only recordings with this in their names
    name: Option<String>,
    /// The program to judge [default: the one built beside this]
    #[arg(long, value_name = "PROGRAM")]
    preslide: Option<PathBuf>,
}

/// Files below `../shared` whose path contains `part`: how they are read, and what is known of them. The first that fits counts.
struct Source {
    part: &'static str,
    /// Separated by blanks.
    arguments: &'static str,
    /// All of them together are one recording.
    joined: bool,
    known: &'static str,
}

const fn each(part: &'static str, arguments: &'static str, known: &'static str) -> Source {
    Source {
        part,
        arguments,
        joined: false,
        known,
    }
}

const EMPS: &str = "offset −3.16 N, 203.5 N·s/m, 20.4 N, 95.1 kg (published)";
const SCREWS: &str = "nothing published but mean torques by speed";
/// The damper's own load cells are parts of its force.
const BANDS: &str = "--ignore band_force1_N --ignore band_force2_N";

/// Amperes under a name that does not say so alone.
const AMPERES: &str = "--map current_A=current_iq_A";
/// The same beside the position in counts.
const COUNTS: &str = "--map current_A=current_iq_A --ignore pos_counts";

/// A joint of the robot, without its motor's own angle.
const JOINT: &str =
    "--map q_rad=joint_q_rad --map effort_raw=motor_torque_raw --ignore motor_q_rad";
/// The pendulum's bare names.
const PENDULUM: &str =
    "--map t_s=time --map q_rad=position --map torque_Nm=torque --map qd_rad_s=velocity";

/// Torque per current of the gimbal motor, the outrunner and the robot is not published: results are per ampere, or per unit.
static SOURCES: [Source; 20] = [
    each(
        ".mat",
        "--map t_s=t --map x_m=qm --map force_N=gtau*vir",
        EMPS,
    ),
    // The force is a constant times this voltage.
    each("recordings/emps/", "--ignore voltage_cmd_V", EMPS),
    // The friction is negative while x increases.
    each(
        "tribometer",
        "--sign -1",
        "strokes of 230 µm between the same ends: place and displacement are one",
    ),
    each("laas_cogging/hold_map", AMPERES, "settled holds, no motion"),
    each("laas_cogging", AMPERES, "cogging of 72 periods a turn"),
    each("pneumatic_seal", "", "constant force: pressure times area"),
    // The clock starts again at each run.
    each("steady_state", "--map segment=run", SCREWS),
    each("screw_drives", "", SCREWS),
    each(
        "staubli_tx40/all_joints",
        "--map t_s=t_s --map q_rad=0.03125*qm6_motor_rad --map effort_raw=torque_or_current6",
        "joint 6: coupled to joint 5",
    ),
    each(
        "staubli_tx40/joint4",
        JOINT,
        "periodic force of 0.2046 rad; viscous",
    ),
    each(
        "staubli_tx40",
        JOINT,
        "viscous; joint 6 coupled to joint 5, which is not in this file",
    ),
    each(
        "brfd_damper",
        BANDS,
        "backlash of 2.5 to 3.7 mm; a level for each tension",
    ),
    Source {
        joined: true,
        ..each(
            "bam_xl330",
            "--ignore duty --ignore torque_enabled",
            "gravity, viscous, friction that follows the load",
        )
    },
    each("dfki_pendulum/gravcomp", PENDULUM, "gravity explains all"),
    each(
        "dfki_pendulum",
        PENDULUM,
        "little: the best rigid body leaves 64 to 83 %",
    ),
    Source {
        joined: true,
        ..each(
            "odrive_cogging/slow_goodgains",
            COUNTS,
            "cogging, orders 7, 12, 14, 28, 36 of a turn",
        )
    },
    each(
        "odrive_cogging/static_hold",
        "",
        "holding currents by position, no clock",
    ),
    each(
        "odrive_cogging",
        COUNTS,
        "cogging, orders 7, 12, 14, 28, 36 of a turn",
    ),
    each(
        "silverbox",
        "",
        "an electronic oscillator, no friction; the file has no clock",
    ),
    each(
        "cascaded_tanks",
        "",
        "two tanks, no motion; the file has no clock",
    ),
];

/// A recording: its name, its files, how they are read and what is known.
struct Case {
    name: String,
    files: Vec<PathBuf>,
    source: &'static Source,
}

/// Every recording below `../shared`.
fn all(root: &Path) -> Result<Vec<Case>, String> {
    let mut cases: Vec<Case> = Vec::new();
    for name in files(root, &["recordings", "benches"])? {
        // A mean torque for each speed is no recording.
        if name.ends_with("stribeck_map.csv") {
            continue;
        }
        let source = SOURCES.iter().find(|s| name.contains(s.part));
        let source = source.ok_or(format!("{name}: how is it read? It is new in ../shared"))?;
        let file = root.join(&name);
        match cases.last_mut() {
            Some(last) if source.joined && last.source.part == source.part => last.files.push(file),
            _ => cases.push(Case {
                name,
                files: vec![file],
                source,
            }),
        }
    }
    Ok(cases)
}

/// Recordings two folders below, by name.
fn files(root: &Path, folders: &[&str]) -> Result<Vec<String>, String> {
    let inside = |path: &Path| -> Result<Vec<String>, String> {
        let entries = std::fs::read_dir(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let mut names = entries
            .map(|e| e.map(|e| e.file_name().to_string_lossy().into_owned()))
            .collect::<Result<Vec<_>, _>>()
            .map_err(|e| e.to_string())?;
        names.sort();
        Ok(names)
    };
    let mut all = Vec::new();
    for folder in folders {
        for machine in inside(&root.join(folder))? {
            let path = root.join(folder).join(&machine);
            if path.is_dir() {
                let recordings = inside(&path)?.into_iter();
                let read = |n: &String| n.ends_with(".csv") || n.ends_with(".mat");
                all.extend(
                    recordings
                        .filter(read)
                        .map(|n| format!("{folder}/{machine}/{n}")),
                );
            }
        }
    }
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

fn row(case: &Case, answer: &Result<Diagnosis, String>, seconds: f64) -> String {
    let (name, known) = (&case.name, case.source.known);
    let d = match answer {
        Err(reason) => {
            let reason = reason.replace('|', "/");
            return format!("| {name} | none | {reason} | | | | {seconds:.1} | {known} |");
        }
        Ok(d) => d,
    };
    let effects: Vec<String> = d.effects.iter().map(words).collect();
    format!(
        "| {name} | {} | {} | {} | {} → {} | {} | {seconds:.1} | {known} |",
        d.verdict,
        effects.join("; "),
        d.unknown_axis.as_deref().unwrap_or("–"),
        figure(d.nmse_test.map(|n| n.0)),
        figure(d.nmse_test.map(|n| n.1)),
        figure(d.noise_floor),
    )
}

/// What `cargo xtask real` does.
pub fn run(o: &Options) -> Result<(), String> {
    let Some(root) = shared() else {
        return Ok(());
    };
    let tool = Tool::new(o.preslide.as_deref())?;
    println!(
        "| recording | verdict | effects | unknown follows | NMSE % before → after | noise % | s | known |\n|---|---|---|---|---|---|---|---|"
    );
    let folder = std::env::temp_dir().join(format!("preslide-real-{}", std::process::id()));
    for case in all(&root)? {
        if o.name
            .as_ref()
            .is_some_and(|part| !case.name.contains(part))
        {
            continue;
        }
        std::fs::create_dir_all(&folder).map_err(|e| e.to_string())?;
        let begun = std::time::Instant::now();
        let arguments = case.source.arguments.split_whitespace();
        let arguments: Vec<String> = arguments.map(str::to_owned).collect();
        let answer = tool.ask(&folder, &case.files, None, &arguments);
        println!("{}", row(&case, &answer, begun.elapsed().as_secs_f64()));
        // The next answer must not be this one.
        let _ = std::fs::remove_dir_all(&folder);
    }
    Ok(())
}
