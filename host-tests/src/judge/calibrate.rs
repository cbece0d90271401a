//! The logistic behind a stated confidence, fitted to judged names, and how far off it is on what it was fitted without.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use nalgebra::{DMatrix, DVector};
use serde_json::Value;

use super::summary::calibration_error;

/// Squares of all weights but the constant are added to the loss with this weight: a feature that hardly varies gets none.
const RIDGE: f64 = 1.0;
/// What all recordings of real machines are called: they are one source, whatever was added to them.
const REAL: &str = "real";
/// Steps of Newton's method; it ends in about eight.
const STEPS: usize = 50;
/// Share of true values that an interval is to hold.
const HELD: f64 = 0.95;
/// True values from which an effect's intervals have a width of their own: one in twenty may be outside.
const ENOUGH: usize = 20;
/// A feature that suspicions have, and names have not.
const OF_HINTS: &str = "evidence";
/// The key of all other effects' intervals.
const OTHERS: &str = "others";

/// A name that was stated, with its truth.
pub struct Stated {
    /// Where the recording is from; the machine, for real ones.
    pub source: String,
    /// The effect that was named.
    pub id: String,
    /// What its confidence is computed from, in the order of [`Judged::features`].
    pub features: Vec<f64>,
    /// What the program stated.
    pub confidence: f64,
    /// Whether it is there.
    pub right: bool,
}

/// Statements of one kind whose truth is known.
#[derive(Default)]
pub struct Judged {
    /// Names of the features.
    pub features: Vec<String>,
    /// The statements.
    pub stated: Vec<Stated>,
}

/// Judged names of some cases.
pub struct Names {
    /// Names that were stated.
    pub names: Judged,
    /// Suspicions, of what did not enter the model.
    pub hints: Judged,
    /// What may be there without a name: right where something is.
    pub unnamed: Judged,
    /// By source and effect: how far a true value is from the middle of its interval, in half widths before widening.
    pub distances: Vec<(String, String, f64)>,
    /// How many times an effect's interval was widened by the program that stated it.
    widened: BTreeMap<String, f64>,
}

/// The program's own calibration.
pub const CALIBRATION: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../host/src/diagnose/calibration.toml"
);

/// The width of an effect among some widths.
fn width(widths: &BTreeMap<String, f64>, effect: &str) -> f64 {
    *widths.get(effect).or(widths.get(OTHERS)).unwrap_or(&1.0)
}

/// A table of the program's calibration as it is committed.
///
/// # Errors
/// Where it cannot be read or has no such table.
pub fn committed(table: &str) -> Result<toml::Table, String> {
    let wrong = |reason: String| format!("{CALIBRATION}: {reason}");
    let text = std::fs::read_to_string(CALIBRATION).map_err(|e| wrong(e.to_string()))?;
    let mut all: toml::Table = toml::from_str(&text).map_err(|e| wrong(e.to_string()))?;
    match all.remove(table) {
        Some(toml::Value::Table(own)) => Ok(own),
        _ => Err(wrong(format!("no table {table}"))),
    }
}

/// The widths of the program as it is committed.
fn committed_widths() -> Result<BTreeMap<String, f64>, String> {
    Ok(committed("widths")?
        .iter()
        .filter_map(|(effect, width)| Some((effect.clone(), width.as_float()?)))
        .collect())
}

impl Names {
    /// From files that `sources --json` and `inject --json` write, by a program with the committed widths: names from `files`, what has no
    /// name from `unnamed`.
    ///
    /// # Errors
    /// What is missing in which file.
    pub fn read(files: &[PathBuf], unnamed: &[PathBuf]) -> Result<Self, String> {
        let mut names = Self {
            names: Judged::default(),
            hints: Judged::default(),
            unnamed: Judged::default(),
            distances: Vec::new(),
            widened: committed_widths()?,
        };
        for file in files {
            names.add_all(file, Self::add)?;
        }
        for file in unnamed {
            names.add_all(file, Self::add_unnamed)?;
        }
        Ok(names)
    }

