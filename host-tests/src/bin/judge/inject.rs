//! Known effects added to real recordings: are they named, where an oracle with the true column says that the data show them?

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use preslide_host_tests::judge::case::Case;
use preslide_host_tests::judge::source::{self, injection};
use preslide_host_tests::judge::summary::Share;
use preslide_host_tests::judge::tool::Tool;
use preslide_host_tests::trials::effect::INJECTED;

/// Known effects added to real recordings, at shares of their effort's deviation
#[derive(Args)]
pub struct Options {
    /// The program to judge [default: the one built beside this]
    #[arg(long, value_name = "PROGRAM")]
    preslide: Option<PathBuf>,
    /// Only recordings and effects whose name contains one of these words, separated by commas
    #[arg(long, value_delimiter = ',', value_name = "WORDS")]
    only: Vec<String>,
    /// RMS of the added effect, in percent of the effort's deviation
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "20,10,5",
        value_name = "PERCENT"
    )]
    strengths: Vec<f64>,
    /// Every Nth pair of recording and effect
    #[arg(long, default_value_t = 1, value_name = "N")]
    every: usize,
    /// Number of the first pair; 1 with --every 2 takes those that 0 left out
    #[arg(long, default_value_t = 0, value_name = "N")]
    from: usize,
    /// Diagnoses at a time
    #[arg(long, default_value_t = 1, value_name = "N")]
    jobs: usize,
    /// Ask only the oracle, and diagnose nothing
    #[arg(long)]
    oracle: bool,
    /// Keep recordings and answers in this folder
    #[arg(long, value_name = "FOLDER")]
    keep: Option<PathBuf>,
    /// Every case with truth and answer, for machines
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// What `cargo xtask inject` does.
pub fn run(o: &Options) -> Result<(), String> {
    let wanted = |machine: &str, effect: &str| {
        let hit = |word: &String| machine.contains(word.as_str()) || effect.contains(word.as_str());
        o.only.is_empty() || o.only.iter().any(hit)
    };
    let pairs = injection::pairs(wanted, o.from, o.every);
    if pairs.is_empty() {
        return Err(format!(
            "no pair of recording and effect is left; effects are {}; recordings those of ../shared that `cargo xtask real` lists",
            INJECTED.each_ref().map(|effect| effect.id).join(", ")
        ));
    }
    if o.oracle {
        return injection::oracles(&pairs, &o.strengths);
    }
    let mut tool = Tool::new(o.preslide.as_deref())?;
    tool.keep = o.keep.clone();
    let cases = injection::cases(&tool, &pairs, &o.strengths, o.jobs)?;
    println!("{}", table(&cases));
    source::write_json(o.json.as_deref(), &cases)
}

/// By effect and strength, then new false names.
fn table(cases: &[Case]) -> String {
    let mut strengths: Vec<f64> = cases.iter().map(|c| c.strength).collect();
    strengths.sort_by(|a, b| b.total_cmp(a));
    strengths.dedup();
    let mut text = format!("\n{:<22}", "named / there / asked");
    for strength in &strengths {
        text += &format!(" {:>16}", format!("{strength} %"));
    }
    let effects = INJECTED.iter().map(|e| (e.id, e.id)).chain([("all", "")]);
    for (name, effect) in effects {
        let own = |c: &&Case| effect.is_empty() || c.truth.iter().any(|t| t.id == effect);
        if !cases.iter().any(|c| own(&c)) {
            continue;
        }
        text += &format!("\n{name:<22}");
        for strength in &strengths {
            let asked: Vec<&Case> = cases
                .iter()
                .filter(own)
                .filter(|c| c.strength == *strength)
                .collect();
            let there: Vec<&&Case> = asked.iter().filter(|c| c.there == Some(true)).collect();
            let named = Share::of(&there, |c| c.truth.iter().all(|t| c.finds_or_declares(t)));
            text += &format!(
                " {:>16}",
                format!("{} / {} / {}", named.part, there.len(), asked.len())
            );
        }
    }
    let there = |strength: f64| {
        let own = cases.iter().filter(move |c| c.strength == strength);
        own.filter(|c| c.there == Some(true))
    };
    for strength in strengths {
        let first = Share::of(there(strength), |c| c.first_right());
        let anywhere = Share::of(there(strength), |c| c.truth.iter().all(|t| c.finds(t)));
        let declared = Share::of(there(strength), |c| {
            c.truth.iter().all(|t| c.finds_or_declares(t))
        });
        let hinted = Share::of(there(strength), |c| {
            let named = |t| {
                c.names()
                    .iter()
                    .any(|n| preslide_host_tests::judge::case::Truth::is(t, n))
            };
            c.truth.iter().all(named)
        });
        text += &format!(
            "\n{strength} %: first {first}, anywhere {anywhere}, or declared {declared}, suspected too {hinted}"
        );
    }
    let wrong = Share::of(cases, |c| c.false_names().next().is_some());
    text += &format!("\nrecordings with a new false name: {wrong}");
    let mut names = BTreeMap::<&str, usize>::new();
    for name in cases.iter().flat_map(|c| c.false_names()) {
        *names.entry(&name.id).or_default() += 1;
    }
    text + &format!(" {names:?}")
}
