//! Kernels in a controller's units: what they are given of a smooth motion, their error, and what they refuse.
//!
//! The references are the law in `f64`, and the bare kernel given whole units of an exact position.

use super::reference::*;
use fixed::types::I16F16;
use preslide::kernels::{CountGms, PackedSlipReserve, Scaled, SlipReserve};
use preslide::{Block, Friction, Motion, ParamError, Scalar, Units};
use preslide_host_tests::deviation::Deviation;
use preslide_host_tests::path::{COUNTS, motion};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Displacements (2⁻¹⁶ counts) of a reference: strokes at 4 nm/s to 16 mm/s, with rests and stops at any fraction of a count.
fn smooth(seed: u64) -> impl Iterator<Item = i32> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (mut left, mut speed) = (0_u32, 0_i32);
    std::iter::from_fn(move || {
        if left == 0 {
            let magnitude = 2_f64.powf(random.random_range(-0.9..21.0));
            let travel = 65536.0 * random.random_range(1.0..3_000.0);
            left = ((travel / magnitude) as u32).clamp(1, 20_000);
            let direction = -f64::from(speed.signum() | 1);
            speed = (direction * magnitude).round() as i32 * i32::from(!random.random_ratio(1, 9));
        }
        left -= 1;
        Some(speed)
    })
}

fn tick<S: Scalar>(q16: i32, units: Units) -> Motion<S> {
    let metres = f64::from(q16) / 65536.0 * COUNT;
    let scalar = |value| S::try_from_f64(value).expect("a motion that fits");
    motion(
        scalar(metres / units.length),
        scalar(metres / SAMPLE_TIME / units.velocity),
    )
}

/// Runs a model and a reference, which takes metres and metres per second, along [`smooth`].
fn smooth_errors<K: Friction>(
    model: Result<K, ParamError>,
    units: Units,
    mut reference: impl FnMut(f64, f64) -> f64,
) -> Deviation {
    let model = model.expect("in range");
    let mut state = model.at_rest();
    let mut errors = Deviation::default();
    for q16 in smooth(1).take(STEPS) {
        let force = model.step(&mut state, tick(q16, units)).to_f64() * units.force;
        let metres = f64::from(q16) / 65536.0 * COUNT;
        errors.add(force, reference(metres, metres / SAMPLE_TIME));
    }
    errors
}

/// Half a unit of 3.7 nm (50 µm are 2¹⁴ of fewer) is 0.2 % of the shortest D, 1 µm, which bears up to 0.4 of `F_s`: 0.08 %, and twice that
/// behind a reversal; as much again comes from the path, and of the stiffnesses, the softest of which are 80 to 160 units.
const QUASI_STATIC: [f64; 3] = [0.5, 0.1, 0.02];

fn laws_along_a_smooth_reference<const N: usize, const PAIRS: usize>() {
    let blocks = blocks::<N>();
    let float = Scaled::<PackedSlipReserve<PAIRS>, f32>::try_new(&blocks, BREAKAWAY, Units::SI);
    let found = smooth_errors(float, Units::SI, quasi_static::<N>());
    check(&found, &format!("packed f32 N = {N}"), QUASI_STATIC);
    let fixed = Scaled::<PackedSlipReserve<PAIRS>, I16F16>::try_new(&blocks, BREAKAWAY, COUNTS);
    let found = smooth_errors(fixed, COUNTS, quasi_static::<N>());
    check(&found, &format!("packed I16F16 N = {N}"), QUASI_STATIC);
    let plain = Scaled::<SlipReserve<N>, I16F16>::try_new(&blocks, BREAKAWAY, COUNTS);
    let found = smooth_errors(plain, COUNTS, quasi_static::<N>());
    check(
        &found,
        &format!("slip reserve I16F16 N = {N}"),
        QUASI_STATIC,
    );
    // A whole unit ahead, of 1 µm at N > 1: 0.3 %, and what slips a unit early by that has its lag begin earlier.
    let exact =
        Scaled::<CountGms<N>, I16F16>::try_new(&blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, COUNTS);
    let found = smooth_errors(exact, COUNTS, full(&blocks));
    check(
        &found,
        &format!("count gms I16F16 N = {N}"),
        [0.5, 0.2, 0.03],
    );
}

