//! The lumped law against the law block by block, and against `f64`.

use super::reference::*;
use preslide::kernels::{CountGms, LumpedCountGms, LumpedGms};
use preslide::{Block, Friction, Gms, Motion, Sliding, Units};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Any law: stiffnesses over three decades, any weights, Stribeck effects from none to strong, lags from none to long.
fn any_law<const N: usize>(random: &mut ChaCha8Rng) -> ([Block; N], Sliding) {
    let parts: [f64; N] = std::array::from_fn(|_| random.random_range(0.1..1.0));
    let sum: f64 = parts.iter().sum();
    let blocks = parts.map(|part| {
        let yields = 10_f64.powf(random.random_range(-6.5..-3.5));
        let weight = part / sum;
        Block {
            stiffness: weight * BREAKAWAY / yields,
            weight,
        }
    });
    let sliding = Sliding {
        coulomb: BREAKAWAY * [1.0, random.random_range(0.2..1.0)][random.random_range(0..2)],
        stribeck_velocity: 10_f64.powf(random.random_range(-4.0..-2.0)),
        stribeck_exponent: random.random_range(1.0..4.0),
        attraction: [
            0.0,
            f64::INFINITY,
            10_f64.powf(random.random_range(0.0..4.0)),
        ][random.random_range(0..3)],
    };
    (blocks, sliding)
}

/// A displacement (m) and a velocity (m/s): strokes from a tremor to a traverse, turned at random, with rests.
fn any_motion(random: &mut ChaCha8Rng, speed: &mut f64) -> (f64, f64) {
    match random.random_range(0..200) {
        0..8 => *speed = -*speed,
        8 => *speed = 10_f64.powf(random.random_range(-6.0..-1.0)),
        9..12 => return (0.0, 0.0),
        12..20 => return (0.0, *speed),
        20 => return (random.random_range(-1e-3..1e-3), *speed),
        _ => {}
    }
    (*speed * SAMPLE_TIME * random.random_range(0.5..1.5), *speed)
}

fn equals_the_law_block_by_block<const N: usize>() {
    let mut most = 0.0_f64;
    for seed in 0..40 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (blocks, sliding) = any_law::<N>(&mut random);
        let reference =
            Gms::<N, f64>::try_new(&blocks, BREAKAWAY, sliding, SAMPLE_TIME, Units::SI).unwrap();
        let lumped =
            LumpedGms::<N, f64>::try_new(&blocks, BREAKAWAY, sliding, SAMPLE_TIME, Units::SI)
                .unwrap();
        let (mut expected, mut state) = (reference.at_rest(), lumped.at_rest());
        let mut speed = 1e-4;
        for step in 0..STEPS / 40 {
            let (displacement, velocity) = any_motion(&mut random, &mut speed);
            let motion = Motion {
                displacement,
                velocity,
            };
            let force = lumped.step(&mut state, motion);
            let error = (force - reference.step(&mut expected, motion)).abs();
            assert!(
                error < 1e-9 * BREAKAWAY,
                "N = {N}, seed {seed}, step {step}: {error} N apart"
            );
            most = most.max(error);
        }
    }
    println!("N = {N}: at most {most:.1e} N from the law block by block");
}

/// In `f64`, with rounding out of the way, over random laws and motions.
#[test]
fn spring_and_slider_are_the_law_block_by_block() {
    equals_the_law_block_by_block::<1>();
    equals_the_law_block_by_block::<2>();
    equals_the_law_block_by_block::<3>();
    equals_the_law_block_by_block::<4>();
    equals_the_law_block_by_block::<6>();
    equals_the_law_block_by_block::<10>();
    equals_the_law_block_by_block::<32>();
}

fn in_counts<const N: usize>(sliding: Sliding) -> (LumpedCountGms<N>, Units) {
    let blocks = blocks::<N>();
    let units = counts(LumpedCountGms::finest_force(&blocks, BREAKAWAY, COUNT));
    let gms = LumpedCountGms::try_new(&blocks, BREAKAWAY, sliding, SAMPLE_TIME, units);
    (gms.unwrap(), units)
}

fn in_f32<const N: usize>(sliding: Sliding) -> LumpedGms<N> {
    LumpedGms::try_new(&blocks(), BREAKAWAY, sliding, SAMPLE_TIME, Units::SI).unwrap()
}

