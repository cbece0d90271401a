//! A simulation in a file of its own, brought to the samples of the recording.

use super::simulated::{Simulated, correlation};
use super::units::Dimension;
use super::words::quantity;
use super::{EffortRole, LoadOptions, MotionKind, Needs, Recording, Warning, load};
use crate::evidence::evidence;
use crate::statistics;
use std::path::Path;

/// Share of the travel by which a simulation may miss the recorded motion that it was to follow.
const FOLLOWS: f64 = 0.01;
/// Least share of the recording that both clocks must cover for them to be one clock.
const SHARED: f64 = 0.9;
/// Longest shift that is looked for (s).
const LATEST_S: f64 = 0.5;
/// Squares that a shift of the motion leaves, over those without, up to which it is the clock's and not the simulation's own.
const SHIFTED: f64 = 0.25;
/// Samples from which a shift is one.
const LEAST: f64 = 2.0;
/// Standard errors over blocks of the recording by which another clock must leave less, and the share of what is left that it must take off unless
/// the file is as long as the recording.
const SURE: f64 = 3.0;
const TAKES: f64 = 0.25;
const BLOCKS: usize = 24;
/// Warnings that matter to what is identified of a file, and nothing to a simulation.
const OF_A_RECORDING: [&str; 2] = ["no-repeats", "extra-columns"];
/// Times by which measured and simulated sizes may differ: beyond, it is another unit.
const ANOTHER_UNIT: f64 = 30.0;

/// What rigid body and friction leave of some efforts along a recording, at the samples that are admitted.
pub type Beside = fn(&Recording, &[Vec<f64>], &dyn Fn(usize) -> bool) -> Option<Vec<Vec<f64>>>;

/// File and column of `FILE[:COLUMN]`; `None` where no such file is there.
fn split(name: &str) -> Option<(&Path, Option<&str>)> {
    let whole = Path::new(name);
    if whole.is_file() {
        return Some((whole, None));
    }
    let (file, column) = name.rsplit_once(':')?;
    let file = Path::new(file);
    file.is_file().then_some((file, Some(column)))
}

