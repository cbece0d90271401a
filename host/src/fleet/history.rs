//! What changed of an axis against its own history, and what of that is an alarm.

use super::Row;
use preslide_fit::report::figures::within;
use preslide_fit::report::units::name_and_unit;
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::collections::BTreeMap;

/// Fewest earlier recordings that say how much a parameter differs from one to the next.
pub const FEWEST: usize = 4;

/// How a parameter changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// From one recording to the next.
    Step,
    /// A little with each of so many recordings.
    Drift(usize),
}

/// A parameter against the axis's earlier recordings.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// Its key.
    pub parameter: String,
    /// How it is judged.
    pub way: Way,
    /// Its mean in the earlier recordings; of a drift where it began.
    pub usual: f64,
    /// By how much it differs.
    pub by: f64,
    /// Half the width of the 95 % interval of that.
    pub reach: f64,
    /// Chance of as large a difference where nothing changed.
    pub chance: f64,
    /// Whether it is one among as many changes at the stated rate.
    pub alarm: bool,
}

/// The changes of each row, of rows that stand axis by axis, in the order of time. A recording of which nothing changed raises an alarm with the probability
/// `false_alarms` at most, however many parameters it has (Bonferroni); the scatter from one recording to the next is the axis's own, and never less
/// than the intervals of the fits.
///
/// A value that raised an alarm is none of the usual ones: a change that lasts raises it again with every recording.
pub fn changes(rows: &[Row], false_alarms: f64) -> Vec<Vec<Change>> {
    let of_axes = rows.chunk_by(|a, b| a.axis == b.axis);
    of_axes.flat_map(|own| of_axis(own, false_alarms)).collect()
}

/// Of an axis a parameter's usual values, by its key and the effort's unit, which no key names.
type Usual<'a> = BTreeMap<(&'a str, Option<&'a str>), Vec<Value>>;

/// A value of a parameter.
#[derive(Clone, Copy)]
struct Value {
    /// The recording's number.
    number: f64,
    value: f64,
    /// Variance by the fit's interval.
    of_fit: Option<f64>,
}

fn of_axis(rows: &[Row], false_alarms: f64) -> Vec<Vec<Change>> {
    let mut usual = Usual::new();
    let numbered = rows.iter().enumerate();
    numbered
        .map(|(number, row)| changes_of(row, number as f64, &mut usual, false_alarms))
        .collect()
}

/// The changes of a row, the surest first; what raises no alarm becomes usual.
fn changes_of<'a>(
    row: &'a Row,
    number: f64,
    usual: &mut Usual<'a>,
    false_alarms: f64,
) -> Vec<Change> {
    let mut changes = Vec::new();
    let mut told = Vec::new();
    for (key, (value, interval)) in &row.parameters {
        let own = Value {
            number,
            value: *value,
            of_fit: interval.map(|[low, high]| ((high - low) / 3.92).powi(2)),
        };
        let key = (key.as_str(), row.effort_unit.as_deref());
        let earlier = usual.entry(key).or_default();
        if earlier.len() >= FEWEST {
            changes.extend(step(key.0, earlier, own));
            changes.extend(drift(key.0, earlier, own));
        }
        told.push((key, own));
    }
    let tried = changes.len().max(1) as f64;
    for change in &mut changes {
        change.alarm = change.chance * tried <= false_alarms;
    }
    for (key, own) in told {
        if !changes.iter().any(|c| c.alarm && c.parameter == key.0) {
            usual.entry(key).or_default().push(own);
        }
    }
    changes.sort_by(|a, b| a.chance.total_cmp(&b.chance));
    changes
}

/// The value against the mean of those before it.
fn step(key: &str, earlier: &[Value], own: Value) -> Option<Change> {
    let n = earlier.len() as f64;
    let mean = earlier.iter().map(|p| p.value).sum::<f64>() / n;
    let squares = earlier
        .iter()
        .map(|p| (p.value - mean).powi(2))
        .sum::<f64>();
    let variance = (squares / (n - 1.0)).max(of_fits(earlier, own));
    let error = (variance * (1.0 + 1.0 / n)).sqrt();
    judged(key, Way::Step, [mean, own.value - mean, error], n - 1.0)
}

