//! What a controller could know of the stage at best: the stage's own parameters, in the words of a model file.

use super::Trial;
use crate::effects::Effect;
use crate::friction::FrictionModel;
use crate::model::Model;
use crate::recording::MotionKind;
use crate::reproduce::paper;
use crate::stage::FrictionConfig;
use crate::stage::concealed::{Concealed, HALF_TRAVEL_M};
use preslide::Block;
use std::f64::consts::PI;

/// Cosines of a map.
const TERMS: usize = 16;
/// Points of a map's integral.
const POINTS: usize = 2000;

/// The stage's parameters as a model: the ten blocks that its hysteresis was calibrated to, with the gain of the day; mass and
/// viscous friction; and the concealed effect with its true values. What it does not hold is how friction wanders.
///
/// # Errors
/// Where the stage or the catalogue refuses a value.
pub fn known(trial: &Trial) -> Result<Model, String> {
    let (effect, config) = (&trial.effect, &trial.config);
    let FrictionConfig {
        breakaway_n,
        viscous_n_s_per_m,
        ..
    } = config.friction;
    let stage = trial.stage().map_err(|e| e.to_string())?;
    let mut gain = stage.friction().repeat_gain();
    let mut model = Model {
        motion: MotionKind::Linear,
        inertia: config.mass_kg,
        viscous: viscous_n_s_per_m,
        friction: FrictionModel::Gms {
            breakaway: breakaway_n,
            blocks: paper::REFERENCE
                .blocks
                .iter()
                .map(|&(stiffness, weight)| Block { stiffness, weight })
                .collect(),
            sliding: None,
        },
        constant_force: 0.0,
        effects: Vec::new(),
        mechanics: Vec::new(),
    };
    let mut values = match *effect {
        Concealed::PeriodicForce {
            force_n,
            period_m,
            phase_rad,
        } => vec![
            ("force_N", force_n),
            ("period_m", period_m),
            ("phase_rad", phase_rad),
        ],
        Concealed::LocalFrictionSpot {
            level,
            position_m,
            width_m,
        } => vec![
            ("level", level),
            ("position_m", position_m),
            ("width_m", width_m),
        ],
        Concealed::PeriodicFriction {
            level,
            period_m,
            phase_rad,
        } => vec![
            ("level", level),
            ("period_m", period_m),
            ("phase_rad", phase_rad),
        ],
        Concealed::Stribeck { drop, velocity_m_s } => {
            // The catalogue's level is that above sliding friction, the stage's drop that below breakaway.
            gain *= 1.0 - drop;
            vec![
                ("level", drop / (1.0 - drop)),
                ("velocity_m_s", velocity_m_s),
                ("exponent", config.friction.stribeck_exponent),
            ]
        }
        Concealed::PositionForce { .. } | Concealed::PositionFriction { .. } => {
            vec![("from_m", -HALF_TRAVEL_M), ("to_m", HALF_TRAVEL_M)]
        }
    };
    let (map, unit, mean): (Box<dyn Fn(f64) -> f64>, _, _) = match effect {
        Concealed::PositionForce { .. } => (Box::new(|x| effect.force_n(x)), "_N", 0.0),
        Concealed::PositionFriction { .. } => (Box::new(|x| effect.level(x)), "", 1.0),
        _ => (Box::new(|_| 0.0), "", 0.0),
    };
    let cosines = cosines(map);
    let keys: Vec<String> = (1..=TERMS).map(|j| format!("cosine{j}{unit}")).collect();
    if values.iter().any(|(key, _)| *key == "from_m") {
        // The mean of a level is a matter of the friction, that of a force one of its own.
        let level = if mean == 0.0 { 1.0 } else { cosines[0] };
        values.extend(
            keys.iter()
                .zip(&cosines[1..])
                .map(|(key, c)| (key.as_str(), c / level)),
        );
        if mean == 0.0 {
            model.constant_force = cosines[0];
        } else {
            gain *= level;
        }
    }
    if let FrictionModel::Gms {
        breakaway, blocks, ..
    } = &mut model.friction
    {
        *breakaway *= gain;
        for block in blocks {
            block.stiffness *= gain;
        }
    }
    model.effects = vec![Effect::new(effect.id(), &values)?];
    Ok(model)
}

/// Coefficients of `f` over the travel: the mean, then `cos(jπu)` for u = 0…1.
fn cosines(f: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..=TERMS)
        .map(|j| {
            let sum: f64 = (0..POINTS)
                .map(|i| {
                    let u = (i as f64 + 0.5) / POINTS as f64;
                    f(HALF_TRAVEL_M * (2.0 * u - 1.0)) * (PI * j as f64 * u).cos()
                })
                .sum();
            sum / POINTS as f64 * if j == 0 { 1.0 } else { 2.0 }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::Path;
    use crate::stage::concealed::KINDS;

    /// The catalogue's terms, with the values of the truth, give the resistance of the stage's own laws where it slides.
    #[test]
    fn the_stage_and_the_catalogue_mean_the_same() {
        for trial in Trial::draw(5, 2 * KINDS) {
            let model = known(&trial).expect("the catalogue has it");
            let gain = trial.stage().expect("valid").friction().repeat_gain();
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
                    let stribeck = match trial.effect {
                        Concealed::Stribeck { drop, velocity_m_s } => {
                            1.0 - drop * (1.0 - (-speed.abs() / velocity_m_s).exp())
                        }
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