impl Recording {
    /// The simulation of `FILE[:COLUMN]` at the samples of this recording, its clock shifted where it starts elsewhere or is late; `None` where
    /// `name` is no file. What was done is a warning.
    ///
    /// # Errors
    /// A message for the user: a file that cannot be read, another quantity, another unit, another time.
    pub fn load_simulated(
        &mut self,
        name: &str,
        beside: Beside,
    ) -> Result<Option<Simulated>, String> {
        let Some((path, column)) = split(name) else {
            return Ok(None);
        };
        let dimension = column.and_then(|c| quantity(c).unit).map(|u| u.dimension);
        let is_position = dimension == Some(Dimension::of_position(self.kind));
        let target = match (is_position, self.kind, self.role) {
            (true, MotionKind::Linear, _) => "x_m",
            (true, MotionKind::Rotary, _) => "q_rad",
            (_, _, EffortRole::Force) => "force_N",
            (_, _, EffortRole::Friction) => "friction_N",
            (_, _, EffortRole::Torque) => "torque_Nm",
            (_, _, EffortRole::Current) => "current_A",
            (_, _, EffortRole::Voltage | EffortRole::Raw) => "voltage_V",
        };
        let map = column.map(|column| (target.to_owned(), column.to_owned()));
        let read = |needs| {
            let options = LoadOptions {
                needs,
                map: map.clone().into_iter().collect(),
                sign: Some(1.0),
                ..LoadOptions::default()
            };
            load(path, &options)
        };
        let loaded = match is_position {
            true => read(Needs::Motion),
            false => read(Needs::Both).or_else(|whole| read(Needs::Effort).map_err(|_| whole)),
        };
        let own = loaded.map_err(|error| format!("--simulated {name}: {error}"))?;
        let wrong = |what: &str| format!("--simulated {name}: {what}");
        if !own.position.is_empty() && own.kind != self.kind {
            return Err(wrong(&format!(
                "it is {}, the recording is {}",
                own.kind.name(),
                self.kind.name()
            )));
        }
        if !is_position && Dimension::of_effort(own.role) != Dimension::of_effort(self.role) {
            return Err(wrong(&format!(
                "it has a {} ({}), the recording a {} ({}); log the simulation in these",
                own.role.name(),
                own.effort_unit(),
                self.role.name(),
                self.effort_unit()
            )));
        }
        let told = own.warnings.iter();
        let told = told.filter(|warning| !OF_A_RECORDING.contains(&warning.code));
        self.warnings.extend(told.map(|warning| Warning {
            message: format!("{name}: {}", warning.message),
            ..warning.clone()
        }));
        let clock = self.clock_of(&own, beside).map_err(|what| wrong(&what))?;
        if clock.later != 0.0 {
            self.warnings.push(warning!(
                "simulated-clock",
                "{name} begins at another time: its clock is taken {} s {}",
                (1e6 * clock.later.abs()).round() / 1e6,
                if clock.later > 0.0 {
                    "later"
                } else {
                    "earlier"
                }
            ));
        }
        let at = |values: &[f64], late: f64| clock.at(&own.t_s, values, &self.t_s, late);
        if is_position || own.effort.is_empty() {
            return Ok(Some(Simulated::Motion {
                position: at(&own.position, 0.0),
                effort: None,
            }));
        }
        let late = lateness(&self.position, &at(&own.position, 0.0), self.sample_time_s);
        let (low, high) = self.ends();
        let follows = own.position.is_empty() || {
            let late = late.unwrap_or(0.0);
            let position = at(&own.position, late);
            // Beyond its ends it says nothing.
            let apart = (position.iter().zip(&self.position).zip(&self.t_s))
                .filter(|(_, t)| clock.covers(&own.t_s, *t + late))
                .map(|((a, b), _)| (a - b).abs());
            apart.fold(0.0, f64::max) <= FOLLOWS * (high - low)
        };
        let late = late.filter(|_| follows);
        let effort = at(&own.effort, late.unwrap_or(0.0));
        let position = at(&own.position, 0.0);
        self.warnings.extend(late.map(|late| {
            let ms = 1e3 * late;
            let message =
                format!("the motion in {name} is {ms:.3} ms late, which is taken off its clock");
            Warning::new("simulated-clock", message)
        }));
        let effort = self.checked(name, effort)?;
        Ok(Some(match follows {
            true => Simulated::Effort(effort),
            false => Simulated::Motion {
                position,
                effort: Some(effort),
            },
        }))
    }

    /// The clock of a simulation: as it is or, where that surely leaves less between the two, begun or ended with the recording.
    fn clock_of(&self, own: &Recording, beside: Beside) -> Result<Clock, String> {
        let mut clocks = Clock::all(&own.t_s, &self.t_s)?;
        let first = clocks[0].later;
        let apart = |clock: &Clock| (clock.later - first).abs() > LEAST * self.sample_time_s;
        clocks = clocks
            .into_iter()
            .enumerate()
            .filter_map(|(i, clock)| (i == 0 || apart(&clock)).then_some(clock))
            .collect();
        let best = self.fits_best(own, &clocks, beside).unwrap_or(0);
        Ok(clocks.swap_remove(best))
    }

