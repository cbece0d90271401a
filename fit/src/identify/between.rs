//! What changed between recordings of one machine: the rigid body of each, and whether one factor of the effort makes one of the other.

use super::fit::{key, shown, unit};
use super::fitting::Fitting;
use super::plain::Plain;
use super::rigid_body;
use super::weights::Weights;
use crate::friction::FrictionModel;
use crate::recording::{MotionKind, Recording};
use crate::report::figures::{ends, within};
use crate::signal::Kinematics;
use serde_json::{Value, json};

/// A change is reported beyond so many times the 95 % reach of a difference: three standard errors, of some ten parameters and files.
const SURE: f64 = 1.5;
/// Folds of a file from which its intervals say something.
const FEWEST: usize = 4;
/// Offsets and places are no factor of anything.
const NO_SIZE: [&str; 3] = ["offset", "spring_centre", "gravity_angle"];

/// What a later recording has otherwise than the first.
#[derive(Clone, Debug)]
pub struct Change {
    /// Number of the file, from 1; the first is compared with.
    pub file: usize,
    /// The factor of the effort that explains all that differs, as a relative change with its 95 % reach.
    pub gain: Option<[f64; 2]>,
    /// Parameters that differ beyond doubt, with their values, the relative change and its 95 % reach.
    pub parameters: Vec<Changed>,
}

/// A parameter that differs.
#[derive(Clone, Debug)]
pub struct Changed {
    /// Its name.
    pub name: &'static str,
    /// In the first file, and in this one.
    pub values: [f64; 2],
    /// Relative change.
    pub change: f64,
    /// Reach of its 95 % interval.
    pub reach: f64,
}

/// Compares every later file with the first, each by the plain physics of all and one factor of their hysteresis. Files that tell too little of
/// it are left out, and so is what does not differ.
pub(super) fn between(fitting: &Fitting, plain: Plain, hysteresis: &FrictionModel) -> Vec<Change> {
    let recording = fitting.recording;
    let breakaway = hysteresis.breakaway().filter(|force| *force > 0.0);
    let friction = hysteresis.force(fitting.kinematics.path(recording)).ok();
    let (Some(breakaway), Some(friction), true) = (breakaway, friction, recording.joined.len() > 1)
    else {
        return Vec::new();
    };
    let kinematics = Kinematics {
        direction: friction.iter().map(|force| force / breakaway).collect(),
        ..fitting.kinematics.clone()
    };
    let weights = Weights::default();
    let of = |file: usize| -> Option<Vec<(&'static str, f64, f64)>> {
        let rows = recording.joined.get(file)?;
        let own = fitting.split.folds.iter().map(|fold| {
            let own = fold.iter().copied().filter(|i| rows.contains(i));
            own.collect::<Vec<usize>>()
        });
        let own: Vec<Vec<usize>> = own.filter(|fold| !fold.is_empty()).collect();
        // Where friction and offset are one sum, it changes with the direction and not with the machine.
        if own.len() < FEWEST || fitting.goes_one_way(&own.concat()) {
            return None;
        }
        let fit = rigid_body::fit(
            recording,
            &kinematics,
            fitting.effort,
            &own,
            &weights,
            plain,
        );
        let sized = fit.ok()?.parameters.into_iter();
        sized
            .filter(|p| !NO_SIZE.contains(&p.0))
            .map(|(name, e)| Some((name, e.value, e.reach()?)))
            .collect()
    };
    let Some(first) = of(0) else {
        return Vec::new();
    };
    let compared = (1..recording.joined.len()).filter_map(|file| {
        let all: Vec<Changed> = first
            .iter()
            .zip(of(file)?)
            .map(|(&(name, a, reach_a), (_, b, reach_b))| Changed {
                name,
                values: [a, b],
                change: b / a - 1.0,
                reach: reach_a.hypot(reach_b) / a.abs(),
            })
            .collect();
        let gain = gain(&all);
        let parameters: Vec<Changed> = all
            .into_iter()
            .filter(|p| p.change.abs() > SURE * p.reach && p.values[0] > 0.0)
            .collect();
        (!parameters.is_empty()).then_some(Change {
            file: file + 1,
            gain,
            parameters,
        })
    });
    compared.collect()
}

/// The one factor that explains every change, with its reach; `None` if there is none, or none is needed.
fn gain(all: &[Changed]) -> Option<[f64; 2]> {
    let weight = |p: &Changed| p.reach.powi(-2);
    let whole: f64 = all.iter().map(weight).sum();
    let mean = all.iter().map(|p| weight(p) * p.change).sum::<f64>() / whole;
    let reach = whole.sqrt().recip();
    let fits = |p: &Changed| (p.change - mean).abs() <= SURE * p.reach;
    let told = all.len() > 1 && mean.abs() > SURE * reach && all.iter().all(fits);
    told.then_some([mean, reach])
}

