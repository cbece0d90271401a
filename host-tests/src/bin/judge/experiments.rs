//! Does it help to ask? Stages that hide what one recording hardly shows are diagnosed after one motion and at most three experiments, which the tool
//! chooses, and beside that after one recording of the same motion that lasts as long as all of them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Args;
use preslide_host_tests::answer::Diagnosis;
use preslide_host_tests::case::Case;
use preslide_host_tests::judge::source::trials;
use preslide_host_tests::judge::tool::{Tool, parallel};
use preslide_host_tests::table::Table;
use preslide_host_tests::trials::body::TICK_S;
use preslide_host_tests::trials::effect::{Id, Strength};
use preslide_host_tests::trials::motion::Reference;
use preslide_host_tests::trials::{Kind, Trial, half_travel, trial_along};
use serde_json::Value;

/// Experiments against passive recordings, on the project's trials
#[derive(Args)]
pub struct Options {
    /// The program to judge [default: the one built beside this]
    #[arg(long, value_name = "PROGRAM")]
    preslide: Option<PathBuf>,
    /// Stages for each effect
    #[arg(long, default_value_t = 3, value_name = "N")]
    each: u64,
    /// Only effects whose name contains one of these words, separated by commas
    #[arg(long, value_delimiter = ',', value_name = "WORDS")]
    only: Vec<String>,
    /// The first stage's seed
    #[arg(long, default_value_t = 60_000_000, value_name = "SEED")]
    seed: u64,
    /// Effects at their usual strength, not twice that
    #[arg(long)]
    typical: bool,
    /// Experiments at most
    #[arg(long, default_value_t = 3, value_name = "N")]
    most: usize,
    /// Diagnoses at a time
    #[arg(long, default_value_t = 1, value_name = "N")]
    jobs: usize,
}

/// What three minutes hardly hold, and, last, nothing.
const HIDDEN: [(Option<Id>, &str); 8] = [
    (Some(Id::RunIn), "run_in"),
    (Some(Id::DwellAging), "dwell_aging"),
    (Some(Id::ThermalDrift), "thermal_drift"),
    (Some(Id::LoadDependentFriction), "load_dependent_friction"),
    (Some(Id::Backlash), "backlash"),
    (Some(Id::DriveCompliance), "drive_compliance"),
    (Some(Id::EncoderError), "encoder_error"),
    (None, "(clean)"),
];

/// Of the first motion: speed (m/s), acceleration (m/s²), repeats, rows a second.
const SPEED: &str = "5mm/s";
const ACCELERATION: &str = "0.2m/s2";
const REPEATS: usize = 2;
/// Share of what mass and sixteen refitted stops leave that the truth must take off to be seen.
const SEEN: f64 = 0.05;
/// Of the stage's travel.
const TRAVEL: f64 = 0.8;

/// An answer to each way, and seconds that were recorded.
struct Judged {
    effect: &'static str,
    active: Case,
    passive: Case,
    asked: Vec<String>,
    /// Whether the truth takes enough off what a refitted baseline leaves of all that was recorded, experiments included.
    seen: bool,
    seconds: f64,
}

/// What `cargo xtask experiments` does.
pub fn run(o: &Options) -> Result<(), String> {
    let tool = Tool::new(o.preslide.as_deref())?;
    let wanted = |effect: &usize| {
        let mut words = o.only.iter();
        o.only.is_empty() || words.any(|word| HIDDEN[*effect].1.contains(word.as_str()))
    };
    let stages: Vec<(usize, u64)> = (0..HIDDEN.len())
        .filter(wanted)
        .flat_map(|effect| (0..o.each).map(move |k| (effect, o.seed + 5 * effect as u64 + k)))
        .collect();
    println!("seeds {} to {}", o.seed, o.seed + 5 * HIDDEN.len() as u64);
    let judged = parallel(&stages, o.jobs, |&(effect, seed)| {
        let folder = std::env::temp_dir().join(format!(
            "preslide-experiments-{}-{seed}",
            std::process::id()
        ));
        let strength = if o.typical {
            Strength::Typical
        } else {
            Strength::Strong
        };
        let judged = judge(&tool, HIDDEN[effect], (seed, strength), o.most, &folder);
        let _ = fs::remove_dir_all(&folder);
        if let Ok(judged) = &judged {
            eprintln!(
                "active  {}\npassive {}\n  asked {}",
                judged.active.line(),
                judged.passive.line(),
                judged.asked.join(" | ")
            );
        }
        judged
    });
    let judged = judged.into_iter().collect::<Result<Vec<_>, _>>()?;
    println!("{}", table(&judged));
    Ok(())
}

