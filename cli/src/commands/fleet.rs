//! `preslide fleet`.

use super::tune::parse_percent;
use super::{Failure, ReadingArgs, command_line, outputs};
use clap::Args;
use preslide_host::fleet::history::{Change, FEWEST, changes};
use preslide_host::fleet::page::{page, ranking, table};
use preslide_host::fleet::table::{columns, write_csv, write_parquet};
use preslide_host::fleet::{Asked, Journal, Member, Part, Row, is_journal, members, rows};
use preslide_host::progress::Progress;
use std::num::NonZero;
use std::path::{Path, PathBuf};

/// Axes that the terminal lists.
const SHOWN: usize = 12;

/// Many axes, a recording a day each: a table with a row a recording, and which axis changed against its own history
#[derive(Args)]
#[command(
    after_help = "Example: preslide fleet recordings/ -o fleet.parquet --report fleet.html\n         preslide fleet 'line3/*/2026-11-*.csv' -o line3.csv --fit-only\n\nAn axis is the folder that holds its recordings, or, of files that lie together, what of their names stands before the first number; its\nrecordings are in the order of their names. Beside the table FILE.rows.jsonl keeps each row as it is made: the same command goes on where it was\nstopped, and reads only what is new or changed."
)]
pub struct Fleet {
    /// Folders, files or patterns in quotes: recordings/, 'line3/*/*.csv'
    #[arg(required = true, value_name = "DIR|GLOB")]
    recordings: Vec<String>,

    /// Write the table: .parquet or .csv; may be given several times, and the rows are kept beside the first
    #[arg(short, long, value_name = "FILE", required = true)]
    output: Vec<PathBuf>,

    /// Write one self-contained page that ranks what drifted
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,

    /// Share of recordings of which nothing changed that may raise an alarm
    #[arg(long, default_value = "1%", value_parser = parse_percent)]
    false_alarms: f64,

    /// Fit parameters only, without a diagnosis: several times as fast
    #[arg(long)]
    fit_only: bool,

    /// Make every Nth row from the Kth on and no table, for clusters that share a file system: each part has a journal of its own, and the same
    /// command without it makes the table of them all
    #[arg(long, value_name = "K/N", conflicts_with = "report")]
    part: Option<Part>,

    /// Recordings at a time [default: the cores of this machine]
    #[arg(long, value_name = "N")]
    jobs: Option<NonZero<usize>>,

