//! Answers that do not flip: a recording is changed in a way that changes nothing about the machine, and the answer must be the same.
//!
//! No truth is needed, so real machines are judged like made ones.

use super::table::{Recording, Table};
use crate::answer::{Diagnosis, Named};
use crate::trials::draw::Draw;

/// A change of a recording that leaves the machine what it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // `name` says what each is
pub enum Property {
    TwiceJoined,
    TwiceFiles,
    Split,
    Cut1s,
    Cut3s,
    CutAtRandom,
    Units,
    SignFlipped,
    Mirrored,
    Later,
    EverySecondRow,
    Jitter,
    LostRows,
    RandomColumn,
    RestAppended,
}

/// All of them, in the order of the table.
pub const PROPERTIES: [Property; 15] = [
    Property::TwiceJoined,
    Property::TwiceFiles,
    Property::Split,
    Property::Cut1s,
    Property::Cut3s,
    Property::CutAtRandom,
    Property::Units,
    Property::SignFlipped,
    Property::Mirrored,
    Property::Later,
    Property::EverySecondRow,
    Property::Jitter,
    Property::LostRows,
    Property::RandomColumn,
    Property::RestAppended,
];

/// Decimation leaves at least this rate (Hz): below it the band of the motion itself would be cut.
const SLOWEST_HZ: f64 = 250.0;
/// A cut takes at most this share of a recording.
const LARGEST_CUT: f64 = 0.15;
/// Time without rows (s) between parts that are not one motion.
const PAUSE_S: f64 = 1.0;

impl Property {
    /// In the table.
    pub fn name(self) -> &'static str {
        match self {
            Property::TwiceJoined => "given twice, one file",
            Property::TwiceFiles => "given twice, two files",
            Property::Split => "split into two files",
            Property::Cut1s => "first second cut off",
            Property::Cut3s => "first 3 s cut off",
            Property::CutAtRandom => "cut at random",
            Property::Units => "mm and mN by --map",
            Property::SignFlipped => "effort negated, --sign",
            Property::Mirrored => "direction mirrored",
            Property::Later => "1000 s later",
            Property::EverySecondRow => "every second row",
            Property::Jitter => "5 % jitter",
            Property::LostRows => "0.1 % of rows lost",
            Property::RandomColumn => "a random column",
            Property::RestAppended => "3 s of rest appended",
        }
    }

    /// The changed recording; `None` where the change would take something away.
    pub fn apply(self, recording: &Recording) -> Option<Recording> {
        let mut changed = recording.clone();
        let mut draw = Draw::new(recording.name.bytes().map(u64::from).sum(), 7);
        let each = |changed: &mut Recording, change: &mut dyn FnMut(&mut Table)| {
            changed.parts.iter_mut().for_each(change);
        };
        match self {
            Property::TwiceJoined => each(&mut changed, &mut |t| *t = joined(t)),
            Property::TwiceFiles => changed.parts.extend(recording.parts.clone()),
            Property::Split => changed.parts = recording.parts.iter().flat_map(halves).collect(),
            Property::Cut1s => cut(&mut changed, 1.0)?,
            Property::Cut3s => cut(&mut changed, 3.0)?,
            Property::CutAtRandom => {
                let whole = seconds(recording.parts.first()?);
                cut(&mut changed, whole * LARGEST_CUT * draw.uniform(0.2, 0.99))?;
            }
            Property::Units => {
                each(&mut changed, &mut in_thousandths);
                let table = recording.parts.first()?;
                for column in [table.position(), table.effort()] {
                    let name = &table.names[column];
                    let map = format!("{name}=0.001*thousandths_{column}");
                    changed.arguments.extend(["--map".to_owned(), map]);
                }
            }
            Property::SignFlipped => {
                each(&mut changed, &mut |t| t.change(t.effort(), |f| -f));
                // Some files hold the opposite of what moves the axis, which the tool finds by itself where no sign is given.
                let work: f64 = recording.parts.iter().map(work).sum();
                let sign = if work < 0.0 { "1" } else { "-1" };
                changed
                    .arguments
                    .extend(["--sign".to_owned(), sign.to_owned()]);
            }
            Property::Mirrored => each(&mut changed, &mut |t| {
                t.change(t.effort(), |f| -f);
                t.change(t.position(), |x| -x);
            }),
            Property::Later => each(&mut changed, &mut |t| t.change(t.time(), |s| s + 1000.0)),
            Property::EverySecondRow => {
                if 0.5 / recording.parts.first()?.sample_time() < SLOWEST_HZ {
                    return None;
                }
                each(&mut changed, &mut |t| *t = t.kept(|row| row % 2 == 0));
            }
            Property::Jitter => each(&mut changed, &mut |t| *t = jittered(t, &mut draw)),
            Property::LostRows => each(&mut changed, &mut |t| *t = t.kept(|_| !draw.chance(1e-3))),
            Property::RandomColumn => each(&mut changed, &mut |t| {
                let mut value = 0.0;
                let mut walk = || {
                    value = 0.999 * value + draw.normal();
                    value
                };
                let column = (0..t.len()).map(|_| walk()).collect();
                t.push("aux7", column);
            }),
            Property::RestAppended => each(&mut changed, &mut |t| rested(t, &mut draw)),
        }
        Some(changed)
    }

    /// Whether more may be said than before: more rows of the same are more evidence to some.
    fn may_say_more(self) -> bool {
        matches!(self, Property::TwiceJoined | Property::TwiceFiles)
    }
}

