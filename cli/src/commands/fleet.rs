//! `preslide fleet`.

use super::tune::parse_percent;
use super::{Failure, OutputArgs, ReadingArgs, command_line, outputs};
use clap::Args;
use preslide_fit::progress::Progress;
use preslide_host::fleet::history::{Change, FEWEST, changes};
use preslide_host::fleet::page::{page, ranking, table, to_json, unread};
use preslide_host::fleet::table::{columns, write_csv, write_parquet};
use preslide_host::fleet::{
    Depth, Journal, Member, Part, Row, is_begun, is_journal, members, rows,
};
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Axes that the terminal lists.
const SHOWN: usize = 12;

/// Watch many axes: a table with a row for each recording, and which axis changed against its own history
#[derive(Args)]
#[command(
    after_help = "Example: preslide fleet recordings/ -o fleet.parquet --report fleet.html\n         preslide fleet 'line3/*/2026-11-*.csv' -o line3.csv --fit-only\n\nAn axis is a folder of recordings, or, among files in one folder, the name up to its first number; recordings are in the order of their names. FILE.rows.jsonl keeps each row as it is made: the same command resumes, and reads only what is new or changed."
)]
pub struct Fleet {
    /// Folders, files or patterns in quotes: recordings/, 'line3/*/*.csv'
    #[arg(required = true, value_name = "DIR|GLOB")]
    recordings: Vec<String>,

    /// Write the table: .parquet or .csv; may be given several times, and the rows are kept beside the first
    #[arg(short, long, value_name = "FILE", required = true)]
    output: Vec<PathBuf>,

    /// Share of unchanged recordings that may raise an alarm
    #[arg(long, value_name = "SHARE", default_value = "1%", value_parser = parse_percent)]
    false_alarms: f64,

    /// Fit parameters only, without a diagnosis: several times as fast
    #[arg(long)]
    fit_only: bool,

    /// Make only every Nth row, from the Kth on, for clusters that share a file system; afterwards the same command without --part
    /// makes the table
    #[arg(long, value_name = "K/N", conflicts_with_all = ["report", "json"])]
    part: Option<Part>,

    /// Cores to use, one recording on each [default: all]
    #[arg(long, value_name = "N")]
    jobs: Option<NonZero<usize>>,

    #[command(flatten)]
    reading: ReadingArgs,

    #[command(flatten)]
    outputs: OutputArgs,
}

/// Rows in the order of their recordings.
struct Made {
    rows: Vec<Row>,
    /// How many of them are new, and how long those took together (s).
    new: (usize, f64),
}