    #[command(flatten)]
    reading: ReadingArgs,
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
        let tables = self.output.iter().map(|path| ("-o", Some(path)));
        let own: Vec<outputs::Output> =
            tables.chain([("--report", self.report.as_ref())]).collect();
        outputs::check(&[], &own, None)?;
        let mut members = members(&self.recordings).map_err(Failure::Input)?;
        // The last table is no recording.
        let is_own = |path: &Path| {
            let same = |table: &PathBuf| path.canonicalize().ok() == table.canonicalize().ok();
            self.output
                .iter()
                .any(|table| same(table) || is_journal(path, table))
        };
        members.retain(|m| !is_own(&m.path));
        if let Some(part) = self.part {
            let own = members.iter().skip(part.number - 1).step_by(part.of);
            let rows = self.all_rows(&own.cloned().collect::<Vec<_>>())?;
            say!(
                "{} rows of part {} of {}; the same command without --part makes the table.",
                rows.len(),
                part.number,
                part.of
            );
            return Ok(());
        }
        self.tell(&self.all_rows(&members)?)
    }

    /// The tables, the terminal's words and the page.
    fn tell(&self, rows: &[Row]) -> Result<(), Failure> {
        let changes = changes(rows, self.false_alarms);
        let columns = columns(rows, &changes);
        for table in &self.output {
            outputs::write_with(table, |path| match ends_with(table, "csv") {
                true => write_csv(path, &columns),
                false => write_parquet(path, &columns),
            })?;
        }
        let words = self.words(rows, &changes);
        say!("{words}");
        let ranked = ranking(rows, &changes);
        if !ranked.is_empty() {
            say!("\n{}", table(&ranked[..ranked.len().min(SHOWN)]).to_text());
        }
        for row in rows.iter().filter(|r| r.error.is_some()).take(SHOWN) {
            say!("{}: {}", row.file, row.error.as_deref().unwrap_or_default());
        }
        if let Some(path) = &self.report {
            let page = page(rows, &changes, words, command_line());
            outputs::write_with(path, |path| page.write_html(path))?;
        }
        match rows.iter().all(|row| row.error.is_some()) {
            true => Err(Failure::Data(
                "none of the recordings gave an answer; the table has each one's reason".to_owned(),
            )),
            false => Ok(()),
        }
    }

    /// The row of every recording, in their order; those that are known are not made again.
    fn all_rows(&self, members: &[Member]) -> Result<Vec<Row>, Failure> {
        let asked = match self.fit_only {
            true => Asked::Fit,
            false => Asked::Diagnosis,
        };
        let how = format!("{asked:?} {}", self.reading.in_words());
        let mut journal = Journal::open(&self.output[0], &how, self.part).map_err(Failure::Tool)?;
        let known: Vec<Option<Row>> = members.iter().map(|m| journal.row(m).cloned()).collect();
        let new: Vec<Member> = members
            .iter()
            .zip(&known)
            .filter(|(_, row)| row.is_none())
            .map(|(m, _)| m.clone())
            .collect();
        let progress = Progress::new("fleet, recordings", new.len() as u64);
        let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
        let jobs = self.jobs.map_or(cores, NonZero::get);
        let row = |member: &Member| {
            Row::of(member, asked, |m| {
                self.reading
                    .load_quietly(&m.path)
                    .map_err(|e| e.to_string())
            })
        };
        let (mut made, mut failed) = (Vec::new(), None);
        rows(&new, jobs, row, |row| {
            failed = failed.take().or(journal.keep(&row).err());
            made.push(row);
            progress.inc(1);
        });
        progress.finish();
        if let Some(reason) = failed {
            tell!("warning: {reason}; the next run makes these rows again");
        }
        made.sort_by(|a, b| a.file.cmp(&b.file));
        let row_of = |(member, row): (&Member, Option<Row>)| {
            row.or_else(|| {
                let at = made
                    .binary_search_by(|r: &Row| r.file.cmp(&member.file))
                    .ok()?;
                Some(made[at].clone())
            })
        };
        Ok(members.iter().zip(known).filter_map(row_of).collect())
    }

    /// What came of it, in words.
    fn words(&self, rows: &[Row], changes: &[Vec<Change>]) -> String {
        let axes = rows.chunk_by(|a, b| a.axis == b.axis).count();
        let failed = rows.iter().filter(|r| r.error.is_some()).count();
        let judged = changes.iter().filter(|own| !own.is_empty()).count();
        let alarms: Vec<&str> = rows
            .chunk_by(|a, b| a.axis == b.axis)
            .zip(by_axis(rows, changes))
            .filter(|(_, own)| own.last().is_some_and(|c| c.iter().any(|c| c.alarm)))
            .map(|(own, _)| own[0].axis.as_str())
            .collect();
        let told = match alarms.as_slice() {
            [] if judged == 0 => format!(
                "No axis has the {FEWEST} earlier recordings that a change is told against."
            ),
            [] => "The newest recording of no axis raises an alarm.".to_owned(),
            many => format!(
                "The newest recording raises an alarm of {} of them: {}.",
                many.len(),
                many.join(", ")
            ),
        };
        format!(
            "{} of {}, {failed} without an answer. {told} Of recordings of which nothing changed {} % raise one at most.",
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

/// The changes of each axis.
fn by_axis<'a>(
    rows: &[Row],
    changes: &'a [Vec<Change>],
) -> impl Iterator<Item = &'a [Vec<Change>]> {
    let mut rest = changes;
    let lengths: Vec<usize> = rows
        .chunk_by(|a, b| a.axis == b.axis)
        .map(<[Row]>::len)
        .collect();
    lengths.into_iter().map(move |n| {
        let (own, after) = rest.split_at(n);
        rest = after;
        own
    })
}
