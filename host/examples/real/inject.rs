//! A known effect is added to a measured force, ever weaker: down to which strength is it named?

use super::{load, run, words};
use preslide_host::diagnose::Diagnosis;
use preslide_host::diagnose::conclude::Effect;
use preslide_host::friction::FrictionModel;
use preslide_host::model::Model;
use preslide_host::recording::Recording;
use preslide_host::report::Table;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Root mean square of what is added, in percent of the force's standard deviation.
const STRENGTHS: [f64; 6] = [20.0, 10.0, 5.0, 2.0, 1.0, 0.5];
/// Where a spot lies and what phase a wave has.
const SEED: u64 = 1;
/// What was published of EMPS [N], taken off before anything is added.
const EMPS_OFFSET: f64 = -3.1648;
/// And its mass [kg], through which an encoder's error is felt.
const EMPS_MASS: f64 = 95.1089;

/// Periods of a wave of force in the travel.
const WAVES: f64 = 12.0;
/// Periods of an encoder in the travel.
const LINES: f64 = 50.0;
/// Widths of a spot in the travel.
const SPOTS: f64 = 15.0;

/// The motion that effects follow.
struct Motion {
    x: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    low: f64,
    travel: f64,
    top: f64,
    /// Uniform in 0..1: place of a spot, phase of a wave.
    place: f64,
    phase: f64,
}

/// A central difference over 10 ms and more, within the pieces; 0 at their ends.
fn slope(y: &[f64], recording: &Recording) -> Vec<f64> {
    let dt = recording.sample_time_s();
    let reach = ((10e-3 / dt).round() as usize).max(2);
    let mut slope = vec![0.0; y.len()];
    for piece in &recording.pieces {
        for i in piece.start + reach..piece.end.saturating_sub(reach) {
            slope[i] = (y[i + reach] - y[i - reach]) / (2.0 * reach as f64 * dt);
        }
    }
    slope
}

impl Motion {
    fn of(recording: &Recording) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let mut uniform = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        let v = slope(&recording.position, recording);
        let fold = |pick: fn(f64, f64) -> f64, y: &[f64]| y.iter().copied().reduce(pick);
        let low = fold(f64::min, &recording.position).unwrap_or(0.0);
        let high = fold(f64::max, &recording.position).unwrap_or(1.0);
        Self {
            a: slope(&v, recording),
            x: recording.position.clone(),
            low,
            travel: high - low,
            top: v.iter().fold(0.0, |top: f64, v| top.max(v.abs())),
            v,
            place: 0.2 + 0.6 * uniform(),
            phase: TAU * uniform(),
        }
    }

    /// The force of an effect, in an unknown scale. Friction has the sign of the velocity, smoothed about standstill.
    fn force(&self, id: &str) -> Vec<f64> {
        let sign = |i: usize| (self.v[i] / (0.02 * self.top)).tanh();
        let at = |i: usize| -> f64 {
            let (x, v, a) = (self.x[i], self.v[i], self.a[i]);
            match id {
                "constant_force" => 1.0,
                "periodic_force" => (TAU * WAVES * x / self.travel + self.phase).cos(),
                "local_friction_spot" => {
                    let away = (x - self.low) / self.travel - self.place;
                    sign(i) * (-(away * SPOTS).powi(2)).exp()
                }
                "stribeck" => sign(i) * (-v.abs() / (0.1 * self.top)).exp(),
                "quadratic_drag" => v * v.abs(),
                // The mass follows the motion as it is measured: d²/dt² of e·cos(k·x + φ).
                "encoder_error" => {
                    let k = TAU * LINES / self.travel;
                    let angle = k * x + self.phase;
                    -EMPS_MASS * ((k * v).powi(2) * angle.cos() + k * a * angle.sin())
                }
                _ => 0.0,
            }
        };
        (0..self.x.len()).map(at).collect()
    }
}

fn rms(y: &[f64]) -> f64 {
    (y.iter().map(|y| y * y).sum::<f64>() / y.len() as f64).sqrt()
}

/// The force delayed so that it changes by an RMS of `size`; between samples by a straight line.
fn delayed(recording: &Recording, size: f64) -> Vec<f64> {
    let dt = recording.sample_time_s();
    let delay = size / rms(&slope(&recording.effort, recording)).max(1e-300);
    let mut effort = recording.effort.clone();
    for piece in &recording.pieces {
        for i in piece.clone() {
            let at = (i - piece.start) as f64 - delay / dt;
            let from = piece.start + at.max(0.0) as usize;
            let share = at.max(0.0).fract();
            let next = (from + 1).min(piece.end - 1);
            effort[i] = (1.0 - share) * recording.effort[from] + share * recording.effort[next];
        }
    }
    effort
}

