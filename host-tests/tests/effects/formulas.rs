//! Each effect alone, in every arithmetic.

use super::*;
use fixed::types::I16F16;
use preslide::effects::{
    ConstantForce, CoulombAsymmetry, DwellAging, Effect, EncoderError, ExternalVibration,
    FrictionalLag, Gravity, LoadDependentFriction, LocalFrictionSpot, PeriodicForce,
    PeriodicFriction, PositionForce, PositionFriction, PositionSpring, QuadraticDrag, RunIn,
    Situation, Stribeck, ThermalDrift, Viscous, ViscousAsymmetry, WarmUp,
};
use preslide_host_tests::deviation::Deviation;
use std::f64::consts::{PI, TAU};

/// What an effect acts on.
#[derive(Clone, Copy, PartialEq)]
enum On {
    Level,
    Force,
    Shift,
}

/// Runs an effect along the ticks against `reference`, and checks its bound on the way.
fn deviation<S: Scalar, E: Effect<S>>(
    effect: E,
    on: On,
    units: Units,
    mut reference: impl FnMut(&Tick) -> f64,
) -> Deviation {
    assert_eq!(
        (E::LEVEL, E::FORCE, E::SHIFT),
        (on == On::Level, on == On::Force, on == On::Shift)
    );
    let mut state = effect.at_rest();
    let mut deviation = Deviation::default();
    let bounds = effect.bounds();
    for tick in ticks() {
        let at = Situation {
            position: scalar::<S>(tick.x / units.length),
            located: true,
            velocity: scalar(tick.v / units.velocity),
            friction: scalar(tick.friction / units.force),
            temperature: Some(scalar(tick.temperature)),
            load: S::try_from_f64(tick.load / units.force),
        };
        let (value, bound, unit) = match on {
            On::Level => (effect.level(&mut state, &at), bounds.level, 1.0),
            On::Force => (effect.force(&mut state, &at), bounds.force, units.force),
            On::Shift => (effect.shift(at.position), bounds.shift, units.length),
        };
        assert!(value.magnitude() <= bound, "{value:?} exceeds {bound:?}");
        deviation.add(value.to_f64() * unit, reference(&tick));
    }
    deviation
}