    fn add_all(
        &mut self,
        file: &Path,
        add: impl Fn(&mut Self, &Value) -> Result<(), String>,
    ) -> Result<(), String> {
        let wrong = |reason: String| format!("{}: {reason}", file.display());
        let text = std::fs::read_to_string(file).map_err(|e| wrong(e.to_string()))?;
        let cases: Value = serde_json::from_str(&text).map_err(|e| wrong(e.to_string()))?;
        let cases = cases.as_array().ok_or_else(|| wrong("no list".into()))?;
        cases
            .iter()
            .try_for_each(|case| add(self, case).map_err(wrong))
    }

    fn add(&mut self, case: &Value) -> Result<(), String> {
        let word = |key: &str| case[key].as_str().unwrap_or_default().to_owned();
        let mut source = word("source");
        if ["injection", "benches", "controls"].contains(&source.as_str()) {
            source = format!("{REAL}: {}", word("name"));
        }
        for distance in case["distances"].as_array().into_iter().flatten() {
            let key = distance[0].as_str().ok_or("a distance without a key")?;
            let effect = key.split('.').next().unwrap_or_default();
            self.distances.push((
                source.clone(),
                effect.to_owned(),
                distance[1].as_f64().ok_or("a distance that is no number")?
                    * width(&self.widened, effect),
            ));
        }
        let names = case["names"].as_array().ok_or("a case without names")?;
        names.iter().try_for_each(|name| {
            let is_hint = name["features"].get(OF_HINTS).is_some();
            let judged = if is_hint {
                &mut self.hints
            } else {
                &mut self.names
            };
            judged.add(&source, name)
        })
    }

    fn add_unnamed(&mut self, case: &Value) -> Result<(), String> {
        let source = case["source"].as_str().unwrap_or_default();
        // Each out-of-catalogue effect is a group of its own: what finds one must find the next.
        let group = match case["truth"][0].as_str() {
            Some(stranger) => format!("{source}: {stranger}"),
            None => source.to_owned(),
        };
        let unnamed = case["unnamed"]
            .as_array()
            .ok_or("a case without `unnamed`")?;
        unnamed.iter().try_for_each(|u| self.unnamed.add(&group, u))
    }
}

impl Judged {
    /// Adds a statement if its truth is known.
    fn add(&mut self, source: &str, statement: &Value) -> Result<(), String> {
        let (Some(features), Some(right)) = (
            statement["features"].as_object(),
            statement["right"].as_bool(),
        ) else {
            return Ok(());
        };
        let keys: Vec<String> = features.keys().cloned().collect();
        if self.features.is_empty() {
            self.features = keys;
        } else if self.features != keys {
            return Err(format!(
                "features {keys:?} instead of {:?}: written by another version of the program",
                self.features
            ));
        }
        self.stated.push(Stated {
            source: source.to_owned(),
            id: statement["id"].as_str().unwrap_or_default().to_owned(),
            features: features
                .values()
                .map(|v| v.as_f64().ok_or("a feature that is no number"))
                .collect::<Result<_, _>>()?,
            confidence: statement["confidence"].as_f64().ok_or("no confidence")?,
            right,
        });
        Ok(())
    }
}

impl Stated {
    /// Its source, one for all real machines.
    pub fn kind(&self) -> &str {
        self.source.split(": ").next().unwrap_or_default()
    }
}

/// How much each name counts: sources count alike, however many names they have.
fn shares(names: &[&Stated]) -> Vec<f64> {
    let mut counts = BTreeMap::<&str, usize>::new();
    for name in names {
        *counts.entry(name.kind()).or_default() += 1;
    }
    let fair = names.len() as f64 / counts.len() as f64;
    names
        .iter()
        .map(|n| fair / counts[n.kind()] as f64)
        .collect()
}