    /// The clock that surely leaves less than the first between a simulation and the recording, beside numbers that may be wrong.
    fn fits_best(&self, own: &Recording, clocks: &[Clock], beside: Beside) -> Option<usize> {
        let is_moving = !own.position.is_empty();
        let (measured, simulated) = match is_moving {
            true => (&self.position, &own.position),
            false => (&self.effort, &own.effort),
        };
        if clocks.len() < 2 || measured.is_empty() || simulated.is_empty() {
            return None;
        }
        let between = |clock: &Clock| -> Vec<f64> {
            let simulated = clock.at(&own.t_s, simulated, &self.t_s, 0.0);
            let opposed = correlation(&simulated, measured) < super::simulated::OPPOSED;
            let sign = if opposed { -1.0 } else { 1.0 };
            let both = measured.iter().zip(simulated);
            both.map(|(m, s)| m - sign * s).collect()
        };
        let between: Vec<Vec<f64>> = clocks.iter().map(between).collect();
        let is_covered = |i: usize| clocks.iter().all(|c| c.covers(&own.t_s, self.t_s[i]));
        let left = match is_moving {
            true => {
                let covered = |all: &Vec<f64>| {
                    let own = (0..all.len()).filter(|i| is_covered(*i));
                    own.map(|i| all[i]).collect()
                };
                between.iter().map(covered).collect()
            }
            false => beside(self, &between, &is_covered)?,
        };
        let squares = |left: &[f64]| left.iter().map(|v| v * v).sum::<f64>();
        let best =
            (0..left.len()).min_by(|a, b| squares(&left[*a]).total_cmp(&squares(&left[*b])))?;
        // One of the recording's own length was made for it: that its stamps begin elsewhere says nothing.
        let lasts = |t: &[f64]| t.last().zip(t.first()).map_or(0.0, |(b, a)| b - a);
        let is_as_long = (lasts(&own.t_s) - lasts(&self.t_s)).abs()
            <= LEAST * self.sample_time_s.max(own.sample_time_s);
        let taken: Vec<f64> = left[0]
            .iter()
            .zip(&left[best])
            .map(|(a, b)| a - b)
            .collect();
        let cut = |k: usize| k * taken.len() / BLOCKS;
        let blocks: Vec<_> = (0..BLOCKS).map(|k| cut(k)..cut(k + 1)).collect();
        let found = evidence(&taken, &left[0], &blocks);
        (found.z >= SURE && (is_as_long || found.share >= TAKES)).then_some(best)
    }

    /// A simulated effort with the sign of the measured one, in its unit as far as its size shows.
    pub(super) fn checked(&mut self, name: &str, mut effort: Vec<f64>) -> Result<Vec<f64>, String> {
        let size = |values: &[f64]| {
            let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
            let square: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
            square.sqrt()
        };
        let times = size(&effort) / size(&self.effort).max(1e-300);
        if !(1.0 / ANOTHER_UNIT..=ANOTHER_UNIT).contains(&times) {
            return Err(format!(
                "--simulated {name}: it is {times:.3} times the measured {}: in another unit, or of another machine; give its unit in the column's name, such as {}_sim_m{}",
                self.role.name(),
                self.role.name(),
                self.effort_unit()
            ));
        }
        if correlation(&effort, &self.effort) < super::simulated::OPPOSED {
            effort.iter_mut().for_each(|v| *v = -*v);
            self.warnings.push(warning!(
                "simulated-sign",
                "{name} has the sign opposite to the measured effort: taken times -1"
            ));
        }
        Ok(effort)
    }
}

/// How a simulation's time becomes the recording's.
struct Clock {
    /// What is added (s).
    later: f64,
}

impl Clock {
    /// Those under which it covers the recording: as it is, begun with it, ended with it.
    fn all(own: &[f64], recorded: &[f64]) -> Result<Vec<Self>, String> {
        let ends = |t: &[f64]| t.first().copied().zip(t.last().copied());
        let Some((own, recorded)) = ends(own).zip(ends(recorded)) else {
            return Err("it has no samples".to_owned());
        };
        let length = recorded.1 - recorded.0;
        let shared = |later: f64| (own.1 + later).min(recorded.1) - (own.0 + later).max(recorded.0);
        let mut all = vec![0.0, recorded.0 - own.0, recorded.1 - own.1];
        all.retain(|later| shared(*later) >= SHARED * length);
        match all.is_empty() {
            false => Ok(all.into_iter().map(|later| Self { later }).collect()),
            true => Err(format!(
                "it lasts {:.3} s, the recording {length:.3} s; simulate the whole recording",
                own.1 - own.0
            )),
        }
    }