/// Length by the clock (s).
fn seconds(table: &Table) -> f64 {
    let time = &table.columns[table.time()];
    time.last()
        .zip(time.first())
        .map_or(0.0, |(to, from)| to - from)
}

/// What the effort gives to the axis (J), by trapezia.
fn work(table: &Table) -> f64 {
    let (x, f) = (
        &table.columns[table.position()],
        &table.columns[table.effort()],
    );
    let pairs = x.windows(2).zip(f.windows(2));
    pairs
        .map(|(x, f)| 0.5 * (f[0] + f[1]) * (x[1] - x[0]))
        .sum()
}

fn joined(table: &Table) -> Table {
    let mut both = table.clone();
    let later = seconds(table) + PAUSE_S;
    for (name, column) in table.names.iter().zip(&mut both.columns) {
        let highest = column.iter().copied().fold(0.0, f64::max);
        let added = match name.as_str() {
            "t_s" => later,
            "repeat" => highest + 1.0,
            _ => 0.0,
        };
        let again: Vec<f64> = column.iter().map(|value| value + added).collect();
        column.extend(again);
    }
    both
}

/// Each with a clock of its own.
fn halves(table: &Table) -> [Table; 2] {
    let middle = table.len() / 2;
    let first = table.kept(|row| row < middle);
    let mut second = table.kept(|row| row >= middle);
    let clock = second.time();
    let from = second.columns[clock].first().copied().unwrap_or(0.0);
    second.change(clock, |s| s - from);
    [first, second]
}

/// Cuts the first seconds off the first file; nothing where that is a large part of it.
fn cut(recording: &mut Recording, by: f64) -> Option<()> {
    let first = recording.parts.first_mut()?;
    let time = first.columns[first.time()].clone();
    let from = time.first()? + by;
    (by < LARGEST_CUT * seconds(first)).then(|| *first = first.kept(|row| time[row] >= from))
}

fn in_thousandths(table: &mut Table) {
    for column in [table.position(), table.effort()] {
        table.change(column, |value| 1000.0 * value);
        table.names[column] = format!("thousandths_{column}");
    }
}

