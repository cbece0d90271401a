//! `cargo xtask`: builds, checks and measures Preslide; installs what that needs.

mod book;
mod browser;
mod chain;
mod commission;
mod example;
mod example_riscv;
mod files;
mod image;
mod imports;
mod judge;
mod logged;
mod package;
mod python;
mod qemu;
mod steps;
mod test;

use std::process::ExitCode;

use anyhow::{Result, bail};
use preslide_cycle_tables as cycles;

struct Command {
    name: &'static str,
    help: &'static str,
    run: fn(&[String]) -> Result<()>,
}

const COMMANDS: &[Command] = &[
    Command {
        name: "test",
        help: "everything CI runs, or the steps named; --all adds the long studies before a release; --serial runs one step at a time; installs what is missing",
        run: test::run_steps,
    },
    Command {
        name: "book",
        help: "builds the book, runs the commands in it and compares what they print; --bless takes new output",
        run: |arguments| {
            let bless = given(&["--bless"], arguments)?.is_some();
            book::run_command(bless, steps::has_step)
        },
    },
    Command {
        name: "imports",
        help: "checks who imports whom: no circles, and the order in ARCHITECTURE.md",
        run: |arguments| given(&[], arguments).and_then(|_| imports::check()),
    },
    Command {
        name: "cycles",
        help: "counts the cycles of each kernel's update on a Cortex-M4F; --check compares with the committed tables if their sources changed, --recount always; --tick splits a control tick; --m0plus and --hazard3 count on the RP2040 and, exactly, on the RP2350's RISC-V core",
        run: |arguments| cycles::run_command(given(&cycles::FLAGS, arguments)?),
    },
    Command {
        name: "qemu",
        help: "runs the firmware in QEMU against the simulated stage: agreement, faults, sizes; --long adds all pairs of law and arithmetic, the whole motion of the commissioning chapter, the cable pulled in every stage, ten times the requests, and a capture identified; --bless takes new outputs",
        run: |arguments| qemu::run_command(given(&["--bless", "--long"], arguments)?),
    },
    Command {
        name: "stage",
        help: "serves an emulated drive, the firmware in QEMU on the simulated stage, on tcp:127.0.0.1:7700 or the PORT named",
        run: qemu::serve_command,
    },
    Command {
        name: "chain",
        help: "records hidden effects, diagnoses them, compiles them into the firmware and tracks again; --seed N, --count K, --brief for what decides alone",
        run: chain::run_command,
    },
];

/// Judges of the diagnosis, each with what it tells; `--help` behind one lists its options.
const JUDGES: [(&str, &str); 6] = [
    (
        "properties",
        "does the diagnosis say the same of a recording that is cut, mirrored, thinned, …?",
    ),
    (
        "inject",
        "are known effects, added to real recordings, named where an oracle sees them?",
    ),
    (
        "experiments",
        "do experiments help, against one recording as long, where it hardly shows the effect?",
    ),
    (
        "sources",
        "how often is the diagnosis right, on every source of recordings with a known truth? one table",
    ),
    (
        "calibrate",
        "fits the confidence of names to judged ones (JSON of `sources` and `inject`), each source left out in turn; --bless writes it",
    ),
    (
        "real",
        "prints what the diagnosis says of each real recording, or of the NAME given",
    ),
];

fn main() -> ExitCode {
    if let Some(code) = cycles::nowhere::rustc() {
        return code;
    }
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let is_help = |word: &String| ["--help", "-h"].contains(&word.as_str());
    let (name, rest) = match arguments.split_first() {
        Some((name, rest)) if name != "help" && !is_help(name) => (name, rest),
        _ => {
            println!("cargo xtask COMMAND\n");
            for (name, help) in commands() {
                println!("  {name:<11} {help}");
            }
            return ExitCode::SUCCESS;
        }
    };
    let done = match COMMANDS.iter().find(|command| command.name == name) {
        Some(command) if rest.iter().any(is_help) => {
            println!("cargo xtask {name}: {}", command.help);
            Ok(())
        }
        Some(command) => (command.run)(rest),
        None if is_command(name) => judge::judge(name, rest),
        None => {
            eprintln!("xtask: there is no command `{name}`; `cargo xtask help` lists them");
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("xtask {name}: {reason:#}");
            ExitCode::FAILURE
        }
    }
}

/// Every command with what it does.
fn commands() -> impl Iterator<Item = (&'static str, &'static str)> {
    let own = COMMANDS.iter().map(|command| (command.name, command.help));
    own.chain(JUDGES)
}

/// Whether there is one of this name.
fn is_command(name: &str) -> bool {
    commands().any(|(known, _)| known == name)
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
