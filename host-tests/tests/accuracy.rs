//! Every model in every arithmetic against the independent reference: largest, RMS and mean error, asserted.
//!
//! `cargo test -p preslide-host-tests --test all -- accuracy:: --nocapture` prints the figures.

use crate::laws::{self, Equation, built};
use fixed::types::{I8F24, I16F16, I32F32};
use preslide::{Coulomb, Friction, Gms, Hsieh, Motion, QuasiStaticGms, Scalar, Sliding, Units};
use preslide_host_tests::deviation::Deviation;
use preslide_host_tests::path::{COUNT, COUNTS, SAMPLE_TIME, motion, random_reversals};
use preslide_host_tests::reference::{Masing, MaxwellSlip, Stribeck};
use preslide_host_tests::table3::{BREAKAWAY, blocks, column, hsieh};
use rayon::prelude::*;

const TICKS: usize = 1_000_000;
const SEED: u64 = 1227;

/// Units that fit ±128: 32 counts (so that counts stay exact), 10 mN, 1 mm/s.
const COARSE: Units = Units {
    length: 32.0 * COUNT,
    force: 1e-2,
    velocity: 1e-3,
};

/// Counts and 10 mN.
const TENS: Units = Units {
    force: 1e-2,
    ..COUNTS
};

/// Bounds on largest, RMS and mean error (N) in one arithmetic.
#[derive(Clone, Copy)]
pub(crate) struct Bounds {
    number: &'static str,
    max: f64,
    rms: f64,
    bias: f64,
}

pub(crate) const fn bounds(number: &'static str, max: f64, rms: f64, bias: f64) -> Bounds {
    Bounds {
        number,
        max,
        rms,
        bias,
    }
}

/// Counts travelled in a tick and the velocity (m/s) that the model gets.
pub(crate) type Tick = (i32, f64);

fn scalar<S: Scalar>(value: f64) -> S {
    S::try_from_f64(value).expect("the path fits the number type")
}

fn deviation<M: Friction>(
    model: &M,
    units: Units,
    path: &[Tick],
    reference: &[f64],
    threshold: f64,
) -> Deviation {
    let mut state = model.at_rest();
    let mut deviation = Deviation::counting_above(threshold);
    for (&(counts, velocity), &expected) in path.iter().zip(reference) {
        let force = model.step(
            &mut state,
            motion(
                scalar(f64::from(counts) * COUNT / units.length),
                scalar(velocity / units.velocity),
            ),
        );
        deviation.add(force.to_f64() * units.force, expected);
    }
    deviation
}

fn print(what: &str, number: &str, found: &Deviation) {
    println!(
        "{what:<34} {number:<7} max {:>8.1e}  RMS {:>8.1e}  bias {:>9.1e}",
        found.max,
        found.rms(),
        found.bias()
    );
}

fn compare<M: Friction>(
    what: &str,
    bounds: &Bounds,
    (model, units): (&M, Units),
    path: &[Tick],
    reference: &[f64],
) {
    let found = deviation(model, units, path, reference, bounds.max);
    print(what, bounds.number, &found);
    let what = format!("{what} {}", bounds.number);
    found.assert_within(&what, bounds.max, bounds.rms, bounds.bias);
}

/// The library's parameters of the same curve.
fn sliding(stribeck: &Stribeck, attraction: f64) -> Sliding {
    Sliding {
        coulomb: stribeck.coulomb,
        stribeck_velocity: stribeck.velocity,
        stribeck_exponent: stribeck.exponent,
        attraction,
    }
}

/// Runs `$check::<N, S>(…)` for every arithmetic.
macro_rules! each_arithmetic {
    ($check:ident, $n:literal, $bounds:expr, $($argument:expr),*) => {{
        let [f32_, f64_, i16f16, i8f24, i32f32] = $bounds;
        $check::<$n, f32>(Units::SI, &f32_, $($argument),*);
        $check::<$n, f64>(Units::SI, &f64_, $($argument),*);
        $check::<$n, I16F16>(COUNTS, &i16f16, $($argument),*);
        $check::<$n, I8F24>(COARSE, &i8f24, $($argument),*);
        $check::<$n, I32F32>(COUNTS, &i32f32, $($argument),*);
    }};
}