/// A recording with an effect in it, `percent` of its force.
fn with(recording: &Recording, id: &str, percent: f64) -> Recording {
    let mean = recording.effort.iter().sum::<f64>() / recording.len() as f64;
    let centred: Vec<f64> = recording.effort.iter().map(|f| f - mean).collect();
    let size = percent / 100.0 * rms(&centred);
    let mut changed = recording.clone();
    if id == "channel_delay" {
        changed.effort = delayed(recording, size);
    } else {
        let force = Motion::of(recording).force(id);
        let scale = size / rms(&force).max(1e-300);
        for (f, added) in changed.effort.iter_mut().zip(force) {
            *f += scale * added;
        }
    }
    changed
}

/// Whether the period or the place of an effect is that of the one that was added.
fn is_it(effect: &Effect, recording: &Recording) -> bool {
    let motion = Motion::of(recording);
    let close = |key: &str, true_value: f64, within: f64| {
        let found = effect.parameters.iter().find(|p| p.0 == key);
        found.is_some_and(|p| (p.1.value - true_value).abs() < within)
    };
    let period = |periods: f64| motion.travel / periods;
    match effect.id {
        "periodic_force" => close("period_m", period(WAVES), 0.03 * period(WAVES)),
        "encoder_error" => close("period_m", period(LINES), 0.03 * period(LINES)),
        "local_friction_spot" => {
            let place = motion.low + motion.place * motion.travel;
            close("position_m", place, motion.travel / SPOTS)
        }
        _ => true,
    }
}

/// The effect that was added, and its place in the list, where it was found.
fn found<'a>(d: &'a Diagnosis, id: &str, recording: &Recording) -> Option<(usize, &'a Effect)> {
    let mut effects = d.effects.iter().enumerate();
    effects.find(|(_, e)| e.id == id && is_it(e, recording))
}

/// Rank, level and nats of an effect, or what stands first instead.
fn cell(d: &Diagnosis, id: &str, recording: &Recording) -> String {
    match found(d, id, recording) {
        Some((place, effect)) => {
            let level = if effect.confident {
                "confident"
            } else {
                "suspected"
            };
            format!("{}. {level} {:.0}", place + 1, effect.nats)
        }
        None => {
            let first = d.effects.first().map_or(d.verdict, |e| e.id);
            format!("– ({first})")
        }
    }
}

/// The weakest strength up from which every one is named, confidently or at all.
fn weakest(named: &[Option<bool>], enough: impl Fn(&Option<bool>) -> bool) -> String {
    let strengths = named.iter().zip(STRENGTHS).take_while(|(f, _)| enough(f));
    strengths
        .last()
        .map_or("none".to_owned(), |(_, s)| format!("{s} %"))
}

fn table(recording: &Recording, model: Option<&Model>, ids: &[&str]) -> Result<Table, String> {
    let name = &recording.name;
    let (plain, _) = run(&format!("{name} as it is"), recording, model)?;
    let before: Vec<String> = plain.effects.iter().map(words).collect();
    let mut rows = Vec::new();
    for id in ids {
        let mut row = vec![id.to_string(), cell(&plain, id, recording)];
        let mut named: Vec<Option<bool>> = Vec::new();
        for percent in STRENGTHS {
            let changed = with(recording, id, percent);
            let (d, _) = run(&format!("{name} + {percent} % {id}"), &changed, model)?;
            named.push(found(&d, id, recording).map(|(_, e)| e.confident));
            row.push(cell(&d, id, recording));
        }
        row.push(weakest(&named, |f| *f == Some(true)));
        row.push(weakest(&named, Option::is_some));
        rows.push(row);
    }
    let strengths = STRENGTHS.map(|s| format!("{s} %"));
    let mut head = vec!["effect".to_owned(), "0 %".to_owned()];
    head.extend(strengths);
    head.extend(["confident down to", "named down to"].map(String::from));
    Ok(Table {
        caption: format!(
            "Injected into {name}: rank, level and nats by strength (RMS of what is added, in % of the force's standard deviation), where its period or place is right too; – (…) is what stands first instead. Seed {SEED}. As it is: {}",
            if before.is_empty() {
                "nothing".to_owned()
            } else {
                before.join("; ")
            }
        ),
        head,
        rows,
    })
}

pub fn tables() -> Result<Vec<Table>, String> {
    let mut emps = load("emps/emps_tracking.csv")?;
    emps.effort.iter_mut().for_each(|f| *f -= EMPS_OFFSET);
    let model = Model {
        viscous: 1.0,
        ..Model::of_friction(emps.kind, FrictionModel::Coulomb { coulomb: 20.4 })
    };
    let tribometer = load("tribometer_reciprocating/reciprocating_5N.csv")?;
    let common = [
        "constant_force",
        "periodic_force",
        "local_friction_spot",
        "stribeck",
        "channel_delay",
    ];
    let inertial: Vec<&str> = common
        .into_iter()
        .chain(["encoder_error", "quadratic_drag"])
        .collect();
    Ok(vec![
        table(&emps, Some(&model), &inertial)?,
        table(&tribometer, None, &common)?,
    ])
}