    /// Whether it has a recorded time.
    fn covers(&self, own: &[f64], recorded: f64) -> bool {
        let within = |first: &f64, last: &f64| (*first..=*last).contains(&(recorded - self.later));
        own.first()
            .zip(own.last())
            .is_some_and(|(a, b)| within(a, b))
    }

    /// Values at the recorded times, straight between two samples and held beyond the ends; they are `late` by so much (s).
    fn at(&self, own: &[f64], values: &[f64], recorded: &[f64], late: f64) -> Vec<f64> {
        if values.is_empty() {
            return Vec::new();
        }
        let value = |t: &f64| statistics::between(own, values, t - self.later + late);
        recorded.iter().map(value).collect()
    }
}

/// By how much (s) a simulated motion is later than the measured one, where a shift explains most of what lies between them.
fn lateness(measured: &[f64], simulated: &[f64], step: f64) -> Option<f64> {
    let n = measured.len();
    if simulated.len() != n {
        return None;
    }
    let most = ((LATEST_S / step) as usize).min(n / 4);
    let left = |shifted: &[f64]| {
        let apart = (most..n - most).map(|i| (measured[i] - shifted[i]).powi(2));
        apart.sum::<f64>()
    };
    let (late, [least, unshifted]) = statistics::lateness(simulated, most, left)?;
    (late.abs() >= LEAST && least < SHIFTED * unshifted).then_some(late * step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::beside_the_motion;
    use std::fmt::Write as _;

    const RATE_HZ: f64 = 1000.0;
    const MASS_KG: f64 = 0.4;

    fn motion(t: f64) -> (f64, f64) {
        let x = 0.03 * (3.1 * t).sin() + 0.01 * (8.3 * t).sin();
        let a = -0.03 * 3.1 * 3.1 * (3.1 * t).sin() - 0.01 * 8.3 * 8.3 * (8.3 * t).sin();
        let v = 0.03 * 3.1 * (3.1 * t).cos() + 0.01 * 8.3 * (8.3 * t).cos();
        (x, MASS_KG * a + 2.0 * (v / 0.001).tanh())
    }

    fn file(
        folder: &Path,
        name: &str,
        head: &str,
        rate: f64,
        row: impl Fn(f64) -> Vec<f64>,
    ) -> std::path::PathBuf {
        let mut text = format!("{head}\n");
        for i in 0..(20.0 * rate) as usize {
            let t = i as f64 / rate;
            let cells: Vec<String> = row(t).iter().map(f64::to_string).collect();
            writeln!(text, "{}", cells.join(",")).expect("text");
        }
        let path = folder.join(name);
        std::fs::write(&path, text).expect("written");
        path
    }

    fn recorded(folder: &Path) -> Recording {
        let row = |t: f64| vec![t, motion(t).0, motion(t).1];
        let path = file(folder, "recording.csv", "t_s,x_m,force_N", RATE_HZ, row);
        load(&path, &LoadOptions::default()).expect("a recording")
    }

    /// Largest difference from the recorded force away from the ends.
    fn apart(recording: &Recording, found: &Simulated) -> f64 {
        let Simulated::Effort(effort) = found else {
            panic!("no effort");
        };
        let pairs = effort.iter().zip(&recording.effort).skip(1000).take(18_000);
        let squares: f64 = pairs.map(|(a, b)| (a - b).powi(2)).sum();
        (squares / 18_000.0).sqrt()
    }

    #[test]
    fn a_file_of_another_rate_start_and_lateness_comes_to_the_samples() {
        let folder = tempfile::tempdir().expect("a folder");
        for (late, start, head) in [
            (0.0, 0.0, "t_s,force_N"),
            (0.0123, 7.5, "t_s,x_m,force_N"),
            (0.0, 3.0, "t_s,force_N"),
        ] {
            let mut recording = recorded(folder.path());
            let row = |t: f64| {
                let (x, force) = motion(t - late);
                match head.contains("x_m") {
                    true => vec![t + start, x, force],
                    false => vec![t + start, force],
                }
            };
            let path = file(folder.path(), "twin.csv", head, 800.0, row);
            let name = format!("{}:force_N", path.display());
            let found = recording
                .load_simulated(&name, beside_the_motion)
                .expect("read")
                .expect("a file");
            let apart = apart(&recording, &found);
            println!(
                "late {late} from {start}: {apart} N RMS, {:?}",
                recording.warnings
            );
            assert!(apart < 0.05, "{late} {start}: {apart}");
            let said = recording
                .warnings
                .iter()
                .filter(|w| w.code == "simulated-clock");
            let expected = usize::from(late != 0.0) + usize::from(start != 0.0);
            assert_eq!(said.count(), expected);
        }
    }

    /// A clock of its own is found though both clocks overlap and the simulation lacks a ripple; one that only began earlier stays.
    #[test]
    fn a_clock_that_overlaps_is_moved_where_that_explains_the_difference() {
        let folder = tempfile::tempdir().expect("a folder");
        let row = |t: f64| {
            let (x, force) = motion(t);
            vec![t, x, force + 0.3 * (x / 0.001).sin()]
        };
        let path = file(folder.path(), "ripple.csv", "t_s,x_m,force_N", RATE_HZ, row);
        for head in ["t_s,force_N", "t_s,x_m,force_N"] {
            for (stamp, moment) in [
                (0.02, 0.0),
                (-0.02, 0.0),
                (1.5, 0.0),
                (-0.7, 0.0),
                (-0.5, -0.5),
            ] {
                let mut recording = load(&path, &LoadOptions::default()).expect("a recording");
                let row = |t: f64| {
                    let (x, force) = motion(t + moment);
                    match head.contains("x_m") {
                        true => vec![t + stamp, x, force],
                        false => vec![t + stamp, force],
                    }
                };
                let twin = file(folder.path(), "twin.csv", head, 500.0, row);
                let found =
                    recording.load_simulated(&twin.display().to_string(), beside_the_motion);
                let found = found.expect("read").expect("a file");
                let apart = apart(&recording, &found);
                println!("{head} {stamp} {moment}: {apart}, {:?}", recording.warnings);
                // The ripple has 0.21 N RMS.
                assert!((apart - 0.212).abs() < 0.02, "{head} {stamp}: {apart}");
                let mut said = recording.warnings.iter();
                let said = said.any(|w| w.code == "simulated-clock");
                assert_eq!(said, stamp != moment);
            }
        }
    }

    #[test]
    fn a_motion_of_its_own_is_one_and_another_unit_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut recording = recorded(folder.path());
        let row = |t: f64| vec![t, 1.1 * motion(t).0, motion(t).1];
        let own = file(folder.path(), "own.csv", "t_s,x_m,force_N", RATE_HZ, row);
        let found = recording.load_simulated(&own.display().to_string(), beside_the_motion);
        assert!(
            matches!(
                found,
                Ok(Some(Simulated::Motion {
                    effort: Some(_),
                    ..
                }))
            ),
            "{found:?}"
        );
        let row = |t: f64| vec![t, motion(t).0, 1000.0 * motion(t).1];
        let milli = file(folder.path(), "milli.csv", "t_s,x_m,force_N", RATE_HZ, row);
        let refused = recording.load_simulated(&milli.display().to_string(), beside_the_motion);
        assert!(
            refused
                .clone()
                .is_err_and(|e| e.contains("1000") && e.contains("unit")),
            "{refused:?}"
        );
        assert_eq!(
            recording.load_simulated("nowhere.csv:force_N", beside_the_motion),
            Ok(None)
        );
    }
}
