//! The tool beside naive recipes ([`super::naive`]) on the same recordings: one table, and curves of true against false names.

use std::fmt::Write as _;

use super::case::{Case, Sort};
use super::summary::{Share, curve, curves_csv, curves_svg, sources};

/// Who answered, and what of all sources.
pub type Answers = (&'static str, Vec<Case>);

/// A row for each source and recipe, at the recipe's standard point (95 % intervals in brackets).
pub fn table(answers: &[Answers]) -> String {
    let mut text = format!("| {:<10} | {:<8} |", "source", "recipe");
    let heads = [
        "clean with a false name",
        "singles: first name right",
        "singles: any name right",
        "precision",
        "false names a recording",
    ];
    for head in heads {
        let _ = write!(text, " {head:<26} |");
    }
    let _ = write!(
        text,
        "\n|{}|{}|{}",
        "-".repeat(12),
        "-".repeat(10),
        format!("{}|", "-".repeat(28)).repeat(heads.len())
    );
    for source in sources(&answers[0].1) {
        for (recipe, cases) in answers {
            let own: Vec<&Case> = cases.iter().filter(|c| c.source == source).collect();
            let _ = write!(text, "\n| {source:<10} | {recipe:<8} |");
            for cell in row(&own) {
                let _ = write!(text, " {cell:<26} |");
            }
        }
    }
    text
}

fn row(cases: &[&Case]) -> [String; 5] {
    let of = |sort: Sort| cases.iter().filter(move |c| c.sort == sort);
    let counted = || cases.iter().filter(|c| c.sort != Sort::Stranger);
    let judged = counted().flat_map(|c| c.confident().filter_map(|n| c.judges(n)));
    let wrong: usize = counted().map(|c| c.false_names().count()).sum();
    [
        Share::of(of(Sort::Clean), |c| c.false_names().next().is_some()).to_string(),
        Share::of(of(Sort::Single), |c| c.first_right()).to_string(),
        Share::of(of(Sort::Single), |c| c.truth.iter().any(|t| c.finds(t))).to_string(),
        Share::of(judged, |right| *right).to_string(),
        format!("{:.1}", wrong as f64 / counted().count() as f64),
    ]
}

/// The curves of all sources and recipes as CSV.
pub fn csv(answers: &[Answers]) -> String {
    let mut text = String::new();
    for (i, (recipe, cases)) in answers.iter().enumerate() {
        let curves = curves_csv(cases);
        let (head, lines) = curves.split_once('\n').unwrap_or_default();
        if i == 0 {
            let _ = writeln!(text, "recipe,{head}");
        }
        for line in lines.lines() {
            let _ = writeln!(text, "{recipe},{line}");
        }
    }
    text
}

/// The curves of one source, a line for each recipe, as far as the worst of them reaches.
pub fn picture(answers: &[Answers], source: &str) -> String {
    let mut all = Vec::new();
    let mut reach: f64 = 1.0;
    for (recipe, cases) in answers {
        let own = cases.iter().filter(|c| c.source == source).cloned();
        // The picture draws a line for each source: here the recipes stand in their place.
        let own: Vec<Case> = own
            .map(|case| Case {
                source: recipe,
                ..case
            })
            .collect();
        let most = curve(&own.iter().collect::<Vec<_>>())
            .iter()
            .map(|c| c.2)
            .max()
            .unwrap_or(0);
        // Four ticks, each a whole number.
        reach = reach.max(4.0 * (most as f64 / (4 * own.len().max(1)) as f64).ceil());
        all.extend(own);
    }
    curves_svg(&all, reach)
}