/// Read at instants off the even ones by up to 5 % of a step, by straight lines between the rows; numbers of parts as they are.
fn jittered(table: &Table, draw: &mut Draw) -> Table {
    let mut jittered = table.clone();
    let clock = table.time();
    let step = table.sample_time();
    for row in 1..table.len().saturating_sub(1) {
        let by = draw.uniform(-0.05, 0.05);
        let to = if by > 0.0 { row + 1 } else { row - 1 };
        let apart = (table.columns[clock][to] - table.columns[clock][row]).abs();
        if apart > 1.5 * step {
            continue;
        }
        for (i, name) in table.names.iter().enumerate() {
            if !["segment", "repeat"].contains(&name.as_str()) {
                let (here, there) = (table.columns[i][row], table.columns[i][to]);
                jittered.columns[i][row] = here + by.abs() * (there - here);
            }
        }
    }
    jittered
}

/// After a pause in the clock, the stage stands where it was and its effort stays what it last was.
fn rested(table: &mut Table, draw: &mut Draw) {
    let (clock, effort) = (table.time(), table.effort());
    let (step, n) = (table.sample_time(), table.len());
    let forces = &table.columns[effort];
    let mut noise: Vec<f64> = forces.windows(2).map(|f| (f[1] - f[0]).abs()).collect();
    noise.sort_by(f64::total_cmp);
    let noise = noise.get(noise.len() / 2).copied().unwrap_or(0.0);
    let last: Vec<f64> = table.columns.iter().map(|c| c[n - 1]).collect();
    for i in 1..=(3.0 / step) as usize {
        for (c, column) in table.columns.iter_mut().enumerate() {
            column.push(match c {
                _ if c == clock => last[c] + PAUSE_S + i as f64 * step,
                _ if c == effort => last[c] + noise * draw.normal(),
                _ => last[c],
            });
        }
    }
}

/// How an answer stands to the one before the change.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The same verdict, the same names, parameters within their intervals.
    Same,
    /// Everything that was said, and more; agreement only where the change allows it.
    More(String),
    /// What was certain is only suspected, or said to be beyond the recording.
    Weaker(String),
    /// The same names, with a parameter elsewhere.
    Moved(String),
    /// Another verdict, a name gone or a name more.
    Flipped(String),
    /// Nothing was answered where there was an answer.
    Refused(String),
    /// The change would take something away from this recording, or it is refused as it is.
    NotAsked,
}

impl Outcome {
    /// Whether the property holds.
    pub fn agrees(&self, property: Property) -> bool {
        match self {
            Outcome::Same | Outcome::NotAsked => true,
            Outcome::More(_) => property.may_say_more(),
            _ => false,
        }
    }

    /// In the table: a word and what differs.
    pub fn words(&self) -> (&'static str, &str) {
        match self {
            Outcome::Same => ("same", ""),
            Outcome::More(what) => ("more", what),
            Outcome::Weaker(what) => ("weaker", what),
            Outcome::Moved(what) => ("moved", what),
            Outcome::Flipped(what) => ("flipped", what),
            Outcome::Refused(what) => ("refused", what),
            Outcome::NotAsked => ("–", ""),
        }
    }
}

/// Whether `d` names `id` confidently, or a confident name declares it as likely.
fn says(d: &Diagnosis, id: &str) -> bool {
    d.confident()
        .any(|e| e.id == id || e.ambiguous_with.iter().any(|other| other == id))
}

fn hints(d: &Diagnosis, id: &str) -> bool {
    let of = |e: &Named| e.id == id || e.ambiguous_with.iter().any(|other| other == id);
    d.effects.iter().any(of)
}

fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(", ")
}