#[test]
fn a_smooth_reference_gives_the_laws_force_at_every_speed() {
    laws_along_a_smooth_reference::<1, 1>();
    laws_along_a_smooth_reference::<4, 2>();
    laws_along_a_smooth_reference::<7, 4>();
    laws_along_a_smooth_reference::<10, 5>();
}

/// In fixed point the kernel gets the nearest whole unit of the exact position, whatever the way there: nothing is lost in 10⁶ ticks.
#[test]
fn a_path_in_fixed_point_is_exact_to_the_bit() {
    let blocks = blocks::<6>();
    let scaled = Scaled::<PackedSlipReserve<3>, I16F16>::try_new(&blocks, BREAKAWAY, COUNTS);
    let scaled = scaled.expect("in range");
    // The largest D is 2000 counts: eighths of a count are the finest unit in which it stays below 2¹⁴.
    let finest = PackedSlipReserve::<3>::finest_force(&blocks, BREAKAWAY, COUNT / 8.0);
    let places = (COUNTS.force / finest).log2().floor() as i32;
    let units = Units {
        length: COUNT / 8.0,
        force: COUNTS.force / 2_f64.powi(places),
        velocity: 1.0,
    };
    let bare = PackedSlipReserve::<3>::try_new(&blocks, BREAKAWAY, units).expect("in range");
    let (mut state, mut bare_state) = (scaled.at_rest(), bare.at_rest());
    let (mut position, mut given) = (0_i64, 0_i64);
    for (step, q16) in smooth(7).take(STEPS).enumerate() {
        position += 8 * i64::from(q16);
        let nearest = (position + 0x8000).div_euclid(0x1_0000);
        let dx = (nearest - given) as i32;
        given = nearest;
        let force = scaled.step(&mut state, Motion::quasi_static(I16F16::from_bits(q16)));
        let wanted = bare.step(&mut bare_state, Motion::quasi_static(whole(dx)));
        let wanted = i64::from(wanted.to_bits()) << 16 >> places;
        assert_eq!(
            i64::from(force.to_bits()),
            wanted,
            "step {step}, {dx} units"
        );
    }
}

/// In floats each tick is rounded towards 0, to 2⁻¹⁶ units, 3 nm of them here: a million ticks of the same 0.02 pm, which are a third of
/// that, keep their path to that a tick, and coming back leaves no force.
#[test]
fn a_float_path_is_kept_to_its_rounding() {
    let blocks = blocks::<4>();
    let packed = Scaled::<PackedSlipReserve<2>, f32>::try_new(&blocks, BREAKAWAY, Units::SI);
    let packed = packed.expect("in range");
    let unit = 2_f64.powi(-28); // 3.7 nm: the finest in which 50 µm are fewer than 2¹⁴
    let stiffness: f64 = blocks.iter().map(|b| b.stiffness).sum();
    for per_tick in [2e-14_f32, 1e-13, 7.3e-13] {
        let mut state = packed.at_rest();
        let mut go = |dx: f32| {
            let mut force = 0.0;
            for _ in 0..STEPS {
                force = packed.step(&mut state, Motion::quasi_static(dx));
            }
            f64::from(force)
        };
        let force = go(per_tick);
        let exact = stiffness * f64::from(per_tick) * STEPS as f64;
        let bound = stiffness * unit * (0.5 + STEPS as f64 / 65_536.0);
        assert!(
            (force - exact).abs() <= bound,
            "{per_tick:e}: {force} N, exact {exact} N"
        );
        assert_eq!(go(-per_tick), 0.0, "{per_tick:e}");
    }
}

