//! Known effects added to real recordings ([`crate::judge::inject`]), and what was said of the recordings before.

use crate::judge::case::{Case, Sort, Truth};
use crate::judge::inject::inject;
use crate::judge::real::{MACHINES, Machine};
use crate::judge::tool::{Tool, parallel};
use crate::trials::effect::INJECTED;

/// A machine and an effect that is added to its recording.
pub type Pair = (&'static Machine, &'static str);

/// The controls have no friction to carry an effect, and a turn one way only is refused as it is.
const CARRIES_NONE: [&str; 3] = ["silverbox", "tanks", "outrunner"];

/// Every `every`th wanted pair of recording and effect, `from` one of them on.
pub fn pairs(wanted: impl Fn(&str, &str) -> bool, from: usize, every: usize) -> Vec<Pair> {
    let machines = MACHINES
        .iter()
        .filter(|m| m.model.is_none() && !CARRIES_NONE.contains(&m.name));
    machines
        .flat_map(|machine| INJECTED.iter().map(move |effect| (machine, effect.id)))
        .filter(|(machine, effect)| wanted(machine.name, effect))
        .skip(from)
        .step_by(every)
        .collect()
}

/// Prints what the oracle says of each.
///
/// # Errors
/// Where a recording cannot be read.
pub fn oracles(pairs: &[Pair], strengths: &[f64]) -> Result<(), String> {
    for (machine, effect) in pairs {
        let recording = machine.recording()?;
        for strength in strengths {
            let said = match inject(&recording, effect, *strength) {
                None => "cannot be carried".to_owned(),
                Some(made) => format!(
                    "share of the loss {:6.3}, {:2} folds of 10, {:5.2} of what was added: {}",
                    made.oracle.share,
                    made.oracle.folds,
                    made.oracle.as_added,
                    if made.oracle.there {
                        "there"
                    } else {
                        "not there"
                    }
                ),
            };
            println!("{:<18} {effect:<20} {strength:>4} %: {said}", machine.name);
        }
    }
    Ok(())
}

/// Asks the tool of every pair at every strength. Where a machine is refused as it is, or is itself said to have the effect, the pair
/// is not asked, and a line says so.
///
/// # Errors
/// Where a recording cannot be read.
pub fn cases(
    tool: &Tool,
    pairs: &[Pair],
    strengths: &[f64],
    jobs: usize,
) -> Result<Vec<Case>, String> {
    let mut cases = Vec::new();
    for machine in MACHINES {
        let effects: Vec<&'static str> = pairs
            .iter()
            .filter(|pair| pair.0.name == machine.name)
            .map(|pair| pair.1)
            .collect();
        if effects.is_empty() {
            continue;
        }
        let recording = machine.recording()?;
        let (plain, seconds) = tool.diagnose(&recording);
        let plain = match plain {
            Ok(plain) => plain,
            Err(reason) => {
                eprintln!("{}: refused as it is: {reason}", machine.name);
                continue;
            }
        };
        let known = machine.known.iter().copied().flatten();
        let own: Vec<String> = plain
            .effects
            .iter()
            .map(|e| e.id.clone())
            .chain(known.map(|id| (*id).to_owned()))
            .collect();
        eprintln!(
            "{} as it is: {} [{}] {seconds:.1} s",
            machine.name,
            plain.verdict,
            own.join(", ")
        );
        let asked: Vec<(&'static str, f64)> = effects
            .into_iter()
            .flat_map(|effect| strengths.iter().map(move |strength| (effect, *strength)))
            .collect();
        let answered = parallel(&asked, jobs, |&(effect, strength)| {
            let made = inject(&recording, effect, strength)?;
            let sure = plain.effects.iter().filter(|e| e.confident);
            if sure
                .clone()
                .any(|e| made.truth.is(e) || made.truth.declared_by(e))
            {
                eprintln!("{}: has a {effect} of its own", machine.name);
                return None;
            }
            let (answer, seconds) = tool.diagnose(&made.recording);
            // Of what is known of the machine itself, a name is right, unless it is for more of the same.
            let known = machine.known.iter().copied().flatten();
            let native = known.filter(|id| **id != effect).map(|id| Truth::named(id));
            let case = Case {
                native: native.collect(),
                source: "injection",
                name: machine.name.to_owned(),
                sort: Sort::Single,
                strength,
                truth: vec![made.truth],
                neutral: own.clone(),
                absent: None,
                there: Some(made.oracle.there),
                verdicts: &[],
                answer,
                seconds,
            };
            eprintln!("{}", case.line());
            Some(case)
        });
        cases.extend(answered.into_iter().flatten());
    }
    Ok(cases)
}
