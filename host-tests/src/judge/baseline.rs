//! The fixed set of every source, and the committed answer to each recording of it.
//!
//! Any other answer fails until `--bless` takes it, and the message says of which recording it is, what it was and what it is now.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::case::{Case, Sort};
use super::source::generated::{self, STAGE};
use super::source::{bench, injection, trials};
use super::tool::Tool;
use crate::trials::catalogue_plan;

/// How much of the fixed set runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Set {
    /// A few cheap recordings of every source: two minutes of one core
    Gate,
    /// All of it, before a release
    Whole,
}

/// A set apart from those that are reported.
const SEED: u64 = 777;
/// Trials of the project's plan, and those of them that the gate asks: the first of each sort of question.
const TRIALS: usize = 20;
const GATE_TRIALS: [usize; 6] = [0, 1, 2, 4, 8, 14];
/// Recordings and effects that are joined; the gate asks the last.
const INJECTED: [(&str, &str); 6] = [
    ("emps", "viscous"),
    ("emps", "periodic_force"),
    ("tribometer", "external_vibration"),
    ("seal_5bar", "local_friction_spot"),
    ("damper_30lb", "position_friction"),
    ("joint4", "stribeck"),
];
const GATE_INJECTED: usize = 1;
/// Machines as they are and controls; the gate asks the last three.
const BENCHES: [&str; 4] = ["emps", "joint4", "silverbox", "tanks"];
const GATE_BENCHES: usize = 3;

type Answers = BTreeMap<String, String>;

fn file() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/baseline.json"))
}

/// The set and its answers.
pub struct Run {
    /// What was answered.
    pub cases: Vec<Case>,
    /// Recordings and effects to be joined, of which a case may not have come.
    pairs: Vec<injection::Pair>,
}

/// Asks the set: of `../shared` only what is there, with a loud line where it is not.
///
/// # Errors
/// Where a recording cannot be read.
pub fn ask(tool: &Tool, set: Set, jobs: usize) -> Result<Run, String> {
    let whole = set == Set::Whole;
    let plan: Vec<_> = catalogue_plan(TRIALS)
        .into_iter()
        .enumerate()
        .filter(|(i, _)| whole || GATE_TRIALS.contains(i))
        .map(|(_, (seed, kind))| (seed + 5_000_000 * SEED, kind))
        .collect();
    let mut cases = trials::cases(tool, &plan, jobs);
    if super::real::shared().is_none() {
        eprintln!("SKIPPED: ../shared is absent; no real recording was asked");
        let pairs = Vec::new();
        return Ok(Run { cases, pairs });
    }
    let (injected, benches) = if whole {
        (&INJECTED[..], &BENCHES[..])
    } else {
        (
            &INJECTED[INJECTED.len() - GATE_INJECTED..],
            &BENCHES[BENCHES.len() - GATE_BENCHES..],
        )
    };
    let wanted = |machine: &str, effect: &str| injected.contains(&(machine, effect));
    let pairs = injection::pairs(wanted, 0, 1);
    cases.extend(injection::cases(tool, &pairs, &[20.0], jobs)?);
    cases.extend(bench::cases(tool, |name| benches.contains(&name), jobs)?);
    // Generated in some minutes where it is not kept: only where someone did so before.
    match STAGE.kept_folder(777_001) {
        _ if !whole => {}
        Some(folder) => {
            let stages = (STAGE.source, folder.as_path());
            cases.extend(generated::cases(tool, stages, 6, |_| true, jobs)?);
        }
        None => {
            eprintln!("SKIPPED: stage, which `cargo xtask sources --only stage` generates");
        }
    }
    Ok(Run { cases, pairs })
}

/// A case by its source and what is in it.
fn key(source: &str, name: &str, sort: Sort, truth: &[&str]) -> String {
    let question = [sort.name(), &truth.join("+")].join(" ");
    format!("{source}: {name}, {}", question.trim_end())
}

fn key_of(case: &Case) -> String {
    let truth: Vec<&str> = case.truth.iter().map(|t| t.id.as_str()).collect();
    key(case.source, &case.name, case.sort, &truth)
}

/// The verdict and the confident names, in their order, with what each is worth.
fn said(case: &Case) -> String {
    let Ok(answer) = &case.answer else {
        return "no answer".to_owned();
    };
    let names: Vec<String> = case
        .confident()
        .map(|named| match case.judges(named) {
            Some(true) => format!("{} ✓", named.id),
            Some(false) => format!("{} ✗", named.id),
            None => named.id.clone(),
        })
        .collect();
    format!("{} [{}]", answer.verdict, names.join(", "))
}

fn answers(run: &Run) -> Answers {
    // Where the machine is refused, or named so as it is, nothing is joined: that is an answer, too.
    let none = run.pairs.iter().map(|(machine, effect)| {
        let key = key("injection", machine.name, Sort::Single, &[effect]);
        (key, "not joined".to_owned())
    });
    let mut answers: Answers = none.collect();
    answers.extend(run.cases.iter().map(|c| (key_of(c), said(c))));
    answers
}

fn committed() -> Result<Answers, String> {
    let told = |error: &dyn std::fmt::Display| format!("{}: {error}", file().display());
    let text = std::fs::read_to_string(file()).map_err(|e| told(&e))?;
    serde_json::from_str(&text).map_err(|e| told(&e))
}

/// Commits these answers; those of cases that did not run stay.
///
/// # Errors
/// Where the file cannot be read or written.
pub fn bless(run: &Run) -> Result<(), String> {
    let mut all = committed()?;
    all.extend(answers(run));
    let text = serde_json::to_string_pretty(&all).map_err(|e| e.to_string())?;
    std::fs::write(file(), text + "\n").map_err(|e| format!("{}: {e}", file().display()))
}

/// Fails where an answer is not the committed one.
///
/// # Errors
/// The answers that are not, or a baseline that cannot be read.
pub fn compare(run: &Run) -> Result<(), String> {
    let now = answers(run);
    let changes = changes(&committed()?, &now);
    if changes.is_empty() {
        println!("{} answers as committed", now.len());
        return Ok(());
    }
    Err(format!(
        "{} of {} answers are not those of host-tests/baseline.json:\n{}\nif they are right, take them with the same command and --bless",
        changes.len(),
        now.len(),
        changes.join("\n")
    ))
}

/// One text for each answer that is not the committed one.
fn changes(committed: &Answers, now: &Answers) -> Vec<String> {
    now.iter()
        .filter_map(|(name, now)| {
            let before = committed.get(name);
            let was = before.map_or("not asked", String::as_str);
            (before != Some(now)).then(|| format!("  {name}\n    was {was}\n    now {now}"))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_only_changed_answers_and_new_recordings() {
        let of = |pairs: &[(&str, &str)]| -> Answers {
            let owned = |(a, b): &(&str, &str)| ((*a).to_owned(), (*b).to_owned());
            pairs.iter().map(owned).collect()
        };
        let committed = of(&[
            ("a", "consistent []"),
            ("b", "consistent []"),
            ("c", "no answer"),
        ]);
        let now = of(&[
            ("a", "consistent []"),
            ("b", "missing-physics [viscous ✗]"),
            ("d", "x []"),
        ]);
        assert_eq!(
            changes(&committed, &now),
            [
                "  b\n    was consistent []\n    now missing-physics [viscous ✗]",
                "  d\n    was not asked\n    now x []"
            ]
        );
    }
}
