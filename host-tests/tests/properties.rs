//! What must hold whatever the parameters and the motion.

use crate::family;
use crate::laws::{self, built};
use fixed::types::{I0F32, I1F31, I2F30, I4F28, I8F24, I16F16, I16F48, I24F8, I30F2, I32F32};
use preslide::{
    Block, Coulomb, Dahl, Friction, Gms, Hsieh, HsiehParams, LuGre, Motion, QuasiStaticGms, Scalar,
    Sliding, Units,
};
use preslide_host_tests::path::{COUNT, COUNTS, SAMPLE_TIME, motion, random_reversals};
use preslide_host_tests::table3::{BREAKAWAY, blocks, falling, hsieh};
use proptest::prelude::*;

/// A failing case is printed in full; no file of past failures is kept.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

fn quasi_static<const N: usize>() -> QuasiStaticGms<N, f64> {
    QuasiStaticGms::try_new(&blocks::<N>(), BREAKAWAY, Units::SI).expect("Table 3 is valid")
}

fn weakening() -> Sliding {
    falling(0.8 * BREAKAWAY, 500.0)
}

fn gms<const N: usize, S: Scalar>(sliding: Sliding, units: Units) -> Gms<N, S> {
    Gms::try_new(&blocks::<N>(), BREAKAWAY, sliding, SAMPLE_TIME, units).expect("Table 3 is valid")
}

fn dahl() -> Dahl<f64> {
    Dahl::try_new(320_000.0, 0.9, 1.6, Units::SI).expect("Table 2 is valid")
}

fn lugre() -> LuGre<f64> {
    let sliding = Sliding::none(BREAKAWAY);
    LuGre::try_new(195_000.0, 0.0, BREAKAWAY, sliding, Units::SI).expect("Table 2 is valid")
}

/// Forces along displacements, without velocity.
fn forces<M: Friction<Scalar = f64>>(model: &M, displacements: &[f64]) -> Vec<f64> {
    family::forces(model, displacements, 0.0)
}

/// Travels from the end of one leg to the end of the next in `steps` equal steps.
pub(crate) fn in_steps(legs: &[f64], steps: usize) -> Vec<f64> {
    legs.iter()
        .flat_map(|leg| std::iter::repeat_n(leg / steps as f64, steps))
        .collect()
}

/// Out to 10 µm, an inner loop back to 4 µm, and on to 10 µm: force at its two ends.
fn inner_loop<M: Friction<Scalar = f64>>(model: &M) -> (f64, f64) {
    let path = in_steps(&[10e-6, -6e-6, 6e-6], 240);
    let force = forces(model, &path);
    (force[239], force[719])
}

#[test]
fn gms_closes_an_inner_loop_to_rounding() {
    let (start, end) = inner_loop(&quasi_static::<10>());
    assert!((end - start).abs() < 1e-13, "{start} {end}");
    let (start, end) = inner_loop(&gms::<10, f64>(weakening(), Units::SI));
    assert!((end - start).abs() < 1e-13, "{start} {end}");
}

#[test]
fn hsieh_without_creep_closes_an_inner_loop_to_rounding() {
    let model = Hsieh::<f64>::try_new(&hsieh(0.0, 0.0), SAMPLE_TIME, Units::SI).expect("valid");
    let (start, end) = inner_loop(&model);
    assert!((end - start).abs() < 1e-12, "{start} {end}");
}

/// A small loop half way up the virgin curve, where a model without non-local memory is furthest off.
fn small_loop_error<M: Friction<Scalar = f64>>(model: &M) -> f64 {
    let path = in_steps(&[1.5e-6, -1e-6, 1e-6], 100);
    let force = forces(model, &path);
    (force[299] - force[99]).abs()
}

#[test]
fn dahl_and_lugre_leave_an_inner_loop_open() {
    assert!(small_loop_error(&quasi_static::<10>()) < 1e-14);
    let dahl = small_loop_error(&dahl());
    let lugre = small_loop_error(&lugre());
    assert!(dahl > 0.02, "Dahl closes to {dahl} N");
    assert!(lugre > 0.02, "LuGre closes to {lugre} N");
}

