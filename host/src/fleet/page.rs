//! What drifted, the surest first: on a page, in a table and for machines.

use super::Row;
use super::history::{Change, Way};
use preslide_fit::report::units::name_and_unit;
use preslide_fit::report::{Axis, Figure, Page, Section, Series, Table};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Histories that are drawn.
const DRAWN: usize = 6;
/// Axes that are listed.
const LISTED: usize = 50;

/// The newest recording of each axis that was read, with its surest change, the surest first.
pub fn ranking<'a>(rows: &'a [Row], changes: &'a [Vec<Change>]) -> Vec<(&'a Row, &'a Change)> {
    let told: Vec<(&Row, &Vec<Change>)> = rows.iter().zip(changes).collect();
    let of_axes = told.chunk_by(|a, b| a.0.axis == b.0.axis);
    // An empty file at the end must not hide what the recording before it shows.
    let newest = of_axes.filter_map(|own| own.iter().rfind(|(row, _)| row.is_read()));
    let mut ranked: Vec<(&Row, &Change)> = newest
        .filter_map(|(row, own)| Some((*row, own.first()?)))
        .collect();
    ranked.sort_by(|a, b| a.1.chance.total_cmp(&b.1.chance));
    ranked
}

/// Axes that were read once and of which the newest files cannot be.
pub fn unread(rows: &[Row]) -> Vec<&str> {
    let of_axes = rows.chunk_by(|a, b| a.axis == b.axis);
    let unread = of_axes.filter_map(|own| {
        let newest = own.last().filter(|row| !row.is_read())?;
        own.iter().any(Row::is_read).then_some(newest.axis.as_str())
    });
    unread.collect()
}

/// The first of a ranking as a table.
pub fn table(ranked: &[(&Row, &Change)], most: usize) -> Table {
    let left_out = match ranked.len() > most {
        true => format!("; {most} of {} axes", ranked.len()),
        false => String::new(),
    };
    let chance = |chance: f64| match chance < 1e-4 {
        true => "< 0.0001".to_owned(),
        false => format!("{chance:.4}"),
    };
    let words = |(row, change): &(&Row, &Change)| change.words(row.effort());
    Table::of(format!(
            "The newest recording of each axis against those before it, the surest change first{left_out}"
        ), ranked.iter().take(most)).column("axis", |(row, _)| row.axis.clone()).column("parameter", |told| { let [name, _] = words(told); name }).column("change", |told| { let [_, size] = words(told); size }).column("by chance", |(_, change)| chance(change.chance)).column("", |(_, change)| {
                if change.alarm { "alarm" } else { "" }.to_owned()
            }).table()
}

/// `preslide.fleet-summary/1`: how many recordings there are, what became of them, and of each axis with a history the surest
/// change of its newest recording that was read, in the ranking's order. `made` of the rows are new, and took `seconds` together.
pub fn to_json(
    rows: &[Row],
    changes: &[Vec<Change>],
    false_alarms: f64,
    (made, seconds): (usize, f64),
) -> Value {
    let mut verdicts: BTreeMap<&str, usize> = BTreeMap::new();
    for verdict in rows.iter().filter_map(|row| row.verdict.as_deref()) {
        *verdicts.entry(verdict).or_default() += 1;
    }
    let errors = rows.iter().filter_map(|row| {
        Some(json!({ "axis": row.axis, "file": row.file, "reason": row.error.as_ref()? }))
    });
    let ranked = ranking(rows, changes);
    let newest = ranked.iter().map(|(row, change)| {
        json!({
            "axis": row.axis,
            "file": row.file,
            "parameter": change.parameter,
            "over_recordings": match change.way { Way::Step => 1, Way::Drift(count) => count },
            "usual": change.usual,
            "by": change.by,
            "by_ci95": [change.by - change.reach, change.by + change.reach],
            "chance": change.chance,
            "alarm": change.alarm,
        })
    });
    json!({
        "schema": "preslide.fleet-summary/1",
        "recordings": rows.len(),
        "axes": rows.chunk_by(|a, b| a.axis == b.axis).count(),
        "made": made,
        "verdicts": verdicts,
        "errors": errors.collect::<Vec<_>>(),
        "false_alarms": false_alarms,
        "with_history": ranked.len(),
        "with_alarm": ranked.iter().filter(|(_, change)| change.alarm).count(),
        "newest": newest.collect::<Vec<_>>(),
        "newest_unread": unread(rows),
        "seconds": seconds,
    })
}

/// The fleet on one page.
pub fn page(rows: &[Row], ranked: &[(&Row, &Change)], lead: String, command: String) -> Page {
    let figures = ranked
        .iter()
        .take(DRAWN)
        .map(|(newest, change)| history(rows, newest, change));
    let errors = rows
        .iter()
        .filter_map(|row| Some(vec![row.file.clone(), row.error.clone()?]));
    Page {
        title: "A fleet of axes".to_owned(),
        lead,
        command,
        sections: vec![
            Section {
                heading: "What drifted".to_owned(),
                paragraphs: vec![
                    "A change is the newest value less the mean of the axis's usual recordings, with the 95 % interval that their scatter gives, or what a straight line through all of them gained; by chance is how often one as large comes without a change. Usual is what raised no alarm: a change that lasts raises it with every recording.".to_owned(),
                ],
                tables: vec![table(ranked, LISTED)],
                figures: figures.collect(),
            },
            Section {
                heading: "Recordings without an answer".to_owned(),
                tables: vec![Table {
                    caption: "Each with its reason".to_owned(),
                    head: ["recording", "reason"].map(str::to_owned).to_vec(),
                    rows: errors.collect(),
                }],
                ..Section::default()
            },
        ],
    }
}

/// A parameter of an axis from recording to recording.
fn history(rows: &[Row], newest: &Row, change: &Change) -> Figure {
    let own = rows.iter().filter(|row| row.axis == newest.axis);
    let told = own.enumerate().filter_map(|(i, row)| {
        let (value, _) = row.parameters.get(&change.parameter)?;
        Some((i as f64 + 1.0, *value))
    });
    let (number, value): (Vec<f64>, Vec<f64>) = told.unzip();
    let (label, unit) = name_and_unit(&change.parameter, newest.effort());
    Figure {
        title: format!(
            "{}: {}",
            newest.axis,
            change.words(newest.effort()).join(" ")
        ),
        x: Axis {
            label: "recording, counted".to_owned(),
            ..Axis::default()
        },
        y: Axis {
            label,
            unit,
            ..Axis::default()
        },
        series: vec![Series::points("each recording", number, value)],
        ..Figure::default()
    }
}
