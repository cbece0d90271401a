//! Figures of the cases of one source, and the table of all sources.

use std::fmt::Write as _;

use statrs::distribution::{Beta, ContinuousCDF as _};

use super::case::{Case, Sort};

/// A count of a whole, with the exact 95 % interval of the share it estimates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Share {
    /// How many.
    pub part: usize,
    /// Of how many.
    pub whole: usize,
}

impl Share {
    /// How many of `items` hold.
    pub fn of<T>(items: impl IntoIterator<Item = T>, holds: impl Fn(&T) -> bool) -> Self {
        let mut share = Self::default();
        for item in items {
            share.part += usize::from(holds(&item));
            share.whole += 1;
        }
        share
    }

    /// Part of whole; NaN of nothing.
    pub fn value(self) -> f64 {
        self.part as f64 / self.whole as f64
    }

    /// The exact binomial interval (Clopper and Pearson 1934), 2.5 % to either side.
    pub fn interval(self) -> [f64; 2] {
        let (k, n) = (self.part as f64, self.whole as f64);
        // The bounds 0 and 1 belong to nothing and to everything, for which there is no distribution.
        let at = |share, a, b| Beta::new(a, b).map(|beta| beta.inverse_cdf(share)).ok();
        [
            at(0.025, k, n - k + 1.0).unwrap_or(0.0),
            at(0.975, k + 1.0, n - k).unwrap_or(1.0),
        ]
    }
}

impl std::fmt::Display for Share {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.whole == 0 {
            return f.pad("–");
        }
        let [low, high] = self.interval().map(|p| 100.0 * p);
        let text = format!(
            "{}/{} {:.0} % ({low:.1}…{high:.1})",
            self.part,
            self.whole,
            100.0 * self.value()
        );
        f.pad(&text)
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Expected calibration error over ten bins of equal width of names whose truth is known: mean distance of the stated confidence from the
/// share that is true, weighted by the number of statements (Naeini et al. 2015). NaN without any.
pub fn calibration_error(stated: &[(f64, bool)]) -> f64 {
    let mut bins = [(0.0, 0usize); 10];
    for &(confidence, there) in stated {
        let bin = &mut bins[((confidence * 10.0).max(0.0) as usize).min(9)];
        *bin = (bin.0 + confidence, bin.1 + usize::from(there));
    }
    let gaps = bins.iter().map(|(sum, there)| (sum - *there as f64).abs());
    gaps.sum::<f64>() / stated.len() as f64
}

/// Confidence and truth of every stated name, suspected ones too, whose truth is known; out-of-catalogue cases are left out.
pub fn stated<'a>(cases: impl Iterator<Item = &'a Case>) -> Vec<(f64, bool)> {
    cases
        .filter(|c| c.sort != Sort::Stranger)
        .flat_map(|c| {
            c.names()
                .iter()
                .filter_map(|n| Some((n.confidence, c.judges(n)?)))
        })
        .collect()
}

/// Names and figures of one source, one a row.
pub fn rows(cases: &[&Case]) -> Vec<(String, String)> {
    let source = Cases(cases);
    let shares = [
        source.clean(),
        source.single_effects(),
        source.several_effects(),
        source.seen(),
        source.strangers(),
        source.machines(),
        source.names(),
        source.places(),
        source.intervals(),
    ];
    let mut rows: Vec<(String, String)> = shares
        .into_iter()
        .flatten()
        .filter(|(_, share)| share.whole > 0)
        .map(|(name, share)| (name, share.to_string()))
        .collect();
    let stated = stated(cases.iter().copied());
    if !stated.is_empty() {
        let error = format!("{:.3} of {}", calibration_error(&stated), stated.len());
        rows.push(("calibration error".to_owned(), error));
    }
    let seconds: Vec<f64> = cases.iter().map(|c| c.seconds).collect();
    let longest = seconds.iter().copied().fold(0.0, f64::max);
    rows.push((
        "time, median and longest [s]".to_owned(),
        format!("{:.1}, {longest:.1}", median(seconds)),
    ));
    rows
}

/// A row, before its share is written out.
type Figure = (String, Share);

fn figure(name: &str, share: Share) -> Figure {
    (name.to_owned(), share)
}

