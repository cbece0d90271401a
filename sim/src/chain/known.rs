//! What a controller could know of the stage at best: the stage's own parameters, in the words of a model file.

use super::Trial;
use crate::stage::concealed::{Concealed, HALF_TRAVEL_M, Kind};
use preslide::Block;
use preslide_fit::effects::Effect;
use preslide_fit::friction::FrictionModel;
use preslide_fit::model::Model;
use preslide_fit::recording::MotionKind;
use preslide_host::paper;
use std::f64::consts::PI;

/// Cosines of a map.
const TERMS: usize = 16;
/// Points of a map's integral.
const POINTS: usize = 2000;

/// The stage's parameters as a model: the ten blocks that its hysteresis was calibrated to, with the gain of the day; the mass
/// with the rotor's, viscous friction; and the concealed effect with its true values. What it does not hold is how friction wanders.
///
/// # Errors
/// Where the stage or the catalogue refuses a value.
pub fn known(trial: &Trial) -> Result<Model, String> {
    let config = &trial.config;
    let stage = trial.stage(0).map_err(|e| e.to_string())?;
    let truth = Truth::of(&trial.effect, config.friction.stribeck_exponent);
    let gain = stage.friction().repeat_gain() * truth.gain;
    let blocks = paper::REFERENCE.blocks.iter();
    let friction = FrictionModel::Gms {
        breakaway: config.friction.breakaway_n * gain,
        blocks: blocks
            .map(|&(stiffness, weight)| Block {
                stiffness: stiffness * gain,
                weight,
            })
            .collect(),
        sliding: None,
    };
    let keys = truth.keys.iter();
    let keys: Vec<(&str, f64)> = keys.map(|(k, v)| (k.as_str(), *v)).collect();
    Ok(Model {
        // What the motor moves is the rotor, too.
        inertia: config.mass_kg + stage.reflected_rotor_kg(),
        viscous: config.friction.viscous_n_s_per_m,
        constant_force: truth.constant_force,
        effects: vec![Effect::new(trial.effect.id(), &keys)?],
        ..Model::of_friction(MotionKind::Linear, friction)
    })
}

/// A concealed effect as the catalogue has it, and what of it is the model's own.
struct Truth {
    /// Keys and values of the effect.
    keys: Vec<(String, f64)>,
    /// Factor on the friction (-).
    gain: f64,
    /// Force (N) that is the same everywhere.
    constant_force: f64,
}

impl Truth {
    fn of(effect: &Concealed, stribeck_exponent: f64) -> Self {
        let alone = |keys: &[(&str, f64)]| Self {
            keys: named(keys),
            gain: 1.0,
            constant_force: 0.0,
        };
        let &Concealed {
            kind,
            size,
            at,
            shape,
        } = effect;
        let wave = [("period_m", at), ("phase_rad", shape)];
        match kind {
            Kind::PeriodicForce => alone(&[("force_N", size), wave[0], wave[1]]),
            Kind::PeriodicFriction => alone(&[("level", size), wave[0], wave[1]]),
            Kind::LocalFrictionSpot => {
                alone(&[("level", size), ("position_m", at), ("width_m", shape)])
            }
            Kind::Stribeck => Self {
                // The catalogue's level is that above sliding friction, the stage's drop that below breakaway.
                gain: 1.0 - size,
                ..alone(&[
                    ("level", size / (1.0 - size)),
                    ("velocity_m_s", at),
                    ("exponent", stribeck_exponent),
                ])
            },
            Kind::PositionForce => {
                let (mean, shape) = cosines(|x| effect.force_n(x));
                Self {
                    keys: map(shape, "_N"),
                    constant_force: mean,
                    gain: 1.0,
                }
            }
            Kind::PositionFriction => {
                // The mean of a level is a matter of the friction.
                let (mean, shape) = cosines(|x| effect.level(x));
                Self {
                    keys: map(shape.map(|cosine| cosine / mean), ""),
                    gain: mean,
                    constant_force: 0.0,
                }
            }
        }
    }
}

fn named(values: &[(&str, f64)]) -> Vec<(String, f64)> {
    let own = |(key, value): &(&str, f64)| ((*key).to_owned(), *value);
    values.iter().map(own).collect()
}

/// The mean of `f` over the travel, and its coefficients of `cos(jπu)`, j = 1…[`TERMS`], for u = 0…1.
fn cosines(f: impl Fn(f64) -> f64) -> (f64, [f64; TERMS]) {
    let against = |j: f64| {
        let sum: f64 = (0..POINTS)
            .map(|i| {
                let u = (i as f64 + 0.5) / POINTS as f64;
                f(HALF_TRAVEL_M * (2.0 * u - 1.0)) * (PI * j * u).cos()
            })
            .sum();
        sum / POINTS as f64
    };
    let shape = std::array::from_fn(|j| 2.0 * against((j + 1) as f64));
    (against(0.0), shape)
}

/// The values of a map over the whole travel.
fn map(shape: [f64; TERMS], unit: &str) -> Vec<(String, f64)> {
    let mut values = named(&[("from_m", -HALF_TRAVEL_M), ("to_m", HALF_TRAVEL_M)]);
    let cosines = shape.iter().enumerate();
    values.extend(cosines.map(|(j, c)| (format!("cosine{}{unit}", j + 1), *c)));
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::concealed::KINDS;
    use preslide_fit::friction::Path;

    /// The catalogue's terms, with the values of the truth, give the resistance of the stage's own laws where it slides.
    #[test]
    fn the_stage_and_the_catalogue_mean_the_same() {
        for trial in Trial::draw(5, 2 * KINDS.len()) {
            let model = known(&trial).expect("the catalogue has it");
            let gain = trial.stage(0).expect("valid").friction().repeat_gain();
            for direction in [1.0, -1.0] {
                let (speed, pace) = (direction * 0.2e-3, direction * 1e-6);
                let position: Vec<f64> = (-1800..1800).map(|i| f64::from(i) * pace).collect();
                let (velocity, whole) = (vec![speed; position.len()], 0..position.len());
                let path = Path {
                    position: &position,
                    velocity: &velocity,
                    pieces: std::slice::from_ref(&whole),
                    sample_time: 5e-3,
                };
                let found = model.resistance(path).expect("computable");
                // The sixteen cosines of a map leave 0.02 N of the narrowest bump. Sliding begins after the longest yield displacement, twice over.
                for (x, found) in position.iter().zip(found).skip(100) {
                    let Concealed { kind, size, at, .. } = trial.effect;
                    let stribeck = match kind {
                        Kind::Stribeck => 1.0 - size * (1.0 - (-speed.abs() / at).exp()),
                        _ => 1.0,
                    };
                    let sliding = direction * 0.9 * gain * stribeck * trial.effect.level(*x);
                    let truth = sliding + trial.effect.force_n(*x) + 10.0 * speed;
                    assert!(
                        (found - truth).abs() < 0.02,
                        "{:?} at {x} m: {found} N, in truth {truth} N",
                        trial.effect
                    );
                }
            }
        }
    }
}
