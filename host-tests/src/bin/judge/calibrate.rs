//! The logistic of a stated confidence, fitted to judged names of all sources and tried on each that it was fitted without.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use preslide_host_tests::judge::calibrate::{
    CALIBRATION, Judged, Names, committed, fit, held_without, left_out, widths,
};

/// Fits the confidence of names and the width of intervals, each source, machine and effect left out in turn
///
/// The names come from files that `cargo xtask sources --json FILE` and `cargo xtask inject --json FILE` write.
#[derive(Args)]
pub struct Options {
    /// Judged cases; the widths of intervals stay as they are if no case has a true value
    #[arg(required = true, value_name = "FILE.json")]
    cases: Vec<PathBuf>,
    /// Judged out-of-catalogue and clean recordings, to fit the probability of what has no name; `sources --sorts stranger,clean` makes
    /// them. Without them it stays as it is
    #[arg(long, value_delimiter = ',', value_name = "FILE.json")]
    unnamed: Vec<PathBuf>,
    /// Fit only the suspicions; names and intervals stay as they are
    #[arg(long)]
    hints_only: bool,
    /// Write the weights into the program's source
    #[arg(long)]
    bless: bool,
}

/// What `cargo xtask calibrate` does.
pub fn run(o: &Options) -> Result<(), String> {
    let names = Names::read(&o.cases, &o.unnamed)?;
    let fitted = |judged: &Judged, what: &str| {
        fit(judged.stated.iter()).ok_or(format!(
            "no {what} with features and a known truth in these files; write them with `cargo xtask sources --json FILE`"
        ))
    };
    let kept = |table: &str| committed(table).map(|t| t.to_string());
    let weights = fitted(&names.names, "name")?;
    let hints = fitted(&names.hints, "suspicion")?;
    print_left_out(&names);
    let [weights, widths, counts] = if o.hints_only {
        [kept("weights")?, kept("widths")?, kept("names")?]
    } else {
        let line = |(effect, width)| format!("{effect} = {width:.2}\n");
        let widths = match names.distances.is_empty() {
            true => kept("widths")?,
            false => (widths(names.distances.iter()).into_iter())
                .map(line)
                .collect(),
        };
        let counts = counted(&names.names);
        [listed(&names.names, &weights), widths, counts]
    };
    let [presence, unnamed] = if o.unnamed.is_empty() {
        [kept("presence")?, kept("unnamed")?]
    } else {
        println!("the same of what has no name: something is there\n");
        println!("{}", left_out(&names.unnamed, |s| s.source.clone()));
        let presence = fitted(&names.unnamed, "stranger and clean recording")?;
        [listed(&names.unnamed, &presence), counted(&names.unnamed)]
    };
    let [hints, suspected] = [listed(&names.hints, &hints), counted(&names.hints)];
    let tables = [
        ("weights", "Of a name that entered.", weights),
        ("hints", "Of a suspicion, which did not.", hints),
        (
            "presence",
            "Of what has no name: whether anything is there.",
            presence,
        ),
        (
            "widths",
            "Times that an interval of an effect is widened, by the last files with true values.",
            widths,
        ),
        ("names", "Names that it was fitted to: right, all.", counts),
        ("suspected", "Suspicions: right, all.", suspected),
        ("unnamed", "What has no name: there, all.", unnamed),
    ];
    let mut text = String::from(
        "# Written by `cargo xtask calibrate --bless`: weights of the logistics behind what is stated as sure, and widths of intervals.\n",
    );
    for (key, words, lines) in tables {
        let _ = write!(text, "\n# {words}\n[{key}]\n{lines}");
    }
    println!("{text}");
    if o.bless {
        std::fs::write(CALIBRATION, text).map_err(|e| format!("{CALIBRATION}: {e}"))?;
    }
    Ok(())
}

fn print_left_out(names: &Names) {
    println!(
        "calibration error as stated and as fitted without the group; right of those at least so sure\n"
    );
    println!("{}", left_out(&names.names, |s| s.kind().to_owned()));
    println!("{}", left_out(&names.names, |s| s.source.clone()));
    println!("{}", left_out(&names.names, |s| s.id.clone()));
    println!("the same of suspicions\n");
    println!("{}", left_out(&names.hints, |s| s.kind().to_owned()));
    println!(
        "95 % intervals: true values held as stated, and widened as fitted without the source\n"
    );
    println!("{}", held_without(names));
}

fn listed(judged: &Judged, weights: &[f64]) -> String {
    let keys = std::iter::once("constant").chain(judged.features.iter().map(String::as_str));
    let lines = keys.zip(weights);
    lines.map(|(key, w)| format!("{key} = {w:.3}\n")).collect()
}

fn counted(judged: &Judged) -> String {
    let mut sources = std::collections::BTreeMap::<&str, [usize; 2]>::new();
    for stated in &judged.stated {
        let own = sources.entry(&stated.source).or_default();
        own[0] += usize::from(stated.right);
        own[1] += 1;
    }
    let lines = sources.into_iter();
    lines
        .map(|(source, [right, all])| format!("{source:?} = [{right}, {all}]\n"))
        .collect()
}