/// Compares the answer after a change with the one before.
pub fn compare(
    property: Property,
    before: &Result<Diagnosis, String>,
    after: &Result<Diagnosis, String>,
) -> Outcome {
    let (before, after) = match (before, after) {
        (Ok(before), Ok(after)) => (before, after),
        (Err(_), _) => return Outcome::NotAsked,
        (Ok(_), Err(reason)) => return Outcome::Refused(reason.clone()),
    };
    let lost: Vec<&str> = before
        .confident_ids()
        .into_iter()
        .filter(|id| !says(after, id))
        .collect();
    let new: Vec<&str> = after
        .confident_ids()
        .into_iter()
        .filter(|id| !says(before, id))
        .collect();
    let verdicts = (before.verdict.as_str(), after.verdict.as_str());
    let verdict = format!("{} → {}", verdicts.0, verdicts.1);
    let hinted = lost.iter().all(|id| hints(after, id));
    let short = after.verdict == "insufficient-data";
    if !lost.is_empty() && (!new.is_empty() || !hinted && !short) {
        let what = format!(
            "{verdict}; lost {}; new {}",
            list(lost.into_iter()),
            list(new.into_iter())
        );
        return Outcome::Flipped(what);
    }
    if !lost.is_empty() {
        return Outcome::Weaker(format!(
            "{verdict}; no longer sure of {}",
            list(lost.into_iter())
        ));
    }
    if !new.is_empty() {
        return Outcome::More(format!("{verdict}; new {}", list(new.into_iter())));
    }
    if verdicts.0 != verdicts.1 {
        return match verdicts {
            (_, "insufficient-data") => Outcome::Weaker(verdict),
            _ if after.alarms() && !before.alarms() => Outcome::More(verdict),
            _ => Outcome::Flipped(verdict),
        };
    }
    match moved(property, before, after) {
        Some(what) => Outcome::Moved(what),
        None => Outcome::Same,
    }
}

/// The first confident name whose parameters are outside the other answer's intervals, in every name alike where there are several.
fn moved(property: Property, before: &Diagnosis, after: &Diagnosis) -> Option<String> {
    before.confident().find_map(|old| {
        let alike = after.confident().filter(|new| new.id == old.id);
        let moves: Option<Vec<String>> = alike.map(|new| differs(property, old, new)).collect();
        moves?.into_iter().next()
    })
}

/// The first parameter that is outside both intervals, or without any, 5 % off.
fn differs(property: Property, old: &Named, new: &Named) -> Option<String> {
    // Where a phase is zero is a convention that a shift may move; a mirror swaps from and to.
    let skipped: &[&str] = match property {
        Property::Mirrored => &["phase", "cosine", "sine", "from_", "to_"],
        _ => &["phase", "cosine", "sine"],
    };
    for (key, value, interval) in &old.parameters {
        let stated = new.parameters.iter().find(|p| p.0 == *key);
        let Some((_, found, own)) =
            stated.filter(|_| !skipped.iter().any(|word| key.contains(word)))
        else {
            continue;
        };
        let (found, own) = match sign(property, &old.id, key) {
            // The shape of a map over the position mirrors term by term.
            None => (found.abs() * value.signum(), None),
            Some(sign) if sign < 0.0 => (-found, own.map(|(low, high)| (-high, -low))),
            Some(_) => (*found, *own),
        };
        let within = |interval: &Option<(f64, f64)>, value: f64| {
            interval.is_some_and(|(low, high)| low <= value && value <= high)
        };
        let near = (found - value).abs() <= 0.05 * value.abs();
        if !near && !within(interval, found) && !within(&own, *value) {
            return Some(format!("{}.{key}: {value:.4e} → {found:.4e}", old.id));
        }
    }
    None
}

/// What becomes of a parameter's sign; `None` where either may be right.
fn sign(property: Property, id: &str, key: &str) -> Option<f64> {
    if property != Property::Mirrored {
        return Some(1.0);
    }
    let odd = ["constant_force", "coulomb_asymmetry"].contains(&id)
        || ["position_m", "position_rad", "centre_m", "centre_rad"].contains(&key);
    match (odd, id) {
        (true, _) => Some(-1.0),
        (_, "position_force" | "position_friction" | "gravity" | "presliding_shape") => None,
        _ => Some(1.0),
    }
}
