//! Effects along a recording, against closed forms and laws integrated anew.

use super::*;
use preslide_host_tests::refusal::refuses;
use std::f64::consts::PI;

#[test]
fn gravity_holds_an_arm_by_the_sine_of_its_angle_and_no_linear_axis() {
    let arm = Model {
        motion: MotionKind::Rotary,
        ..model(vec![example(&form::GRAVITY)])
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
    let pick = |form| along(vec![example(form)], coulomb.clone());
    let near = |form: &'static Form, tolerance: f64, wanted: &dyn Fn(usize) -> f64| {
        let off = difference(&pick(form), 0, |i| wanted(i) + rest(i));
        eprintln!("{form:?}: {off:.1e} N");
        assert!(off < tolerance, "{form:?}: {off:e}");
    };
    let plain = difference(&along(vec![], coulomb.clone()), 0, |i| {
        friction(i) + rest(i)
    });
    assert!(plain < 1e-12, "{plain:e}");
    near(&form::COULOMB_ASYMMETRY, 1e-12, &|i| {
        friction(i) * (1.0 + 0.1 * v[i].signum())
    });
    near(&form::QUADRATIC_DRAG, 1e-12, &|i| {
        friction(i) + 40.0 * v[i] * v[i].abs()
    });
    near(&form::VISCOUS_ASYMMETRY, 1e-12, &|i| {
        friction(i) + 6.0 * v[i].abs()
    });
    near(&form::TRANSMITTED_FRICTION, 1e-12, &|i| {
        friction(i) * (1.0 + 0.3 * (1.6 * a[i] + 0.05).abs() / 0.8)
    });
    near(&form::STRIBECK, 3e-4, &|i| {
        friction(i) * (1.0 + 0.3 * exp(i, 2.0))
    });
    near(&form::POSITION_SPRING, 1e-12, &|i| {
        friction(i) + 12.0 * (x[i] - 1.0 / 3.0)
    });
    near(&form::POSITION_FORCE, 1e-6, &|i| {
        friction(i) + map(i, &[0.1, 0.0, -0.05])
    });
    near(&form::POSITION_FRICTION, 1e-6, &|i| {
        friction(i) * (1.0 + map(i, &[0.1, 0.05]))
    });
    near(&form::LOCAL_FRICTION_SPOT, 4e-4, &|i| {
        friction(i) * (1.0 + 0.5 * (-((x[i] - 4e-3) / 1e-3).powi(2)).exp())
    });
    near(&form::PERIODIC_FORCE, 1e-6, &|i| {
        friction(i) + 0.05 * (TAU * x[i] / 1.3e-3 + 0.4).cos()
    });
    near(&form::PERIODIC_FRICTION, 1e-6, &|i| {
        friction(i) * (1.0 + 0.1 * (TAU * x[i] / 2e-3 - 1.0).cos())
    });
    near(&form::EXTERNAL_VIBRATION, 1e-6, &|i| {
        friction(i) + 0.1 * (TAU * 17.0 * t[i] + 0.3).sin()
    });
    near(&form::THERMAL_DRIFT, 1e-12, &|i| {
        friction(i) * (1.0 - 0.02 * t[i])
    });
    near(&form::WARM_UP, 1e-3, &|i| {
        friction(i) * (1.0 + 0.2 * (-t[i] / 1.5).exp())
    });
    near(&form::LOAD_DEPENDENT_FRICTION, 1e-12, &|i| {
        friction(i) * (1.0 + 0.02 * t[i])
    });
    near(&form::ACTUATOR_SATURATION, 1e-12, &|i| {
        (friction(i) + rest(i)).clamp(-0.7, 0.7) - rest(i)
    });
    near(&form::ACTUATOR_DEAD_ZONE, 1e-12, &|i| {
        friction(i) + 0.1 * (friction(i) + rest(i)).signum()
    });
    // The encoder's error comes back out: to first order in 2πe/p = 0.13.
    let k = TAU / 1e-4;
    near(&form::ENCODER_ERROR, 2e-2, &|i| {
        let angle = k * x[i] + 0.7;
        let slope = 1.0 + 2e-6 * k * angle.sin();
        friction(i)
            + 2.0 * (a[i] * (slope - 1.0) + 2e-6 * k * k * angle.cos() * v[i] * v[i])
            + 3.0 * v[i] * (slope - 1.0)
    });
    let path = |i: usize| (0..=i).map(|n| v[n].abs() * STEP).sum::<f64>();
    let off = (0..4000).step_by(37).map(|i| {
        let wanted = friction(i) * (1.0 + 0.2 * (-path(i) / 0.05).exp()) + rest(i);
        (pick(&form::RUN_IN)[i] - wanted).abs()
    });
    assert!(off.fold(0.0, f64::max) < 1e-3);
    // All levels at once: m = 1 + Σ(m_i − 1), and forces beside them.
    let all = along(
        [
            &form::COULOMB_ASYMMETRY,
            &form::POSITION_FRICTION,
            &form::PERIODIC_FRICTION,
            &form::PERIODIC_FORCE,
            &form::POSITION_SPRING,
        ]
        .map(example)
        .to_vec(),
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
    for (form, tolerance, levels) in [
        (&form::FRICTIONAL_LAG, 1e-3, lag),
        (&form::DWELL_AGING, 4e-3, age),
    ] {
        let found = along(vec![example(form)], coulomb.clone());
        let off = difference(&found, 0, |i| {
            0.8 * v[i].signum() * (1.0 + levels[i]) + rest(i)
        });
        eprintln!("{form:?}: {off:.1e} N");
        assert!(off < tolerance, "{form:?}: {off:e}");
    }
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
    for (form, column) in [
        (&form::THERMAL_DRIFT, "temperature_C"),
        (&form::LOAD_DEPENDENT_FRICTION, "load_N"),
    ] {
        refuses(
            model(vec![example(form)]).resistance(path),
            &[column, "--map"],
        );
    }
    assert!(
        model(vec![example(&form::WARM_UP)])
            .resistance(path)
            .is_ok()
    );
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
    refuses(
        model(vec![fast]).resistance(path),
        &["external_vibration", "500"],
    );
}

/// Every effect with every law that it goes with, one tick after the other: the bits of the whole path.
#[test]
fn a_stepper_has_the_bits_of_the_path() {
    let [_, x, v, a] = sine();
    let (x, v, a) = (&x[..2000], &v[..2000], &a[..2000]);
    let column = |from: f64, per: f64| -> Vec<f64> {
        (0..2000)
            .map(|i| from + per * f64::from(i) * STEP)
            .collect()
    };
    let (temperature, load) = (column(20.0, 1.0), column(30.0, 2.0));
    let path = Path {
        position: x,
        velocity: v,
        pieces: std::slice::from_ref(&(0..2000)),
        sample_time: STEP,
    };
    let measured = Measured {
        t_s: None,
        acceleration: Some(a),
        temperature_c: Some(&temperature),
        load_n: Some(&load),
    };
    let laws = [
        FrictionModel::Coulomb { coulomb: 0.8 },
        FrictionModel::maxwell_slip(&[3e3, 1e3], &[1e-4, 5e-4]),
        FrictionModel::LuGre {
            stiffness: 2e4,
            damping: 1.0,
            breakaway: 1.0,
            sliding: preslide::Sliding {
                coulomb: 0.8,
                stribeck_velocity: 5e-3,
                stribeck_exponent: 2.0,
                attraction: 10.0,
            },
        },
    ];
    let (mut same, mut refused) = (0, Vec::new());
    for effect in every() {
        for friction in &laws {
            let model = Model {
                friction: friction.clone(),
                ..model(vec![effect.clone()])
            };
            let mut stepper = match Stepper::of(&model, STEP) {
                Ok(stepper) => stepper,
                Err(reason) => {
                    // What one refuses of the parameters the other does, too: creep of a law without a highest force.
                    let is_refused = model.force_along(path, &measured).is_err();
                    assert_eq!(is_refused, reason.contains("creep"), "{reason}");
                    refused.push(reason);
                    continue;
                }
            };
            let whole = model
                .force_along(path, &measured)
                .expect("all that effects need");
            for i in 0..x.len() {
                let now = Now {
                    position: x[i],
                    velocity: Some(v[i]),
                    acceleration: Some(a[i]),
                    temperature_c: Some(temperature[i]),
                    load_n: Some(load[i]),
                };
                let force = stepper.step(&now).expect("all that effects need");
                assert_eq!(
                    force.to_bits(),
                    whole[i].to_bits(),
                    "{}, {}, sample {i}: {force} and {}",
                    effect.id(),
                    friction.name(),
                    whole[i]
                );
            }
            same += 1;
        }
    }
    assert_eq!(
        (same, refused.len()),
        (3 * (every().len() - 2) - 1, 7),
        "{refused:?}"
    );
    assert!(
        refused
            .iter()
            .all(|r| ["drive_compliance", "channel_delay", "creep"]
                .iter()
                .any(|id| r.contains(id))),
        "{refused:?}"
    );
    let mut cold =
        Stepper::of(&model(vec![example(&form::THERMAL_DRIFT)]), STEP).expect("a stepper");
    refuses(cold.step(&Now::default()), &["temperature_C"]);
}
