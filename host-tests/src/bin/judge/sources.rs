//! Every source of recordings with a known truth, asked of `preslide diagnose`: one table, and a gate for CI.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use preslide_host_tests::judge::baseline::{self, Set};
use preslide_host_tests::judge::case::{Case, Sort};
use preslide_host_tests::judge::source::generated::{self, Generator, LABS, STAGE};
use preslide_host_tests::judge::source::{bench, injection, trials, write_json};
use preslide_host_tests::judge::summary;
use preslide_host_tests::judge::tool::Tool;
use preslide_host_tests::trials::{catalogue_plan, clean_plan};

/// Where recordings with a known truth come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Source {
    /// The project's trials
    Trials,
    /// `../shared/generators/stage`
    Stage,
    /// Laboratory machines, by a generator whose author had read nothing of the project
    Labs,
    /// Known effects in real recordings
    Injection,
    /// Real machines as they are, and controls
    Benches,
}

/// The diagnosis on every source of recordings with a known truth, in one table
#[derive(Args)]
pub struct Options {
    /// The program to judge [default: the one built beside this]
    #[arg(long, value_name = "PROGRAM")]
    preslide: Option<PathBuf>,
    /// Sources to run
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "trials,stage,labs,injection,benches",
        value_name = "SOURCES"
    )]
    only: Vec<Source>,
    /// Take every Nth recording of each source
    #[arg(long, default_value_t = 1, value_name = "N")]
    every: usize,
    /// Another set of the project's trials
    #[arg(long, default_value_t = 0, value_name = "S")]
    seed: u64,
    /// Trials of the project's plan
    #[arg(long, default_value_t = 300, value_name = "N")]
    count: usize,
    /// Clean trials besides, over all families and laws
    #[arg(long, default_value_t = 0, value_name = "N")]
    clean: usize,
    /// Sorts of question in trials, stage and labs [default: all]
    #[arg(long, value_delimiter = ',', value_name = "SORTS")]
    sorts: Vec<Sort>,
    /// Seeds of `../shared/generators/stage`, 76 trials each
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "777001,777002,777003",
        value_name = "SEEDS"
    )]
    stage: Vec<u64>,
    /// Seeds of `host-tests/generators/labs`, 190 trials each
    #[arg(long, value_delimiter = ',', default_value = "1", value_name = "SEEDS")]
    labs: Vec<u64>,
    /// An existing set of `stage`, instead of the seeds
    #[arg(long, value_name = "FOLDER")]
    stage_folder: Option<PathBuf>,
    /// A Python with numpy, numba and scipy [default: an environment made under target/judge]
    #[arg(long, value_name = "PROGRAM")]
    python: Option<PathBuf>,
    /// Strengths of injections, in percent of the effort's deviation
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "20,10,5",
        value_name = "PERCENT"
    )]
    strengths: Vec<f64>,
    /// Diagnoses at a time
    #[arg(long, default_value_t = 1, value_name = "N")]
    jobs: usize,
    /// Every case with truth and answer, for machines
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// The fixed set, compared with the committed answers: the part that CI runs, or all of it
    #[arg(long, value_name = "SET", num_args = 0..=1, default_missing_value = "gate")]
    ci: Option<Set>,
    /// With --ci: commit these answers instead
    #[arg(long, requires = "ci")]
    bless: bool,
}

fn ask(o: &Options, tool: &Tool) -> Result<Vec<Case>, String> {
    let wants = |source| o.only.contains(&source);
    let shared = preslide_host_tests::judge::real::shared().is_some();
    let sorts = |sort: Sort| o.sorts.is_empty() || o.sorts.contains(&sort);
    let mut cases = Vec::new();
    if wants(Source::Trials) {
        let plan = catalogue_plan(o.count)
            .into_iter()
            .step_by(o.every)
            .chain(clean_plan(o.clean))
            .filter(|(_, kind)| sorts(trials::sort(*kind)));
        let plan: Vec<_> = plan
            .map(|(seed, kind)| (seed + 5_000_000 * o.seed, kind))
            .collect();
        cases.extend(trials::cases(tool, &plan, o.jobs));
    }
    let mut sets: Vec<(&Generator, PathBuf)> = Vec::new();
    let mut generate = |generator: &'static Generator, seeds: &[u64]| {
        seeds.iter().try_for_each(|seed| {
            sets.push((generator, generator.folder(*seed, o.python.as_deref())?));
            Ok::<(), String>(())
        })
    };
    if wants(Source::Labs) {
        generate(&LABS, &o.labs)?;
    }
    if wants(Source::Stage) && shared && o.stage_folder.is_none() {
        generate(&STAGE, &o.stage)?;
    }
    sets.extend(o.stage_folder.iter().map(|folder| (&STAGE, folder.clone())));
    for (generator, folder) in &sets {
        let of = (generator.source, folder.as_path());
        cases.extend(generated::cases(tool, of, o.every, sorts, o.jobs)?);
    }
    if wants(Source::Injection) && shared {
        let pairs = injection::pairs(|_, _| true, 0, o.every);
        cases.extend(injection::cases(tool, &pairs, &o.strengths, o.jobs)?);
    }
    if wants(Source::Benches) && shared {
        cases.extend(bench::cases(tool, |_| true, o.jobs)?);
    }
    if cases.is_empty() {
        return Err(
            "nothing is left to ask: choose a larger --count, a smaller --every, other --sorts, or clone the project beside ../shared, which holds the real machines"
                .to_owned(),
        );
    }
    Ok(cases)
}

/// What `cargo xtask sources` does.
pub fn run(o: &Options) -> Result<(), String> {
    let tool = Tool::new(o.preslide.as_deref())?;
    let Some(set) = o.ci else {
        return tell(o, &ask(o, &tool)?);
    };
    let asked = baseline::ask(&tool, set, o.jobs)?;
    tell(o, &asked.cases)?;
    if o.bless {
        baseline::bless(&asked)
    } else {
        baseline::compare(&asked)
    }
}

/// The table, and the file that was asked for.
fn tell(o: &Options, cases: &[Case]) -> Result<(), String> {
    println!("{}", summary::table(cases));
    write_json(o.json.as_deref(), cases)
}