fn against_f64<const N: usize>() {
    let blocks = blocks::<N>();
    let (kernel, units) = in_counts::<N>(SLIDING);
    let mut exact = Exact::new(&blocks);
    errors(&kernel, units, |dx, v| exact.step(dx, v))
        .check(&format!("lumped_i32 N = {N}"), [0.01, 0.004, 0.0002]);
    let mut exact = Exact::new(&blocks);
    errors(&in_f32::<N>(SLIDING), Units::SI, |dx, v| exact.step(dx, v))
        .check(&format!("lumped_f32 N = {N}"), [0.01, 0.004, 0.0002]);
    let gms = Gms::<N>::try_new(&blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, Units::SI).unwrap();
    let mut exact = Exact::new(&blocks);
    errors(&gms, Units::SI, |dx, v| exact.step(dx, v))
        .check(&format!("gms_f32 N = {N}"), [0.01, 0.004, 0.0002]);
}

#[test]
fn in_counts_and_in_f32_it_stays_within_its_bounds_of_the_f64_reference() {
    against_f64::<1>();
    against_f64::<2>();
    against_f64::<3>();
    against_f64::<4>();
    against_f64::<6>();
    against_f64::<8>();
    against_f64::<10>();
}

/// Ten million ticks: sums that are carried on could drift. Errors of the first and of the last million against `f64`, beside those of
/// the law block by block in the same numbers, which carries no sum: its bias over a window is the motion's and the table's.
#[test]
fn nothing_drifts_over_ten_million_ticks() {
    const LONG: usize = 10_000_000;
    let blocks = blocks::<6>();
    let (whole, units) = in_counts::<6>(SLIDING);
    let float = in_f32::<6>(SLIDING);
    let force = CountGms::finest_force(&blocks, BREAKAWAY, COUNT);
    let by_block_units = counts(force);
    let whole_by_block =
        CountGms::try_new(&blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, by_block_units).unwrap();
    let float_by_block =
        Gms::<6>::try_new(&blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, Units::SI).unwrap();
    let (mut a, mut b) = (whole.at_rest(), float.at_rest());
    let (mut c, mut d) = (whole_by_block.at_rest(), float_by_block.at_rest());
    let mut exact = Exact::new(&blocks);
    let mut found: [[Errors; 4]; 2] = Default::default();
    for (step, (dx, speed)) in strokes(2).take(LONG).enumerate() {
        let velocity = speed * COUNT / SAMPLE_TIME;
        let counted = motion(dx, velocity, units);
        let in_metres = motion(dx, velocity, Units::SI);
        let forces = [
            f64::from(whole.step(&mut a, counted).to_bits()) * units.force,
            f64::from(float.step(&mut b, in_metres)),
            f64::from(whole_by_block.step(&mut c, counted).to_bits()) * force,
            f64::from(float_by_block.step(&mut d, in_metres)),
        ];
        let expected = exact.step(f64::from(dx) * COUNT, velocity);
        let window = match step {
            0..STEPS => 0,
            _ if step >= LONG - STEPS => 1,
            _ => continue,
        };
        for (errors, force) in found[window].iter_mut().zip(forces) {
            errors.add(force - expected);
        }
    }
    for (errors, window) in found.iter().zip(["first", "last"]) {
        let names = ["lumped_i32", "lumped_f32", "gms_i32", "gms_f32"];
        let mut biases = [0.0; 4];
        for ((kernel, name), bias) in errors.iter().zip(names).zip(&mut biases) {
            *bias = kernel.check(&format!("{name}, {window} million"), [0.01, 0.004, 0.0005]);
        }
        for (lumped, by_block) in [(0, 2), (1, 3)] {
            let apart = biases[lumped] - biases[by_block];
            assert!(apart.abs() < 1e-4, "{} million: {apart} %", window);
        }
    }
}

/// Ten million ticks without an event, at the rest that a loop of control trembles about: in counts every tick of the loop has the same
/// bits ever after; in `f32` the travel drifts as a block's deflection does.
#[test]
fn a_tremor_without_events_is_a_spring_forever() {
    let tremor = [1, 2, -1, 3, -4, -3, 2, 0, -1, 1];
    let (whole, units) = in_counts::<6>(SLIDING);
    let mut state = whole.at_rest();
    let mut round = || {
        tremor.map(|dx| {
            let motion = motion(dx, f64::from(dx) * COUNT / SAMPLE_TIME, units);
            whole.step(&mut state, motion).to_bits()
        })
    };
    let first = round();
    for _ in 0..STEPS {
        assert_eq!(round(), first);
    }

    fn run<K: Friction<Scalar = f32>>(kernel: &K, tremor: &[i32]) -> f64 {
        let mut state = kernel.at_rest();
        let mut force = 0.0;
        for _ in 0..STEPS {
            for dx in tremor {
                let velocity = f64::from(*dx) * COUNT / SAMPLE_TIME;
                force = kernel.step(&mut state, motion(*dx, velocity, Units::SI));
            }
        }
        f64::from(force)
    }
    let gms = Gms::<6>::try_new(&blocks(), BREAKAWAY, SLIDING, SAMPLE_TIME, Units::SI).unwrap();
    let percent = |force: f64| 100.0 * force.abs() / BREAKAWAY;
    let lumped = percent(run(&in_f32::<6>(SLIDING), &tremor));
    let by_block = percent(run(&gms, &tremor));
    println!("after ten million ticks: lumped_f32 {lumped:.5} %, gms_f32 {by_block:.5} % of F_s");
    assert!(lumped <= by_block + 0.001, "{lumped} % > {by_block} %");
}

