//! The effects of the library against formulas that share no code with it, and what must hold whatever comes in.

use fixed::types::I16F16;
use preslide::control::{Coefficients, Controller, Measurement, Settings};
use preslide::effects::{
    ConstantForce, CoulombAsymmetry, DwellAging, Effect, EncoderError, ExternalVibration,
    FrictionalLag, Gravity, LoadDependentFriction, LocalFrictionSpot, PeriodicForce,
    PeriodicFriction, PositionForce, PositionFriction, PositionSpring, QuadraticDrag, RunIn,
    Situation, Stribeck, ThermalDrift, Viscous, WarmUp, With,
};
use preslide::{Block, Friction, Gms, Motion, QuasiStaticGms, Scalar, Sliding, Units};
use preslide_host_tests::deviation::Deviation;
use preslide_host_tests::path::{COUNT, SAMPLE_TIME, random_reversals};
use std::f64::consts::{PI, TAU};

const COUNTS: Units = Units {
    length: COUNT,
    force: 1e-3,
    velocity: 1e-3,
};

const TICKS: usize = 200_000;

/// A tick in SI.
#[derive(Clone, Copy)]
struct Tick {
    t: f64,
    x: f64,
    v: f64,
    friction: f64,
    temperature: f64,
    load: f64,
}

/// ±0.4 mm about 0.1 mm, up to 30 mm/s, slow and fast, with rests; friction, temperature and load of no particular law.
fn ticks() -> impl Iterator<Item = Tick> {
    random_reversals(7, TICKS, 2000.0, 60.0)
        .into_iter()
        .enumerate()
        .scan(4000_i64, |count, (i, step)| {
            *count += i64::from(step);
            if (*count - 4000).abs() > 16_000 {
                *count = 4000;
            }
            let t = i as f64 * SAMPLE_TIME;
            Some(Tick {
                t,
                x: *count as f64 * COUNT,
                v: f64::from(step) * COUNT / SAMPLE_TIME,
                friction: 0.9 * (31.0 * t).sin(),
                temperature: 20.0 + 8.0 * (0.7 * t).sin(),
                load: 30.0 + 5.0 * (1.3 * t).sin(),
            })
        })
}

/// What an effect acts on.
#[derive(Clone, Copy, PartialEq)]
enum On {
    Level,
    Force,
    Shift,
}