/// Every effect in one number type: what it is, its deviation, and its amplitude.
fn all<S: Scalar>(u: Units) -> Vec<(&'static str, Deviation, f64)> {
    let exp = |v: f64, v_s: f64, d: f64| (-(v.abs() / v_s).powf(d)).exp();
    let map = |x: f64, terms: &[f64]| -> f64 {
        let place = ((x + 2e-4) / 5e-4).clamp(0.0, 1.0);
        (1..)
            .zip(terms)
            .map(|(j, c)| c * (f64::from(j) * PI * place).cos())
            .sum()
    };
    let mut lag = None;
    let ok = "valid parameters";
    let mut found = vec![
        (
            "constant_force",
            deviation(
                ConstantForce::<S>::try_new(-0.2, u).expect(ok),
                On::Force,
                u,
                |_| -0.2,
            ),
            0.2,
        ),
        (
            "viscous",
            deviation(
                Viscous::<S>::try_new(12.0, 0.2, u).expect(ok),
                On::Force,
                u,
                |t| (12.0 * t.v).clamp(-0.2, 0.2),
            ),
            0.2,
        ),
        (
            "viscous_asymmetry",
            deviation(
                ViscousAsymmetry::<S>::try_new(12.0, 0.2, u).expect(ok),
                On::Force,
                u,
                |t| (12.0 * t.v.abs()).clamp(-0.2, 0.2),
            ),
            0.2,
        ),
        (
            "quadratic_drag",
            deviation(
                QuadraticDrag::<S>::try_new(400.0, 1.0, u).expect(ok),
                On::Force,
                u,
                |t| 400.0 * t.v * t.v.abs(),
            ),
            0.36,
        ),
        (
            "position_spring",
            deviation(
                PositionSpring::<S>::try_new(300.0, 1e-4, 0.1, u).expect(ok),
                On::Force,
                u,
                |t| (300.0 * (t.x - 1e-4)).clamp(-0.1, 0.1),
            ),
            0.1,
        ),
        (
            "position_force",
            deviation(
                PositionForce::<3, S>::try_new(-2e-4, 3e-4, [0.05, -0.02, 0.01], u).expect(ok),
                On::Force,
                u,
                |t| map(t.x, &[0.05, -0.02, 0.01]),
            ),
            0.08,
        ),
        (
            "periodic_force",
            deviation(
                PeriodicForce::<S>::try_new(0.03, 2.5e-4, 1.0, u).expect(ok),
                On::Force,
                u,
                |t| 0.03 * (TAU * t.x / 2.5e-4 + 1.0).cos(),
            ),
            0.03,
        ),
        (
            "coulomb_asymmetry",
            deviation(
                CoulombAsymmetry::<S>::try_new(-0.15).expect(ok),
                On::Level,
                u,
                |t| {
                    if t.friction == 0.0 {
                        0.0
                    } else {
                        -0.15 * t.friction.signum()
                    }
                },
            ),
            0.15,
        ),
        (
            "stribeck, exponent 1",
            deviation(
                Stribeck::<S>::try_new(0.3, 4e-3, 1.0, u).expect(ok),
                On::Level,
                u,
                |t| 0.3 * exp(t.v, 4e-3, 1.0),
            ),
            0.3,
        ),
        (
            "stribeck, exponent 2",
            deviation(
                Stribeck::<S>::try_new(0.3, 4e-3, 2.0, u).expect(ok),
                On::Level,
                u,
                |t| 0.3 * exp(t.v, 4e-3, 2.0),
            ),
            0.3,
        ),
        (
            "frictional_lag",
            deviation(
                FrictionalLag::<S>::try_new(0.3, 4e-3, 2.0, 5e-3, SAMPLE_TIME, u).expect(ok),
                On::Level,
                u,
                move |t| {
                    let now = 0.3 * exp(t.v, 4e-3, 2.0);
                    let next = now + (lag.unwrap_or(0.3) - now) * (-SAMPLE_TIME / 5e-3_f64).exp();
                    lag = Some(next);
                    next
                },
            ),
            0.3,
        ),
        (
            "position_friction",
            deviation(
                PositionFriction::<2, S>::try_new(-2e-4, 3e-4, [0.2, 0.1], u).expect(ok),
                On::Level,
                u,
                |t| map(t.x, &[0.2, 0.1]),
            ),
            0.3,
        ),
        (
            "local_friction_spot",
            deviation(
                LocalFrictionSpot::<S>::try_new(0.5, 1.5e-4, 1e-4, u).expect(ok),
                On::Level,
                u,
                |t| 0.5 * (-((t.x - 1.5e-4) / 1e-4).powi(2)).exp(),
            ),
            0.5,
        ),
        (
            "periodic_friction",
            deviation(
                PeriodicFriction::<S>::try_new(0.1, 2.5e-4, -2.0, u).expect(ok),
                On::Level,
                u,
                |t| 0.1 * (TAU * t.x / 2.5e-4 - 2.0).cos(),
            ),
            0.1,
        ),
        (
            "encoder_error",
            deviation(
                EncoderError::<S>::try_new(5e-7, 2.5e-4, 0.5, u).expect(ok),
                On::Shift,
                u,
                |t| -5e-7 * (TAU * t.x / 2.5e-4 + 0.5).cos(),
            ),
            5e-7,
        ),
    ];
    if u == Units::SI {
        let (mut path, mut age) = (0.0, 0.0_f64);
        found.extend([
            (
                "external_vibration",
                deviation(
                    ExternalVibration::<S>::try_new(0.05, 25.0, 0.3, SAMPLE_TIME, u).expect(ok),
                    On::Force,
                    u,
                    |t| 0.05 * (TAU * 25.0 * t.t + 0.3).sin(),
                ),
                0.05,
            ),
            (
                "thermal_drift",
                deviation(
                    ThermalDrift::<S>::try_new(-0.02, 21.0, 0.1).expect(ok),
                    On::Level,
                    u,
                    |t| (-0.02 * (t.temperature - 21.0)).clamp(-0.1, 0.1),
                ),
                0.1,
            ),
            (
                "load_dependent_friction",
                deviation(
                    LoadDependentFriction::<S>::try_new(0.03, 30.0, 1.0, u).expect(ok),
                    On::Level,
                    u,
                    |t| 0.03 * (t.load - 30.0),
                ),
                0.15,
            ),
            (
                "warm_up",
                deviation(
                    WarmUp::<S>::try_new(0.2, 3.0, SAMPLE_TIME).expect(ok),
                    On::Level,
                    u,
                    |t| 0.2 * (-(t.t + SAMPLE_TIME) / 3.0).exp(),
                ),
                0.2,
            ),
            (
                "run_in",
                deviation(
                    RunIn::<S>::try_new(0.2, 0.02, SAMPLE_TIME, u).expect(ok),
                    On::Level,
                    u,
                    move |t| {
                        path += t.v.abs() * SAMPLE_TIME;
                        0.2 * (-path / 0.02).exp()
                    },
                ),
                0.2,
            ),
            // The law solved exactly over the tick, with a hundredth of its age lost in one at the highest speed.
            (
                "dwell_aging",
                deviation(
                    DwellAging::<S>::try_new(0.05, 1e-3, 1.5e-4, 3.0, SAMPLE_TIME, u).expect(ok),
                    On::Level,
                    u,
                    move |t| {
                        let rate = t.v.abs() / 1.5e-4;
                        age = if rate > 0.0 {
                            let steady = 1.0 / rate;
                            steady + (age - steady) * (-rate * SAMPLE_TIME).exp()
                        } else {
                            age + SAMPLE_TIME
                        };
                        0.05 * (1.0 + age / 1e-3).log10()
                    },
                ),
                0.05,
            ),
        ]);
    }
    found
}