/// The constant, then a weight for each feature: the maximum of the likelihood less the ridge.
pub fn fit<'a>(names: impl Iterator<Item = &'a Stated>) -> Option<Vec<f64>> {
    let names: Vec<&Stated> = names.collect();
    let count = names.first()?.features.len() + 1;
    let shares = shares(&names);
    let rows = DMatrix::from_fn(names.len(), count, |i, j| {
        if j == 0 {
            1.0
        } else {
            names[i].features[j - 1]
        }
    });
    let ridge = DMatrix::from_diagonal(&DVector::from_fn(
        count,
        |j, _| {
            if j == 0 { 1e-6 } else { RIDGE }
        },
    ));
    let mut weights = DVector::zeros(count);
    for _ in 0..STEPS {
        let p = (&rows * &weights).map(logistic);
        let error = DVector::from_fn(names.len(), |i, _| {
            shares[i] * (f64::from(names[i].right) - p[i])
        });
        let slope = rows.transpose() * error - &ridge * &weights;
        let bent = DMatrix::from_fn(names.len(), count, |i, j| {
            shares[i] * rows[(i, j)] * p[i] * (1.0 - p[i])
        });
        let step = (rows.transpose() * bent + &ridge).lu().solve(&slope)?;
        weights += &step;
        if step.norm() < 1e-9 {
            break;
        }
    }
    Some(weights.iter().copied().collect())
}

/// How many times as wide an interval must be to hold 95 % of the true values, by effect where there are 20 of them, else over all
/// others; sources count alike.
pub fn widths<'a>(
    distances: impl Iterator<Item = &'a (String, String, f64)>,
) -> BTreeMap<String, f64> {
    let all: Vec<_> = distances.collect();
    let mut groups = BTreeMap::<&str, Vec<(&str, f64)>>::new();
    for (source, effect, distance) in &all {
        let own = all.iter().filter(|d| d.1 == *effect).count();
        let key = if own >= ENOUGH { effect } else { OTHERS };
        groups.entry(key).or_default().push((source, *distance));
    }
    groups
        .into_iter()
        .map(|(key, own)| (key.to_owned(), quantile(own).max(1.0)))
        .collect()
}

/// The distance that [`HELD`] of them do not exceed, each weighted by its source's share.
fn quantile(mut distances: Vec<(&str, f64)>) -> f64 {
    distances.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut counts = BTreeMap::<&str, f64>::new();
    for (source, _) in &distances {
        *counts.entry(source).or_default() += 1.0;
    }
    let whole = counts.len() as f64;
    let mut below = 0.0;
    let held = distances.iter().find(|(source, _)| {
        below += 1.0 / counts[source];
        below >= HELD * whole - 1e-9
    });
    held.map_or(1.0, |d| d.1)
}

/// For each source: true values, how many the intervals as stated hold, and how many those widened without it.
pub fn held_without(names: &Names) -> String {
    let sources: std::collections::BTreeSet<&str> =
        names.distances.iter().map(|d| d.0.as_str()).collect();
    let mut text = format!(
        "{:<28} {:>9} {:>8} {:>8}\n",
        "left out", "values", "held", "widened"
    );
    for source in sources {
        let widths = widths(names.distances.iter().filter(|d| d.0 != source));
        let own = || names.distances.iter().filter(|d| d.0 == source);
        let held = own().filter(|d| d.2 <= width(&names.widened, &d.1)).count();
        let widened = own().filter(|d| d.2 <= width(&widths, &d.1)).count();
        let _ = writeln!(
            text,
            "{source:<28} {:>9} {held:>8} {widened:>8}",
            own().count()
        );
    }
    text
}

/// Probability under some weights.
pub fn probability(weights: &[f64], features: &[f64]) -> f64 {
    let sum: f64 = weights[1..].iter().zip(features).map(|(w, f)| w * f).sum();
    logistic(weights[0] + sum)
}

fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

/// For each group (a source, a machine, an effect): names, how many are right, calibration error as stated and under weights
/// fitted without the group, precision of those that then are at least 0.6 and 0.9.
pub fn left_out(names: &Judged, group: impl Fn(&Stated) -> String) -> String {
    let mut groups = BTreeMap::<String, Vec<&Stated>>::new();
    for stated in &names.stated {
        groups.entry(group(stated)).or_default().push(stated);
    }
    let mut text = format!(
        "{:<28} {:>9} {:>8} {:>8} {:>11} {:>11}\n",
        "left out", "right", "stated", "fitted", "at ≥ 0.6", "at ≥ 0.9"
    );
    let mut all: Vec<(f64, bool)> = Vec::new();
    for (name, own) in &groups {
        let others = names.stated.iter().filter(|s| group(s) != *name);
        let Some(weights) = fit(others) else {
            continue;
        };
        let stated: Vec<(f64, bool)> = own.iter().map(|s| (s.confidence, s.right)).collect();
        let fitted: Vec<(f64, bool)> = own
            .iter()
            .map(|s| (probability(&weights, &s.features), s.right))
            .collect();
        text += &row(name, &stated, &fitted);
        all.extend(fitted);
    }
    let stated: Vec<(f64, bool)> = names
        .stated
        .iter()
        .map(|s| (s.confidence, s.right))
        .collect();
    text + &row("all", &stated, &all)
}