/// The cases of one source.
struct Cases<'a>(&'a [&'a Case]);

impl<'a> Cases<'a> {
    fn of(&self, sort: Sort) -> impl Iterator<Item = &'a &'a Case> + use<'a> {
        self.0.iter().filter(move |c| c.sort == sort)
    }

    /// Those of which it is known whether a name is false.
    fn known(&self) -> impl Iterator<Item = &'a &'a Case> + use<'a> {
        self.0.iter().filter(|c| c.sort != Sort::Stranger)
    }

    /// Refusals, and what is said where nothing is concealed.
    fn clean(&self) -> Vec<Figure> {
        let clean = || self.of(Sort::Clean);
        vec![
            figure(
                "without an answer",
                Share::of(self.0, |c| c.answer.is_err()),
            ),
            figure(
                "clean: false names",
                Share::of(clean(), |c| c.false_names().next().is_some()),
            ),
            figure(
                "clean: called unknown",
                Share::of(clean(), |c| c.verdict() == "unknown-physics"),
            ),
        ]
    }

    /// One effect, by strength, and where it hides.
    fn single_effects(&self) -> Vec<Figure> {
        let mut strengths: Vec<f64> = self.of(Sort::Single).map(|c| c.strength).collect();
        strengths.sort_by(f64::total_cmp);
        strengths.dedup();
        let declared = |c: &&&Case| c.truth.iter().all(|t| c.finds_or_declares(t));
        let mut figures = Vec::new();
        for strength in strengths {
            let own = || {
                self.of(Sort::Single)
                    .filter(move |c| c.strength == strength)
            };
            figures.extend([
                (
                    format!("×{strength}: first name right"),
                    Share::of(own(), |c| c.first_right()),
                ),
                (
                    format!("×{strength}: named or declared"),
                    Share::of(own(), declared),
                ),
                (
                    format!("×{strength}: named or declared, where an oracle sees it"),
                    Share::of(own().filter(|c| c.there == Some(true)), declared),
                ),
            ]);
        }
        figures.push(figure(
            "in a corner or on a wrong model: first name right",
            Share::of(self.of(Sort::Hidden), |c| c.first_right()),
        ));
        figures
    }

    fn several_effects(&self) -> Vec<Figure> {
        let figures = [(Sort::Pair, "pair"), (Sort::Masked, "masked")].map(|(sort, name)| {
            let found = |c: &&&Case| c.truth.iter().all(|t| c.finds(t));
            let one = |c: &&&Case| c.truth.iter().any(|t| c.finds(t));
            [
                (
                    format!("{name}: both named"),
                    Share::of(self.of(sort), found),
                ),
                (format!("{name}: one named"), Share::of(self.of(sort), one)),
            ]
        });
        figures.concat()
    }

    /// What the source's own oracle sees, alone or with others.
    fn seen(&self) -> Vec<Figure> {
        let effects = || {
            self.known()
                .flat_map(|c| c.truth.iter().map(move |t| (c, t)))
        };
        let seen = effects().filter(|(_, t)| t.seen == Some(true));
        let beside_a_fit = effects().filter(|(_, t)| t.seen_beside_a_fit == Some(true));
        let strangers = self.of(Sort::Stranger);
        let shown = strangers.filter(|c| c.truth.iter().all(|t| t.seen == Some(true)));
        vec![
            figure(
                "effects that an oracle sees: named or declared",
                Share::of(seen, |(c, t)| c.finds_or_declares(t)),
            ),
            figure(
                "  that it sees while it fits the friction too",
                Share::of(beside_a_fit, |(c, t)| c.finds_or_declares(t)),
            ),
            figure(
                "out of catalogue, seen by it: unknown",
                Share::of(shown, |c| c.verdict() == "unknown-physics"),
            ),
        ]
    }

    /// What is outside the catalogue.
    fn strangers(&self) -> Vec<Figure> {
        let strangers = || self.of(Sort::Stranger);
        vec![
            figure(
                "out of catalogue: unknown",
                Share::of(strangers(), |c| c.verdict() == "unknown-physics"),
            ),
            figure(
                "out of catalogue: a false name",
                Share::of(strangers(), |c| c.false_names().next().is_some()),
            ),
            figure(
                "out of catalogue: consistent",
                Share::of(strangers(), |c| c.verdict() == "consistent"),
            ),
        ]
    }

    /// Machines as they are.
    fn machines(&self) -> Vec<Figure> {
        let machines = || self.of(Sort::Machine);
        let known = machines().flat_map(|c| c.truth.iter().map(move |t| (c, t)));
        let verdicts = machines().filter_map(|c| c.verdict_right());
        vec![
            figure(
                "machines: known effects named or declared",
                Share::of(known, |(c, t)| c.finds_or_declares(t)),
            ),
            figure(
                "machines: right verdict where one is known",
                Share::of(verdicts, |right| *right),
            ),
            figure(
                "machines: nothing absent named",
                Share::of(machines(), |c| c.false_names().next().is_none()),
            ),
        ]
    }

    /// How far confident names can be trusted.
    fn names(&self) -> Vec<Figure> {
        let judged = || {
            self.known().flat_map(|c| {
                c.confident()
                    .filter_map(|n| Some((n.confidence, c.judges(n)?)))
            })
        };
        vec![
            figure(
                "precision of confident names",
                Share::of(judged(), |(_, right)| *right),
            ),
            figure(
                "  of those at ≥ 0.9",
                Share::of(judged().filter(|(p, _)| *p >= 0.9), |(_, right)| *right),
            ),
            figure(
                "recordings with a false name",
                Share::of(self.known(), |c| c.false_names().next().is_some()),
            ),
        ]
    }

    fn places(&self) -> Vec<Figure> {
        let places: Vec<(bool, bool)> = self.0.iter().flat_map(|c| c.places()).collect();
        vec![
            figure(
                "named effects with a place: stated",
                Share::of(&places, |p| p.0),
            ),
            figure(
                "named effects with a place: overlaps by half",
                Share::of(&places, |p| p.1),
            ),
        ]
    }

    /// Whether stated intervals hold the truth.
    fn intervals(&self) -> Vec<Figure> {
        let distances: Vec<(String, f64)> = self.0.iter().flat_map(|c| c.distances()).collect();
        let level = distances.iter().filter(|d| d.0 == "stribeck.level");
        vec![
            figure(
                "95 % intervals that hold the truth",
                Share::of(&distances, |d| d.1 <= 1.0),
            ),
            figure("  Stribeck's level", Share::of(level, |d| d.1 <= 1.0)),
        ]
    }
}

