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
    let mut table = Table {
        all,
        text: String::new(),
    };
    table.line("trials", all.len().to_string());
    table.share_of("without an answer", |_| true, |j| j.answer.is_err());
    table.false_alarms();
    table.effects_alone();
    table.by_worth();
    table.effects_together();
    table.outside_the_catalogue();
    table.place_and_improvement();
    let scores: Vec<ParameterScore> = all.iter().flat_map(Judged::parameters).collect();
    table.calibration(&scores);
    table.times();

    let mut text = table.text;
    confusion(all, &mut text);
    parameters(&scores, &mut text);
    text
}

/// The figures of a run, a line each.
struct Table<'a> {
    all: &'a [Judged],
    text: String,
}

impl<'a> Table<'a> {
    fn line(&mut self, what: &str, value: String) {
        let _ = writeln!(self.text, "  {what:<58} {value}");
    }

    /// Of the trials that are `among`, the share of those for which it `holds`.
    fn share_of(
        &mut self,
        what: &str,
        among: impl Fn(&Judged) -> bool,
        holds: impl Fn(&Judged) -> bool,
    ) {
        let own: Vec<&Judged> = self.all.iter().filter(|j| among(j)).collect();
        self.line(what, count(&own, holds));
    }

    fn false_alarms(&mut self) {
        self.share_of(
            "false alarms on clean recordings",
            |j| j.is("clean"),
            Judged::alarms,
        );
        for law in LAWS {
            self.share_of(
                &format!("  {}", law.name()),
                |j| j.is("clean") && j.label.law == law,
                Judged::alarms,
            );
        }
    }

    fn effects_alone(&mut self) {
        for strength in [Strength::Weak, Strength::Typical, Strength::Strong] {
            let name = strength.name();
            let own = |j: &Judged| j.is("single") && j.label.strength == name;
            self.share_of(&format!("first name right, alone, {name}"), own, |j| {
                j.found_within(1)
            });
            self.share_of(
                &format!("one of two names right, alone, {name}"),
                own,
                |j| j.found_within(2),
            );
            self.share_of(
                &format!("named confidently, alone, {name}"),
                own,
                all_named_confidently,
            );
        }
        for (kind, words) in [
            ("wrong_baseline", "absorbed by a wrong baseline"),
            ("corner", "in a corner of the travel"),
        ] {
            self.share_of(
                &format!("first name right, {words}"),
                |j| j.is(kind),
                |j| j.found_within(1),
            );
        }
    }

    /// By the worth that the diagnosis states of its first name, whichever that is.
    fn by_worth(&mut self) {
        for (low, high) in [
            (0.0, 8.0),
            (8.0, 30.0),
            (30.0, 100.0),
            (100.0, 300.0),
            (300.0, f64::INFINITY),
        ] {
            let first_is_worth = |j: &Judged| {
                let names = j.names();
                let first = names.first();
                first.is_some_and(|n| (low..high).contains(&n.nats))
            };
            self.share_of(
                &format!("first name right where it is stated at {low} to {high} nats"),
                |j| !j.clean() && !j.is("outside") && first_is_worth(j),
                |j| j.found_within(1),
            );
        }
        let (named, tenable) = self
            .all
            .iter()
            .map(Judged::confident)
            .fold((0, 0), |(n, t), (a, b)| (n + a, t + b));
        self.line("precision of confident names", share(tenable, named));
    }

    fn effects_together(&mut self) {
        let pair = |j: &Judged| j.is("pair");
        self.share_of("both of a pair named", pair, |j| {
            j.truth().iter().all(|&id| j.found(id, false))
        });
        self.share_of(
            "both of a pair named confidently",
            pair,
            all_named_confidently,
        );
        self.share_of(
            "hidden behind a three times larger one, named",
            |j| j.is("masked"),
            |j| j.truth().first().is_some_and(|&id| j.found(id, false)),
        );
    }

    fn outside_the_catalogue(&mut self) {
        let outside = |j: &Judged| j.is("outside");
        self.share_of("outside the catalogue, flagged as unknown", outside, |j| {
            j.answer.as_ref().is_ok_and(|a| a.unknown)
        });
        self.share_of("outside the catalogue, named confidently", outside, |j| {
            j.confident().0 > 0
        });
    }

    fn place_and_improvement(&mut self) {
        let found: Vec<Option<f64>> = self.all.iter().filter_map(Judged::localisation).collect();
        let placed: Vec<f64> = found.iter().copied().flatten().collect();
        self.line(
            "place stated for effects that have one",
            share(placed.len(), found.len()),
        );
        self.line(
            "  median distance of centres, in widths of the true place",
            number(median(placed)),
        );
        let improvements: Vec<f64> = self
            .all
            .iter()
            .filter(|j| j.label.effects.iter().all(|e| e.id.in_catalogue()))
            .filter_map(Judged::improvement)
            .collect();
        self.line(
            &format!(
                "share of the achievable improvement, median of {}",
                improvements.len()
            ),
            number(median(improvements)),
        );
    }

    fn calibration(&mut self, scores: &[ParameterScore]) {
        let stated: Vec<(f64, bool)> = self.all.iter().flat_map(Judged::stated).collect();
        self.line(
            &format!("expected calibration error of {} confidences", stated.len()),
            number(calibration_error(&stated)),
        );
        let covered: Vec<bool> = scores.iter().filter_map(|s| s.covered).collect();
        self.line(
            "95 % intervals that hold the true value",
            share(covered.iter().filter(|c| **c).count(), covered.len()),
        );
    }

    fn times(&mut self) {
        let seconds: Vec<f64> = self.all.iter().map(|j| j.wall_s).collect();
        let longest = seconds.iter().copied().reduce(f64::max);
        self.line("time of a diagnosis, median [s]", number(median(seconds)));
        self.line("time of a diagnosis, longest [s]", number(longest));
    }
}

fn all_named_confidently(judged: &Judged) -> bool {
    judged.truth().iter().all(|&id| judged.found(id, true))
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