#[test]
fn a_reversal_from_slip_unloads_along_the_full_stiffness() {
    let stiffness: f64 = blocks::<6>().iter().map(|block| block.stiffness).sum();
    for sliding in [Sliding::none(BREAKAWAY), weakening()] {
        let model = gms::<6, f64>(sliding, Units::SI);
        let mut state = model.at_rest();
        let mut sliding_force = 0.0;
        for _ in 0..2_000 {
            sliding_force = model.step(&mut state, motion(1e-7, 2e-3));
        }
        assert!(state.slipping().iter().all(|&slips| slips));
        let back = model.step(&mut state, motion(-1e-8, -2e-4));
        assert!(state.slipping().iter().all(|&slips| !slips));
        assert!((sliding_force - back - stiffness * 1e-8).abs() < 1e-12);
    }
}

#[test]
fn gms_slides_at_the_coulomb_force_when_fast_and_breaks_away_at_the_static_force_when_slow() {
    let model = gms::<6, f64>(weakening(), Units::SI);
    let weights: f64 = blocks::<6>().iter().map(|block| block.weight).sum();
    for (velocity, expected) in [(0.1, 0.8 * BREAKAWAY), (0.0, BREAKAWAY)] {
        let mut state = model.at_rest();
        let mut force = 0.0;
        for _ in 0..5_000 {
            force = model.step(&mut state, motion(1e-7, velocity));
        }
        assert!((force - weights * expected).abs() < 1e-9, "{force}");
    }
    let limit = model.limit().expect("GMS has a limit");
    assert!((limit - weights * BREAKAWAY).abs() < 1e-15, "{limit}");
}

#[test]
fn a_tick_without_motion_changes_nothing_in_any_model() {
    for law in laws::all() {
        let model = built::<f64>(&law.models[0], Units::SI).expect("valid");
        let [mut walked, mut rested] = [model.at_rest(), model.at_rest()];
        // Ends going up inside a loop, and going down inside one.
        for leg in [3e-6, -2e-6, 1e-6, -5e-7, 4e-6] {
            for _ in 0..10 {
                let motion = Motion::quasi_static(leg / 10.0);
                let force = model.step(&mut walked, motion);
                assert_eq!(force, model.step(&mut rested, motion), "{}", law.name);
                let again = model.step(&mut rested, Motion::quasi_static(0.0));
                assert_eq!(force, again, "{}", law.name);
            }
        }
    }
}

/// The same of all that a model remembers, where it can be compared.
#[test]
fn a_tick_without_motion_leaves_the_state_as_it_is() {
    fn check<M: Friction<Scalar = f64, State: PartialEq + std::fmt::Debug>>(model: &M) {
        let mut state = model.at_rest();
        for leg in [3e-6, -2e-6, 1e-6, -5e-7] {
            for _ in 0..10 {
                model.step(&mut state, Motion::quasi_static(leg / 10.0));
                let before = state.clone();
                model.step(&mut state, Motion::quasi_static(0.0));
                assert_eq!(before, state);
            }
        }
    }
    check(&quasi_static::<6>());
    check(&gms::<6, f64>(weakening(), Units::SI));
    check(&dahl());
    check(&lugre());
    check(&Hsieh::<f64>::try_new(&hsieh(0.0, 0.0), SAMPLE_TIME, Units::SI).expect("valid"));
}

#[test]
fn gms_without_weakening_equals_the_quasi_static_form_bit_for_bit() {
    for attraction in [0.0, 500.0, f64::INFINITY] {
        let sliding = Sliding {
            attraction,
            ..Sliding::none(BREAKAWAY)
        };
        let full = gms::<10, f64>(sliding, Units::SI);
        let simple = quasi_static::<10>();
        let (mut a, mut b) = (full.at_rest(), simple.at_rest());
        for counts in random_reversals(9, 100_000, 4_000.0, 200.0) {
            let motion = motion(
                f64::from(counts) * COUNT,
                f64::from(counts) * COUNT / SAMPLE_TIME,
            );
            assert_eq!(full.step(&mut a, motion), simple.step(&mut b, motion));
        }
    }
}