impl Change {
    /// For machines.
    pub(super) fn to_json(&self, kind: MotionKind) -> Value {
        let parameter = |p: &Changed| json!({ "key": key(kind, p.name), "values": p.values, "change": p.change, "reach": p.reach });
        json!({
            "file": self.file, "gain": self.gain,
            "parameters": self.parameters.iter().map(parameter).collect::<Vec<_>>(),
        })
    }

    /// In words, a sentence without its full stop.
    pub fn words(&self, recording: &Recording) -> String {
        let names: Vec<&str> = recording.name.split(", ").collect();
        let of = |file: usize| match names.get(file - 1) {
            Some(name) if names.len() == recording.joined.len() => (*name).to_owned(),
            _ => format!("file {file}"),
        };
        let percent = |change: f64, reach: f64| within(100.0 * change, 100.0 * reach, "%");
        let parts = self.parameters.iter().map(|p| {
            let (a, b, unit) = ends(p.values[0], p.values[1], &unit(recording, p.name));
            let name = shown(recording, p.name);
            format!("{name} {a} → {b} {unit} ({})", percent(p.change, p.reach))
        });
        let parts = parts.collect::<Vec<_>>().join(", ");
        let gain = self.gain.map_or(
            "no one factor of the effort explains that: the machine changed, not its scale".to_owned(),
            |[gain, reach]| {
                format!(
                    "one factor of the effort, {}, explains all that differs: a drive gain or a scale",
                    percent(gain, reach)
                )
            },
        );
        format!("from {} to {}: {parts}; {gain}", of(1), of(self.file))
    }
}

#[cfg(test)]
mod tests {
    use crate::identify::{Identification, Options, identify};
    use crate::progress::Progress;
    use crate::recording::{LoadOptions, Recording, load_csv};
    use preslide_host_tests::made::{Blocks, sines};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use std::f64::consts::TAU;
    use std::fmt::Write as _;

    /// 20 s of a body with a block of friction, recorded with a gain and noise of 20 mN.
    fn made(name: &str, seed: u64, mass: f64, friction: f64, gain: f64) -> Recording {
        println!("{name}: seed {seed}");
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut block = Blocks::new(&[(friction / 2e-5, 2e-5)]);
        let mut text = "t_s,x_m,force_N\n".to_owned();
        for i in 0..20_000 {
            let t = f64::from(i) * 1e-3;
            let [x, v, a] = sines(&[[0.02, TAU * 0.5, 0.0], [2e-3, TAU * 2.0, 0.0]], t);
            let noise = 0.02 * random.random_range(-1.0..1.0);
            let force = gain * (mass * a + 6.0 * v + block.force(x)) + noise;
            let _ = writeln!(text, "{t:.3},{x:.8e},{force:.6}");
        }
        load_csv(text.as_bytes(), name, &LoadOptions::default()).expect("valid")
    }

    fn told(files: Vec<Recording>) -> (Identification, Vec<String>) {
        let joined = Recording::join(files).expect("one machine");
        let progress = Progress::new("test", 0);
        let found = identify(&joined, &Options::default(), &progress).expect("a fit");
        let words = found.between.iter().map(|c| c.words(&joined)).collect();
        println!("{words:?}");
        (found, words)
    }

    #[test]
    fn separates_a_gain_a_changed_machine_and_no_change() {
        let first = || made("first.csv", 1, 3.0, 4.0, 1.0);
        let (found, _) = told(vec![first(), made("same.csv", 2, 3.0, 4.0, 1.0)]);
        assert!(found.between.is_empty());

        let (found, words) = told(vec![first(), made("gain.csv", 3, 3.0, 4.0, 0.97)]);
        let [gain, reach] = found.between[0].gain.expect("one factor");
        assert!(
            (gain + 0.03).abs() < 2.0 * reach && reach < 5e-3,
            "{gain} ± {reach}"
        );
        assert!(
            words[0].starts_with("from first.csv to gain.csv: "),
            "{words:?}"
        );

        let (found, _) = told(vec![first(), made("worn.csv", 4, 3.0, 4.4, 1.0)]);
        let change = &found.between[0];
        assert!(change.gain.is_none());
        let names: Vec<&str> = change.parameters.iter().map(|p| p.name).collect();
        assert_eq!(names, ["coulomb"]);
        let coulomb = &change.parameters[0];
        assert!(
            (coulomb.change - 0.1).abs() < 2.0 * coulomb.reach,
            "{coulomb:?}"
        );
    }
}