fn row(name: &str, stated: &[(f64, bool)], fitted: &[(f64, bool)]) -> String {
    let above = |least: f64| {
        let own = fitted.iter().filter(|f| f.0 >= least);
        let (count, right) = own.fold((0, 0), |(n, r), f| (n + 1, r + usize::from(f.1)));
        format!("{right}/{count}")
    };
    let right = stated.iter().filter(|s| s.1).count();
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{name:<28} {:>9} {:>8.3} {:>8.3} {:>11} {:>11}",
        format!("{right}/{}", stated.len()),
        calibration_error(stated),
        calibration_error(fitted),
        above(0.6),
        above(0.9)
    );
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 20 distances of one effect, 0.1 to 2.0, and three of another: 95 % of the former are up to 1.9, and all of the latter.
    #[test]
    fn intervals_are_widened_to_hold_nineteen_of_twenty() {
        let many = (1..=20).map(|i| ("a".to_owned(), "stribeck".to_owned(), 0.1 * f64::from(i)));
        let few = [0.5, 2.5, 3.0].map(|d| ("a".to_owned(), "viscous".to_owned(), d));
        let distances: Vec<_> = many.chain(few).collect();
        let widths = widths(distances.iter());
        assert_eq!(widths.keys().collect::<Vec<_>>(), [OTHERS, "stribeck"]);
        assert!((widths["stribeck"] - 1.9).abs() < 1e-12, "{widths:?}");
        assert!((widths[OTHERS] - 3.0).abs() < 1e-12, "{widths:?}");
    }

    fn stated(source: &str, feature: f64, right: bool) -> Stated {
        Stated {
            source: source.to_owned(),
            id: String::new(),
            features: vec![feature],
            confidence: 0.5,
            right,
        }
    }

    /// Nine in ten of 2000 names are right in one source and one in ten of 10 in the other: even odds, if sources count alike.
    #[test]
    fn a_small_source_counts_as_much() {
        let many = (0..2000).map(|i| stated("many", f64::from(i % 2), i / 2 % 10 != 0));
        let few = (0..10).map(|i| stated("few", 2.0 * f64::from(i % 2), i == 0));
        let all: Vec<Stated> = many.chain(few).collect();
        let weights = fit(all.iter()).expect("solvable");
        let mean = |source: &str| {
            let own = all.iter().filter(|s| s.source == source);
            let p: Vec<f64> = own.map(|s| probability(&weights, &s.features)).collect();
            p.iter().sum::<f64>() / p.len() as f64
        };
        // At the maximum the constant's slope is zero: what is expected of the sources is what they have.
        assert!(
            (mean("many") + mean("few") - 1.0).abs() < 1e-6,
            "{weights:?}"
        );
    }

    /// 800 of 1000 at 1 and 200 of 1000 at 0: the odds are 4 and 1/4, but for the ridge.
    #[test]
    fn odds_of_two_groups_come_back() {
        let right = |i: i32| (i / 2) % 5 == 0 || i % 2 == 1 && (i / 2) % 5 != 1;
        let stated: Vec<Stated> = (0..2000)
            .map(|i| stated("", f64::from(i % 2), right(i)))
            .collect();
        let weights = fit(stated.iter()).expect("solvable");
        assert!(
            (probability(&weights, &[1.0]) - 0.8).abs() < 0.03,
            "{weights:?}"
        );
        assert!(
            (probability(&weights, &[0.0]) - 0.2).abs() < 0.03,
            "{weights:?}"
        );
    }
}
