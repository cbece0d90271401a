//! EMPS by its benchmark's rules: `cargo run --release -p preslide-cli --example emps [FOLDER]`.
//!
//! Trained on `emps_tracking.csv` alone, `emps_pulses.csv` is simulated from its recorded force without looking at its position after the
//! first 20 samples. Names of the catalogue are added one at a time to mass, Coulomb and viscous friction and offset, each set fitted
//! by output error: what is made small is the error of the simulated position, not of the force. Which name stays is
//! decided within the training file, where each half is simulated with what the other gave; the test file decides nothing.

use nalgebra::{DMatrix, DVector};
use preslide_host::effects::Effect;
use preslide_host::friction::FrictionModel;
use preslide_host::identify::{Options, identify};
use preslide_host::model::Model;
use preslide_host::progress::Progress;
use preslide_host::recording::{LoadOptions, MotionKind, Recording, load};
use preslide_host::simulate::motion_with_inertia;
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// Samples that start a simulation, by the benchmark's rules.
const GIVEN: usize = 20;
/// Steps of Gauss and Newton's method, and the change of a parameter, in its scale, over which a slope is taken: standstill comes and
/// goes with the parameters, and the error is not smooth below it.
const STEPS: usize = 10;
const SLOPE: f64 = 0.02;
/// Every so many samples are compared.
const EVERY: usize = 10;
/// Gain of the error within the training file that a name must bring.
const WORTH: f64 = 0.98;
/// The stage's travel (m).
const TRAVEL: [f64; 2] = [0.0, 0.25];

/// What is fitted: the rigid body first, then the names.
struct Name {
    id: &'static str,
    /// Key, start and scale; a scale of 0 stays.
    keys: &'static [(&'static str, f64, f64)],
}

const NAMES: [Name; 6] = [
    Name {
        id: "coulomb_asymmetry",
        keys: &[("asymmetry", 0.0, 0.02)],
    },
    Name {
        id: "stribeck",
        keys: &[
            ("level", 0.02, 0.05),
            ("velocity_m_s", 0.02, 0.005),
            ("exponent", 1.0, 0.0),
        ],
    },
    Name {
        id: "quadratic_drag",
        keys: &[("drag_N_s2_per_m2", 0.0, 50.0)],
    },
    Name {
        id: "position_spring",
        keys: &[("stiffness_N_per_m", 0.0, 5.0), ("centre_m", 0.125, 0.0)],
    },
    Name {
        id: "position_friction",
        keys: &[
            ("from_m", TRAVEL[0], 0.0),
            ("to_m", TRAVEL[1], 0.0),
            ("cosine1", 0.0, 0.03),
            ("cosine2", 0.0, 0.03),
        ],
    },
    Name {
        id: "position_force",
        keys: &[
            ("from_m", TRAVEL[0], 0.0),
            ("to_m", TRAVEL[1], 0.0),
            ("cosine1_N", 0.0, 0.5),
            ("cosine2_N", 0.0, 0.5),
        ],
    },
];

/// Mass, Coulomb, viscous, offset: scales.
const SCALES: [f64; 4] = [1.0, 0.5, 5.0, 0.2];

/// A set of names with its values.
#[derive(Clone)]
struct Fit {
    names: Vec<usize>,
    values: Vec<f64>,
}

impl Fit {
    fn with(&self, name: usize) -> Self {
        let starts = NAMES[name].keys.iter().map(|k| k.1);
        Self {
            names: self.names.iter().copied().chain([name]).collect(),
            values: self.values.iter().copied().chain(starts).collect(),
        }
    }

    fn scales(&self) -> Vec<f64> {
        let of = |n: &usize| NAMES[*n].keys.iter().map(|k| k.2);
        let names = self.names.iter().flat_map(of);
        SCALES.into_iter().chain(names).collect()
    }

    fn model(&self) -> Result<Model, String> {
        let mut values = self.values[SCALES.len()..].iter();
        let mut effects = Vec::new();
        for &name in &self.names {
            let Name { id, keys } = &NAMES[name];
            let own: Vec<(&str, f64)> = keys
                .iter()
                .zip(values.by_ref())
                .map(|(k, v)| (k.0, *v))
                .collect();
            effects.push(Effect::new(id, &own)?);
        }
        let [mass, coulomb, viscous, offset] = [0, 1, 2, 3].map(|i| self.values[i]);
        Ok(Model {
            inertia: mass,
            viscous,
            constant_force: offset,
            effects,
            ..Model::of_friction(MotionKind::Linear, FrictionModel::Coulomb { coulomb })
        })
    }

