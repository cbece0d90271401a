//! The logistic of a stated confidence, fitted to judged names of all sources and tried on each that it was fitted without.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use preslide_host_tests::judge::calibrate::{
    CALIBRATION, Names, fit, held_without, left_out, widths,
};

/// Fits the confidence of names and the width of intervals, each source, machine and effect left out in turn
///
/// The names come from files that `cargo xtask sources --json FILE` and `cargo xtask inject --json FILE` write.
#[derive(Parser)]
#[command(name = "cargo xtask calibrate")]
struct Options {
    /// Judged cases
    #[arg(required = true, value_name = "FILE.json")]
    cases: Vec<PathBuf>,
    /// Write the weights into the program's source
    #[arg(long)]
    bless: bool,
}

fn run(o: &Options) -> Result<(), String> {
    let names = Names::read(&o.cases)?;
    let weights = fit(names.stated.iter())
        .ok_or("no name with features and a known truth in these files; write them with `cargo xtask sources --json FILE`")?;
    println!(
        "calibration error as stated and as fitted without the group; right of those at least so sure\n"
    );
    println!("{}", left_out(&names, |s| s.kind().to_owned()));
    println!("{}", left_out(&names, |s| s.source.clone()));
    println!("{}", left_out(&names, |s| s.id.clone()));
    println!(
        "95 % intervals: true values held as stated, and widened as fitted without the source\n"
    );
    println!("{}", held_without(&names));
    let text = file(&names, &weights);
    println!("{text}");
    if o.bless {
        std::fs::write(CALIBRATION, text).map_err(|e| format!("{CALIBRATION}: {e}"))?;
    }
    Ok(())
}

fn file(names: &Names, weights: &[f64]) -> String {
    let mut sources = std::collections::BTreeMap::<&str, [usize; 2]>::new();
    for stated in &names.stated {
        let own = sources.entry(&stated.source).or_default();
        own[0] += usize::from(stated.right);
        own[1] += 1;
    }
    let mut text = String::from(
        "# Written by `cargo xtask calibrate --bless`: weights of the logistic behind a stated confidence, and widths of intervals.\n\n[weights]\n",
    );
    let keys = std::iter::once("constant").chain(names.features.iter().map(String::as_str));
    for (key, weight) in keys.zip(weights) {
        let _ = writeln!(text, "{key} = {weight:.3}");
    }
    text += "\n# Times that an interval of an effect is widened.\n[widths]\n";
    for (effect, width) in widths(names.distances.iter()) {
        let _ = writeln!(text, "{effect} = {width:.2}");
    }
    text += "\n# Names that it was fitted to: right, all.\n[names]\n";
    for (source, [right, all]) in sources {
        let _ = writeln!(text, "{source:?} = [{right}, {all}]");
    }
    text
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("calibrate: {reason}");
            ExitCode::FAILURE
        }
    }
}