/// Runs `$do!(N)` with numbers of blocks.
macro_rules! with_blocks {
    ($do:ident: $($n:literal)*) => { $($do!($n);)* };
    ($do:ident, $sizes:expr) => {
        match $sizes {
            Sizes::Some => {
                with_blocks!($do: 1 4 10);
            }
            Sizes::All => {
                with_blocks!($do: 1 2 3 4 5 6 7 8 9 10);
            }
        }
    };
}

/// Which numbers of blocks run.
#[derive(Clone, Copy, PartialEq)]
enum Sizes {
    /// Some, with the smallest and the largest: what a gate can afford.
    Some,
    All,
}

fn header(what: &str) {
    println!("\n{what}: {TICKS} ticks, seed {SEED}, errors in N (F_s = {BREAKAWAY} N)");
}

#[test]
fn quasi_static_gms_is_within_bounds_of_the_masing_rules() {
    quasi_static_gms(Sizes::Some);
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn quasi_static_gms_of_every_size_is_within_bounds_of_the_masing_rules() {
    quasi_static_gms(Sizes::All);
}

fn quasi_static_gms(sizes: Sizes) {
    fn check<const N: usize, S: Scalar>(
        units: Units,
        bounds: &Bounds,
        path: &[Tick],
        reference: &[f64],
    ) {
        let model = QuasiStaticGms::<N, S>::try_new(&blocks::<N>(), BREAKAWAY, units)
            .expect("Table 3 is valid");
        let what = format!("quasi-static GMS, N = {N}");
        compare(&what, bounds, (&model, units), path, reference);
    }
    const BOUNDS: [Bounds; 5] = [
        bounds("f32", 1.5e-5, 2.6e-6, 1e-7),
        bounds("f64", 3e-14, 5.5e-15, 1e-16),
        bounds("I16F16", 2e-5, 1.5e-5, 1.1e-6),
        bounds("I8F24", 2e-8, 1.1e-8, 3.3e-9),
        bounds("I32F32", 4.5e-10, 3.4e-10, 2.4e-11),
    ];
    header("Quasi-static GMS");
    let path: Vec<Tick> = random_reversals(SEED, TICKS, 4_000.0, 200.0)
        .into_iter()
        .map(|counts| (counts, 0.0))
        .collect();
    macro_rules! at {
        ($n:literal) => {
            let mut masing = Masing::new(column($n), BREAKAWAY, COUNT);
            let reference: Vec<f64> = path.iter().map(|tick| masing.advance(tick.0)).collect();
            each_arithmetic!(check, $n, BOUNDS, &path, &reference);
        };
    }
    with_blocks!(at, sizes);
}

/// Share of the ticks on which the full law may differ by more than rounding, up to `F_s − F_c`.
///
/// The law is discontinuous: a block that comes back to exactly its limit, as happens in counts, slips or sticks
/// by the last bit, and if the limit then rises, the one lags while the other follows the motion.
const TIES: f64 = 1e-3;

/// Attraction parameter for which the lag is a tenth of the gap per tick (N/s).
const ATTRACTION: f64 = 2_000.0;

fn gms_against_the_equations(
    what: &str,
    stribeck: Stribeck,
    path: &[Tick],
    bounds: [Bounds; 5],
    sizes: Sizes,
) {
    fn check<const N: usize, S: Scalar>(
        units: Units,
        bounds: &Bounds,
        what: &str,
        sliding: Sliding,
        path: &[Tick],
        reference: &[f64],
    ) {
        let model = Gms::<N, S>::try_new(&blocks::<N>(), BREAKAWAY, sliding, SAMPLE_TIME, units)
            .expect("Table 3 is valid");
        let found = deviation(&model, units, path, reference, bounds.max);
        let what = format!("{what}, N = {N}");
        print(&what, bounds.number, &found);
        let ties = found.share_above();
        if ties > 0.0 {
            println!(
                "{what:<34} {:<7} above {:.0e} N on {ties:.1e} of the ticks",
                bounds.number, bounds.max
            );
        }
        assert!(
            ties <= TIES,
            "{what} {}: above {:e} on {ties:e} of the ticks",
            bounds.number,
            bounds.max
        );
        let weakening = BREAKAWAY - sliding.coulomb;
        found.assert_within(&what, weakening, bounds.rms, bounds.bias);
    }
    let sliding = sliding(&stribeck, ATTRACTION);
    header(what);
    macro_rules! at {
        ($n:literal) => {
            let mut equations = MaxwellSlip::new(column($n), stribeck, ATTRACTION, SAMPLE_TIME);
            let reference: Vec<f64> = path
                .iter()
                .map(|&(counts, v)| equations.advance(f64::from(counts) * COUNT, v))
                .collect();
            each_arithmetic!(check, $n, bounds, what, sliding, path, &reference);
        };
    }
    with_blocks!(at, sizes);
}

#[test]
fn gms_at_speeds_that_need_no_interpolation_is_within_bounds_of_the_equations() {
    gms_without_interpolation(Sizes::Some);
}

#[test]
fn gms_with_interpolated_stribeck_curve_is_within_bounds_of_the_equations() {
    gms_with_interpolation(Sizes::Some);
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn gms_of_every_size_is_within_bounds_of_the_equations() {
    gms_without_interpolation(Sizes::All);
    gms_with_interpolation(Sizes::All);
}

fn gms_without_interpolation(sizes: Sizes) {
    // Standstill (F_s) and a hundred Stribeck velocities (F_c), changing every few ticks.
    let path: Vec<Tick> = random_reversals(SEED, TICKS, 4_000.0, 200.0)
        .into_iter()
        .enumerate()
        .map(|(i, counts)| (counts, if (i / 7) % 3 == 0 { 0.1 } else { 0.0 }))
        .collect();
    let stribeck = Stribeck {
        breakaway: BREAKAWAY,
        coulomb: 0.9 * BREAKAWAY,
        velocity: 1e-3,
        exponent: 2.0,
    };
    const BOUNDS: [Bounds; 5] = [
        bounds("f32", 1.5e-5, 4.5e-5, 2e-7),
        bounds("f64", 5e-12, 3.2e-5, 1.7e-7),
        bounds("I16F16", 2.4e-5, 4.5e-5, 1.1e-6),
        bounds("I8F24", 1.6e-7, 3.2e-5, 1.8e-7),
        bounds("I32F32", 6.5e-10, 3.2e-5, 1.7e-7),
    ];
    gms_against_the_equations("GMS, s(v) exact", stribeck, &path, BOUNDS, sizes);
}

fn gms_with_interpolation(sizes: Sizes) {
    let path: Vec<Tick> = random_reversals(SEED, TICKS, 4_000.0, 200.0)
        .into_iter()
        .map(|counts| (counts, f64::from(counts) * COUNT / SAMPLE_TIME))
        .collect();
    let stribeck = Stribeck {
        breakaway: BREAKAWAY,
        coulomb: 0.9 * BREAKAWAY,
        velocity: 10e-3,
        exponent: 2.0,
    };
    const BOUNDS: [Bounds; 5] = [
        bounds("f32", 4.8e-5, 2e-5, 1.5e-6),
        bounds("f64", 3.6e-5, 2e-5, 1.4e-6),
        bounds("I16F16", 6.5e-5, 3.4e-5, 2.4e-6),
        bounds("I8F24", 3.6e-5, 2e-5, 1.4e-6),
        bounds("I32F32", 3.6e-5, 2e-5, 1.4e-6),
    ];
    gms_against_the_equations("GMS, s(v) by table", stribeck, &path, BOUNDS, sizes);
}

#[test]
fn every_law_is_within_bounds_of_its_equation() {
    let equations = laws::all().into_iter().flat_map(|law| law.equations);
    let equations: Vec<_> = equations.collect();
    equations.into_par_iter().for_each(|equation| {
        let Equation {
            what,
            model,
            path,
            mut force,
            bounds,
        } = equation;
        let forces: Vec<f64> = path.iter().map(|&(counts, v)| force(counts, v)).collect();
        for bounds in &bounds {
            macro_rules! check {
                ($number:ty, $units:expr) => {{
                    let model = built::<$number>(&model, $units).expect("valid");
                    compare(&what, bounds, (&model, $units), &path, &forces);
                }};
            }
            match bounds.number {
                "f32" => check!(f32, Units::SI),
                "f64" => check!(f64, Units::SI),
                "I16F16" => check!(I16F16, COUNTS),
                "I8F24" => check!(I8F24, COARSE),
                "I32F32" => check!(I32F32, COUNTS),
                "I32F32 of 10 mN" => check!(I32F32, TENS),
                other => panic!("{what}: {other}"),
            }
        }
    });
}

#[test]
fn coulomb_is_exact_to_rounding() {
    let path = laws::slow();
    let reference: Vec<f64> = path
        .iter()
        .map(|&(_, v)| {
            if v == 0.0 {
                0.0
            } else {
                v.signum() * 0.9 + 200.0 * v
            }
        })
        .collect();
    println!(
        "\nCoulomb and viscous: {} ticks, seed {SEED}, errors in N",
        path.len()
    );
    macro_rules! check {
        ($number:ty, $units:expr, $bounds:expr) => {
            let model = Coulomb::<$number>::try_new(0.9, 200.0, $units).expect("valid");
            compare(
                "Coulomb and viscous",
                &$bounds,
                (&model, $units),
                &path,
                &reference,
            );
        };
    }
    check!(f32, Units::SI, bounds("f32", 6e-8, 3e-8, 1e-9));
    check!(f64, Units::SI, bounds("f64", 0.0, 0.0, 0.0));
    check!(I16F16, COUNTS, bounds("I16F16", 3e-16, 1e-16, 1e-17));
    check!(I32F32, COUNTS, bounds("I32F32", 3e-16, 1e-16, 1e-17));
}

#[test]
fn stribeck_table_is_within_its_documented_error_for_every_exponent() {
    const SHARE: f64 = 0.5;
    println!("\nStribeck table: largest error of s(v)/F_s in units of 1 - F_c/F_s");
    for tenths in 10..=40 {
        let exponent = f64::from(tenths) / 10.0;
        let stribeck = Stribeck {
            breakaway: 1.0,
            coulomb: SHARE,
            velocity: 1.0,
            exponent,
        };
        let sliding = sliding(&stribeck, f64::INFINITY);
        let one = [preslide::Block {
            stiffness: 1.0,
            weight: 1.0,
        }];
        let model = Gms::<1, f64>::try_new(&one, 1.0, sliding, 1e-3, Units::SI).expect("valid");
        let mut state = model.at_rest();
        let mut found = Deviation::default();
        for i in 0..200_000 {
            let velocity = f64::from(i) * 1e-4;
            // Without lag the force in slip is s(v) itself.
            let force = model.step(&mut state, motion(10.0, velocity));
            found.add(
                force / (1.0 - SHARE),
                stribeck.force(velocity) / (1.0 - SHARE),
            );
        }
        println!("exponent {exponent:.1}: {:.2e}", found.max);
        let bound = if exponent < 2.0 { 3.8e-3 } else { 6e-4 };
        assert!(found.max <= bound, "exponent {exponent}: {:e}", found.max);
    }
}

#[test]
fn hsieh_converges_to_the_equations_as_the_tick_shrinks() {
    let path: Vec<Tick> = laws::slow().into_iter().take(3_000).collect();
    let rms_with = |ticks: i32| {
        let params = hsieh(0.0, 500.0);
        let time = SAMPLE_TIME / f64::from(ticks);
        let model = Hsieh::<f64>::try_new(&params, time, Units::SI).expect("Table 2 is valid");
        let mut state = model.at_rest();
        let mut equations = laws::marched(&params);
        let mut found = Deviation::default();
        for &(counts, _) in &path {
            let displacement = f64::from(counts) * COUNT;
            let (expected, _) = equations.advance(displacement, SAMPLE_TIME, 2_000);
            let mut force = 0.0;
            for _ in 0..ticks {
                let motion = Motion::quasi_static(displacement / f64::from(ticks));
                force = model.step(&mut state, motion);
            }
            found.add(force, expected);
        }
        found.rms()
    };
    let [whole, coarse, fine] = [1, 16, 64].map(rms_with);
    println!(
        "\nHsieh: RMS error {whole:.1e} N, {coarse:.1e} N at a 16th of the tick, {fine:.1e} N at a 64th"
    );
    // First order, once the tick is short against the plastic flow.
    assert!(
        coarse < whole / 6.0 && fine < coarse / 3.3,
        "{whole:e} {coarse:e} {fine:e}"
    );
}
