//! What drifted, the surest first, on a page and in a table.

use super::Row;
use super::history::Change;
use crate::report::units::name_and_unit;
use crate::report::{Axis, Figure, Page, Section, Series, Table};

/// Histories that are drawn.
const DRAWN: usize = 6;
/// Axes that are listed.
const LISTED: usize = 50;

/// The newest recording of each axis with its surest change, the surest first.
pub fn ranking<'a>(rows: &'a [Row], changes: &'a [Vec<Change>]) -> Vec<(&'a Row, &'a Change)> {
    let is_newest = |i: usize| rows.get(i + 1).is_none_or(|next| next.axis != rows[i].axis);
    let newest = rows
        .iter()
        .zip(changes)
        .enumerate()
        .filter(|(i, _)| is_newest(*i));
    let mut ranked: Vec<(&Row, &Change)> = newest
        .filter_map(|(_, (row, own))| Some((row, own.first()?)))
        .collect();
    ranked.sort_by(|a, b| a.1.chance.total_cmp(&b.1.chance));
    ranked
}

/// The first of a ranking as a table.
pub fn table(ranked: &[(&Row, &Change)], most: usize) -> Table {
    let left_out = match ranked.len() > most {
        true => format!("; {most} of {} axes", ranked.len()),
        false => String::new(),
    };
    let row = |(row, change): &(&Row, &Change)| {
        vec![
            row.axis.clone(),
            change.parameter.clone(),
            change.size(),
            match change.chance < 1e-4 {
                true => format!("{:.0e}", change.chance),
                false => format!("{:.4}", change.chance),
            },
            if change.alarm { "alarm" } else { "" }.to_owned(),
        ]
    };
    Table {
        caption: format!(
            "The newest recording of each axis against those before it, the surest change first{left_out}"
        ),
        head: ["axis", "parameter", "change", "by chance", ""]
            .map(str::to_owned)
            .to_vec(),
        rows: ranked.iter().take(most).map(row).collect(),
    }
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
                    "A change is the newest value less the mean of the axis's earlier recordings, with the 95 % interval that their scatter gives; by chance is how often a change as large comes where nothing changed.".to_owned(),
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
    let effort = newest.effort_unit.as_deref().unwrap_or_default();
    let (label, unit) = name_and_unit(&change.parameter, effort);
    Figure {
        title: format!("{}: {}", newest.axis, change.words()),
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
