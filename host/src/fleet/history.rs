//! What changed of an axis against its own history, and what of that is an alarm.

use super::Row;
use preslide_fit::report::figures::within;
use preslide_fit::report::units::name_and_unit;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Fewest earlier recordings that say how much a parameter differs from one to the next.
pub const FEWEST: usize = 4;

/// A parameter against the axis's earlier recordings.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// Its key.
    pub parameter: String,
    /// Its mean in the earlier recordings.
    pub usual: f64,
    /// By how much it differs.
    pub by: f64,
    /// Half the width of the 95 % interval of that.
    pub reach: f64,
    /// Chance of as large a difference where nothing changed.
    pub chance: f64,
    /// Whether it is one among as many parameters at the stated rate.
    pub alarm: bool,
}

/// The changes of each row, of rows that stand axis by axis, in the order of time. A recording of which nothing changed raises an alarm with the probability
/// `false_alarms` at most, however many parameters it has (Bonferroni); the scatter from one recording to the next is the axis's own, and never less
/// than the intervals of the fits.
pub fn changes(rows: &[Row], false_alarms: f64) -> Vec<Vec<Change>> {
    let of_axes = rows.chunk_by(|a, b| a.axis == b.axis);
    of_axes
        .flat_map(|own| (0..own.len()).map(move |i| (&own[..i], &own[i])))
        .map(|(earlier, row)| {
            let keys = row.parameters.keys();
            let mut changes: Vec<Change> =
                keys.filter_map(|key| change(earlier, row, key)).collect();
            let tried = changes.len().max(1) as f64;
            for change in &mut changes {
                change.alarm = change.chance * tried <= false_alarms;
            }
            changes.sort_by(|a, b| a.chance.total_cmp(&b.chance));
            changes
        })
        .collect()
}

fn change(earlier: &[Row], row: &Row, key: &str) -> Option<Change> {
    let (value, interval) = row.parameters.get(key)?;
    // A key names its unit but for the effort's.
    let alike = earlier.iter().filter(|r| r.effort_unit == row.effort_unit);
    let told: Vec<&(f64, Option<[f64; 2]>)> = alike.filter_map(|r| r.parameters.get(key)).collect();
    if told.len() < FEWEST {
        return None;
    }
    let n = told.len() as f64;
    let usual = told.iter().map(|p| p.0).sum::<f64>() / n;
    let scatter = told.iter().map(|p| (p.0 - usual).powi(2)).sum::<f64>() / (n - 1.0);
    let own: Vec<f64> = told
        .iter()
        .filter_map(|p| p.1)
        .chain(*interval)
        .map(|[low, high]| ((high - low) / 3.92).powi(2))
        .collect();
    let of_fits = own.iter().sum::<f64>() / own.len().max(1) as f64;
    let error = (scatter.max(of_fits) * (1.0 + 1.0 / n)).sqrt();
    let t = StudentsT::new(0.0, 1.0, n - 1.0).ok()?;
    let apart = value - usual;
    // What repeats to the last digit has no scatter to be judged by.
    if error.is_nan() || error <= 1e-9 * usual.abs() {
        return None;
    }
    Some(Change {
        parameter: key.to_owned(),
        usual,
        by: apart,
        reach: t.inverse_cdf(0.975) * error,
        chance: 2.0 * t.cdf(-(apart / error).abs()),
        alarm: false,
    })
}

impl Change {
    /// The parameter for people, and `+12.0 ± 3.1 %`; of what may as well be none in its own unit, of an effort in such a unit.
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
        [name, format!("{sign}{size}")]
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
        assert!(!last[1].alarm, "{last:?}");
    }

    #[test]
    fn a_short_history_raises_no_alarm() {
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let rows = axis("press", FEWEST + 1, &mut random);
        let all = changes(&rows, 1.0);
        assert!(all[..FEWEST].iter().all(Vec::is_empty) && all[FEWEST].len() == 3);
    }
}