impl Fleet {
    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        let is_table = |path: &&PathBuf| ends_with(path, "csv") || ends_with(path, "parquet");
        if let Some(path) = self.output.iter().find(|path| !is_table(path)) {
            return Err(Failure::Input(format!(
                "-o {}: name a table .parquet or .csv",
                path.display()
            )));
        }
        let mut members = members(&self.recordings).map_err(Failure::Input)?;
        // The last table and its journals lie among the recordings, perhaps.
        let begun = self.output.iter().filter(|table| is_begun(table));
        let begun: Vec<PathBuf> = begun
            .filter_map(|table| table.canonicalize().ok())
            .collect();
        let is_own = |path: &Path| {
            self.output.iter().any(|table| is_journal(path, table))
                || !begun.is_empty() && path.canonicalize().is_ok_and(|path| begun.contains(&path))
        };
        members.retain(|m| !is_own(&m.path));
        let inputs: Vec<&Path> = members.iter().map(|m| m.path.as_path()).collect();
        let own: Vec<outputs::Output> = self.output.iter().map(|p| ("-o", Some(p))).collect();
        outputs::check(&inputs, &own, Some(&self.outputs))?;
        if let Some(part) = self.part {
            let own = members.iter().skip(part.number - 1).step_by(part.of);
            let rows = self.all_rows(&own.cloned().collect::<Vec<_>>())?.rows;
            say!(
                "{} of part {} of {}; the same command without --part makes the table.",
                many(rows.len(), "row", "rows"),
                part.number,
                part.of
            );
            return Ok(());
        }
        self.tell(&self.all_rows(&members)?, &members)
    }

    /// The tables, the terminal's words and the page.
    fn tell(&self, made: &Made, members: &[Member]) -> Result<(), Failure> {
        let rows = &made.rows;
        let changes = changes(rows, self.false_alarms);
        let columns = columns(rows, &changes);
        for table in &self.output {
            outputs::write_with(table, |path| match ends_with(table, "csv") {
                true => write_csv(path, &columns),
                false => write_parquet(path, &columns),
            })?;
        }
        let ranked = ranking(rows, &changes);
        let wrong = rows.iter().filter_map(|r| Some((r, r.error.as_ref()?)));
        let wrong: Vec<(&Row, &String)> = wrong.collect();
        let words = self.words(rows, &ranked, wrong.len());
        explain!("{words}");
        if !ranked.is_empty() {
            say!("\n{}", table(&ranked, SHOWN).to_text());
        }
        for (row, reason) in wrong.iter().take(SHOWN) {
            say!("{}: {reason}", row.file);
        }
        if let Some(more @ 1..) = wrong.len().checked_sub(SHOWN) {
            say!("{more} more have no answer; the column `error` gives each reason.");
        }
        let alarm = ranked.iter().find(|(_, change)| change.alarm);
        let changed = alarm.and_then(|(row, _)| members.iter().find(|m| m.file == row.file));
        if let Some(changed) = changed {
            let file = std::slice::from_ref(&changed.path);
            say!("Next: {}", self.reading.command("diagnose", file, None));
        }
        let summary = to_json(rows, &changes, self.false_alarms, made.new);
        self.outputs
            .write(&summary, || page(rows, &ranked, words, command_line()))?;
        match wrong.len() == rows.len() {
            true => Err(Failure::Data(
                "no recording gave an answer; the table gives each reason".to_owned(),
            )),
            false => Ok(()),
        }
    }

    /// The row of every recording, in their order; those that are known are not made again.
    fn all_rows(&self, members: &[Member]) -> Result<Made, Failure> {
        let start = Instant::now();
        let depth = match self.fit_only {
            true => Depth::Fit,
            false => Depth::Diagnosis,
        };
        let how = format!("{depth:?} {}", self.reading.in_words());
        let mut journal = Journal::open(&self.output[0], &how, self.part).map_err(Failure::Tool)?;
        let mut all: Vec<Option<Row>> = members.iter().map(|m| journal.row(m).cloned()).collect();
        let places: Vec<usize> = (0..all.len()).filter(|i| all[*i].is_none()).collect();
        let new: Vec<Member> = places.iter().map(|i| members[*i].clone()).collect();
        let progress = Progress::new("fleet, recordings", new.len() as u64);
        let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
        let jobs = self.jobs.map_or(cores, NonZero::get);
        let row = |member: &Member| {
            Row::of(member, depth, |m| {
                self.reading
                    .load_quietly(&m.path)
                    .map_err(|e| e.problem.to_string())
            })
        };
        let mut failed = None;
        rows(&new, jobs, row, |place, row| {
            failed = failed.take().or(journal.keep(&row).err());
            all[places[place]] = Some(row);
            progress.inc(1);
        });
        progress.finish();
        if let Some(reason) = failed {
            tell!("warning: {reason}; the next run makes these rows again");
        }
        Ok(Made {
            rows: all.into_iter().flatten().collect(),
            new: (new.len(), start.elapsed().as_secs_f64()),
        })
    }

    /// The result in words.
    fn words(&self, rows: &[Row], ranked: &[(&Row, &Change)], failed: usize) -> String {
        let axes = rows.chunk_by(|a, b| a.axis == b.axis).count();
        // The surest change of an axis is an alarm where any is.
        let alarms = ranked.iter().filter(|(_, change)| change.alarm);
        let alarms: Vec<&str> = alarms.map(|(row, _)| row.axis.as_str()).collect();
        let told = match alarms.as_slice() {
            [] if ranked.is_empty() => {
                format!("No axis has {FEWEST} earlier recordings yet, the fewest to compare with.")
            }
            [] => "No axis's newest recording raises an alarm.".to_owned(),
            many => format!(
                "The newest recording raises an alarm on {} of them: {}.",
                many.len(),
                many.join(", ")
            ),
        };
        let unread = match unread(rows).join(", ") {
            axes if axes.is_empty() => axes,
            axes => format!(
                " Newer files of {axes} could not be read; the last recording that could be is compared."
            ),
        };
        format!(
            "{} of {}, {failed} without an answer. {told}{unread} At most {} % of unchanged recordings raise an alarm.",
            many(rows.len(), "recording", "recordings"),
            many(axes, "axis", "axes"),
            100.0 * self.false_alarms
        )
    }
}

fn many(count: usize, one: &str, several: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { several })
}

fn ends_with(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|own| own == ending)
}