/// The straight line through all values: what wears by less than its scatter from one recording to the next shows in many.
fn drift(key: &str, earlier: &[Value], own: Value) -> Option<Change> {
    let all = || earlier.iter().chain([&own]);
    let n = earlier.len() as f64 + 1.0;
    let [number, mean] =
        [|p: &Value| p.number, |p: &Value| p.value].map(|of| all().map(of).sum::<f64>() / n);
    let spread = all().map(|p| (p.number - number).powi(2)).sum::<f64>();
    let slope = all()
        .map(|p| (p.number - number) * (p.value - mean))
        .sum::<f64>()
        / spread;
    let line = |at: f64| mean + slope * (at - number);
    let squares = all()
        .map(|p| (p.value - line(p.number)).powi(2))
        .sum::<f64>();
    let variance = (squares / (n - 2.0)).max(of_fits(earlier, own));
    let first = earlier.first()?.number;
    let span = own.number - first;
    let way = Way::Drift(earlier.len() + 1);
    let error = (variance / spread).sqrt() * span;
    judged(key, way, [line(first), slope * span, error], n - 2.0)
}

/// Mean variance by the fits' intervals, 0 without any.
fn of_fits(earlier: &[Value], own: Value) -> f64 {
    let all: Vec<f64> = earlier
        .iter()
        .chain([&own])
        .filter_map(|p| p.of_fit)
        .collect();
    all.iter().sum::<f64>() / all.len().max(1) as f64
}

/// A difference with its standard error, by Student's t.
fn judged(key: &str, way: Way, [usual, by, error]: [f64; 3], freedom: f64) -> Option<Change> {
    let t = StudentsT::new(0.0, 1.0, freedom).ok()?;
    // What repeats to the last digit has no scatter to be judged by.
    if error.is_nan() || error <= 1e-9 * usual.abs() {
        return None;
    }
    Some(Change {
        parameter: key.to_owned(),
        way,
        usual,
        by,
        reach: t.inverse_cdf(0.975) * error,
        chance: 2.0 * t.cdf(-(by / error).abs()),
        alarm: false,
    })
}

