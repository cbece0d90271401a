//! Real machines as they are, and controls that have no friction ([`crate::judge::real`]).

use crate::judge::case::{Case, Sort, Truth};
use crate::judge::real::MACHINES;
use crate::judge::tool::{Tool, parallel};

/// Asks the tool of every wanted machine. A refusal is right where only `insufficient-data` or an unknown would be.
///
/// # Errors
/// Where a file cannot be read.
pub fn cases(tool: &Tool, wanted: impl Fn(&str) -> bool, jobs: usize) -> Result<Vec<Case>, String> {
    let machines: Vec<_> = MACHINES.iter().filter(|m| wanted(m.name)).collect();
    let answered = parallel(&machines, jobs, |machine| {
        let (answer, seconds) = tool.diagnose(&machine.recording()?);
        // Of the names that are right for one thing, the first is the one asked; the others are no error.
        let known = machine.known.iter().filter_map(|names| names.split_first());
        let neutral = known.clone().flat_map(|(_, others)| others.iter());
        let control = ["silverbox", "tanks"].contains(&machine.name);
        let case = Case {
            source: if control { "controls" } else { "benches" },
            name: machine.name.to_owned(),
            sort: Sort::Machine,
            strength: 0.0,
            truth: known.map(|(first, _)| Truth::named(first)).collect(),
            native: Vec::new(),
            neutral: neutral.map(|id| (*id).to_owned()).collect(),
            absent: Some(machine.absent.iter().map(|id| (*id).to_owned()).collect()),
            there: None,
            verdicts: machine.verdicts,
            answer,
            seconds,
        };
        eprintln!("{}", case.line());
        Ok(case)
    });
    answered.into_iter().collect()
}