#[test]
fn gms_is_stable_for_every_lag_from_none_to_infinite() {
    for attraction in [0.0, 1e-3, 1e3, 1e6, 1e12, 1e300, f64::INFINITY] {
        let sliding = Sliding {
            attraction,
            ..weakening()
        };
        let model = gms::<6, f64>(sliding, Units::SI);
        let limit = model.limit().expect("GMS has a limit");
        let mut state = model.at_rest();
        let mut previous = 0.0;
        for i in 0..10_000 {
            let velocity = if i < 5_000 { 0.0 } else { 0.1 };
            let force = model.step(&mut state, motion(1e-7, velocity));
            assert!(force.abs() <= limit);
            // Rises to the breakaway force, then falls: never rings.
            if i < 5_000 {
                assert!(force >= previous - 1e-15, "C = {attraction}, tick {i}");
            } else {
                assert!(force <= previous + 1e-15, "C = {attraction}, tick {i}");
            }
            previous = force;
        }
    }
}

/// Any `f64`, NaN and infinities included, often enough of the size that matters.
fn any_displacement() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => -1e-4..1e-4_f64,
        2 => any::<f64>(),
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, f64::MAX, f64::MIN, f64::MIN_POSITIVE]),
    ]
}

/// Within its limit after any input; its memory then.
fn drive<M: Friction, T: Copy>(
    model: &M,
    inputs: &[(T, T)],
    number: impl Fn(T) -> M::Scalar,
) -> Result<M::State, TestCaseError> {
    let mut state = model.at_rest();
    for &(displacement, velocity) in inputs {
        let motion = motion(number(displacement), number(velocity));
        let force = model.step(&mut state, motion);
        if let Some(limit) = model.limit() {
            prop_assert!(force.magnitude() <= limit, "|{force:?}| > {limit:?}");
        }
    }
    Ok(state)
}

/// After any input: bounded, and a sane motion gives a finite force again.
fn stays_sound<M: Friction>(
    model: &M,
    inputs: &[(f64, f64)],
    number: impl Fn(f64) -> M::Scalar + Copy,
) -> Result<(), TestCaseError> {
    let mut state = drive(model, inputs, number)?;
    let motion = motion(number(1e-7), number(2e-3));
    let force = model.step(&mut state, motion);
    prop_assert!(force.to_f64().is_finite(), "{force:?}");
    Ok(())
}