fn scalar<S: Scalar>(value: f64) -> S {
    S::try_from_f64(value).expect("in range")
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

const BLOCKS: [Block; 3] = [
    Block {
        stiffness: 325_379.0,
        weight: 0.352,
    },
    Block {
        stiffness: 40_535.0,
        weight: 0.307,
    },
    Block {
        stiffness: 7_886.0,
        weight: 0.341,
    },
];

fn gms<S: Scalar>(units: Units) -> Gms<3, S> {
    let sliding = Sliding {
        coulomb: 0.81,
        stribeck_velocity: 1e-3,
        stribeck_exponent: 2.0,
        attraction: 20.0,
    };
    Gms::try_new(&BLOCKS, 0.9, sliding, SAMPLE_TIME, units).expect("valid")
}

/// Without effects the model is the model: the same bits, and nothing stored in the parameters.
#[test]
fn what_is_absent_costs_nothing() {
    assert_eq!(size_of::<With<Gms<3>, ()>>(), size_of::<Gms<3>>());
    let (bare, with) = (
        gms::<f32>(Units::SI),
        With::try_new(gms::<f32>(Units::SI), ()).expect("fits"),
    );
    assert_eq!(bare.limit(), with.limit());
    let (mut a, mut b) = (bare.at_rest(), with.at_rest());
    for step in random_reversals(3, 100_000, 3000.0, 40.0) {
        let dx = (f64::from(step) * COUNT) as f32;
        let motion = Motion {
            displacement: dx,
            velocity: dx / SAMPLE_TIME as f32,
        };
        with.set_position(&mut b, 1e-3);
        assert_eq!(
            bare.step(&mut a, motion).to_bits(),
            with.step(&mut b, motion).to_bits()
        );
    }
}

type Composed<S> = With<
    Gms<3, S>,
    (
        (
            ConstantForce<S>,
            Viscous<S>,
            CoulombAsymmetry<S>,
            Stribeck<S>,
        ),
        (
            PeriodicForce<S>,
            PeriodicFriction<S>,
            PositionFriction<2, S>,
            LocalFrictionSpot<S>,
        ),
        EncoderError<S>,
        PositionSpring<S>,
    ),
>;

fn composed<S: Scalar>(u: Units) -> Composed<S> {
    let ok = "valid parameters";
    With::try_new(
        gms(u),
        (
            (
                ConstantForce::try_new(0.1, u).expect(ok),
                Viscous::try_new(12.0, 0.3, u).expect(ok),
                CoulombAsymmetry::try_new(0.05).expect(ok),
                Stribeck::try_new(0.2, 2e-3, 2.0, u).expect(ok),
            ),
            (
                PeriodicForce::try_new(0.03, 2.857e-4, 0.4, u).expect(ok),
                PeriodicFriction::try_new(0.1, 1e-4, 0.0, u).expect(ok),
                PositionFriction::try_new(-4e-4, 6e-4, [0.1, 0.05], u).expect(ok),
                LocalFrictionSpot::try_new(0.4, 1e-4, 5e-5, u).expect(ok),
            ),
            EncoderError::try_new(1e-7, 1e-5, 0.0, u).expect(ok),
            PositionSpring::try_new(20.0, 0.0, 0.1, u).expect(ok),
        ),
    )
    .expect("fits")
}

/// `m = 1 + Σ(m_i − 1)`, forces added, the displacement corrected: the whole against its parts, formula by formula.
#[test]
fn a_composition_is_the_sum_of_its_terms() {
    let model = composed::<f64>(Units::SI);
    let core = gms::<f64>(Units::SI);
    let (mut state, mut bare) = (model.at_rest(), core.at_rest());
    let mut deviation = Deviation::default();
    let (mut last, mut true_last) = (None, 0.0);
    for tick in ticks() {
        // The path jumps back when it leaves the travel; a displacement of the path is taken as it is.
        let dx = last.map_or(0.0, |l| tick.x - l);
        last = Some(tick.x);
        let x = tick.x - 1e-7 * (TAU * tick.x / 1e-5).cos();
        let moved = if deviation.max == 0.0 && true_last == 0.0 {
            dx
        } else {
            x - true_last
        };
        true_last = x;
        let f = core.step(
            &mut bare,
            Motion {
                displacement: moved,
                velocity: tick.v,
            },
        );
        let u = ((x + 4e-4) / 1e-3).clamp(0.0, 1.0);
        let m = 1.0
            + 0.05 * if f == 0.0 { 0.0 } else { f.signum() }
            + 0.2 * (-(tick.v / 2e-3).powi(2)).exp()
            + 0.1 * (TAU * x / 1e-4).cos()
            + 0.1 * (PI * u).cos()
            + 0.05 * (2.0 * PI * u).cos()
            + 0.4 * (-((x - 1e-4) / 5e-5).powi(2)).exp();
        let added = 0.1
            + (12.0 * tick.v).clamp(-0.3, 0.3)
            + 0.03 * (TAU * x / 2.857e-4 + 0.4).cos()
            + (20.0 * x).clamp(-0.1, 0.1);
        model.set_position(&mut state, tick.x);
        let force = model.step(
            &mut state,
            Motion {
                displacement: dx,
                velocity: tick.v,
            },
        );
        deviation.add(force, m * f + added);
    }
    eprintln!(
        "composition: max {:.1e} N, RMS {:.1e} N, bias {:+.1e} N",
        deviation.max,
        deviation.rms(),
        deviation.bias()
    );
    deviation.assert_within("composition", 5e-4, 1e-4, 2e-5);
}

/// Whatever comes in, NaN and infinity too, no force beyond the stated limit comes out, and the model recovers.
#[test]
fn no_input_breaks_the_bound() {
    fn check<S: Scalar>(units: Units, bad: &[S]) {
        let model = composed::<S>(units);
        let limit = model.limit().expect("all terms are bounded");
        let stated = (1.0 + 0.05 + 0.2 + 0.1 + 0.15 + 0.4) * 0.9 + 0.1 + 0.3 + 0.03 + 0.1;
        assert!((limit.to_f64() * units.force / stated - 1.0).abs() < 1e-3);
        let mut state = model.at_rest();
        let mut reached = 0.0_f64;
        for (i, step) in random_reversals(5, 100_000, 3000.0, 40.0)
            .into_iter()
            .enumerate()
        {
            let pick = |k: usize, good: f64| match bad.get((i / 97 + k) % 41) {
                Some(&value) if i % 7 == k % 7 => value,
                _ => scalar(good),
            };
            let dx = f64::from(step) * COUNT;
            model.set_position(
                &mut state,
                pick(0, (i % 20_000) as f64 * COUNT / units.length),
            );
            state.temperature = Some(pick(1, 20.0));
            let force = model.step(
                &mut state,
                Motion {
                    displacement: pick(2, dx / units.length),
                    velocity: pick(3, dx / SAMPLE_TIME / units.velocity),
                },
            );
            assert!(
                force.magnitude() <= limit,
                "tick {i}: {force:?} exceeds {limit:?}"
            );
            reached = reached.max(force.magnitude().to_f64() * units.force);
        }
        assert!(reached > 0.5, "{reached}");
    }
    check::<f32>(
        Units::SI,
        &[
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MAX,
            f32::MIN,
            1e9,
            -1e9,
            0.0,
            -0.0,
        ],
    );
    check::<f64>(
        Units::SI,
        &[
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::MAX,
            f64::MIN,
            1e18,
        ],
    );
    check::<I16F16>(COUNTS, &[I16F16::MAX, I16F16::MIN, I16F16::DELTA]);
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let u = Units::SI;
    let refused = |error: Option<preslide::ParamError>, part: &str| {
        let error = error.expect("refused").to_string();
        assert!(error.contains(part), "`{part}` is not in: {error}");
    };
    refused(Viscous::<f32>::try_new(f64::NAN, 1.0, u).err(), "viscous");
    refused(Viscous::<f32>::try_new(1.0, 0.0, u).err(), "limit");
    refused(
        Stribeck::<f32>::try_new(0.1, 1e-3, 0.5, u).err(),
        "exponent",
    );
    refused(
        Stribeck::<f32>::try_new(f64::NAN, 1e-3, 2.0, u).err(),
        "level",
    );
    refused(
        Stribeck::<f32>::try_new(0.1, -1.0, 2.0, u).err(),
        "velocity",
    );
    refused(CoulombAsymmetry::<f32>::try_new(1.5).err(), "asymmetry");
    refused(
        PeriodicForce::<f32>::try_new(0.1, 0.0, 0.0, u).err(),
        "period",
    );
    refused(
        EncoderError::<f32>::try_new(2e-6, 1e-5, 0.0, u).err(),
        "encoder error",
    );
    refused(
        PositionForce::<1, f32>::try_new(1.0, 1.0, [0.1], u).err(),
        "travel",
    );
    refused(
        ExternalVibration::<f32>::try_new(0.1, 600.0, 0.0, 1e-3, u).err(),
        "frequency",
    );
    refused(
        DwellAging::<f32>::try_new(0.1, 10.0, 1e-5, 6.0, 50e-6, u).err(),
        "ageing",
    );
    // Periods that I16F16 cannot resolve in counts, a frequency that it would put out of step.
    refused(
        PeriodicForce::<I16F16>::try_new(0.1, 16.7, 0.0, COUNTS).err(),
        "turns",
    );
    refused(
        PeriodicForce::<I16F16>::try_new(0.1, 5e-3, 0.0, COUNTS).err(),
        "turns",
    );
    refused(
        ExternalVibration::<I16F16>::try_new(0.1, 33.0, 0.0, SAMPLE_TIME, COUNTS).err(),
        "turns",
    );
    let huge = ConstantForce::<I16F16>::try_new(32.7, COUNTS).expect("alone it fits");
    refused(With::try_new(gms::<I16F16>(COUNTS), huge).err(), "composed");
}

/// The control task takes the composed model by type, and tells it where the axis is, once it has been told itself.
#[test]
fn the_controller_places_the_model() {
    let settings = Settings::PAPER_AXIS;
    let u = Units::SI;
    let force = |x0: i32, homed: bool| {
        let friction = QuasiStaticGms::<3, f32>::try_new(&BLOCKS, 0.9, u).expect("valid");
        let model = With::try_new(
            friction,
            PositionSpring::try_new(500.0, 0.0, 2.0, u).expect("valid"),
        )
        .expect("fits");
        let coefficients = Coefficients::try_new(&settings, model, u).expect("valid");
        let mut controller = Controller::new(coefficients, 0_u32);
        let mut code = 0;
        if homed {
            controller.set_position(0, 0);
        }
        // Carried slowly to x0 by hand before it is enabled.
        let mut at = 0;
        let measurement = |at: i32| Measurement {
            count: at.cast_unsigned(),
            supply: 6000,
            current: 0,
            late: false,
        };
        while at != x0 {
            at += (x0 - at).signum() * (x0 - at).abs().min(20);
            assert!(!controller.tick(measurement(at)).enabled);
        }
        assert_eq!(controller.enable(), Ok(()));
        for _ in 0..200 {
            code = controller.tick(measurement(at)).code;
        }
        assert_eq!(controller.fault(), None);
        f64::from(code)
    };
    let (left, middle, right) = (force(-40_000, true), force(0, true), force(40_000, true));
    let lost = force(40_000, false);
    assert!(lost.abs() <= 1.0, "{lost}");
    assert!(middle.abs() <= 1.0, "{middle}");
    assert!(
        right > 100.0 && (right + left).abs() < 2.0,
        "{left} {right}"
    );
}

/// Temperature and load reach the model through its state; a failed sensor means the nominal friction.
#[test]
fn surroundings_are_told_through_the_state() {
    let u = Units::SI;
    let friction = QuasiStaticGms::<3, f64>::try_new(&BLOCKS, 0.9, u).expect("valid");
    let drift = ThermalDrift::try_new(-0.02, 20.0, 0.5).expect("valid");
    let load = LoadDependentFriction::try_new(0.01, 30.0, 0.5, u).expect("valid");
    let model = With::try_new(friction, (drift, load)).expect("fits");
    let mut state = model.at_rest();
    let mut force = |temperature: Option<f64>, load: Option<f64>| {
        (state.temperature, state.load) = (temperature, load);
        model.step(&mut state, Motion::quasi_static(1e-2))
    };
    for (temperature, load, level) in [
        (None, None, 1.0),
        (Some(25.0), None, 0.9),
        (Some(25.0), Some(40.0), 1.0),
        (Some(f64::NAN), Some(f64::NAN), 1.0),
        (Some(1e9), None, 0.5),
    ] {
        assert!(
            (force(temperature, load) - 0.9 * level).abs() < 1e-9,
            "{temperature:?} {load:?}"
        );
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

/// What belongs to a place acts once the place is known: alone, in a tuple, in a nested tuple; what does not acts at once.
#[test]
fn effects_of_place_wait_until_the_axis_is_located() {
    let gms = || QuasiStaticGms::<3, f64>::try_new(&BLOCKS, 0.9, Units::SI).expect("valid");
    let cogging = || PeriodicForce::<f64>::try_new(0.03, 2.857e-4, 0.0, Units::SI).expect("valid");
    let spot = || LocalFrictionSpot::<f64>::try_new(0.5, 0.0, 1e-4, Units::SI).expect("valid");
    let constant = || ConstantForce::<f64>::try_new(0.2, Units::SI).expect("valid");
    let error = || EncoderError::<f64>::try_new(50e-9, 10e-6, 0.3, Units::SI).expect("valid");
    let motion = Motion {
        displacement: 1e-3,
        velocity: 1e-3,
    };
    fn both<F: Friction<Scalar = f64>>(model: &F, motion: Motion<f64>) -> [f64; 2] {
        [false, true].map(|placed| {
            let mut state = model.at_rest();
            if placed {
                model.set_position(&mut state, 0.0);
            }
            model.step(&mut state, motion)
        })
    }
    let [alone, _] = both(&gms(), motion);
    // The library's waves and bells are approximations, good to 1e-4 of their level.
    let close = |a: f64, b: f64| assert!((a - b).abs() < 5e-5, "{a} {b}");
    let single = With::try_new(gms(), cogging()).expect("valid");
    let [off, on] = both(&single, motion);
    close(off, alone);
    close(on, alone + 0.03);
    let nested = With::try_new(gms(), (constant(), (spot(), cogging()), error())).expect("valid");
    let [off, on] = both(&nested, motion);
    close(off, alone + 0.2);
    close(on, (1.5 * alone) + 0.2 + 0.03);
}
