//! The tables of a run of trials, and its results for machines.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::{Value, json};

use super::effect::{CATALOGUE, Strength};
use super::law::LAWS;
use super::score::{Judged, ParameterScore};

/// `part` of `whole` as a percentage with both counts.
fn share(part: usize, whole: usize) -> String {
    if whole == 0 {
        return "– (none)".to_owned();
    }
    format!(
        "{:5.1} % ({part}/{whole})",
        100.0 * part as f64 / whole as f64
    )
}

fn count(judged: &[&Judged], holds: impl Fn(&Judged) -> bool) -> String {
    share(judged.iter().filter(|j| holds(j)).count(), judged.len())
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.retain(|v| v.is_finite());
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

fn number(value: Option<f64>) -> String {
    value.map_or("–".to_owned(), |v| format!("{v:.3}"))
}

/// Expected calibration error over ten bins of equal width: mean distance of the stated confidence from
/// the share that is true, weighted by the number of statements (Naeini et al. 2015). `None` without any.
pub fn calibration_error(stated: &[(f64, bool)]) -> Option<f64> {
    let mut bins = [(0usize, 0.0, 0usize); 10];
    for &(confidence, there) in stated {
        let bin = &mut bins[((confidence * 10.0).max(0.0) as usize).min(9)];
        *bin = (bin.0 + 1, bin.1 + confidence, bin.2 + usize::from(there));
    }
    let gap: f64 = bins
        .iter()
        .map(|(_, sum, there)| (sum - *there as f64).abs())
        .sum();
    (!stated.is_empty()).then(|| gap / stated.len() as f64)
}

/// All tables, for a person to read.
pub fn tables(all: &[Judged]) -> String {
    let of = |kind: &str| all.iter().filter(|j| j.is(kind)).collect::<Vec<_>>();
    let mut text = String::new();
    let mut line = |what: &str, value: String| {
        let _ = writeln!(text, "  {what:<58} {value}");
    };
    line("trials", all.len().to_string());
    line(
        "without an answer",
        share(all.iter().filter(|j| j.answer.is_err()).count(), all.len()),
    );

    let clean = of("clean");
    line(
        "false alarms on clean recordings",
        count(&clean, Judged::alarms),
    );
    for law in LAWS {
        let own: Vec<&Judged> = clean
            .iter()
            .copied()
            .filter(|j| j.label.law == law)
            .collect();
        line(&format!("  {}", law.name()), count(&own, Judged::alarms));
    }
    for strength in [Strength::Weak, Strength::Typical, Strength::Strong] {
        let own: Vec<&Judged> = of("single")
            .into_iter()
            .filter(|j| j.label.strength == strength.name())
            .collect();
        let name = strength.name();
        line(
            &format!("first name right, alone, {name}"),
            count(&own, |j| j.found_within(1)),
        );
        line(
            &format!("one of two names right, alone, {name}"),
            count(&own, |j| j.found_within(2)),
        );
        line(
            &format!("named confidently, alone, {name}"),
            count(&own, |j| j.truth().iter().all(|&id| j.found(id, true))),
        );
    }
    for (kind, words) in [
        ("wrong_baseline", "absorbed by a wrong baseline"),
        ("corner", "in a corner of the travel"),
    ] {
        line(
            &format!("first name right, {words}"),
            count(&of(kind), |j| j.found_within(1)),
        );
    }
    for (low, high) in [
        (0.0, 8.0),
        (8.0, 30.0),
        (30.0, 100.0),
        (100.0, 300.0),
        (300.0, f64::INFINITY),
    ] {
        // By the worth that the diagnosis states of its first name, whichever that is.
        let own: Vec<&Judged> = all
            .iter()
            .filter(|j| !j.clean() && !j.is("outside"))
            .filter(|j| {
                j.names()
                    .first()
                    .is_some_and(|n| (low..high).contains(&n.nats))
            })
            .collect();
        line(
            &format!("first name right where it is stated at {low} to {high} nats"),
            count(&own, |j| j.found_within(1)),
        );
    }
    let (named, tenable) = all
        .iter()
        .map(Judged::confident)
        .fold((0, 0), |(n, t), (a, b)| (n + a, t + b));
    line("precision of confident names", share(tenable, named));
    let both = |j: &Judged| j.truth().iter().all(|&id| j.found(id, false));
    line("both of a pair named", count(&of("pair"), both));
    line(
        "both of a pair named confidently",
        count(&of("pair"), |j| {
            j.truth().iter().all(|&id| j.found(id, true))
        }),
    );
    line(
        "hidden behind a three times larger one, named",
        count(&of("masked"), |j| {
            j.truth().first().is_some_and(|&id| j.found(id, false))
        }),
    );
    let outside = of("outside");
    let unknown = |j: &Judged| j.answer.as_ref().is_ok_and(|a| a.unknown);
    line(
        "outside the catalogue, flagged as unknown",
        count(&outside, unknown),
    );
    line(
        "outside the catalogue, named confidently",
        count(&outside, |j| j.confident().0 > 0),
    );

    let found: Vec<Option<f64>> = all.iter().filter_map(Judged::localisation).collect();
    let placed: Vec<f64> = found.iter().copied().flatten().collect();
    line(
        "place stated for effects that have one",
        share(placed.len(), found.len()),
    );
    line(
        "  median distance of centres, in widths of the true place",
        number(median(placed)),
    );
    let improvements: Vec<f64> = all
        .iter()
        .filter(|j| j.label.effects.iter().all(|e| e.id.in_catalogue()))
        .filter_map(Judged::improvement)
        .collect();
    line(
        &format!(
            "share of the achievable improvement, median of {}",
            improvements.len()
        ),
        number(median(improvements)),
    );
    let stated: Vec<(f64, bool)> = all.iter().flat_map(Judged::stated).collect();
    line(
        &format!("expected calibration error of {} confidences", stated.len()),
        number(calibration_error(&stated)),
    );
    let scores: Vec<ParameterScore> = all.iter().flat_map(Judged::parameters).collect();
    let covered: Vec<bool> = scores.iter().filter_map(|s| s.covered).collect();
    line(
        "95 % intervals that hold the true value",
        share(covered.iter().filter(|c| **c).count(), covered.len()),
    );
    let seconds = |pick: fn(&Judged) -> f64| all.iter().map(pick).collect::<Vec<f64>>();
    line(
        "time of a diagnosis, median [s]",
        number(median(seconds(|j| j.wall_s))),
    );
    line(
        "time of a diagnosis, longest [s]",
        number(seconds(|j| j.wall_s).into_iter().reduce(f64::max)),
    );

    confusion(all, &mut text);
    parameters(&scores, &mut text);
    text
}

/// One row for each true effect alone: the first names given, most frequent first.
fn confusion(all: &[Judged], text: &mut String) {
    let _ = writeln!(
        text,
        "\nConfusion (effects alone; first name given, `?` where only suspected):"
    );
    let mut rows: BTreeMap<(usize, &str), BTreeMap<String, usize>> = BTreeMap::new();
    for judged in all.iter().filter(|j| !j.is("pair") && !j.is("masked")) {
        let row = match judged.truth().first() {
            None => (0, "clean"),
            Some(id) => {
                let place = CATALOGUE
                    .iter()
                    .position(|c| c == id)
                    .unwrap_or(CATALOGUE.len());
                (place + 1, id.name())
            }
        };
        let said = match (&judged.answer, judged.names().first()) {
            (Err(_), _) => "no answer".to_owned(),
            (Ok(answer), _) if answer.unknown && !answer.effects.iter().any(|e| e.confident) => {
                "unknown".to_owned()
            }
            (Ok(answer), None) => answer.verdict.clone(),
            (_, Some(name)) => format!("{}{}", name.id, if name.confident { "" } else { "?" }),
        };
        *rows.entry(row).or_default().entry(said).or_default() += 1;
    }
    for ((_, truth), said) in rows {
        let mut said: Vec<(String, usize)> = said.into_iter().collect();
        said.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
        let said: Vec<String> = said.iter().map(|(name, n)| format!("{name} {n}")).collect();
        let _ = writeln!(text, "  {truth:<24} {}", said.join(", "));
    }
}

fn parameters(scores: &[ParameterScore], text: &mut String) {
    let _ = writeln!(
        text,
        "\nParameters of rightly named effects (by name, or else by unit):"
    );
    let mut rows: BTreeMap<&str, Vec<&ParameterScore>> = BTreeMap::new();
    for score in scores {
        rows.entry(&score.name).or_default().push(score);
    }
    for (name, scores) in rows {
        let covered: Vec<bool> = scores.iter().filter_map(|s| s.covered).collect();
        let _ = writeln!(
            text,
            "  {name:<46} {:>3} times, median error {:>6.1} %, inside the interval {}",
            scores.len(),
            100.0 * median(scores.iter().map(|s| s.relative_error).collect()).unwrap_or(f64::NAN),
            share(covered.iter().filter(|c| **c).count(), covered.len())
        );
    }
}

/// Every trial with label, answer and judgement, for machines.
pub fn to_json(all: &[Judged]) -> Value {
    let trials: Vec<Value> = all
        .iter()
        .map(|j| {
            let effects: Vec<Value> = j
                .label
                .effects
                .iter()
                .zip(&j.effect_rms)
                .map(|(effect, rms)| {
                    let parameters: BTreeMap<_, _> = effect.parameters().collect();
                    json!({ "id": effect.id.name(), "parameters": parameters, "rms_N": rms })
                })
                .collect();
            let names: Vec<Value> = j
                .names()
                .iter()
                .map(|n| json!({ "id": n.id, "confident": n.confident, "confidence": n.confidence, "nats": n.nats }))
                .collect();
            json!({
                "seed": j.label.seed,
                "kind": j.label.kind.name(),
                "law": j.label.law.name(),
                "strength": j.label.strength,
                "effects": effects,
                "achievable": { "baseline_nmse": j.achievable_nmse.0, "floor_nmse": j.achievable_nmse.1 },
                "error": j.answer.as_ref().err(),
                "verdict": j.answer.as_ref().ok().map(|a| &a.verdict),
                "unknown": j.answer.as_ref().ok().map(|a| a.unknown),
                "names": names,
                "first_right": j.found_within(1),
                "improvement": j.improvement(),
                "wall_s": j.wall_s,
            })
        })
        .collect();
    json!({ "schema": "preslide.trials/1", "trials": trials })
}