#[test]
fn no_input_corrupts_the_state_or_exceeds_the_limit() {
    let blocks = blocks::<5>();
    let packed = Scaled::<PackedSlipReserve<3>, f32>::try_new(&blocks, BREAKAWAY, Units::SI);
    let packed = packed.expect("in range");
    let limit = packed.limit().expect("bounded");
    assert!((f64::from(limit) - BREAKAWAY).abs() < 1e-3 * BREAKAWAY);
    let mut state = packed.at_rest();
    let mut random = ChaCha8Rng::seed_from_u64(11);
    for _ in 0..STEPS {
        let dx = match random.random_range(0..10) {
            0 => [
                f32::NAN,
                f32::INFINITY,
                f32::NEG_INFINITY,
                f32::MAX,
                f32::MIN,
            ][random.random_range(0..5)],
            1 => random.random_range(-1.0..1.0),
            _ => random.random_range(-1e-5..1e-5),
        };
        let force = packed.step(&mut state, motion(dx, dx));
        assert!(force.abs() <= limit, "{dx}: {force} beyond {limit}");
    }
    // A long way slips every block: what was before is forgotten.
    assert_eq!(packed.step(&mut state, Motion::quasi_static(1.0)), limit);
    assert_eq!(packed.step(&mut state, Motion::quasi_static(-1.0)), -limit);
}

#[test]
fn what_no_unit_resolves_is_refused_by_name() {
    let two = |stiffness: [f64; 2]| {
        stiffness.map(|stiffness| Block {
            stiffness,
            weight: 0.5,
        })
    };
    let refused = |blocks: &[Block; 2], breakaway: f64, units| {
        let float = Scaled::<PackedSlipReserve<1>, f32>::try_new(blocks, breakaway, units);
        float.expect_err("out of range").to_string()
    };
    // D of 450 µm beside 0.46 µm: the short one is 15.6 units of those of which the long one is 16 383.
    let error = refused(&two([0.97e6, 1e3]), 0.9, Units::SI);
    assert!(error.contains("yield displacement of block 1"), "{error}");
    assert!(error.contains("more than 1 % off"), "{error}");
    // D that take more counts than fit; in metres they fit.
    let far = two([10.0, 5.0]);
    let error = refused(&far, 0.9, COUNTS);
    assert!(
        error.contains("yield displacement of block 1") && error.contains("16383"),
        "{error}"
    );
    assert!(Scaled::<PackedSlipReserve<1>, f32>::try_new(&far, 0.9, Units::SI).is_ok());
    let error = refused(&two([1e5, f64::NAN]), 0.9, Units::SI);
    assert!(error.contains("stiffness of block 2"), "{error}");
    let error = refused(&two([1e5, 1e4]), f64::INFINITY, Units::SI);
    assert!(error.contains("breakaway force"), "{error}");
    let fine = Units {
        force: 1e-6,
        ..COUNTS
    };
    let error = Scaled::<SlipReserve<2>, I16F16>::try_new(&two([1e5, 1e4]), 0.9, fine);
    assert!(
        error
            .expect_err("900 000 µN")
            .to_string()
            .contains("breakaway force")
    );
    let slow = preslide::Sliding {
        stribeck_velocity: -1.0,
        ..SLIDING
    };
    let error =
        Scaled::<CountGms<2>, f32>::try_new(&two([1e5, 1e4]), 0.9, slow, SAMPLE_TIME, Units::SI);
    assert!(
        error
            .expect_err("negative")
            .to_string()
            .contains("Stribeck velocity")
    );
}

/// Equal parameters keep the memory; others of the same unit of length keep what of it the kernel keeps, and the fraction.
#[test]
fn equal_parameters_take_the_memory_over() {
    let blocks = blocks::<4>();
    let of = |breakaway| {
        Scaled::<PackedSlipReserve<2>, f32>::try_new(&blocks, breakaway, Units::SI)
            .expect("in range")
    };
    let model = of(BREAKAWAY);
    let mut state = model.at_rest();
    for q16 in smooth(3).take(50_000) {
        model.step(&mut state, tick(q16, Units::SI));
    }
    assert_eq!(of(BREAKAWAY).take_over(&model, &state), state);
    assert_ne!(state, model.at_rest());
    let other = of(0.5 * BREAKAWAY);
    assert_eq!(other.take_over(&model, &state), other.at_rest());
    model.release(&mut state);
    assert_eq!(state, model.at_rest());
}