/// The sources in the order of their first case.
pub fn sources(cases: &[Case]) -> Vec<&'static str> {
    let mut sources: Vec<&'static str> = Vec::new();
    for case in cases {
        if !sources.contains(&case.source) {
            sources.push(case.source);
        }
    }
    sources
}

/// One table: a column for each source, a row for each figure (95 % intervals in brackets).
pub fn table(cases: &[Case]) -> String {
    let sources = sources(cases);
    let columns: Vec<Vec<(String, String)>> = sources
        .iter()
        .map(|source| {
            rows(
                &cases
                    .iter()
                    .filter(|c| c.source == *source)
                    .collect::<Vec<_>>(),
            )
        })
        .collect();
    let mut names: Vec<&String> = Vec::new();
    // Every row stands behind the one that it follows in some source.
    for column in &columns {
        let mut at = 0;
        for (name, _) in column {
            match names.iter().position(|n| *n == name) {
                Some(place) => at = place + 1,
                None => {
                    names.insert(at, name);
                    at += 1;
                }
            }
        }
    }
    let mut text = format!("| {:<52} |", "");
    for (i, source) in sources.iter().enumerate() {
        let n = cases.iter().filter(|c| c.source == *source).count();
        let _ = write!(text, " {:<28} |", format!("{} ({n})", sources[i]));
    }
    let _ = write!(
        text,
        "\n|{}|{}",
        "-".repeat(54),
        format!("{}|", "-".repeat(30)).repeat(sources.len())
    );
    for name in names {
        let _ = write!(text, "\n| {name:<52} |");
        for column in &columns {
            let value = column
                .iter()
                .find(|row| row.0 == *name)
                .map_or("", |row| &row.1);
            let _ = write!(text, " {value:<28} |");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calibration_counts_the_gap() {
        let stated: Vec<(f64, bool)> = (0..100).map(|i| (0.85, i < 85)).collect();
        assert!(calibration_error(&stated) < 1e-9);
        let boasting: Vec<(f64, bool)> = (0..100).map(|i| (0.95, i < 45)).collect();
        assert!((calibration_error(&boasting) - 0.5).abs() < 1e-9);
        assert!(calibration_error(&[]).is_nan());
    }

    #[test]
    fn exact_intervals_are_those_of_the_tables() {
        // Clopper and Pearson at 95 %: 0 of 99, 5 of 39, 10 of 10.
        for ((part, whole), [low, high]) in [
            ((0, 99), [0.0, 0.03658]),
            ((5, 39), [0.04297, 0.27426]),
            ((10, 10), [0.69150, 1.0]),
        ] {
            let [a, b] = Share { part, whole }.interval();
            assert!(
                (a - low).abs() < 1e-4 && (b - high).abs() < 1e-4,
                "{part}/{whole}: {a} {b}"
            );
        }
    }
}
