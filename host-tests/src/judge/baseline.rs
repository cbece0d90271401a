//! The fixed small set of every source that CI asks, and the committed figures that it may not fall behind by more than chance.
//!
//! A figure is a count of a fixed set. It is worse where the count is lower than an honest engine as good as the committed one would
//! give once in twenty (binomial, with the committed share smoothed by half a count): more than the set's own scatter.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::case::{Case, Sort};
use super::source::generated::{self, STAGE};
use super::source::{bench, injection, machines, trials};
use super::summary::{Share, at_most};
use super::tool::Tool;
use crate::trials::catalogue_plan;

/// Below the committed count by more than happens this often by chance.
const CHANCE: f64 = 0.05;
/// Trials of the project's plan; the first machines; recordings and effects that are joined.
const TRIALS: usize = 20;
const MACHINES: u64 = 10;
/// A set apart from those that are reported.
const SEED: u64 = 777;
const INJECTED: [(&str, &str); 6] = [
    ("emps", "viscous"),
    ("emps", "periodic_force"),
    ("tribometer", "external_vibration"),
    ("seal_5bar", "local_friction_spot"),
    ("joint4", "stribeck"),
    ("damper_30lb", "position_friction"),
];
const BENCHES: [&str; 4] = ["emps", "joint4", "silverbox", "tanks"];

fn file() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/baseline.json"))
}

/// The fixed set: of `../shared` only what is there, with a loud line where it is not.
///
/// # Errors
/// Where a recording cannot be read.
pub fn cases(tool: &Tool, jobs: usize) -> Result<Vec<Case>, String> {
    let plan: Vec<_> = catalogue_plan(TRIALS)
        .into_iter()
        .map(|(seed, kind)| (seed + 5_000_000 * SEED, kind))
        .collect();
    let mut cases = trials::cases(tool, &plan, jobs);
    let seeds: Vec<u64> = (0..MACHINES).map(|i| i + 1_000_000 * SEED).collect();
    cases.extend(machines::cases(tool, &seeds, |_| true, jobs));
    if super::real::shared().is_some() {
        let pairs = injection::pairs(
            |machine, effect| INJECTED.contains(&(machine, effect)),
            0,
            1,
        );
        cases.extend(injection::cases(tool, &pairs, &[20.0], jobs)?);
        cases.extend(bench::cases(tool, |name| BENCHES.contains(&name), jobs)?);
        // Generated in some minutes where it is not kept: only where someone did so before.
        if let Some(folder) = STAGE.kept_folder(777_001) {
            cases.extend(generated::cases(
                tool,
                (STAGE.source, &folder),
                6,
                |_| true,
                jobs,
            )?);
        } else {
            eprintln!("SKIPPED: stage, which `cargo xtask sources --only stage` generates");
        }
    }
    Ok(cases)
}

/// What is counted, more being better, for each source.
fn figures(cases: &[Case]) -> BTreeMap<String, Share> {
    let mut figures = BTreeMap::new();
    for source in super::summary::sources(cases) {
        let own = || cases.iter().filter(move |c| c.source == source);
        let mut add = |name: &str, share: Share| {
            if share.whole > 0 {
                figures.insert(format!("{source}: {name}"), share);
            }
        };
        add("answered", Share::of(own(), |c| c.answer.is_ok()));
        add(
            "recordings without a false name",
            Share::of(own(), |c| c.false_names().next().is_none()),
        );
        let clean = own().filter(|c| c.sort == Sort::Clean);
        add(
            "clean not called unknown",
            Share::of(clean, |c| c.verdict() != "unknown-physics"),
        );
        let strangers = own().filter(|c| c.sort == Sort::Stranger);
        add(
            "strangers not named",
            Share::of(strangers, |c| c.confident().next().is_none()),
        );
        let effects = own().filter(|c| c.sort != Sort::Stranger);
        let effects = effects.flat_map(|c| c.truth.iter().map(move |t| (c, t)));
        add(
            "effects named or declared",
            Share::of(effects, |(c, t)| c.finds_or_declares(t)),
        );
    }
    figures
}

/// Writes the figures as the committed ones.
///
/// # Errors
/// Where the file cannot be written.
pub fn bless(cases: &[Case]) -> Result<(), String> {
    let figures: BTreeMap<String, [usize; 2]> = figures(cases)
        .into_iter()
        .map(|(name, s)| (name, [s.part, s.whole]))
        .collect();
    let text = serde_json::to_string_pretty(&figures).map_err(|e| e.to_string())?;
    std::fs::write(file(), text + "\n").map_err(|e| format!("{}: {e}", file().display()))
}

/// Fails where a figure is worse than the committed one by more than chance.
///
/// # Errors
/// The figures that are, or a baseline that cannot be read.
pub fn compare(cases: &[Case]) -> Result<(), String> {
    let text = std::fs::read_to_string(file()).map_err(|e| format!("{}: {e}", file().display()))?;
    let committed: BTreeMap<String, [usize; 2]> =
        serde_json::from_str(&text).map_err(|e| format!("{}: {e}", file().display()))?;
    let mut worse = Vec::new();
    for (name, now) in figures(cases) {
        let Some(&[part, whole]) = committed.get(&name) else {
            println!("{name}: {now}, no baseline");
            continue;
        };
        let expected = (part as f64 + 0.5) / (whole as f64 + 1.0);
        let falls = now.part < part && at_most(now.part, now.whole, expected) < CHANCE;
        println!(
            "{name}: {}/{}, baseline {part}/{whole}{}",
            now.part,
            now.whole,
            if falls { " ✗" } else { "" }
        );
        if falls {
            worse.push(format!(
                "{name}: {} of {} where {part} of {whole} were",
                now.part, now.whole
            ));
        }
    }
    if worse.is_empty() {
        return Ok(());
    }
    Err(format!(
        "worse than the baseline by more than chance:\n  {}",
        worse.join("\n  ")
    ))
}