#[test]
fn no_input_takes_it_beyond_its_limit() {
    let (whole, _) = in_counts::<6>(SLIDING);
    let float = in_f32::<6>(SLIDING);
    let breakaway = BREAKAWAY as f32 * (1.0 + 1e-5);
    let limits = (whole.limit().unwrap(), float.limit().unwrap());
    assert!(limits.1 <= breakaway, "{} N", limits.1);
    let mut states = (whole.at_rest(), float.at_rest());
    let mut random = ChaCha8Rng::seed_from_u64(4);
    for step in 0..STEPS {
        let displacement = any_displacement(&mut random);
        let velocity = match random.random_range(0..20) {
            0 => [i32::MIN, i32::MAX, 0, 1][random.random_range(0..4)],
            _ => random.random_range(-100_000..=100_000),
        };
        let in_counts = Motion {
            displacement: super::reference::whole(displacement),
            velocity: super::reference::whole(velocity),
        };
        let force = whole.step(&mut states.0, in_counts);
        assert!(force.abs() <= limits.0, "step {step}: {force}");

        let strange = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MAX,
            -1e30,
            0.0,
        ];
        let mut any = |value: f32| match random.random_range(0..200) {
            0 => strange[random.random_range(0..strange.len())],
            _ => value,
        };
        let in_metres = Motion {
            displacement: any(displacement as f32 * COUNT as f32),
            velocity: any(velocity as f32 * 1e-7),
        };
        let force = float.step(&mut states.1, in_metres);
        assert!(
            force.abs() <= limits.1,
            "step {step}: {in_metres:?}: {force}"
        );
    }
}

/// After a long slide all blocks stick again when the motion turns: the force falls by `ΣW − Σk·x`, and by twice of it at the end.
#[test]
fn a_turn_while_all_slip_sticks_them_again() {
    let (gms, units) = in_counts::<6>(Sliding::none(BREAKAWAY));
    let mut state = gms.at_rest();
    let mut go = |counts: i32| {
        let force = gms.step(&mut state, motion(counts, 0.0, units)).to_bits();
        f64::from(force) * units.force
    };
    for _ in 0..1_000 {
        go(20);
    }
    assert!((go(20) - BREAKAWAY).abs() < 1e-5 * BREAKAWAY);
    let stiffness: f64 = blocks::<6>().iter().map(|block| block.stiffness).sum();
    for back in 1..=10 {
        let expected = BREAKAWAY - stiffness * f64::from(back) * COUNT;
        let force = go(-1);
        assert!(
            (force - expected).abs() < 1e-5 * BREAKAWAY,
            "{back}: {force} N"
        );
    }
    assert!((go(-10_000) + BREAKAWAY).abs() < 1e-5 * BREAKAWAY);
}

/// The rounding is that of where the last event lay, a few units of force: it does not grow with the number of loops.
#[test]
fn a_loop_closes_and_its_inside_is_wiped_out_after_any_number_of_events() {
    let (gms, units) = in_counts::<4>(Sliding::none(BREAKAWAY));
    let mut state = gms.at_rest();
    let mut go = |counts: i32| gms.step(&mut state, motion(counts, 0.0, units)).to_bits();
    go(1_000);
    go(-700);
    let outer = go(300);
    for round in 0..100_000 {
        go(-150);
        go(50);
        go(-30);
        let closed = go(130);
        assert!(
            (closed - outer).abs() <= 8,
            "round {round}: {closed}, {outer}"
        );
    }
}

#[test]
fn what_lies_outside_its_range_is_refused_with_its_name() {
    let message = |blocks: &[Block; 2], units| {
        LumpedCountGms::try_new(blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, units)
            .unwrap_err()
            .to_string()
    };
    let block = |stiffness| Block {
        stiffness,
        weight: 0.5,
    };
    let apart = message(&[block(1e8), block(1e3)], counts(1e-3));
    assert!(apart.contains("over the smallest"), "{apart}");
    let long = message(&[block(10.0), block(15.0)], counts(1e-3));
    assert!(long.contains("in units of length"), "{long}");
    let coarse = Units {
        velocity: 1e-3,
        ..counts(1e-6)
    };
    let coarse = message(&blocks(), coarse);
    assert!(coarse.contains("unit of velocity"), "{coarse}");
    let fine = message(&blocks(), counts(1e-11));
    assert!(fine.contains("block 1"), "{fine}");
}
