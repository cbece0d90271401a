//! Numeric columns beyond those that a recording needs: what else the effort may follow.

use super::units::Dimension;
use super::{MotionKind, Warning, lost, words};

/// Cells that are no number after which a column that has more of them than numbers is one of words.
const WORDS: usize = 64;

/// A further column of the file, as it is written there: no unit is changed.
#[derive(Clone, Debug, PartialEq)]
pub struct Extra {
    /// The column's name as written, its unit suffix included.
    pub name: String,
    /// One value for every sample of the recording, finite and not all the same.
    pub values: Vec<f64>,
}

impl Extra {
    /// What its values are multiplied by to be positions of that kind in SI (m or rad), where its name ends in a unit of one.
    pub fn position_factor(&self, kind: MotionKind) -> Option<f64> {
        let unit = words::quantity(&self.name).unit?;
        (unit.dimension == Dimension::of_position(kind)).then_some(unit.factor)
    }

    /// Whether a column of such a name may be a motion: its unit, where it ends in one, is of length, angle or speed.
    pub fn is_motion(name: &str) -> bool {
        let unit = words::quantity(name).unit;
        unit.is_none_or(|u| {
            matches!(
                u.dimension,
                Dimension::Length | Dimension::Angle | Dimension::Speed | Dimension::AngularSpeed
            )
        })
    }
}

/// A further column while the file is read.
#[derive(Debug)]
pub(super) struct Reading {
    pub(super) name: String,
    pub(super) values: Vec<f64>,
    /// Samples that hold no number: the first, with its place, for messages, and all of them.
    broken: (String, Vec<usize>),
    /// Why it is none.
    pub(super) refused: Option<String>,
}

impl Reading {
    pub(super) fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            values: Vec::new(),
            broken: (String::new(), Vec::new()),
            refused: None,
        }
    }

    /// Takes the next value; or what stands there instead, with its place.
    pub(super) fn push(&mut self, value: Result<f64, String>) {
        let why = match value {
            _ if self.refused.is_some() => return,
            Ok(value) => return self.values.push(value),
            Err(why) => why,
        };
        let (first, places) = &mut self.broken;
        if places.is_empty() {
            *first = why;
        }
        places.push(self.values.len());
        self.values.push(f64::NAN);
        // Words throughout need not be counted to the end.
        if places.len() > WORDS && 2 * places.len() > self.values.len() {
            self.end();
        }
    }

    /// Holds what is lost from the value before, where that is little, which is said; or else refuses the column.
    fn end(&mut self) -> Option<String> {
        let (first, places) = std::mem::take(&mut self.broken);
        if places.is_empty() || self.refused.is_some() {
            return None;
        }
        if lost::too_many(places.len(), self.values.len() - places.len()) {
            self.refuse(first);
            return None;
        }
        lost::hold(&mut self.values, &places);
        let others = match places.len() - 1 {
            0 => String::new(),
            n => format!(" and {n} more"),
        };
        Some(format!("{} ({first}{others})", self.name))
    }

    /// Ends the reading of a column that holds something else than numbers.
    pub(super) fn refuse(&mut self, why: String) {
        self.values = Vec::new();
        self.refused = Some(why);
    }
}

/// Columns that stay at one value, by name.
pub(super) type Constant = Vec<(String, f64)>;

/// What became of the further columns: those that vary, and those that do not.
pub(super) type Sorted = (Vec<Extra>, Constant);

/// Keeps the columns of numbers; says in one line which are kept and which are not, but for those that are taken.
pub(super) fn sort(
    readings: Vec<Reading>,
    taken: &[String],
    warnings: &mut Vec<Warning>,
) -> Sorted {
    let (mut extra, mut constant) = (Vec::new(), Vec::new());
    let (mut left, mut held) = (Vec::new(), Vec::new());
    for mut reading in readings {
        held.extend(reading.end());
        let Reading {
            name,
            values,
            refused,
            ..
        } = reading;
        match (refused, values.first()) {
            (Some(why), _) => left.push(format!("{name} ({why})")),
            (None, Some(&first)) if values.iter().all(|&v| v == first) => {
                left.push(format!("{name} (always {first})"));
                constant.push((name, first));
            }
            (None, _) => extra.push(Extra { name, values }),
        }
    }
    let names = extra.iter().map(|e| &e.name);
    let names: Vec<&str> = (names.filter(|n| !taken.contains(n)).map(String::as_str)).collect();
    if !names.is_empty() {
        warnings.push(warning!(
            "extra-columns",
            "kept for what the effort may follow: {}; --ignore NAME leaves one out",
            names.join(", ")
        ));
    }
    if !held.is_empty() {
        warnings.push(warning!(
            "held-values",
            "no number, so the value before is taken: {}",
            held.join(", ")
        ));
    }
    if !left.is_empty() {
        warnings.push(warning!("unused-columns", "not used: {}", left.join(", ")));
    }
    (extra, constant)
}

