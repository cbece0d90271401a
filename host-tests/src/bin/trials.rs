//! Runs `preslide diagnose` on generated recordings whose truth it does not see, and prints what it is worth.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use preslide_host_tests::judge::case::Case;
use preslide_host_tests::judge::summary;
use preslide_host_tests::judge::tool::{Tool, parallel};
use preslide_host_tests::trials::score::Judged;
use preslide_host_tests::trials::{Kind, catalogue_plan, clean_plan, report, trial};

const HELP: &str = "\
Usage: trials [OPTIONS]

  --count N        trials of the plan to run [default: 300]
  --clean N        N clean trials over all families and laws instead of the plan
  --seed S         another set of recordings of the same plan [default: 0]
  --only WORDS     only trials whose kind, law or effect contains one of these words, separated by commas
  --diagnose CMD   the command to judge, called as `CMD RECORDING --model MODEL --json ANSWER`
                   [default: `preslide diagnose` from the folder of this program]
  --limit SECONDS  longest time for one diagnosis [default: 120]
  --jobs N         trials at a time [default: the number of cores]
  --json FILE      every trial with label and answer, for machines
  --write FOLDER   only write the trials as files, one folder each: recording.csv, model.toml, label.toml
  --sizes          only print what each effect adds to the force, at its strengths
  --gate           fail on a false alarm, or where fewer than two thirds of the effects are named
  --quiet          no line for each trial";

struct Options {
    count: usize,
    clean: Option<usize>,
    seed: u64,
    only: Vec<String>,
    diagnose: Vec<String>,
    limit: Duration,
    jobs: usize,
    json: Option<PathBuf>,
    write: Option<PathBuf>,
    sizes: bool,
    quiet: bool,
    gate: bool,
}

fn options(mut arguments: impl Iterator<Item = String>) -> Result<Option<Options>, String> {
    let mut o = Options {
        count: 300,
        clean: None,
        seed: 0,
        only: Vec::new(),
        diagnose: Vec::new(),
        limit: Duration::from_secs(120),
        jobs: std::thread::available_parallelism().map_or(1, usize::from),
        json: None,
        write: None,
        sizes: false,
        quiet: false,
        gate: false,
    };
    while let Some(argument) = arguments.next() {
        let mut value = || {
            arguments.next().ok_or(format!(
                "{argument} needs a value; --help lists the options"
            ))
        };
        let whole = |text: String| {
            text.parse::<u64>()
                .map_err(|_| format!("{argument}: `{text}` is not a whole number from 0"))
        };
        match argument.as_str() {
            "--count" => o.count = whole(value()?)? as usize,
            "--clean" => o.clean = Some(whole(value()?)? as usize),
            "--seed" => o.seed = whole(value()?)?,
            "--only" => o.only = value()?.split(',').map(str::to_owned).collect(),
            "--diagnose" => o.diagnose = value()?.split_whitespace().map(str::to_owned).collect(),
            "--limit" => o.limit = Duration::from_secs(whole(value()?)?),
            "--jobs" => o.jobs = (whole(value()?)? as usize).max(1),
            "--json" => o.json = Some(value()?.into()),
            "--write" => o.write = Some(value()?.into()),
            "--sizes" => o.sizes = true,
            "--quiet" => o.quiet = true,
            "--gate" => o.gate = true,
            "--help" | "-h" => return Ok(None),
            _ => return Err(format!("`{argument}` is no option; --help lists them")),
        }
    }
    Ok(Some(o))
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
        command: o.diagnose.clone(),
        limit: o.limit,
        recipe: None,
    };
    let done = AtomicUsize::new(0);
    let started = Instant::now();
    let judged: Vec<Judged> = parallel(plan, o.jobs, |_, &(seed, kind)| {
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
    });
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

fn write(o: &Options, plan: &[(u64, Kind)], to: &Path) -> Result<(), String> {
    let results = parallel(plan, o.jobs, |_, &(seed, kind)| {
        let folder = to.join(seed.to_string());
        std::fs::create_dir_all(&folder)
            .and_then(|()| trial(seed, kind).write(&folder))
            .map_err(|e| format!("{}: {e}", folder.display()))
    });
    results.into_iter().collect()
}

/// What each effect adds: RMS share of the force, and NMSE of a refitted baseline and of the noise.
fn sizes(o: &Options, plan: &[(u64, Kind)]) {
    println!(
        "{:<52} {:>8} {:>8} {:>10} {:>10}",
        "trial", "RMS [N]", "share %", "baseline %", "floor %"
    );
    let lines = parallel(plan, o.jobs, |_, &(seed, kind)| {
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
    });
    println!("{}", lines.join("\n"));
}

fn run() -> Result<(), String> {
    let Some(mut o) = options(std::env::args().skip(1))? else {
        println!("{HELP}");
        return Ok(());
    };
    let plan = plan(&o);
    if plan.is_empty() {
        return Err(
            "no trial is left; choose a larger --count or other words for --only".to_owned(),
        );
    }
    if let Some(folder) = &o.write {
        return write(&o, &plan, folder);
    }
    if o.sizes {
        sizes(&o, &plan);
        return Ok(());
    }
    if o.diagnose.is_empty() {
        let own = std::env::current_exe().map_err(|e| e.to_string())?;
        let tool = own.with_file_name(format!("preslide{}", std::env::consts::EXE_SUFFIX));
        if !tool.exists() {
            return Err(format!(
                "{} is not built; run `cargo build --release -p preslide-cli`, or name a command with --diagnose",
                tool.display()
            ));
        }
        o.diagnose = vec![tool.display().to_string(), "diagnose".to_owned()];
    }
    judge(&o, &plan)
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("trials: {reason}");
            ExitCode::FAILURE
        }
    }
}
