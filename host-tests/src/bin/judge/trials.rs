//! Runs `preslide diagnose` on generated recordings whose truth it does not see, and prints what it is worth.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use clap::Args;
use preslide_host_tests::judge::case::Case;
use preslide_host_tests::judge::summary;
use preslide_host_tests::judge::tool::Tool;
use preslide_host_tests::trials::score::Judged;
use preslide_host_tests::trials::{Kind, catalogue_plan, clean_plan, report, trial};
use rayon::prelude::*;

/// Runs `preslide diagnose` on generated recordings whose truth it does not see, and prints what it is worth.
#[derive(Args)]
pub struct Options {
    /// Trials of the plan to run.
    #[arg(long, value_name = "N", default_value_t = 300)]
    count: usize,
    /// Clean trials over all families and laws instead of the plan.
    #[arg(long, value_name = "N", conflicts_with = "count")]
    clean: Option<usize>,
    /// Another set of recordings of the same plan.
    #[arg(long, value_name = "S", default_value_t = 0)]
    seed: u64,
    /// Only trials whose kind, law or effect contains one of these words, separated by commas.
    #[arg(long, value_name = "WORDS", value_delimiter = ',')]
    only: Vec<String>,
    /// The command to judge, called as `CMD RECORDING --model MODEL --json ANSWER`; without it `preslide diagnose` from the
    /// folder of this program.
    #[arg(long, value_name = "CMD")]
    diagnose: Option<String>,
    /// Longest time for one diagnosis (s).
    #[arg(long, value_name = "SECONDS", default_value_t = 120)]
    limit: u64,
    /// Trials at a time; without it as many as there are cores.
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
    /// Writes every trial with label and answer, for machines.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Only writes the trials as files, one folder each: recording.csv, model.toml, label.toml.
    #[arg(long, value_name = "FOLDER")]
    write: Option<PathBuf>,
    /// Only prints what each effect adds to the force, at its strengths.
    #[arg(long)]
    sizes: bool,
    /// Fails on a false alarm, or where fewer than two thirds of the effects are named.
    #[arg(long)]
    gate: bool,
    /// No line for each trial.
    #[arg(long)]
    quiet: bool,
}

fn plan(o: &Options) -> Vec<(u64, Kind)> {
    let wanted = |seed: u64, kind: Kind| {
        let law = preslide_host_tests::trials::law::LAWS[(seed % 5) as usize].name();
        let effects = kind.ids().into_iter().map(|id| id.name());
        let mut words = effects.chain([kind.name(), law]);
        o.only.is_empty()
            || words.any(|word| o.only.iter().any(|only| word.contains(only.as_str())))
    };
    let plan = o.clean.map_or_else(|| catalogue_plan(o.count), clean_plan);
    plan.into_iter()
        // A million trials lie between two sets.
        .map(|(seed, kind)| (seed + 5_000_000 * o.seed, kind))
        .filter(|&(seed, kind)| wanted(seed, kind))
        .collect()
}

fn judge(o: &Options, plan: &[(u64, Kind)]) -> Result<(), String> {
    let tool = Tool {
        command: command(o)?,
        limit: Duration::from_secs(o.limit),
        recipe: None,
    };
    let done = AtomicUsize::new(0);
    let started = Instant::now();
    let judge_one = |&(seed, kind): &(u64, Kind)| {
        let made = trial(seed, kind);
        // Blind: the tool gets a folder without the truth.
        let (answer, seconds) = tool.diagnose(&made.given("trial"));
        let judged = Judged::new(&made, answer, seconds);
        let n = done.fetch_add(1, Ordering::Relaxed) + 1;
        if !o.quiet {
            let left = started.elapsed().as_secs_f64() / n as f64 * (plan.len() - n) as f64;
            eprintln!(
                "{n:>4}/{} {:>4.0} s left {}",
                plan.len(),
                left,
                judged.line()
            );
        }
        judged
    };
    let judged: Vec<Judged> = plan.par_iter().map(judge_one).collect();
    println!("{}", report::tables(&judged));
    let cases: Vec<Case> = judged.iter().map(Case::from).collect();
    println!("\n{}", summary::table(&cases));
    if let Some(file) = &o.json {
        let text =
            serde_json::to_string_pretty(&report::to_json(&judged)).map_err(|e| e.to_string())?;
        std::fs::write(file, text).map_err(|e| format!("{}: {e}", file.display()))?;
    }
    if o.gate {
        gate(&judged)?;
    }
    if judged.iter().all(|j| j.answer.is_err()) {
        return Err("no trial got an answer".to_owned());
    }
    Ok(())
}

