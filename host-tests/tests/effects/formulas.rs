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
use preslide_host_tests::trials;
use preslide_host_tests::trials::draw::Draw;
use preslide_host_tests::trials::effect::{Acting, CATALOGUE, Present};
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

/// Rows of a table: an effect's name, what it acts on, its amplitude, its constructor, and the formula.
macro_rules! effects {
    ($u:ident: $($what:literal, $on:ident, $scale:literal: $effect:expr => $formula:expr;)*) => {
        [$(($what, deviation($effect.expect("valid parameters"), On::$on, $u, $formula), $scale)),*]
    };
}

/// Every effect in one number type: what it is, its deviation, and its amplitude.
fn all<S: Scalar>(u: Units) -> Vec<(&'static str, Deviation, f64)> {
    let exp = |v: f64, v_s: f64, d: f64| (-(v.abs() / v_s).powf(d)).exp();
    let map = |x: f64, terms: &[f64]| -> f64 {
        let place = ((x + 2e-4) / 5e-4).clamp(0.0, 1.0);
        let cosines = (1..).zip(terms);
        cosines
            .map(|(j, c)| c * (f64::from(j) * PI * place).cos())
            .sum()
    };
    let mut lag = None;
    let lagging = move |t: &Tick| {
        let now = 0.3 * exp(t.v, 4e-3, 2.0);
        let next = now + (lag.unwrap_or(0.3) - now) * (-SAMPLE_TIME / 5e-3_f64).exp();
        lag = Some(next);
        next
    };
    let mut found = Vec::from(effects! { u:
        "constant_force", Force, 0.2: ConstantForce::<S>::try_new(-0.2, u) => |_| -0.2;
        "viscous", Force, 0.2: Viscous::<S>::try_new(12.0, 0.2, u) => |t| (12.0 * t.v).clamp(-0.2, 0.2);
        "viscous_asymmetry", Force, 0.2: ViscousAsymmetry::<S>::try_new(12.0, 0.2, u)
            => |t| (12.0 * t.v.abs()).clamp(-0.2, 0.2);
        "quadratic_drag", Force, 0.36: QuadraticDrag::<S>::try_new(400.0, 1.0, u) => |t| 400.0 * t.v * t.v.abs();
        "position_spring", Force, 0.1: PositionSpring::<S>::try_new(300.0, 1e-4, 0.1, u)
            => |t| (300.0 * (t.x - 1e-4)).clamp(-0.1, 0.1);
        "position_force", Force, 0.08: PositionForce::<3, S>::try_new(-2e-4, 3e-4, [0.05, -0.02, 0.01], u)
            => |t| map(t.x, &[0.05, -0.02, 0.01]);
        "periodic_force", Force, 0.03: PeriodicForce::<S>::try_new(0.03, 2.5e-4, 1.0, u)
            => |t| 0.03 * (TAU * t.x / 2.5e-4 + 1.0).cos();
        "coulomb_asymmetry", Level, 0.15: CoulombAsymmetry::<S>::try_new(-0.15) => |t| -0.15 * sign(t.friction);
        "stribeck, exponent 1", Level, 0.3: Stribeck::<S>::try_new(0.3, 4e-3, 1.0, u) => |t| 0.3 * exp(t.v, 4e-3, 1.0);
        "stribeck, exponent 2", Level, 0.3: Stribeck::<S>::try_new(0.3, 4e-3, 2.0, u) => |t| 0.3 * exp(t.v, 4e-3, 2.0);
        "frictional_lag", Level, 0.3: FrictionalLag::<S>::try_new(0.3, 4e-3, 2.0, 5e-3, SAMPLE_TIME, u) => lagging;
        "position_friction", Level, 0.3: PositionFriction::<2, S>::try_new(-2e-4, 3e-4, [0.2, 0.1], u)
            => |t| map(t.x, &[0.2, 0.1]);
        "local_friction_spot", Level, 0.5: LocalFrictionSpot::<S>::try_new(0.5, 1.5e-4, 1e-4, u)
            => |t| 0.5 * (-((t.x - 1.5e-4) / 1e-4).powi(2)).exp();
        "periodic_friction", Level, 0.1: PeriodicFriction::<S>::try_new(0.1, 2.5e-4, -2.0, u)
            => |t| 0.1 * (TAU * t.x / 2.5e-4 - 2.0).cos();
        "encoder_error", Shift, 5e-7: EncoderError::<S>::try_new(5e-7, 2.5e-4, 0.5, u)
            => |t| -5e-7 * (TAU * t.x / 2.5e-4 + 0.5).cos();
    });
    if u == Units::SI {
        let (mut path, mut age) = (0.0, 0.0_f64);
        let running_in = move |t: &Tick| {
            path += t.v.abs() * SAMPLE_TIME;
            0.2 * (-path / 0.02).exp()
        };
        // The law solved exactly over the tick, with a hundredth of its age lost in one at the highest speed.
        let ageing = move |t: &Tick| {
            let rate = t.v.abs() / 1.5e-4;
            age = if rate > 0.0 {
                let steady = 1.0 / rate;
                steady + (age - steady) * (-rate * SAMPLE_TIME).exp()
            } else {
                age + SAMPLE_TIME
            };
            0.05 * (1.0 + age / 1e-3).log10()
        };
        found.extend(effects! { u:
            "external_vibration", Force, 0.05: ExternalVibration::<S>::try_new(0.05, 25.0, 0.3, SAMPLE_TIME, u)
                => |t| 0.05 * (TAU * 25.0 * t.t + 0.3).sin();
            "thermal_drift", Level, 0.1: ThermalDrift::<S>::try_new(-0.02, 21.0, 0.1)
                => |t| (-0.02 * (t.temperature - 21.0)).clamp(-0.1, 0.1);
            "load_dependent_friction", Level, 0.15: LoadDependentFriction::<S>::try_new(0.03, 30.0, 1.0, u)
                => |t| 0.03 * (t.load - 30.0);
            "warm_up", Level, 0.2: WarmUp::<S>::try_new(0.2, 3.0, SAMPLE_TIME)
                => |t| 0.2 * (-(t.t + SAMPLE_TIME) / 3.0).exp();
            "run_in", Level, 0.2: RunIn::<S>::try_new(0.2, 0.02, SAMPLE_TIME, u) => running_in;
            "dwell_aging", Level, 0.05: DwellAging::<S>::try_new(0.05, 1e-3, 1.5e-4, 3.0, SAMPLE_TIME, u) => ageing;
        });
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

/// The terms of model files and what the simulated stages are given, with parameters as these are drawn: every effect whose keys are the same.
#[test]
fn every_term_is_what_the_simulated_stages_have() {
    const HALF_TRAVEL: f64 = 0.3e-3;
    let mut compared = Vec::new();
    for id in CATALOGUE {
        let own = trials::effect::Effect::draw(id, 1.0, HALF_TRAVEL, 0.9, &mut Draw::new(8, 0));
        let values: Vec<_> = own.parameters().collect();
        let Ok(effect) = preslide_fit::effects::Effect::new(id.name(), &values) else {
            continue;
        };
        let Some(mut term) = (effect.form.library)(&effect, SAMPLE_TIME).expect("valid") else {
            continue;
        };
        let (mut largest, mut apart) = (0.0_f64, Deviation::default());
        for tick in ticks() {
            let mut sum = Acting::NONE;
            own.act(
                &Present {
                    t: tick.t,
                    x: tick.x,
                    v: tick.v,
                    warmer: 0.0,
                    loaded: 0.0,
                    half_travel: HALF_TRAVEL,
                    bursts: &[],
                    here: 1.0,
                    corner: None,
                },
                &mut sum,
            );
            let wanted = [sum.level - 1.0 + sum.tilt * sign(tick.friction), sum.added];
            let (level, force) = term(&Situation {
                position: tick.x,
                located: true,
                velocity: tick.v,
                friction: tick.friction,
                temperature: None,
                load: None,
            });
            for (found, wanted) in [level, force].into_iter().zip(wanted) {
                largest = largest.max(wanted.abs());
                apart.add(found, wanted);
            }
        }
        // What remembers does not act here.
        if largest > 0.0 {
            eprintln!(
                "{}: {:.1e} of the amplitude",
                id.name(),
                apart.max / largest
            );
            assert!(apart.max < 3e-3 * largest, "{}: {apart:?}", id.name());
            compared.push(id);
        }
    }
    assert!(compared.len() >= 9, "{compared:?}");
}

fn sign(f: f64) -> f64 {
    if f == 0.0 { 0.0 } else { f.signum() }
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
