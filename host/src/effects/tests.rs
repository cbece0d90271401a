//! Effects read, written and run, against closed forms.

use super::*;
use crate::friction::{FrictionModel, Path};
use crate::model::{Measured, Model};
use crate::recording::MotionKind;
use std::f64::consts::{PI, TAU};

/// Every effect of the catalogue, `constant_force` aside, which a model keeps on its own.
pub(crate) fn every() -> Vec<Effect> {
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
    ]
    .map(|(id, values)| Effect::new(id, values).expect(id))
    .to_vec()
}

/// The effect that only a rotary axis has.
fn gravity() -> Effect {
    Effect::new("gravity", &[("force_N", 3.31), ("angle_rad", 0.2)]).expect("gravity")
}

#[test]
fn gravity_holds_an_arm_by_the_sine_of_its_angle_and_no_linear_axis() {
    let arm = Model {
        motion: MotionKind::Rotary,
        ..model(vec![gravity()])
    };
    let position: Vec<f64> = (0..400).map(|i| f64::from(i) * 0.05 - 9.0).collect();
    let rest = vec![0.0; position.len()];
    let path = Path {
        position: &position,
        velocity: &rest,
        pieces: std::slice::from_ref(&(0..400)),
        sample_time: 1e-3,
    };
    let with = arm.resistance(path).expect("needs nothing more");
    let without = model(vec![]).resistance(path).expect("needs nothing more");
    for ((with, without), q) in with.iter().zip(&without).zip(&position) {
        let error = with - without - 3.31 * (q - 0.2).sin();
        assert!(error.abs() < 1e-5, "{error} N·m at {q} rad");
    }
    let text = arm.to_toml(&[]).replace("rotary", "linear");
    let text = text
        .replace("_Nm_s_per_rad", "_N_s_per_m")
        .replace("inertia_kg_m2", "mass_kg")
        .replace("_Nm", "_N");
    let error = Model::parse(&text).expect_err("linear");
    assert!(error.contains("constant_force"), "{error}");
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

#[test]
fn every_effect_is_read_back_as_it_was_written() {
    for motion in [MotionKind::Linear, MotionKind::Rotary] {
        let mut effects = every();
        if motion == MotionKind::Rotary {
            effects.push(gravity());
        }
        let model = Model {
            motion,
            ..model(effects)
        };
        let text = model.to_toml(&[]);
        assert_eq!(Model::parse(&text).as_ref(), Ok(&model), "{text}");
        if motion == MotionKind::Rotary {
            for key in [
                "drag_Nm_s2_per_rad2",
                "cosine3_Nm",
                "period_rad",
                "phase_rad",
                "angle_rad",
                "load_N",
                "stiffness_Nm_per_rad",
                "rate_rad_s",
            ] {
                assert!(
                    text.contains(&format!("\n{key} = ")),
                    "{key} is not in:\n{text}"
                );
            }
        }
    }
    let mut shuffled = every()[5].clone();
    shuffled.values.reverse();
    let given: Vec<_> = shuffled
        .values
        .iter()
        .map(|(k, v)| (k.as_str(), *v))
        .collect();
    assert_eq!(
        Effect::new("position_force", &given).as_ref(),
        Ok(&every()[5])
    );
}

#[test]
fn what_is_wrong_is_named_with_the_remedy() {
    let head = model(vec![]).to_toml(&[]);
    for (entry, parts) in [
        ("", &["effects[2].id", "missing"][..]),
        ("id = 3", &["effects[2].id", "string"]),
        (
            "id = \"warp\"",
            &["effects[2].id", "\"warp\"", "not known", "stribeck"],
        ),
        (
            "id = \"viscous\"",
            &["effects[2].id", "viscous_N_s_per_m", "[friction]"],
        ),
        ("id = \"lead_error\"", &["lead_error", "calibration"]),
        ("id = \"presliding_shape\"", &["more blocks"]),
        (
            "id = \"run_in\"\nlevel = 0.1",
            &["effects[2].path_m", "missing", "level, path_m"],
        ),
        (
            "id = \"run_in\"\nlevel = 0.1\npath_m = 1.0\nspeed = 2",
            &["effects[2].speed", "unknown key", "level, path_m"],
        ),
        (
            "id = \"run_in\"\nlevel = \"much\"\npath_m = 1.0",
            &["effects[2].level", "number"],
        ),
        (
            "id = \"run_in\"\nlevel = nan\npath_m = 1.0",
            &["effects[2].level", "NaN"],
        ),
        (
            "id = \"run_in\"\nlevel = 0.1\npath_m = 0",
            &["effects[2].path_m", "0 must be above zero"],
        ),
        (
            "id = \"stribeck\"\nlevel = 0.1\nvelocity_m_s = 1e-3\nexponent = 9.0",
            &["effects[2].exponent", "1 to 4"],
        ),
        (
            "id = \"coulomb_asymmetry\"\nasymmetry = -1.5",
            &["effects[2].asymmetry", "±1"],
        ),
        (
            "id = \"thermal_drift\"\nlevel = 0.1\ntemperature_C = 20.0",
            &[
                "effects[2].level",
                "unknown key",
                "level_per_K",
                "time_constant_s",
            ],
        ),
        (
            "id = \"position_force\"\nfrom_m = 0\nto_m = 1\ncosine1_N = 1\ncosine3_N = 1",
            &["effects[2].cosine2_N", "missing", "gap"],
        ),
        (
            "id = \"position_force\"\nfrom_m = 0\nto_m = 1",
            &["effects[2].cosine1_N", "missing"],
        ),
        (
            "id = \"position_force\"\nfrom_m = 0\nto_m = 1\ncosine1 = 1",
            &["effects[2].cosine1", "unknown key", "cosine1_N"],
        ),
        (
            "id = \"position_friction\"\nfrom_m = 1\nto_m = 1\ncosine1 = 0.1",
            &["effects[2].to_m", "above from_m"],
        ),
        (
            "id = \"encoder_error\"\nerror_m = 1.0\nperiod_m = 1e-5\nphase_rad = 0",
            &["effects[2].", "encoder_error", "encoder error"],
        ),
    ] {
        let error = Model::parse(&format!("{head}\n[[effects]]\n{entry}\n")).expect_err(entry);
        for part in parts {
            assert!(error.contains(part), "`{part}` is not in:\n{error}");
        }
    }
    let rotary = head
        .replace("linear", "rotary")
        .replace("mass_kg", "inertia_kg_m2")
        .replace("_N_s_per_m", "_Nm_s_per_rad")
        .replace("_N ", "_Nm ");
    let error = Model::parse(&format!(
        "{rotary}\n[[effects]]\nid = \"periodic_force\"\nforce_Nm = 1.0\n"
    ))
    .expect_err("incomplete");
    assert!(
        error.contains("effects[2].period_rad: missing")
            && error.contains("force_Nm, period_rad, phase_rad"),
        "{error}"
    );
    let many: Vec<_> = (1..=MOST_TERMS + 1).map(|j| format!("cosine{j}")).collect();
    let mut values: Vec<_> = many.iter().map(|key| (key.as_str(), 0.1)).collect();
    values.extend([("from_m", 0.0), ("to_m", 1.0)]);
    assert!(
        Effect::new("position_friction", &values)
            .expect_err("too many")
            .contains("at most 16")
    );
    assert!(
        Effect::new("run_in", &[("level", 0.1), ("level", 0.1), ("path_m", 1.0)])
            .expect_err("twice")
            .contains("twice")
    );
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

#[test]
fn effects_along_a_recording_are_their_formulas() {
    let [t, x, v, a] = sine();
    let coulomb = FrictionModel::Coulomb { coulomb: 0.8 };
    let friction = |i: usize| 0.8 * v[i].signum();
    let rest = |i: usize| 2.0 * a[i] + 3.0 * v[i] + 0.05;
    let exp = |i: usize, d: f64| (-(v[i].abs() / 5e-3).powf(d)).exp();
    let map = |i: usize, terms: &[f64]| -> f64 {
        let u = ((x[i] + 0.01) / 0.03).clamp(0.0, 1.0);
        (1..)
            .zip(terms)
            .map(|(j, c)| c * (f64::from(j) * PI * u).cos())
            .sum()
    };
    let every = every();
    let pick = |n: usize| along(vec![every[n].clone()], coulomb.clone());
    let near = |n: usize, tolerance: f64, wanted: &dyn Fn(usize) -> f64| {
        let off = difference(&pick(n), 0, |i| wanted(i) + rest(i));
        eprintln!("{}: {off:.1e} N", every[n].id);
        assert!(off < tolerance, "{}: {off:e}", every[n].id);
    };
    let plain = difference(&along(vec![], coulomb.clone()), 0, |i| {
        friction(i) + rest(i)
    });
    assert!(plain < 1e-12, "{plain:e}");
    near(0, 1e-12, &|i| friction(i) * (1.0 + 0.1 * v[i].signum()));
    near(1, 1e-12, &|i| friction(i) + 40.0 * v[i] * v[i].abs());
    near(2, 3e-4, &|i| friction(i) * (1.0 + 0.3 * exp(i, 2.0)));
    near(4, 1e-12, &|i| friction(i) + 12.0 * (x[i] - 1.0 / 3.0));
    near(5, 1e-6, &|i| friction(i) + map(i, &[0.1, 0.0, -0.05]));
    near(6, 1e-6, &|i| friction(i) * (1.0 + map(i, &[0.1, 0.05])));
    near(7, 4e-4, &|i| {
        friction(i) * (1.0 + 0.5 * (-((x[i] - 4e-3) / 1e-3).powi(2)).exp())
    });
    near(8, 1e-6, &|i| {
        friction(i) + 0.05 * (TAU * x[i] / 1.3e-3 + 0.4).cos()
    });
    near(9, 1e-6, &|i| {
        friction(i) * (1.0 + 0.1 * (TAU * x[i] / 2e-3 - 1.0).cos())
    });
    near(11, 1e-6, &|i| {
        friction(i) + 0.1 * (TAU * 17.0 * t[i] + 0.3).sin()
    });
    near(15, 1e-12, &|i| friction(i) * (1.0 - 0.02 * t[i]));
    near(16, 1e-3, &|i| {
        friction(i) * (1.0 + 0.2 * (-t[i] / 1.5).exp())
    });
    near(19, 1e-12, &|i| friction(i) * (1.0 + 0.02 * t[i]));
    near(21, 1e-12, &|i| {
        (friction(i) + rest(i)).clamp(-0.7, 0.7) - rest(i)
    });
    near(20, 1e-12, &|i| {
        friction(i) + 0.1 * (friction(i) + rest(i)).signum()
    });
    // The encoder's error comes back out: to first order in 2πe/p = 0.13.
    let k = TAU / 1e-4;
    near(10, 2e-2, &|i| {
        let angle = k * x[i] + 0.7;
        let slope = 1.0 + 2e-6 * k * angle.sin();
        friction(i)
            + 2.0 * (a[i] * (slope - 1.0) + 2e-6 * k * k * angle.cos() * v[i] * v[i])
            + 3.0 * v[i] * (slope - 1.0)
    });
    let path = |i: usize| (0..=i).map(|n| v[n].abs() * STEP).sum::<f64>();
    let off = (0..4000).step_by(37).map(|i| {
        let wanted = friction(i) * (1.0 + 0.2 * (-path(i) / 0.05).exp()) + rest(i);
        (pick(17)[i] - wanted).abs()
    });
    assert!(off.fold(0.0, f64::max) < 1e-3);
    // All levels at once: m = 1 + Σ(m_i − 1), and forces beside them.
    let all = along(
        [0, 6, 9, 8, 4].map(|n| every[n].clone()).to_vec(),
        coulomb.clone(),
    );
    let off = difference(&all, 0, |i| {
        let m = 1.0
            + 0.1 * v[i].signum()
            + map(i, &[0.1, 0.05])
            + 0.1 * (TAU * x[i] / 2e-3 - 1.0).cos();
        m * friction(i)
            + 0.05 * (TAU * x[i] / 1.3e-3 + 0.4).cos()
            + 12.0 * (x[i] - 1.0 / 3.0)
            + rest(i)
    });
    assert!(off < 2e-6, "{off:e}");
    // A level is not below 0.
    let none = Effect::new(
        "position_friction",
        &[("from_m", -1.0), ("to_m", 9.0), ("cosine1", -5.0)],
    )
    .expect("valid");
    assert!(difference(&along(vec![none], coulomb), 0, rest) < 1e-12);
}

/// The history of effects with memory, integrated anew.
#[test]
fn effects_with_memory_follow_their_laws() {
    let [t, _, v, a] = sine();
    let coulomb = FrictionModel::Coulomb { coulomb: 0.8 };
    let every = every();
    let rest = |i: usize| 2.0 * a[i] + 3.0 * v[i] + 0.05;
    let (mut lag, mut age) = (vec![0.0; 4000], vec![0.0; 4000]);
    let (mut level, mut theta) = (0.2, 0.0);
    for i in 0..4000 {
        if i == 2000 {
            // The gap: at rest.
            theta += t[i] - t[i - 1] - STEP;
            level = 0.2 + (level - 0.2) * (-(t[i] - t[i - 1] - STEP) / 0.02_f64).exp();
        }
        let now = 0.2 * (-v[i].abs() / 5e-3).exp();
        level = now + (level - now) * (-STEP / 0.02_f64).exp();
        lag[i] = level;
        let rate = v[i].abs() / 1e-4;
        theta = if rate > 1e-9 {
            1.0 / rate + (theta - 1.0 / rate) * (-rate * STEP).exp()
        } else {
            theta + STEP
        };
        age[i] = 0.05 * (1.0 + theta / 0.1).log10();
    }
    for (n, tolerance, levels) in [(3, 1e-3, lag), (18, 4e-3, age)] {
        let found = along(vec![every[n].clone()], coulomb.clone());
        let off = difference(&found, 0, |i| {
            0.8 * v[i].signum() * (1.0 + levels[i]) + rest(i)
        });
        eprintln!("{}: {off:.1e} N", every[n].id);
        assert!(off < tolerance, "{}: {off:e}", every[n].id);
    }
}

/// What only the host can do.
#[test]
fn mechanics_and_channels() {
    let [t, x, v, a] = sine();
    let every = every();
    let rest = |i: usize| 2.0 * a[i] + 3.0 * v[i] + 0.05;
    let w = TAU * 0.9;
    // A spring instead of friction: everything is smooth and linear.
    let spring = FrictionModel::maxwell_slip(&[100.0], &[1.0]);
    let force = |t: f64, x0: f64| {
        let (sin, cos) = (w * t).sin_cos();
        100.0 * (0.005 + 0.01 * sin - x0) - 0.02 * w * w * sin + 0.03 * w * cos + 0.05
    };
    // The second piece goes on from the deflection of the first: its displacement starts anew.
    let origin = |i: usize| {
        if i < 2000 {
            x[0]
        } else {
            x[0] + x[2000] - x[1999]
        }
    };
    let plain = along(vec![], spring.clone());
    let off = difference(&plain, 0, |i| force(t[i], origin(i)));
    assert!(off < 1e-9, "{off:e}");

    let late = along(vec![every[12].clone()], spring.clone());
    let off = difference(&late, 4, |i| force(t[i] - 2.5e-3, origin(i)));
    assert!(off < 1e-4, "delay {off:e}");
    assert!(difference(&late, 4, |i| force(t[i], origin(i))) > 3e-3);

    // Behind a spring k = ω²·M/4 the load is at x − F_t/k, F_t = M/2·a + F; in a sine that scales the motion of load and
    // spring: F falls by 100 N/m·(F_t − F_t(0))/k, and −F_t''·(M/2)/k = 2·(w/ω)²·(F_t − mean) is added.
    let soft = along(vec![every[13].clone()], spring);
    let omega = TAU * 60.0;
    let k = omega * omega * 0.5;
    let off = difference(&soft, 7, |i| {
        let transmitted = |i: usize| a[i] + 100.0 * (x[i] - origin(i));
        let mean = 100.0 * (0.005 - origin(i));
        let start = if i < 2000 {
            0.0
        } else {
            transmitted(1999) - transmitted(2000)
        };
        let first = a[0];
        let sprung = 2.0 * (w / omega).powi(2) * (transmitted(i) - mean);
        force(t[i], origin(i)) - 100.0 * (transmitted(i) + start - first) / k + sprung
    });
    assert!(off < 1e-4, "compliance {off:e}");

    // A play of 0.1 mm: after each turn friction is used up at once, and nothing is transmitted for that distance.
    let stop = FrictionModel::maxwell_slip(&[1e6], &[8e-7]);
    let play = along(vec![every[14].clone()], stop.clone());
    let mut crossed = Vec::new();
    for i in 1..4000 {
        if i % 2000 != 0 && v[i].signum() != v[i - 1].signum() {
            let idle: Vec<usize> = (i..i + 200)
                .filter(|&n| n / 2000 == i / 2000 && (play[n] - rest(n)).abs() < 1e-3)
                .collect();
            if let (Some(from), Some(to)) = (idle.first(), idle.last()) {
                crossed.push((x[*from] - x[*to]).abs());
            }
        }
    }
    assert!(crossed.len() >= 5, "{crossed:?}");
    for gap in crossed {
        assert!((0.7e-4..1.02e-4).contains(&gap), "{gap:e}");
    }
    // Without friction left over: the same force as without a play, away from the turns.
    let bare = along(vec![], stop);
    assert!(difference(&play, 100, |i| bare[i]) < 1e-9);

    // Held under load, a block of stiffness k relaxes by dF/dt = −k·rate·sinh(F/F_limit):
    // tanh(F/(2·F_limit)) falls exponentially with F_limit/(k·rate) = 0.8 s.
    let model = Model {
        inertia: 0.0,
        viscous: 0.0,
        constant_force: 0.0,
        ..model(vec![every[22].clone()])
    };
    let model = Model {
        friction: FrictionModel::maxwell_slip(&[1e3], &[8e-4]),
        ..model
    };
    let position: Vec<f64> = (0..2000).map(|i| if i == 0 { 0.0 } else { 4e-4 }).collect();
    let path = Path {
        position: &position,
        velocity: &vec![0.0; 2000],
        pieces: std::slice::from_ref(&(0..2000)),
        sample_time: STEP,
    };
    let force = model.resistance(path).expect("bounded");
    for (i, f) in force.iter().enumerate().skip(1) {
        let share = (0.25_f64).tanh() * (-(i as f64 - 1.0) * STEP / 0.8).exp();
        let wanted = 2.0 * 0.8 * share.atanh();
        assert!((f - wanted).abs() < 1e-3, "{i}: {f} {wanted}");
    }
    let lugre = FrictionModel::LuGre {
        stiffness: 1e5,
        damping: 300.0,
        breakaway: 0.9,
        sliding: preslide::Sliding::none(0.9),
    };
    let error = Model {
        friction: lugre,
        ..model
    }
    .resistance(path)
    .expect_err("unbounded");
    assert!(error.contains("creep"), "{error}");
}

/// What a recording does not hold is said, not left out.
#[test]
fn a_missing_column_is_an_error() {
    let [_, x, v, _] = sine();
    let path = Path {
        position: &x,
        velocity: &v,
        pieces: &[0..2000, 2000..4000],
        sample_time: STEP,
    };
    for (n, column) in [(15, "temperature_C"), (19, "load_N")] {
        let error = model(vec![every()[n].clone()])
            .resistance(path)
            .expect_err(column);
        assert!(error.contains(column) && error.contains("--map"), "{error}");
    }
    assert!(model(vec![every()[16].clone()]).resistance(path).is_ok());
    // A vibration that the samples cannot show.
    let fast = Effect::new(
        "external_vibration",
        &[
            ("force_N", 0.1),
            ("frequency_Hz", 900.0),
            ("phase_rad", 0.0),
        ],
    )
    .expect("valid");
    let error = model(vec![fast]).resistance(path).expect_err("aliased");
    assert!(
        error.contains("external_vibration") && error.contains("500"),
        "{error}"
    );
}