    /// Simulated less measured position (m).
    fn error(&self, recording: &Recording) -> Result<Vec<f64>, String> {
        let found = motion_with_inertia(&self.model()?, recording, GIVEN)?;
        let apart = found.position.iter().zip(&recording.position);
        Ok(apart.skip(GIVEN).map(|(a, b)| a - b).collect())
    }

    fn rmse_mm(&self, recording: &Recording) -> Result<f64, String> {
        let error = self.error(recording)?;
        let square: f64 = error.iter().map(|e| e * e).sum();
        Ok(1e3 * (square / error.len() as f64).sqrt())
    }

    /// Moves the values by `shares` of their scales.
    fn moved(&self, shares: &[f64]) -> Self {
        let scaled = self.values.iter().zip(self.scales()).zip(shares);
        Self {
            values: scaled.map(|((v, scale), s)| v + s * scale).collect(),
            ..self.clone()
        }
    }

    /// Fitted to a recording's position by Levenberg and Marquardt's method.
    fn fitted(mut self, recording: &Recording) -> Result<Self, String> {
        let few = |fit: &Self| -> Option<DVector<f64>> {
            let error = fit.error(recording).ok()?;
            Some(DVector::from_iterator(
                error.len().div_ceil(EVERY),
                error.into_iter().step_by(EVERY),
            ))
        };
        let refused = "the start of the search is refused";
        let mut now = few(&self).ok_or(refused)?;
        let n = self.values.len();
        let mut damping = 1e-3;
        for _ in 0..STEPS {
            let scales = self.scales();
            let slope = |j: usize| {
                let mut shares = vec![0.0; n];
                shares[j] = if scales[j] > 0.0 { SLOPE } else { 0.0 };
                few(&self.moved(&shares))
                    .map_or_else(|| DVector::zeros(now.len()), |e| (e - &now) / SLOPE)
            };
            let slopes: Vec<DVector<f64>> = (0..n).into_par_iter().map(slope).collect();
            let slopes = DMatrix::from_columns(&slopes);
            let (gram, right) = (slopes.tr_mul(&slopes), slopes.tr_mul(&now));
            let largest = gram.diagonal().max();
            let mut better = None;
            while better.is_none() && damping < 1e3 {
                let mut damped = gram.clone();
                for j in 0..n {
                    damped[(j, j)] += damping * gram[(j, j)] + 1e-9 * largest;
                }
                let step = damped.cholesky().map(|c| c.solve(&right));
                let next = step.map(|s| self.moved((-s).as_slice()));
                better = next.and_then(|next| {
                    let error = few(&next)?;
                    (error.norm() < now.norm()).then_some((next, error))
                });
                damping *= if better.is_some() { 0.2 } else { 5.0 };
            }
            let Some((next, error)) = better else { break };
            let gained = 1.0 - error.norm() / now.norm();
            (self, now) = (next, error);
            if gained < 1e-3 {
                break;
            }
        }
        Ok(self)
    }

    fn words(&self) -> String {
        let rigid = ["kg", "N", "N s/m", "N"];
        let mut words: Vec<String> = rigid
            .iter()
            .zip(&self.values)
            .map(|(unit, v)| format!("{v:.2} {unit}"))
            .collect();
        let keys = self.names.iter().flat_map(|n| NAMES[*n].keys);
        let values = keys.zip(&self.values[SCALES.len()..]);
        words.extend(
            values
                .filter(|(k, _)| k.2 > 0.0)
                .map(|(k, v)| format!("{} {v:.3}", k.0)),
        );
        words.join(", ")
    }
}

/// The training file, its halves and the test file.
struct Bench {
    train: Recording,
    halves: [Recording; 2],
    test: Recording,
}

impl Bench {
    /// Error of each half with what the other gave (mm).
    fn across(&self, start: &Fit) -> Result<f64, String> {
        let mut square = 0.0;
        for (own, other) in [(0, 1), (1, 0)] {
            let fit = start.clone().fitted(&self.halves[own])?;
            square += 0.5 * fit.rmse_mm(&self.halves[other])?.powi(2);
        }
        Ok(square.sqrt())
    }