/// Makes constants of the columns that have come to be, where samples were left out.
pub(super) fn move_constant((extra, constant): (&mut Vec<Extra>, &mut Constant)) {
    extra.retain(|e| {
        let first = e.values.first().copied().unwrap_or(0.0);
        let varies = e.values.iter().any(|&v| v != first);
        if !varies {
            constant.push((e.name.clone(), first));
        }
        varies
    });
}

/// Joins the further columns of two recordings of `samples.0` and `samples.1` samples: those that both have. One that is constant in
/// a recording is a column there too. Returns the names that only one of them has.
pub(super) fn join((first, second): (&mut Sorted, Sorted), samples: (usize, usize)) -> Vec<String> {
    let of = |sorted: &Sorted, name: &str, samples: usize| {
        let varying = sorted.0.iter().find(|e| e.name == name);
        let constant = || sorted.1.iter().find(|c| c.0 == name);
        varying
            .map(|e| e.values.clone())
            .or_else(|| constant().map(|c| vec![c.1; samples]))
    };
    let names = |sorted: &Sorted| -> Vec<String> {
        let varying = sorted.0.iter().map(|e| e.name.clone());
        varying
            .chain(sorted.1.iter().map(|c| c.0.clone()))
            .collect()
    };
    let (mut own, mut other) = (names(first), names(&second));
    let mut joined = (Vec::new(), Vec::new());
    let mut dropped = Vec::new();
    for name in own.drain(..) {
        let same = |c: &&(String, f64)| c.0 == name;
        if let (Some(a), Some(b)) = (first.1.iter().find(same), second.1.iter().find(same))
            && a.1 == b.1
        {
            joined.1.push(a.clone());
            continue;
        }
        match (of(first, &name, samples.0), of(&second, &name, samples.1)) {
            (Some(mut values), Some(more)) => {
                values.extend(more);
                joined.0.push(Extra { name, values });
            }
            _ => dropped.push(name),
        }
    }
    other.retain(|name| of(first, name, samples.0).is_none());
    dropped.extend(other);
    *first = joined;
    dropped
}

#[cfg(test)]
mod tests {
    use super::super::tests::{options, said};
    use super::super::{DROPPED, Recording, RecordingError, load_csv};
    use preslide_host_tests::refusal::refuses;

    fn load(text: &str, ignore: &[&str]) -> Recording {
        without(text, ignore).unwrap_or_else(|e| panic!("{e}"))
    }
    fn without(text: &str, ignore: &[&str]) -> Result<Recording, RecordingError> {
        let mut options = options(&[]);
        options.ignore = ignore.iter().map(|&i| i.to_owned()).collect();
        load_csv(text.as_bytes(), "extra.csv", &options)
    }
    fn names(recording: &Recording) -> Vec<&str> {
        recording.extra.iter().map(|e| e.name.as_str()).collect()
    }
    const FILE: &str = "t_s,x_m,force_N,joint5_q_rad,mode,note,vin_V\n\
        0,0,1,0.5,2,a,7\n1,1,1,0.7,2,b,7\n2,0,1,0.9,2,c,8\n";

    #[test]
    fn further_numbers_are_kept_as_written_and_the_rest_is_said() {
        let all = load(FILE, &[]);
        assert_eq!(names(&all), ["joint5_q_rad", "vin_V"]);
        assert_eq!(all.extra[0].values, [0.5, 0.7, 0.9]);
        assert!(said(&all, "extra-columns").contains("joint5_q_rad, vin_V"));
        for part in ["mode (always 2)", "note (line 2: `a` is not a number)"] {
            assert!(said(&all, "unused-columns").contains(part), "{all:?}");
        }
        assert_eq!(names(&load(FILE, &["vin_V"])), ["joint5_q_rad"]);
        let window = all.slice_time(0.5, 3.0).expect("two samples");
        assert_eq!(window.extra[1].values, [7.0, 8.0]);
    }

    #[test]
    fn a_name_to_ignore_that_is_not_there_is_refused() {
        refuses(without(FILE, &["vin"]), &["vin_V"]);
    }

    #[test]
    fn joined_recordings_keep_what_all_have_and_a_constant_in_one_is_a_column_there() {
        let second = "t_s,x_m,force_N,joint5_q_rad,mode,vin_V\n\
            0,0,1,0.5,3,7\n1,1,1,0.5,3,7\n2,0,1,0.5,3,7\n";
        let whole = Recording::join(vec![load(FILE, &[]), load(second, &[])]).expect("joined");
        assert_eq!(names(&whole), ["joint5_q_rad", "vin_V", "mode"]);
        assert_eq!(whole.extra[0].values, [0.5, 0.7, 0.9, 0.5, 0.5, 0.5]);
        assert_eq!(whole.extra[2].values, [2.0, 2.0, 2.0, 3.0, 3.0, 3.0]);
        let without = load("t_s,x_m,force_N\n0,0,1\n1,1,1\n2,0,1\n", &[]);
        let whole = Recording::join(vec![load(FILE, &[]), without]).expect("joined");
        assert!(whole.extra.is_empty());
        assert!(said(&whole, DROPPED).contains("vin_V"));
    }
}