/// Every model in one float type.
fn every_model_stays_sound<S: Scalar + Send + 'static>(
    inputs: &[(f64, f64)],
    number: impl Fn(f64) -> S + Copy,
) -> Result<(), TestCaseError> {
    for model in laws::all().iter().flat_map(|law| &law.models) {
        stays_sound(
            &built::<S>(model, Units::SI).expect("valid"),
            inputs,
            number,
        )?;
    }
    for viscous in [0.0, 4_416.0] {
        let coulomb = Coulomb::<S>::try_new(0.9, viscous, Units::SI);
        stays_sound(&coulomb.expect("valid"), inputs, number)?;
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn force_never_exceeds_the_limit_and_no_input_poisons_a_state(
        inputs in prop::collection::vec((any_displacement(), any_displacement()), 1..60),
    ) {
        every_model_stays_sound(&inputs, |value| value)?;
        every_model_stays_sound(&inputs, |value| value as f32)?;
    }

    #[test]
    fn opposite_motion_gives_the_opposite_force(
        path in prop::collection::vec(-2e-5..2e-5_f64, 1..100),
    ) {
        for model in laws::all().iter().flat_map(|law| &law.models) {
            let law = built::<f64>(model, Units::SI).expect("valid");
            let (mut a, mut b) = (law.at_rest(), law.at_rest());
            for &dx in &path {
                let v = dx / SAMPLE_TIME;
                let there = law.step(&mut a, motion(dx, v));
                let back = law.step(&mut b, motion(-dx, -v));
                prop_assert_eq!(there, -back, "{:?}", model);
            }
        }
    }

    #[test]
    fn fixed_point_forces_are_odd_but_for_one_rounding_a_block(
        path in prop::collection::vec(-2_000..2_000_i32, 1..100),
    ) {
        let model = gms::<10, I16F16>(weakening(), COUNTS);
        let (mut a, mut b) = (model.at_rest(), model.at_rest());
        for &counts in &path {
            let dx = I16F16::from_num(counts);
            let v = dx / 10;
            let there = model.step(&mut a, motion(dx, v));
            let back = model.step(&mut b, motion(-dx, -v));
            prop_assert!((there + back).abs() <= I16F16::DELTA * 10);
        }
    }

    #[test]
    fn the_path_after_a_closed_loop_is_as_if_the_loop_had_not_been(
        out in 1e-6..5e-5_f64,
        loops in prop::collection::vec(0.01..1.0_f64, 1..8),
        on in 1e-7..5e-5_f64,
    ) {
        // Wiping out: each loop turns within the one before, back to where it began, then the motion goes on.
        let model = quasi_static::<10>();
        let mut legs = vec![out];
        let mut depths = loops.clone();
        depths.sort_by(f64::total_cmp);
        for depth in &depths {
            legs.extend([-depth * out, depth * out]);
        }
        legs.push(on);
        let looped = forces(&model, &in_steps(&legs, 7));
        let direct = forces(&model, &[out, on]);
        prop_assert!((looped[looped.len() - 1] - direct[1]).abs() < 1e-13);
        // Return-point memory: every closed loop ends at the force that it began at.
        for closed in 1..=depths.len() {
            prop_assert!((looped[7 * (2 * closed + 1) - 1] - direct[0]).abs() < 1e-13);
        }
    }

    #[test]
    fn quasi_static_force_depends_on_the_turning_points_alone(
        legs in prop::collection::vec(1e-8..5e-5_f64, 1..12),
        steps in 2..200_usize,
    ) {
        // Rate independence and exactness: one step a leg, or many.
        let legs: Vec<f64> = legs.iter().enumerate().map(|(i, leg)| if i % 2 == 0 { *leg } else { -leg }).collect();
        let model = quasi_static::<10>();
        let coarse = forces(&model, &legs);
        let fine = forces(&model, &in_steps(&legs, steps));
        for (i, force) in coarse.iter().enumerate() {
            prop_assert!((force - fine[steps * (i + 1) - 1]).abs() < 1e-12);
        }
        // The velocity is not looked at.
        let (mut a, mut b) = (model.at_rest(), model.at_rest());
        for &dx in &legs {
            let fast = motion(dx, 1e3);
            prop_assert_eq!(model.step(&mut a, Motion::quasi_static(dx)), model.step(&mut b, fast));
        }
    }

    #[test]
    fn a_closed_cycle_dissipates_energy(
        before in prop::collection::vec(-2e-5..2e-5_f64, 0..10),
        cycle in prop::collection::vec(-2e-5..2e-5_f64, 1..10),
    ) {
        // The second run of a cycle starts and ends in the same state, so the work done on it is dissipated.
        fn work<M: Friction<Scalar = f64>>(model: &M, before: &[f64], cycle: &[f64]) -> f64 {
            const STEPS: usize = 400;
            let mut legs = before.to_vec();
            let back: f64 = -cycle.iter().sum::<f64>();
            for _ in 0..2 {
                legs.extend(cycle);
                legs.push(back);
            }
            let path = in_steps(&legs, STEPS);
            let force = forces(model, &path);
            let from = path.len() - (cycle.len() + 1) * STEPS;
            (from..path.len()).map(|i| 0.5 * (force[i] + force[i - 1]) * path[i]).sum()
        }
        prop_assert!(work(&quasi_static::<10>(), &before, &cycle) >= -1e-17);
        prop_assert!(work(&gms::<10, f64>(weakening(), Units::SI), &before, &cycle) >= -1e-17);
    }
}

/// Extreme and ordinary values of a fixed point type as raw bits.
fn any_bits() -> impl Strategy<Value = i64> {
    prop_oneof![
        any::<i64>(),
        -2_000_000..2_000_000_i64,
        prop::sample::select(vec![
            i64::MIN,
            i64::MAX,
            i64::from(i32::MIN),
            i64::from(i32::MAX),
            0,
            1,
            -1
        ]),
    ]
}

/// Positive parameters over twelve decades.
fn any_positive() -> impl Strategy<Value = f64> {
    (-6.0..6.0_f64).prop_map(|decades| 10.0_f64.powf(decades))
}

/// Every model that accepts the parameters in this type runs on any input without a panic (overflow checks are
/// on in this profile) and within its limit.
fn fixed_point_is_refused_or_sound<S: Scalar>(
    p: &[f64; 8],
    inputs: &[(i64, i64)],
    number: impl Fn(i64) -> S + Copy,
) -> Result<u32, TestCaseError> {
    let units = Units {
        length: p[0],
        force: p[1],
        velocity: p[2],
    };
    let weight = p[7] / (1.0 + p[7]);
    let two = [
        Block {
            stiffness: p[3],
            weight,
        },
        Block {
            stiffness: p[4],
            weight: 1.0 - weight,
        },
    ];
    let sliding = Sliding {
        coulomb: p[5] / (1.0 + p[6]),
        stribeck_velocity: p[2],
        stribeck_exponent: 1.0 + 3.0 * weight,
        attraction: p[4],
    };
    let mut accepted = 0;
    if let Ok(model) = QuasiStaticGms::<2, S>::try_new(&two, p[5], units) {
        drive(&model, inputs, number)?;
        accepted += 1;
    }
    if let Ok(model) = Gms::<2, S>::try_new(&two, p[5], sliding, 1e-3, units) {
        drive(&model, inputs, number)?;
        accepted += 1;
    }
    for exponent in [0.5, 1.0, 1.6] {
        if let Ok(model) = Dahl::<S>::try_new(p[3], p[5], exponent, units) {
            drive(&model, inputs, number)?;
            accepted += 1;
        }
    }
    for damping in [0.0, p[6]] {
        if let Ok(model) = LuGre::<S>::try_new(p[3], damping, p[5], sliding, units) {
            drive(&model, inputs, number)?;
            accepted += 1;
        }
        if let Ok(model) = Coulomb::<S>::try_new(p[5], damping, units) {
            drive(&model, inputs, number)?;
            accepted += 1;
        }
    }
    let params = HsiehParams {
        k1: p[3],
        k2: p[4],
        beta: 1.0 / p[0],
        viscous: p[6],
        creep: p[7],
        hardening: p[5],
        hardening_exponent: 1.0 + weight,
    };
    if let Ok(model) = Hsieh::<S>::try_new(&params, 1e-3, units) {
        drive(&model, inputs, number)?;
        accepted += 1;
    }
    Ok(accepted)
}

/// Parameters of order one in their own units, so that narrow types accept some.
fn near_one() -> impl Strategy<Value = f64> {
    (-1.5..1.5_f64).prop_map(|decades| 10.0_f64.powf(decades))
}

proptest! {
    #![proptest_config(cases(2_000))]

    #[test]
    fn fixed_point_never_panics_and_keeps_its_limit(
        wide in prop::array::uniform8(any_positive()),
        narrow in prop::array::uniform8(near_one()),
        inputs in prop::collection::vec((any_bits(), any_bits()), 1..40),
    ) {
        for p in [&wide, &narrow] {
            fixed_point_is_refused_or_sound(p, &inputs, |b| I16F16::from_bits(b as i32))?;
            fixed_point_is_refused_or_sound(p, &inputs, |b| I8F24::from_bits(b as i32))?;
            fixed_point_is_refused_or_sound(p, &inputs, |b| I24F8::from_bits(b as i32))?;
            fixed_point_is_refused_or_sound(p, &inputs, |b| I4F28::from_bits(b as i32))?;
            fixed_point_is_refused_or_sound(p, &inputs, |b| I2F30::from_bits(b as i32))?;
            fixed_point_is_refused_or_sound(p, &inputs, |b| I1F31::from_bits(b as i32))?;
            fixed_point_is_refused_or_sound(p, &inputs, |b| I0F32::from_bits(b as i32))?;
            fixed_point_is_refused_or_sound(p, &inputs, |b| I30F2::from_bits(b as i32))?;
            fixed_point_is_refused_or_sound(p, &inputs, I32F32::from_bits)?;
            fixed_point_is_refused_or_sound(p, &inputs, I16F48::from_bits)?;
        }
    }
}

#[test]
fn the_fixed_point_property_reaches_every_model() {
    // Otherwise the property above could hold because everything is refused.
    let p = [1.0, 1.0, 1.0, 2.0, 1.0, 3.0, 0.5, 1.0];
    let inputs = [(65_536, 65_536), (-65_536, 0)];
    let accepted = fixed_point_is_refused_or_sound(&p, &inputs, |b| I16F16::from_bits(b as i32))
        .expect("sound");
    assert_eq!(accepted, 10);
}
