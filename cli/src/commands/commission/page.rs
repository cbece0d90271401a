//! The page of a commissioning: before, after, what is sure, the experiments with their results, what stays open.

use super::super::Failure;
use super::findings::Findings;
use super::journal::{Journal, Played};
use preslide_fit::recording::{self, LoadOptions, Needs};
use preslide_fit::report::figures::quantity;
use preslide_fit::report::{Axis, Emphasis, Figure, Page, Section, Series, Table};
use preslide_host::diagnose::effect;

/// Samples of a curve.
const CURVE: usize = 4_000;

/// The unseen motion without the model and with it.
fn proof(journal: &Journal) -> Option<[Played; 2]> {
    let of = |name: &str| journal.played.get(name).copied();
    Some([of("unseen-without")?, of("unseen-with")?])
}

/// A following error of the journal, which counts in 10⁻⁹ of a unit.
fn shown(error: f64, unit: &str) -> String {
    quantity(1e-9 * error, unit)
}

/// In a few lines.
pub fn result(journal: &Journal, unit: &str) -> Vec<String> {
    let Some([without, with]) = proof(journal) else {
        return Vec::new();
    };
    vec![
        format!(
            "On a motion that no fit saw: following error {} RMS with the feedback alone, {} with the model (largest {} and {}).",
            shown(without.rms, unit),
            shown(with.rms, unit),
            shown(without.largest, unit),
            shown(with.largest, unit)
        ),
        format!("The page: {}", journal.file("report.html").display()),
    ]
}

/// The page.
pub fn page(
    journal: &Journal,
    findings: &Findings,
    unit: &str,
    command: String,
) -> Result<Page, Failure> {
    let found = &findings.diagnosis;
    let mut lead = result(journal, unit);
    lead.truncate(1);
    lead.push(found.recommendation(&findings.recording));
    let useless = preslide_host::export::refused(&findings.extended());
    let mut next = format!(
        "The controller has hysteresis and moving mass. Effects are compiled in: preslide export {}{}{} -o stage_model.rs, then build the firmware with PRESLIDE_MODEL. \
         Observer gains are compiled in as well: preslide tune {} --axis AXIS.toml --resonance FREQUENCY proposes them for a drive whose first mode is there.",
        journal.file("extended.toml").display(),
        useless
            .iter()
            .map(|(id, _)| format!(" --without {id}"))
            .collect::<String>(),
        (journal.recordings().iter())
            .map(|file| format!(" --recording {}", file.display()))
            .collect::<String>(),
        journal.file("model.toml").display()
    );
    let possible = found.possible_words(&findings.recording);
    if let Some(possible) = possible {
        next = format!("{possible}. {next}");
    }
    Ok(Page {
        title: "Commissioning".to_owned(),
        lead: lead.join(" "),
        command,
        sections: vec![
            Section {
                heading: "What is sure".to_owned(),
                paragraphs: vec![found.verdict_words(&findings.recording)],
                tables: vec![found.budget_table(&findings.recording)],
                ..Section::default()
            },
            Section {
                heading: "Before and after".to_owned(),
                tables: vec![followed(journal, unit)],
                figures: vec![errors(journal, unit)?],
                ..Section::default()
            },
            Section {
                heading: "Experiments".to_owned(),
                paragraphs: match journal.asked.is_empty() {
                    true => vec!["No experiment was played.".to_owned()],
                    false => Vec::new(),
                },
                tables: asked(journal).into_iter().collect(),
                ..Section::default()
            },
            Section {
                heading: "What stays open".to_owned(),
                paragraphs: found
                    .lacks
                    .iter()
                    .map(|lack| lack.words())
                    .chain([next])
                    .collect(),
                ..Section::default()
            },
        ],
    })
}

fn followed(journal: &Journal, unit: &str) -> Table {
    Table::of(
        "Following error by the encoder; unseen-with has the model, all others the feedback alone",
        &journal.played,
    )
    .column("motion", |(name, _)| String::clone(name))
    .column("RMS", |(_, played)| shown(played.rms, unit))
    .column("largest", |(_, played)| shown(played.largest, unit))
    .table()
}

fn asked(journal: &Journal) -> Option<Table> {
    let name = |id: &String| effect::by_id(id).map_or(id.clone(), |e| e.name().to_owned());
    (!journal.asked.is_empty()).then(|| {
        Table::of("Experiments: purpose and result of each", &journal.asked)
            .column("experiment", |asked| asked.name.clone())
            .column("for", |asked| {
                asked.about.iter().map(name).collect::<Vec<_>>().join(", ")
            })
            .column("answer", |asked| asked.answer.clone().unwrap_or_default())
            .table()
    })
}

/// The unseen motion's following error over time.
fn errors(journal: &Journal, unit: &str) -> Result<Figure, Failure> {
    let of = |name: &str, words: &str, emphasis: Emphasis| {
        let options = LoadOptions {
            needs: Needs::Motion,
            ..LoadOptions::default()
        };
        let read = recording::load(&journal.file(&format!("{name}.csv")), &options)?;
        let reference = read.reference.as_deref().unwrap_or(&read.position);
        let every = read.len().div_ceil(CURVE).max(1);
        let rows = (0..read.len()).step_by(every);
        let (t, e): (Vec<f64>, Vec<f64>) = rows
            .map(|i| (read.t_s[i] - read.t_s[0], reference[i] - read.position[i]))
            .unzip();
        Ok::<_, Failure>(Series::line(words, t, e).emphasis(emphasis))
    };
    let figure = Figure::new(
        "Following error of a motion that no fit saw",
        Axis::new("time", "s"),
        Axis::new("error", unit),
    );
    Ok(figure
        .with(of("unseen-without", "feedback alone", Emphasis::Faint)?)
        .with(of("unseen-with", "with the model", Emphasis::Strong)?))
}
