//! Effects of every kind, and what their tests share.

mod along;
mod file;
mod mechanics;

use super::*;
use crate::friction::{FrictionModel, Path};
use crate::model::{Measured, Model, Now, Stepper};
use crate::recording::MotionKind;
use std::f64::consts::TAU;

/// Every effect of the catalogue, `constant_force` aside, which a model keeps on its own.
pub(super) fn every() -> Vec<Effect> {
    [
        ("coulomb_asymmetry", &[("asymmetry", 0.1)][..]),
        ("quadratic_drag", &[("drag_N_s2_per_m2", 40.0)]),
        (
            "stribeck",
            &[("level", 0.3), ("velocity_m_s", 5e-3), ("exponent", 2.0)],
        ),
        (
            "frictional_lag",
            &[
                ("level", 0.2),
                ("velocity_m_s", 5e-3),
                ("exponent", 1.0),
                ("time_constant_s", 0.02),
            ],
        ),
        (
            "position_spring",
            &[("stiffness_N_per_m", 12.0), ("centre_m", 1.0 / 3.0)],
        ),
        (
            "position_force",
            &[
                ("from_m", -0.01),
                ("to_m", 0.02),
                ("cosine1_N", 0.1),
                ("cosine2_N", 0.0),
                ("cosine3_N", -0.05),
            ],
        ),
        (
            "position_friction",
            &[
                ("from_m", -0.01),
                ("to_m", 0.02),
                ("cosine1", 0.1),
                ("cosine2", 0.05),
            ],
        ),
        (
            "local_friction_spot",
            &[("level", 0.5), ("position_m", 4e-3), ("width_m", 1e-3)],
        ),
        (
            "periodic_force",
            &[("force_N", 0.05), ("period_m", 1.3e-3), ("phase_rad", 0.4)],
        ),
        (
            "periodic_friction",
            &[("level", 0.1), ("period_m", 2e-3), ("phase_rad", -1.0)],
        ),
        (
            "encoder_error",
            &[("error_m", 2e-6), ("period_m", 1e-4), ("phase_rad", 0.7)],
        ),
        (
            "external_vibration",
            &[("force_N", 0.1), ("frequency_Hz", 17.0), ("phase_rad", 0.3)],
        ),
        ("channel_delay", &[("delay_s", 2.5e-3)]),
        ("drive_compliance", &[("frequency_Hz", 60.0)]),
        ("backlash", &[("gap_m", 1e-4)]),
        (
            "thermal_drift",
            &[("level_per_K", -0.02), ("temperature_C", 20.0)],
        ),
        ("thermal_drift", &[("level", 0.2), ("time_constant_s", 1.5)]),
        ("run_in", &[("level", 0.2), ("path_m", 0.05)]),
        (
            "dwell_aging",
            &[
                ("level_per_decade", 0.05),
                ("time_constant_s", 0.1),
                ("erasing_path_m", 1e-4),
            ],
        ),
        (
            "load_dependent_friction",
            &[("level_per_N", 0.01), ("load_N", 30.0)],
        ),
        ("actuator_dead_zone", &[("width_N", 0.2)]),
        ("actuator_saturation", &[("limit_N", 0.7)]),
        ("creep", &[("rate_m_s", 1e-3), ("share_of_breakaway", 1.0)]),
        (
            "load_dependent_friction",
            &[("share_of_transmitted", 0.3), ("motor_mass_kg", 0.4)],
        ),
        ("viscous_asymmetry", &[("half_difference_N_s_per_m", 6.0)]),
        (
            "torque_ripple",
            &[("share", 0.1), ("period_m", 1.7e-3), ("phase_rad", 0.6)],
        ),
    ]
    .map(|(id, values)| Effect::new(id, values).expect(id))
    .to_vec()
}

/// The effect that only a rotary axis has.
pub(super) fn gravity() -> Effect {
    Effect::new("gravity", &[("force_N", 3.31), ("angle_rad", 0.2)]).expect("gravity")
}

fn model(effects: Vec<Effect>) -> Model {
    Model {
        motion: MotionKind::Linear,
        inertia: 2.0,
        viscous: 3.0,
        friction: FrictionModel::Coulomb { coulomb: 0.8 },
        constant_force: 0.05,
        effects,
        mechanics: Vec::new(),
    }
}

const STEP: f64 = 1e-3;

/// 10 mm back and forth, two runs of 2 s with a gap of a second between them: time, position, velocity, acceleration.
fn sine() -> [Vec<f64>; 4] {
    let t: Vec<f64> = (0..4000)
        .map(|i| f64::from(i) * STEP + if i < 2000 { 0.0 } else { 1.0 })
        .collect();
    let w = TAU * 0.9;
    let of = |f: &dyn Fn(f64) -> f64| t.iter().map(|t| f(*t)).collect();
    let x = of(&|t| 0.005 + 0.01 * (w * t).sin());
    let v = of(&|t| 0.01 * w * (w * t).cos());
    let a = of(&|t| -0.01 * w * w * (w * t).sin());
    [t, x, v, a]
}

/// The force of a model with one effect along [`sine`], acceleration, temperature and load recorded.
fn along(effects: Vec<Effect>, friction: FrictionModel) -> Vec<f64> {
    let [t, x, v, a] = sine();
    let path = Path {
        position: &x,
        velocity: &v,
        pieces: &[0..2000, 2000..4000],
        sample_time: STEP,
    };
    let temperature: Vec<f64> = t.iter().map(|t| 20.0 + t).collect();
    let load: Vec<f64> = t.iter().map(|t| 30.0 + 2.0 * t).collect();
    let measured = Measured {
        t_s: Some(&t),
        acceleration: Some(&a),
        temperature_c: Some(&temperature),
        load_n: Some(&load),
    };
    let model = Model {
        friction,
        ..model(effects)
    };
    model
        .force_along(path, &measured)
        .expect("all that effects need")
}

/// Largest difference, leaving out what is within `margin` samples of an end of a piece or of a sign change of the velocity.
fn difference(found: &[f64], margin: usize, wanted: impl Fn(usize) -> f64) -> f64 {
    let [_, _, v, _] = sine();
    let near_a_turn = |i: usize| {
        let (from, to) = (i.saturating_sub(margin), (i + margin).min(v.len() - 1));
        v[from].signum() != v[to].signum() || i % 2000 < margin || i % 2000 >= 2000 - margin
    };
    (0..v.len())
        .filter(|&i| margin == 0 || !near_a_turn(i))
        .map(|i| (found[i] - wanted(i)).abs())
        .fold(0.0, f64::max)
}
