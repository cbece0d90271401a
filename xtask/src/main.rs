//! `cargo xtask`: builds, checks and measures Preslide; installs what that needs.

mod book;
mod browser;
mod files;
mod imports;
mod judge;
mod package;
mod python;
mod steps;
mod test;

use std::process::ExitCode;

use anyhow::{Result, bail};
use preslide_cycle_tables as cycles;
use preslide_emulated::{chain, qemu};

/// Every command with what it does, a line each. The last six are judges of the diagnosis, which list their own options.
const HELP: &str = "cargo xtask COMMAND

  test        everything CI runs, or the steps named; --all adds the long studies before a release; --serial runs one step at a time; installs what is missing
  book        builds the book, runs the commands in it and compares what they print; --bless takes new output
  imports     checks who imports whom: no circles, and the order in ARCHITECTURE.md
  cycles      counts the cycles of each kernel's update on a Cortex-M4F; --check compares with the committed tables if their sources changed, --recount always; --tick splits a control tick; --m0plus and --hazard3 count on the RP2040 and, exactly, on the RP2350's RISC-V core
  qemu        runs the firmware in QEMU against the simulated stage: agreement, faults, sizes; --long adds all pairs of law and arithmetic, the whole motion of the commissioning chapter, the cable pulled in every stage, ten times the requests, and a capture identified; --bless takes new outputs
  stage       serves an emulated drive, the firmware in QEMU on the simulated stage, on tcp:127.0.0.1:7700 or the PORT named
  chain       records hidden effects, diagnoses them, compiles them into the firmware and tracks again; --seed N, --count K, --brief for what decides alone
  properties  does the diagnosis say the same of a recording that is cut, mirrored, thinned, …?
  inject      are known effects, added to real recordings, named where an oracle sees them?
  experiments do experiments help, against one recording as long, where it hardly shows the effect?
  sources     how often is the diagnosis right, on every source of recordings with a known truth? one table
  calibrate   fits the confidence of names to judged ones (JSON of `sources` and `inject`), each source left out in turn; --bless writes it
  real        prints what the diagnosis says of each real recording, or of the NAME given
";

fn main() -> ExitCode {
    if let Some(code) = cycles::nowhere::rustc() {
        return code;
    }
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (name, rest) = match arguments.split_first() {
        Some((name, rest)) if !["help", "--help", "-h"].contains(&name.as_str()) => (name, rest),
        _ => {
            print!("{HELP}");
            return ExitCode::SUCCESS;
        }
    };
    let Some(help) = help(name) else {
        eprintln!("xtask: there is no command `{name}`; `cargo xtask help` lists them");
        return ExitCode::from(2);
    };
    match command(name, help, rest) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("xtask {name}: {reason:#}");
            ExitCode::FAILURE
        }
    }
}

/// The line of a command, if there is one of this name.
fn help(name: &str) -> Option<&'static str> {
    HELP.lines()
        .skip(1)
        .find(|line| line.split_whitespace().next() == Some(name))
}

/// Whether there is a command of this name.
fn is_command(name: &str) -> bool {
    help(name).is_some()
}

fn command(name: &str, help: &str, arguments: &[String]) -> Result<()> {
    match name {
        "properties" | "inject" | "experiments" | "sources" | "calibrate" | "real" => {
            judge::judge(name, arguments)
        }
        _ if arguments
            .iter()
            .any(|word| ["--help", "-h"].contains(&word.as_str())) =>
        {
            println!("cargo xtask {}", help.trim());
            Ok(())
        }
        "test" => test::run_steps(arguments),
        "book" => {
            let bless = given(&["--bless"], arguments)?.is_some();
            book::run_command(bless, steps::has_step)
        }
        "imports" => given(&[], arguments).and_then(|_| imports::check()),
        "cycles" => cycles::run_command(given(&cycles::FLAGS, arguments)?),
        "qemu" => qemu::run_command(given(&["--bless", "--long"], arguments)?),
        "stage" => qemu::serve_command(arguments),
        "chain" => chain::run_command(arguments),
        _ => bail!("nothing does it"),
    }
}

/// Which of the flags that a command takes was given, if one was.
fn given<'a>(flags: &[&'a str], arguments: &[String]) -> Result<Option<&'a str>> {
    let known = match arguments {
        [] => return Ok(None),
        [one] => flags.iter().find(|flag| one == *flag),
        _ => None,
    };
    if known.is_none() {
        let known = [flags, &["nothing"]].concat().join(" or ");
        bail!("it takes {known}, got `{}`", arguments.join(" "));
    }
    Ok(known.copied())
}

#[cfg(test)]
mod tests {
    use super::given;

    #[test]
    fn every_flag_of_a_command_is_known_and_no_other() {
        let flags = ["--check", "--tick"];
        let of = |words: &[&str]| {
            let words: Vec<String> = words.iter().map(|w| (*w).to_owned()).collect();
            given(&flags, &words).map_err(|error| error.to_string())
        };
        assert_eq!(of(&[]), Ok(None));
        for flag in flags {
            assert_eq!(of(&[flag]), Ok(Some(flag)));
        }
        for wrong in [
            &["--check, --tick"][..],
            &["--bless"],
            &["--check", "--tick"],
        ] {
            let error = of(wrong).expect_err("no flag of it");
            assert!(error.contains("--check or --tick"), "{error}");
        }
    }
}
