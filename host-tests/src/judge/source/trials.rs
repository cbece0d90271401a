//! The project's own trials ([`crate::trials`]) as cases.

use crate::answer::Diagnosis;
use crate::judge::case::{Case, Place, Sort, Truth};
use crate::judge::tool::{Tool, parallel};
use crate::trials::{Kind, Label, Trial, trial};

/// The sort of question that a kind of trial is.
pub fn sort(kind: Kind) -> Sort {
    match kind {
        Kind::Clean | Kind::CleanOf(_) => Sort::Clean,
        Kind::Single(..) => Sort::Single,
        Kind::Corner(_) | Kind::WrongBaseline(_) => Sort::Hidden,
        Kind::Pair(..) => Sort::Pair,
        Kind::Masked(..) => Sort::Masked,
        Kind::Outside(_) => Sort::Stranger,
    }
}

/// A trial with an answer.
pub fn case(label: &Label, answer: Result<Diagnosis, String>, seconds: f64) -> Case {
    let truth = label.effects.iter().enumerate().map(|(i, effect)| Truth {
        place: label
            .region
            .filter(|_| i == 0)
            .map(|region| Place::new(region.axis, region.from, region.to)),
        parameters: effect
            .parameters()
            .filter(|(name, value)| !name.starts_with("phase") && *value != 0.0)
            .map(|(name, value)| (name.to_owned(), value))
            .collect(),
        ..Truth::named(effect.id.name())
    });
    let truth: Vec<Truth> = truth.collect();
    // A lag follows a Stribeck curve.
    let lag = truth.iter().any(|t| t.id == "frictional_lag");
    Case {
        source: "trials",
        name: match label.kind {
            Kind::CleanOf(family) => format!(
                "seed {} ({}, {})",
                label.seed,
                label.law.name(),
                family.name()
            ),
            _ => format!("seed {} ({})", label.seed, label.law.name()),
        },
        sort: sort(label.kind),
        strength: match label.kind {
            Kind::Clean | Kind::CleanOf(_) => 0.0,
            kind => kind.strength().factor(),
        },
        truth,
        native: Vec::new(),
        neutral: if lag {
            vec!["stribeck".to_owned()]
        } else {
            Vec::new()
        },
        absent: None,
        there: None,
        verdicts: &[],
        answer,
        seconds,
    }
}

/// Asks the tool of every trial of a plan.
pub fn cases(tool: &Tool, plan: &[(u64, Kind)], jobs: usize) -> Vec<Case> {
    parallel(plan, jobs, |&(seed, kind)| {
        let made: Trial = trial(seed, kind);
        let (answer, seconds) = tool.diagnose(&made.given("trial"));
        let case = case(&made.label, answer, seconds);
        eprintln!("{}", case.line());
        case
    })
}