/// Relative to the amplitude: maximum, RMS, bias. Tables (64 intervals) and the cosine (6e-7) set the scale in floats.
#[test]
fn every_effect_agrees_with_its_formula() {
    for (what, found, scale, max, rms, bias) in [
        ("f64", all::<f64>(Units::SI)),
        ("f32", all::<f32>(Units::SI)),
        ("I16F16", all::<I16F16>(COUNTS)),
    ]
    .into_iter()
    .flat_map(|(kind, rows)| {
        rows.into_iter().map(move |(what, found, scale)| {
            let (max, rms, bias) = match (what, kind) {
                ("stribeck, exponent 1" | "run_in" | "warm_up", _) => (3e-3, 2e-3, 2e-3),
                ("dwell_aging", _) => (2e-2, 2e-3, 1e-3),
                (
                    "local_friction_spot" | "stribeck, exponent 2" | "frictional_lag",
                    "f32" | "f64",
                ) => (1e-3, 5e-4, 4e-4),
                // A quarter of a million ticks of rounding in the phase.
                ("external_vibration", "f32") => (2e-3, 1e-3, 1e-4),

                (_, "f64") => (3e-6, 1e-6, 1e-6),
                (_, "f32") => (2e-5, 1e-5, 1e-5),
                _ => (6e-3, 4e-3, 4e-3),
            };
            (format!("{what} in {kind}"), found, scale, max, rms, bias)
        })
    }) {
        eprintln!(
            "{what}: max {:.1e}, RMS {:.1e}, bias {:+.1e} of the amplitude",
            found.max / scale,
            found.rms() / scale,
            found.bias() / scale
        );
        found.assert_within(&what, max * scale, rms * scale, bias * scale);
    }
}

/// Over two turns each way, in rad and in the 8192 counts per turn of a small encoder.
#[test]
fn gravity_is_the_sine_of_the_angle_in_every_arithmetic() {
    fn worst<S: Scalar>(units: Units) -> f64 {
        let gravity = Gravity::<S>::try_new(3.31, 0.7, units).expect("fits");
        let of = |i: i32| {
            let q = f64::from(i) * 4.0 * PI / 10_000.0;
            let scalar = |value: f64| S::try_from_f64(value).expect("in range");
            let at = Situation {
                position: scalar(q / units.length),
                located: true,
                velocity: S::ZERO,
                friction: S::ZERO,
                temperature: None,
                load: None,
            };
            let force = gravity.force(&mut (), &at).to_f64() * units.force;
            assert!(force.abs() <= gravity.bounds().force.to_f64() * units.force);
            (force - 3.31 * (q - 0.7).sin()).abs()
        };
        (-10_000..=10_000).map(of).fold(0.0, f64::max)
    }
    let counts = Units {
        length: TAU / 8192.0,
        ..Units::SI
    };
    for (name, error, most) in [
        ("f64", worst::<f64>(Units::SI), 5e-6),
        ("f32", worst::<f32>(Units::SI), 1e-5),
        ("I16F16 in counts", worst::<I16F16>(counts), 4e-3),
    ] {
        eprintln!("gravity of 3.31 N·m in {name}: largest error {error:.1e} N·m");
        assert!(error < most, "{name}: {error:e} N·m");
    }
}