    /// Error of both halves with parameters that neither was asked for (mm).
    fn halves_with(&self, fit: &Fit) -> Result<f64, String> {
        let [a, b] = [fit.rmse_mm(&self.halves[0])?, fit.rmse_mm(&self.halves[1])?];
        Ok((0.5 * (a * a + b * b)).sqrt())
    }

    fn row(&self, title: &str, fit: &Fit, across: Option<f64>) -> Result<(), String> {
        println!(
            "{title:<44} {:>8} {:>7.2} {:>7.2}  {}",
            across.map_or("–".to_owned(), |a| format!("{a:.2}")),
            fit.rmse_mm(&self.train)?,
            fit.rmse_mm(&self.test)?,
            fit.words()
        );
        Ok(())
    }
}

/// Mass, Coulomb and viscous friction and offset by least squares of the force, as `preslide identify` gives them.
fn least_squares(train: &Recording) -> Result<Fit, String> {
    let found = identify(train, &Options::default(), &Progress::new("identify", 0))?;
    let coulomb = &found.candidates[0];
    let value = |key: &str| {
        let found = coulomb.rigid_body.iter().chain(&coulomb.parameters);
        let found = found
            .map(|p| (p.0, p.1.value))
            .find(|p| p.0.starts_with(key));
        found.map(|p| p.1).ok_or(format!("no {key}"))
    };
    let keys = ["mass", "coulomb", "viscous", "offset"];
    let values = keys
        .map(value)
        .into_iter()
        .collect::<Result<Vec<f64>, String>>()?;
    Ok(Fit {
        names: Vec::new(),
        values,
    })
}

fn read(folder: &Path, file: &str) -> Result<Recording, String> {
    let options = LoadOptions {
        ignore: vec!["voltage_cmd_V".to_owned()],
        ..LoadOptions::default()
    };
    load(&folder.join(file), &options).map_err(|e| e.to_string())
}

fn main() -> Result<(), String> {
    let folder = std::env::args().nth(1).map_or_else(
        || {
            PathBuf::from(concat!(
                env!("CARGO_MANIFEST_DIR"),
                "/../../shared/recordings/emps"
            ))
        },
        PathBuf::from,
    );
    if !folder.exists() {
        println!(
            "SKIPPED: {} is absent; name the folder of the EMPS recordings",
            folder.display()
        );
        return Ok(());
    }
    let train = read(&folder, "emps_tracking.csv")?;
    let test = read(&folder, "emps_pulses.csv")?;
    let end = train.t_s[train.len() - 1];
    let half = |from, to| train.slice_time(from, to).map_err(|e| e.to_string());
    let bench = Bench {
        halves: [half(0.0, 0.5 * end)?, half(0.5 * end, end)?],
        train,
        test,
    };
    println!(
        "position error of open-loop simulations, RMS in mm; across: each half of the training file with what the other gave"
    );
    println!(
        "{:<44} {:>8} {:>7} {:>7}  parameters",
        "fit", "across", "train", "test"
    );
    let least = least_squares(&bench.train)?;
    let given = bench.halves_with(&least)?;
    bench.row("least squares of the force (identify)", &least, Some(given))?;
    let mut best = least.clone().fitted(&bench.train)?;
    let mut lowest = bench.across(&least)?;
    bench.row("output error", &best, Some(lowest))?;
    loop {
        let mut found: Option<(f64, Fit)> = None;
        for name in (0..NAMES.len()).filter(|n| !best.names.contains(n)) {
            let start = best.with(name);
            let across = bench.across(&start)?;
            let fit = start.fitted(&bench.train)?;
            let all: Vec<&str> = fit.names.iter().map(|n| NAMES[*n].id).collect();
            bench.row(&format!("  + {}", all.join(" + ")), &fit, Some(across))?;
            if found.as_ref().is_none_or(|f| across < f.0) {
                found = Some((across, fit));
            }
        }
        match found {
            Some((across, fit)) if across < WORTH * lowest => (lowest, best) = (across, fit),
            _ => break,
        }
    }
    bench.row("chosen within the training file", &best, Some(lowest))?;
    // How much of the rest is a model's, and how much is that the stage was not the same on both days.
    let own = least.fitted(&bench.test)?;
    bench.row("not by the rules: the same fitted to the test", &own, None)
}