impl Change {
    /// The parameter for people, and `+12.0 ± 3.1 %`, of a drift with the recordings that it took; of what may as well be none in its own unit, of
    /// an effort in such a unit.
    pub fn words(&self, effort: &str) -> [String; 2] {
        let (name, unit) = name_and_unit(&self.parameter, effort);
        let sign = if self.by > 0.0 { "+" } else { "" };
        let size = match self.usual.abs() > self.reach {
            true => {
                let percent = 100.0 / self.usual.abs();
                within(percent * self.by, percent * self.reach, "%")
            }
            false => within(self.by, self.reach, &unit),
        };
        let over = match self.way {
            Way::Step => String::new(),
            Way::Drift(recordings) => format!(" over {recordings} recordings"),
        };
        [name, format!("{sign}{size}{over}")]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use statrs::distribution::Normal;

    /// Rows of one axis, each of three parameters that scatter by 2 %, with intervals of 1 %.
    fn axis(name: &str, count: usize, random: &mut ChaCha8Rng) -> Vec<Row> {
        let normal = Normal::standard();
        let mut draw = |usual: f64| {
            let z = normal.inverse_cdf(random.random_range(1e-9..1.0 - 1e-9));
            let value = usual * (1.0 + 0.02 * z);
            (value, Some([0.995 * value, 1.005 * value]))
        };
        let mut row = |i: usize| Row {
            axis: name.to_owned(),
            file: format!("{name}/{i}"),
            parameters: [
                ("mass_kg", 3.0),
                ("coulomb_N", 12.0),
                ("viscous_N_s_per_m", 200.0),
            ]
            .map(|(key, usual)| (key.to_owned(), draw(usual)))
            .into(),
            ..Row::default()
        };
        (0..count).map(&mut row).collect()
    }

    #[test]
    fn unchanged_recordings_raise_alarms_at_the_stated_rate() {
        const SEED: u64 = 20261127;
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        for length in [6, 12, 40] {
            let rows: Vec<Row> = (0..3000 / length * 10)
                .flat_map(|i| axis(&format!("axis{i}"), length, &mut random))
                .collect();
            let all = changes(&rows, 0.01);
            let judged = all.iter().filter(|c| !c.is_empty()).count() as f64;
            let alarms = all.iter().filter(|own| own.iter().any(|c| c.alarm)).count() as f64;
            let rate = alarms / judged;
            eprintln!(
                "seed {SEED}, {length} recordings an axis: {alarms} alarms of {judged}, {rate:.4}"
            );
            assert!((0.006..0.0125).contains(&rate), "{length}: {rate}");
        }
    }

    #[test]
    fn reports_what_changed_and_by_how_much() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut rows = axis("press", 20, &mut random);
        let coulomb = &mut rows[19].parameters.get_mut("coulomb_N").expect("there").0;
        *coulomb *= 1.15;
        let last = changes(&rows, 0.01).pop().expect("rows");
        assert!(
            last[0].alarm && last[0].parameter == "coulomb_N",
            "{last:?}"
        );
        let percent = 100.0 * last[0].by / last[0].usual;
        assert!((8.0..22.0).contains(&percent), "{}", last[0].parameter);
        let others = last.iter().filter(|c| c.parameter != "coulomb_N");
        assert!(
            others.clone().count() == 4 && !others.into_iter().any(|c| c.alarm),
            "{last:?}"
        );
    }

    /// Whoever looks once a week must see what happened on Monday: the days after it are no more usual than that day.
    #[test]
    fn a_change_that_lasts_raises_an_alarm_every_day() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut rows = axis("press", 40, &mut random);
        for row in &mut rows[15..] {
            let (mass, interval) = row.parameters.get_mut("mass_kg").expect("there");
            *mass *= 1.15;
            *interval = interval.map(|ci| ci.map(|limit| 1.15 * limit));
        }
        for own in &changes(&rows, 0.01)[15..] {
            let step = own
                .iter()
                .find(|c| c.parameter == "mass_kg" && c.way == Way::Step);
            let step = step.expect("judged");
            assert!(
                step.alarm && (step.by / step.usual - 0.15).abs() < 0.08,
                "{step:?}"
            );
        }
    }

    /// Wear by its scatter from one recording to the next widens that scatter, in which each recording alone is none to be seen.
    #[test]
    fn creeping_wear_raises_an_alarm() {
        let mut random = ChaCha8Rng::seed_from_u64(6);
        let mut first = Vec::new();
        for _ in 0..40 {
            let mut rows = axis("press", 20, &mut random);
            for (day, row) in rows.iter_mut().enumerate() {
                let (coulomb, _) = row.parameters.get_mut("coulomb_N").expect("there");
                *coulomb *= 1.0 + 0.02 * day as f64;
            }
            let all = changes(&rows, 0.01);
            let alarms =
                |own: &Vec<Change>| own.iter().any(|c| c.alarm && c.parameter == "coulomb_N");
            first.push(all.iter().position(alarms).unwrap_or(rows.len()));
            assert!(alarms(&all[19]), "{:?}", all[19]);
        }
        first.sort_unstable();
        eprintln!(
            "2 % a day in scatter of 2 %: the first alarm comes on day {} (median), {} at the latest",
            first[20] + 1,
            first[39] + 1
        );
        assert!(first[20] <= 9 && first[39] <= 12, "{first:?}");
    }

    #[test]
    fn a_short_history_raises_no_alarm() {
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let rows = axis("press", FEWEST + 1, &mut random);
        let all = changes(&rows, 1.0);
        assert!(all[..FEWEST].iter().all(Vec::is_empty) && all[FEWEST].len() == 6);
    }
}
