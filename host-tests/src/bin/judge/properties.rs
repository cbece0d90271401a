//! Asks whether `preslide diagnose` says the same of a recording that was changed in ways that change nothing about the machine.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use preslide_host_tests::answer::{Diagnosis, Named};
use preslide_host_tests::judge::properties::{Outcome, PROPERTIES, Property, compare};
use preslide_host_tests::judge::real::machine;
use preslide_host_tests::judge::table::Recording;
use preslide_host_tests::judge::tool::{Tool, parallel};
use preslide_host_tests::trials::effect::{Id, Strength};
use preslide_host_tests::trials::{Kind, repeatable, trial};

/// Answers that must not flip: made and real recordings, each changed in fifteen ways
#[derive(Args)]
pub struct Options {
    /// The program to judge [default: the one built beside this]
    #[arg(long, value_name = "PROGRAM")]
    preslide: Option<PathBuf>,
    /// Only recordings and properties whose name contains one of these words, separated by commas
    #[arg(long, value_delimiter = ',', value_name = "WORDS")]
    only: Vec<String>,
    /// Another set of made recordings
    #[arg(long, default_value_t = 0, value_name = "S")]
    seed: u64,
    /// Perfectly repeatable clean stages with the right model; each must be consistent
    #[arg(long, default_value_t = 15, value_name = "N")]
    stages: u64,
    /// Diagnoses at a time
    #[arg(long, default_value_t = 1, value_name = "N")]
    jobs: usize,
    /// Fail unless at least this many answers agree
    #[arg(long, value_name = "N")]
    at_least: Option<usize>,
    /// Leave out the real machines
    #[arg(long)]
    made: bool,
}

/// Real machines that are asked: a ball screw, a tribometer, a robot's joint, a servo, a damper.
const REAL: [&str; 5] = ["emps", "tribometer", "joint4", "servo", "damper_30lb"];

/// Two clean stages and six effects of unlike nature, over the five laws.
const MADE: [(u64, Kind); 8] = [
    (0, Kind::Clean),
    (2, Kind::Clean),
    (1, Kind::Single(Id::Viscous, Strength::Strong)),
    (3, Kind::Single(Id::Stribeck, Strength::Strong)),
    (4, Kind::Single(Id::PeriodicForce, Strength::Typical)),
    (5, Kind::Single(Id::LocalFrictionSpot, Strength::Strong)),
    (7, Kind::Single(Id::ConstantForce, Strength::Strong)),
    (6, Kind::Pair(Id::PositionSpring, Id::ExternalVibration)),
];
/// Far from every seed of the trials.
const SEEDS: u64 = 70_000_000;

fn wanted(only: &[String], name: &str) -> bool {
    only.is_empty() || only.iter().any(|word| name.contains(word.as_str()))
}

fn recordings(o: &Options) -> Result<Vec<Recording>, String> {
    let mut all = Vec::new();
    for (i, kind) in MADE {
        let seed = SEEDS + 1000 * o.seed + i;
        let made = trial(seed, kind);
        let ids: Vec<&str> = kind.ids().iter().map(|id| id.name()).collect();
        let what = if ids.is_empty() {
            "clean".to_owned()
        } else {
            ids.join("+")
        };
        all.push(made.given(format!("{what} ({})", made.label.law.name())));
    }
    if !o.made && preslide_host_tests::judge::real::shared().is_some() {
        for name in REAL {
            all.push(machine(name).ok_or(name)?.recording()?);
        }
    }
    Ok(all)
}

fn stages(o: &Options, tool: &Tool) -> (usize, usize) {
    let seeds: Vec<u64> = (0..o.stages)
        .map(|i| SEEDS + 500 + 1000 * o.seed + i)
        .collect();
    let lines = parallel(&seeds, o.jobs, |&seed| {
        let (answer, seconds) = tool.diagnose(&repeatable(seed).given("stage"));
        let said = match &answer {
            Err(reason) => reason.clone(),
            Ok(d) => {
                let names = d
                    .effects
                    .iter()
                    .filter(|e| e.confident)
                    .map(|e| e.id.as_str());
                format!("{} {}", d.verdict, names.collect::<Vec<_>>().join(", "))
            }
        };
        println!("  seed {seed} {seconds:5.1} s: {said}");
        answer.is_ok_and(|d| d.verdict == "consistent")
    });
    (lines.iter().filter(|right| **right).count(), lines.len())
}