/// Fails where the diagnosis has become worse than a fixed set allows.
fn gate(judged: &[Judged]) -> Result<(), String> {
    let alarms = judged.iter().filter(|j| j.clean() && j.alarms()).count();
    let single: Vec<&Judged> = judged.iter().filter(|j| j.is("single")).collect();
    let right = single.iter().filter(|j| j.found_within(1)).count();
    if alarms > 0 || 3 * right < 2 * single.len() {
        return Err(format!(
            "{alarms} false alarms where none was, {right} of {} effects named first where two thirds were; the lines above tell which",
            single.len()
        ));
    }
    Ok(())
}

/// The command to judge: the one asked for, or `preslide diagnose` from the folder of this program.
fn command(o: &Options) -> Result<Vec<String>, String> {
    match &o.diagnose {
        Some(command) => Ok(command.split_whitespace().map(str::to_owned).collect()),
        None => Ok(Tool::new(None)?.command),
    }
}

fn write(plan: &[(u64, Kind)], to: &Path) -> Result<(), String> {
    plan.par_iter().try_for_each(|&(seed, kind)| {
        let folder = to.join(seed.to_string());
        std::fs::create_dir_all(&folder)
            .and_then(|()| trial(seed, kind).write(&folder))
            .map_err(|e| format!("{}: {e}", folder.display()))
    })
}

/// What each effect adds: RMS share of the force, and NMSE of a refitted baseline and of the noise.
fn sizes(plan: &[(u64, Kind)]) {
    println!(
        "{:<52} {:>8} {:>8} {:>10} {:>10}",
        "trial", "RMS [N]", "share %", "baseline %", "floor %"
    );
    let line = |&(seed, kind): &(u64, Kind)| {
        let made = trial(seed, kind);
        let (label, a) = (&made.label, &made.achievable);
        let effects = label.effects.iter().zip(&a.effect_rms);
        let rows = effects
            .map(|(e, rms)| (e.id.name(), *rms))
            .collect::<Vec<_>>();
        let rows = if rows.is_empty() {
            vec![("clean", 0.0)]
        } else {
            rows
        };
        rows.iter()
            .map(|(name, rms)| {
                format!(
                    "{:<24} {:<8} {:<18} {rms:8.4} {:8.2} {:10.3} {:10.3}",
                    name,
                    label.strength,
                    label.law.name(),
                    100.0 * rms / a.force_rms,
                    a.baseline_nmse,
                    a.floor_nmse
                )
            })
            .collect::<Vec<_>>()
            .join("\n")
    };
    let lines: Vec<String> = plan.par_iter().map(line).collect();
    println!("{}", lines.join("\n"));
}

/// What `cargo xtask trials` does.
pub fn run(o: &Options) -> Result<(), String> {
    // 0 is rayon's word for the number of cores.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(o.jobs.unwrap_or(0));
    pool.build_global().map_err(|e| e.to_string())?;
    let plan = plan(o);
    if plan.is_empty() {
        return Err(
            "no trial is left; choose a larger --count or other words for --only".to_owned(),
        );
    }
    if let Some(folder) = &o.write {
        return write(&plan, folder);
    }
    if o.sizes {
        sizes(&plan);
        return Ok(());
    }
    judge(o, &plan)
}
