//! Effects beside a friction model: nothing lost, nothing added, and no force beyond the bound.

use super::*;
use fixed::types::I16F16;
use preslide::effects::{
    ConstantForce, CoulombAsymmetry, EncoderError, LoadDependentFriction, LocalFrictionSpot,
    PeriodicForce, PeriodicFriction, PositionFriction, PositionSpring, Stribeck, ThermalDrift,
    Viscous, With,
};
use preslide::{Friction, Motion, QuasiStaticGms};
use preslide_host_tests::deviation::Deviation;
use preslide_host_tests::path::motion;
use std::f64::consts::{PI, TAU};

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
        let motion = motion(dx, dx / SAMPLE_TIME as f32);
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
        let f = core.step(&mut bare, motion(moved, tick.v));
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
        let force = model.step(&mut state, motion(dx, tick.v));
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
                motion(
                    pick(2, dx / units.length),
                    pick(3, dx / SAMPLE_TIME / units.velocity),
                ),
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

/// Temperature and load reach the model through its state; a failed sensor means the nominal friction.
#[test]
fn the_state_carries_temperature_and_load() {
    let u = Units::SI;
    let friction =
        QuasiStaticGms::<3, f64>::try_new(&table3::blocks::<3>(), 0.9, u).expect("valid");
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
