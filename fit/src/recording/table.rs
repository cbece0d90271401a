//! What all file formats come to: columns of numbers, and where each sample stands in the file.

use super::columns::Plan;
use super::error::Problem;
use super::extra::Reading;
use super::labels::Labels;
use super::lost;

/// The columns that a [`Plan`] asks for.
#[derive(Debug)]
pub(super) struct Table {
    pub(super) plan: Plan,
    /// One per source of the plan, in its order.
    pub(super) data: Vec<Data>,
    /// The columns that the plan does not use.
    pub(super) extra: Vec<Reading>,
    pub(super) place: Location,
    /// Unused columns that keep their first value for a while, and the sample where they first
    /// change: candidates for a segment where time starts again.
    pub(super) first_change: Vec<(String, usize)>,
}

/// The samples of one source.
#[derive(Debug)]
pub(super) enum Data {
    Numbers(Vec<f64>),
    Labels(Labels),
}

/// Places without a sample after which a file that has more of them than samples is read no further.
const MOST_BROKEN: usize = 1000;

/// A place that holds no sample.
struct Broken {
    place: u64,
    /// Samples before it.
    samples: usize,
    has_time: bool,
}

/// A table to which its samples come one after the other.
pub(super) struct Builder {
    pub(super) table: Table,
    max_samples: usize,
    pub(super) samples: usize,
    /// The place after the last sample.
    expected: u64,
    /// What is wrong at the first place that holds no sample, and all of them.
    broken: (Option<Problem>, Vec<Broken>),
}

impl Builder {
    /// Of samples at places that are called so.
    pub(super) fn new(plan: Plan, what: &'static str, max_samples: usize) -> Self {
        let data = plan.sources.iter().map(|s| match s.known.slot.is_label() {
            true => Data::Labels(Labels::default()),
            false => Data::Numbers(Vec::new()),
        });
        let extra = plan.unused.iter().map(|&c| Reading::new(&plan.names[c]));
        let breaks = Vec::new();
        Self {
            table: Table {
                data: data.collect(),
                extra: extra.collect(),
                place: Location { what, breaks },
                first_change: Vec::new(),
                plan,
            },
            max_samples,
            samples: 0,
            expected: 0,
            broken: (None, Vec::new()),
        }
    }

    /// Takes a sample: the value of each source, the text of a column of labels, and the number of a column without a role.
    pub(super) fn take(
        &mut self,
        place: u64,
        values: &[f64],
        label: impl Fn(usize) -> String,
        number: impl Fn(usize) -> Result<f64, String>,
    ) -> Result<(), Problem> {
        let Table {
            plan,
            data,
            extra,
            place: location,
            ..
        } = &mut self.table;
        let what = location.what;
        let at = || format!("{what} {place}");
        if self.samples >= self.max_samples {
            return Err(Problem::too_many_samples(at(), self.max_samples));
        }
        for ((source, data), &value) in plan.sources.iter().zip(data).zip(values) {
            match data {
                Data::Numbers(values) => values.push(value),
                Data::Labels(labels) => {
                    let column = source.columns().next().unwrap_or(0);
                    let taken = labels.push(&label(column));
                    taken.map_err(|what| Problem::cell(at(), source.known.name, what))?;
                }
            }
        }
        for (reading, &column) in extra.iter_mut().zip(&plan.unused) {
            reading.push(number(column).map_err(|what| format!("{}: {what}", at())));
        }
        if location.breaks.is_empty() || place != self.expected {
            location.breaks.push((self.samples, place));
        }
        self.expected = place + 1;
        self.samples += 1;
        Ok(())
    }

    /// Keeps what is wrong at a place without a sample until all of them are known; what has no time may be a footer.
    pub(super) fn lose(
        &mut self,
        place: u64,
        problem: Problem,
        has_time: bool,
    ) -> Result<(), Problem> {
        let (first, rows) = &mut self.broken;
        rows.push(Broken {
            place,
            samples: self.samples,
            has_time,
        });
        first.get_or_insert(problem);
        // Nothing that follows could make a recording of it, however long it is.
        match first.take_if(|_| rows.len() > MOST_BROKEN && rows.len() > self.samples) {
            Some(problem) => Err(with_others(problem, self.table.place.what, rows)),
            None => Ok(()),
        }
    }

    /// The table, where few enough samples are lost, which is said.
    pub(super) fn finish(mut self) -> Result<Table, Problem> {
        let what = self.table.place.what;
        let warnings = &mut self.table.plan.warnings;
        if let (Some(problem), mut rows) = self.broken {
            let end = rows.iter().rev();
            let footer = end.take_while(|row| row.samples == self.samples && !row.has_time);
            let footer = rows.split_off(rows.len() - footer.count());
            // One line in place of the samples, or more of it than of them, is no footer.
            if footer.len() > self.samples || lost::too_many(rows.len(), self.samples) {
                return Err(with_others(problem, what, &rows));
            }
            if let Some(row) = footer.first() {
                warnings.push(warning!(
                    "footer",
                    "{} {what}s from {what} {} to the end hold no time and were left out",
                    footer.len(),
                    row.place
                ));
            }
            if !rows.is_empty() {
                let places: Vec<u64> = rows.iter().map(|row| row.place).collect();
                warnings.push(lost::said(what, &places, &problem.found()));
            }
        }
        // Labels that are no numbers show only at the end; `assemble` finishes them.
        Ok(self.table)
    }
}

/// The problem at the first of these places, with how many more there are.
fn with_others(mut problem: Problem, what: &str, rows: &[Broken]) -> Problem {
    if let (Problem::Row { found, .. }, Some(next)) = (&mut problem, rows.get(1)) {
        let (more, place) = (rows.len() - 1, next.place);
        // Beyond these the file may not have been read.
        let least = if more < MOST_BROKEN { "" } else { "at least " };
        *found += &format!(" (and {least}{more} more such rows, the next in {what} {place})");
    }
    problem
}

/// Where samples stand in their file.
#[derive(Debug)]
pub(super) struct Location {
    /// What is counted: "line" of a text, "element" of a variable, both from 1.
    pub(super) what: &'static str,
    /// `(sample, place)` wherever a place does not follow its predecessor's.
    pub(super) breaks: Vec<(usize, u64)>,
}

impl Location {
    /// "line 17" or "element 16", for messages.
    pub(super) fn of(&self, sample: usize) -> String {
        format!("{} {}", self.what, self.number(sample))
    }

    fn number(&self, sample: usize) -> u64 {
        let before = self.breaks.partition_point(|&(first, _)| first <= sample);
        let known = before.checked_sub(1).and_then(|i| self.breaks.get(i));
        let (first, place) = known.copied().unwrap_or((0, 1));
        place + sample.saturating_sub(first) as u64
    }

    /// The places of the samples that are kept.
    pub(super) fn keep(&mut self, kept: &[bool]) {
        let old = (0..kept.len()).filter(|i| kept[*i]);
        let places = old.map(|i| self.number(i)).enumerate();
        self.breaks = places.collect();
    }
}