fn judge(
    tool: &Tool,
    (id, effect): (Option<Id>, &'static str),
    (seed, strength): (u64, Strength),
    most: usize,
    folder: &Path,
) -> Result<Judged, String> {
    fs::create_dir_all(folder).map_err(|e| e.to_string())?;
    let kind = id.map_or(Kind::Clean, |id| Kind::Single(id, strength));
    let travel = 2.0 * TRAVEL * half_travel(seed, kind);
    let first = planned(tool, travel, REPEATS, folder)?;
    let once = planned(tool, travel, 1, folder)?.len();
    let (mut motions, mut asked, mut about) = (vec![first], Vec::new(), Vec::new());
    let (active, seen) = loop {
        let (label, parts) = recorded(seed, kind, &motions);
        let motion = folder.join("experiment.csv");
        let _ = fs::remove_file(&motion);
        let known = if about.is_empty() {
            "none".to_owned()
        } else {
            about.join(",")
        };
        let more = [
            "--experiment",
            &motion.display().to_string(),
            "--asked",
            &known,
        ]
        .map(str::to_owned);
        let answer = ask(tool, folder, &parts, &more);
        let next = fs::read_to_string(&motion).ok();
        match next.filter(|_| motions.len() <= most && answer.is_ok()) {
            None => break (trials::case(&label.label, answer, 0.0), sees(&label)),
            Some(text) => {
                let ids = asked_about(folder)?;
                asked.push(ids.join(","));
                about.extend(ids);
                motions.push(positions(&text, "x_ref_m")?);
            }
        }
    };
    let seconds = motions.iter().map(Vec::len).sum::<usize>() as f64 * STEP_S;
    let repeats =
        (motions.iter().map(Vec::len).sum::<usize>() as f64 / once as f64).round() as usize;
    let (label, parts) = recorded(
        seed,
        kind,
        &[planned(tool, travel, repeats.max(REPEATS), folder)?],
    );
    let passive = trials::case(&label.label, ask(tool, folder, &parts, &[]), 0.0);
    Ok(Judged {
        effect,
        active,
        passive,
        asked,
        seen,
        seconds,
    })
}

fn sees(trial: &Trial) -> bool {
    let found = &trial.achievable;
    1.0 - found.floor_nmse / found.baseline_nmse >= SEEN
}

/// Time between two positions of a motion here (s).
const STEP_S: f64 = 1e-3;

/// A motion of `preslide plan`, with the number of its repeat.
fn planned(
    tool: &Tool,
    travel: f64,
    repeats: usize,
    folder: &Path,
) -> Result<Vec<(f64, u32)>, String> {
    let path = folder.join("plan.csv");
    let line = format!(
        "plan --travel {travel:e}m --speed {SPEED} --acceleration {ACCELERATION} --repeats {repeats} --rate 1kHz --smallest 4um -o"
    );
    let status = Command::new(&tool.command[0])
        .args(line.split(' '))
        .arg(&path)
        .output()
        .map_err(|e| e.to_string())?;
    if !status.status.success() {
        return Err(String::from_utf8_lossy(&status.stderr).into_owned());
    }
    positions(
        &fs::read_to_string(&path).map_err(|e| e.to_string())?,
        "x_m",
    )
}

fn positions(text: &str, column: &str) -> Result<Vec<(f64, u32)>, String> {
    let table = Table::parse(text)?;
    let of = |name: &str| table.find(name).ok_or(format!("no column {name}"));
    let (x, repeat) = (of(column)?, of("repeat")?);
    Ok(table.columns[x]
        .iter()
        .zip(&table.columns[repeat])
        .map(|(x, r)| (*x, *r as u32))
        .collect())
}

/// Motions one after the other on one stage that is never switched off, and what was recorded of each.
fn recorded(seed: u64, kind: Kind, motions: &[Vec<(f64, u32)>]) -> (Trial, Vec<Table>) {
    let mut rows: Vec<(f64, u32)> = Vec::new();
    let mut ends = Vec::new();
    for motion in motions {
        let numbers = rows.last().map_or(0, |row| row.1 + 1);
        // From where the stage stands to where the motion begins, in a second.
        let (from, to) = (rows.last().map_or(0.0, |row| row.0), motion[0].0);
        let way = (1..=1000).map(|i| f64::from(i) / 1000.0);
        rows.extend(way.map(|s| {
            (
                from + (to - from) * s * s * s * (10.0 + s * (6.0 * s - 15.0)),
                numbers,
            )
        }));
        let begins = rows.len();
        rows.extend(motion.iter().map(|(x, repeat)| (*x, repeat + numbers)));
        ends.push(begins..rows.len());
    }
    let x: Vec<f64> = rows.iter().map(|row| row.0).collect();
    let fine = (STEP_S / TICK_S).round() as usize;
    let last = x.len() - 1;
    let at = |i: isize| x[i.clamp(0, last as isize) as usize];
    let position = |n: usize| {
        let (i, u) = ((n / fine) as isize, (n % fine) as f64 / fine as f64);
        let (a, b, c, d) = (at(i - 1), at(i), at(i + 1), at(i + 2));
        b + 0.5 * u * (c - a + u * (2.0 * a - 5.0 * b + 4.0 * c - d + u * (3.0 * (b - c) + d - a)))
    };
    let path: Vec<f64> = (0..rows.len() * fine).map(position).collect();
    let ticks = (0..path.len()).map(|n| {
        let (before, here, after) = (
            path[n.saturating_sub(1)],
            path[n],
            path[(n + 1).min(path.len() - 1)],
        );
        Reference {
            x: here,
            v: (after - before) / (2.0 * TICK_S),
            a: (after - 2.0 * here + before) / (TICK_S * TICK_S),
            segment: 0,
            repeat: rows[n / fine].1,
        }
    });
    let made = trial_along(seed, kind, ticks.collect());
    let whole = made.given("trial").parts.remove(0);
    let step = (whole.sample_time() / STEP_S).round() as usize;
    let part = |rows: std::ops::Range<usize>| {
        let own = rows.start / step.max(1)..rows.end / step.max(1);
        whole.kept(|i| own.contains(&i))
    };
    let parts = ends.into_iter().map(part).collect();
    (made, parts)
}

fn write(folder: &Path, parts: &[Table]) -> Result<Vec<PathBuf>, String> {
    let named = parts.iter().enumerate().map(|(i, part)| {
        let path = folder.join(format!("recording{i}.csv"));
        part.write(&path).map(|()| path)
    });
    named.collect()
}

fn ask(tool: &Tool, folder: &Path, parts: &[Table], more: &[String]) -> Result<Diagnosis, String> {
    tool.ask(folder, &write(folder, parts)?, None, more)
}

/// What the experiment of the last answer is for, by id.
fn asked_about(folder: &Path) -> Result<Vec<String>, String> {
    let text = fs::read_to_string(folder.join("answer.json")).map_err(|e| e.to_string())?;
    let answer: Value = serde_json::from_str(&text).map_err(|e| e.to_string())?;
    let ids = answer["experiment"]["about"].as_array();
    let ids = ids.ok_or("the answer does not say what its experiment is for")?;
    Ok(ids
        .iter()
        .filter_map(Value::as_str)
        .map(str::to_owned)
        .collect())
}

fn table(judged: &[Judged]) -> String {
    let mut text = format!(
        "\n{:<26} {:>7} {:>5} {:>15} {:>15} {:>13} {:>13}",
        "effect",
        "stages",
        "seen",
        "first, passive",
        "first, asked",
        "false, passive",
        "false, asked"
    );
    for effect in HIDDEN.iter().map(|(_, name)| *name).chain(["all"]) {
        let own: Vec<&Judged> = judged
            .iter()
            .filter(|j| effect == "all" || j.effect == effect)
            .collect();
        let count = |of: &dyn Fn(&Judged) -> bool| own.iter().filter(|j| of(j)).count();
        text += &format!(
            "\n{effect:<26} {:>7} {:>5} {:>15} {:>15} {:>13} {:>13}",
            own.len(),
            count(&|j| j.seen),
            count(&|j| j.passive.first_right()),
            count(&|j| j.active.first_right()),
            own.iter()
                .map(|j| j.passive.false_names().count())
                .sum::<usize>(),
            own.iter()
                .map(|j| j.active.false_names().count())
                .sum::<usize>(),
        );
    }
    let seconds: f64 = judged.iter().map(|j| j.seconds).sum::<f64>() / judged.len().max(1) as f64;
    text + &format!(
        "\nrecorded for {seconds:.0} s in the mean, either way; first: the first certain name is right; seen: the truth takes off a twentieth, at least, of what mass and sixteen refitted stops leave"
    )
}
