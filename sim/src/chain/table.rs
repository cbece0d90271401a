//! What the chain ended in, as a table.

use serde::{Deserialize, Serialize};
use std::fmt::Write as _;

/// Share of the best that is possible within which the chain should end (-): issue 6.
const AIM: f64 = 1.3;

/// What the diagnosis says in its JSON, as far as the table shows it.
#[derive(Clone, Debug, Deserialize)]
pub struct Diagnosed {
    baseline: Error,
    extended: Error,
    effects: Vec<Named>,
}

#[derive(Clone, Debug, Deserialize)]
struct Error {
    nmse_test: f64,
}

#[derive(Clone, Debug, Deserialize)]
struct Named {
    id: String,
    level: String,
    confidence: f64,
}

/// How well a motion was tracked.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub enum Tracked {
    /// Nobody asked.
    #[default]
    NotRun,
    /// The firmware gave up.
    Fault,
    /// RMS error (m).
    Within(f64),
}

impl From<Option<f64>> for Tracked {
    /// Of an RMS error (m) where the firmware did not give up.
    fn from(error: Option<f64>) -> Self {
        error.map_or(Self::Fault, Self::Within)
    }
}

impl Tracked {
    /// In nm.
    fn words(self) -> String {
        match self {
            Self::NotRun => "–".to_owned(),
            Self::Fault => "fault".to_owned(),
            Self::Within(error) => format!("{:.0}", error * 1e9),
        }
    }
}

/// How well the same gains tracked.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Errors {
    /// Without any friction model.
    pub none: Tracked,
    /// With what `identify` found.
    pub before: Tracked,
    /// With the blocks that `diagnose` refitted, but without the effects that it added.
    pub refit: Tracked,
    /// With both.
    pub after: Tracked,
    /// With the stage's own parameters.
    pub known: Tracked,
}

/// One trial.
#[derive(Clone, Debug)]
pub struct Row {
    /// What was concealed.
    pub concealed: &'static str,
    /// What the diagnosis said.
    pub told: Diagnosed,
    /// How well the axis was followed.
    pub errors: Errors,
}

impl Row {
    /// The confident names, the first one first.
    fn names(&self) -> Vec<&Named> {
        let of = self.told.effects.iter();
        of.filter(|effect| effect.level == "confident").collect()
    }

    /// The concealed effect was named first.
    pub fn is_named(&self) -> bool {
        let names = self.names();
        names.first().is_some_and(|name| name.id == self.concealed)
    }

    /// Error after the chain over that with the truth known (-).
    fn ratio(&self) -> Option<f64> {
        match (self.errors.after, self.errors.known) {
            (Tracked::Within(after), Tracked::Within(known)) => Some(after / known),
            _ => None,
        }
    }

    /// The chain ended within 1.3 times what knowing the truth gives.
    pub fn is_close(&self) -> bool {
        self.ratio().is_some_and(|ratio| ratio <= AIM)
    }
}

/// The table, its summary, and whether five of six trials, rounded up, ended close to what is possible.
pub fn table(rows: &[Row]) -> (String, bool) {
    let mut text = format!(
        "{:<20} {:<28} {:>10} {:>16}   {:^39} {:>7}\n{:<20} {:<28} {:>10} {:>16}   {:>7} {:>7} {:>7} {:>7} {:>7} {:>7}\n",
        "concealed",
        "named as",
        "confidence",
        "held-out NMSE %",
        "RMS tracking error (nm)",
        "after/",
        "",
        "",
        "",
        "before   after",
        "none",
        "before",
        "refit",
        "after",
        "known",
        "known",
    );
    for row in rows {
        let names = row.names();
        let list: Vec<&str> = names.iter().map(|name| name.id.as_str()).collect();
        let confidence = names
            .first()
            .map_or("–".to_owned(), |name| format!("{:.2}", name.confidence));
        let Errors {
            none,
            before,
            refit,
            after,
            known,
        } = row.errors;
        let _ = writeln!(
            text,
            "{:<20} {:<28} {:>10} {:>7.3} {:>8.3}   {:>7} {:>7} {:>7} {:>7} {:>7} {:>7}",
            row.concealed,
            if list.is_empty() {
                "nothing".to_owned()
            } else {
                list.join(", ")
            },
            confidence,
            row.told.baseline.nmse_test,
            row.told.extended.nmse_test,
            none.words(),
            before.words(),
            refit.words(),
            after.words(),
            known.words(),
            row.ratio()
                .map_or("–".to_owned(), |ratio| format!("{ratio:.2}")),
        );
    }
    let count = |is: fn(&Row) -> bool| rows.iter().filter(|row| is(row)).count();
    let (named, close) = (count(Row::is_named), count(Row::is_close));
    let enough = 6 * close >= 5 * rows.len();
    let _ = writeln!(
        text,
        "{named} of {} named first; {close} of {} tracked within {AIM} × the error with the truth known: the aim, five of six, is {}.",
        rows.len(),
        rows.len(),
        if enough { "met" } else { "missed" }
    );
    (text, enough)
}