/// An answer in a line.
fn said(answer: &Result<Diagnosis, String>) -> String {
    let d = match answer {
        Err(reason) => return reason.clone(),
        Ok(d) => d,
    };
    let name = |e: &Named| format!("{}{}", e.id, if e.confident { "" } else { "?" });
    let names: Vec<String> = d.effects.iter().map(name).collect();
    format!("{} [{}]", d.verdict, names.join(", "))
}

/// Asks of one recording as it is and changed; nothing where it is refused as it is.
fn ask(o: &Options, tool: &Tool, recording: &Recording, of: &[Property]) -> Vec<Outcome> {
    let (before, seconds) = tool.diagnose(recording);
    println!("{}: {} ({seconds:.1} s)", recording.name, said(&before));
    if before.is_err() {
        return Vec::new();
    }
    parallel(of, o.jobs, |property| {
        let outcome = match property.apply(recording) {
            None => Outcome::NotAsked,
            Some(changed) => compare(*property, &before, &tool.diagnose(&changed).0),
        };
        let (word, what) = outcome.words();
        println!("  {:<26} {word:<8} {what}", property.name());
        outcome
    })
}

/// Outcomes counted.
#[derive(Default)]
struct Tally {
    /// How many agree, and of how many, beside each of [`PROPERTIES`].
    totals: [[usize; 2]; PROPERTIES.len()],
    /// How many outcomes are called what.
    words: BTreeMap<&'static str, usize>,
}

impl Tally {
    fn add(&mut self, property: Property, outcome: &Outcome) {
        if *outcome == Outcome::NotAsked {
            return;
        }
        let place = PROPERTIES.iter().position(|p| *p == property).unwrap_or(0);
        self.totals[place][0] += usize::from(outcome.agrees(property));
        self.totals[place][1] += 1;
        *self.words.entry(outcome.words().0).or_default() += 1;
    }

    /// How many agree, and of how many.
    fn sum(&self) -> (usize, usize) {
        let sum = |i: usize| self.totals.iter().map(|t| t[i]).sum();
        (sum(0), sum(1))
    }

    fn print(&self) {
        println!("\n{:<26} agree of", "property");
        let asked = PROPERTIES.iter().zip(&self.totals);
        for (property, [agree, of]) in asked.filter(|(_, t)| t[1] > 0) {
            println!("{:<26} {agree:>5} {of}", property.name());
        }
    }
}

/// Why nothing was asked.
fn nothing_is_called_so() -> String {
    let names: Vec<&str> = PROPERTIES.iter().map(|p| p.name()).collect();
    format!(
        "--only: no recording and no property is called so; properties are {}, recordings {}, effects of made ones, and `stages`",
        names.join(", "),
        REAL.join(", ")
    )
}

/// What `cargo xtask properties` does.
pub fn run(o: &Options) -> Result<(), String> {
    let tool = Tool::new(o.preslide.as_deref())?;
    let (mut held, mut asked) = (0, 0);
    if wanted(&o.only, "stages") {
        println!("Perfectly repeatable clean stages with the right model:");
        (held, asked) = stages(o, &tool);
        println!("consistent: {held} of {asked}\n");
    }
    let mut tally = Tally::default();
    for recording in recordings(o)? {
        let own = wanted(&o.only, &recording.name);
        let mut of = PROPERTIES.to_vec();
        of.retain(|p| own || wanted(&o.only, p.name()));
        if of.is_empty() {
            continue;
        }
        let outcomes = ask(o, &tool, &recording, &of);
        for (property, outcome) in of.iter().zip(&outcomes) {
            tally.add(*property, outcome);
        }
    }
    let (agree, of) = tally.sum();
    (held, asked) = (held + agree, asked + of);
    if asked == 0 {
        return Err(nothing_is_called_so());
    }
    tally.print();
    println!("\n{held} of {asked} hold; {:?}", tally.words);
    match o.at_least {
        Some(least) if held < least => Err(format!(
            "{held} answers hold where {least} did; the lines above show which do not"
        )),
        _ => Ok(()),
    }
}
