//! The whole-number kernels: those of one law against each other bit for bit, each law against `f64`.
//!
//! The references are written from the equations and share no code with the kernels.

mod exhaustive;
mod reference;
mod scaled;

use preslide::kernels::{CountGms, PackedSlipReserve, SlipReserve};
use preslide::{Block, Friction, Motion, Units};
use preslide_host_tests::path::motion;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use reference::*;

/// `z ← clamp(z + dx, −D, D)`, `F = Σ k·z` in 64-bit integers, `D` in counts and `k` from `W = k·D`.
struct Clamped(Vec<[i64; 3]>);

impl Clamped {
    fn new(blocks: &[Block], units: Units) -> Self {
        let integers = |block: &Block| {
            let breakaway = block.weight * BREAKAWAY;
            let yields = (breakaway / block.stiffness / units.length).round();
            [
                0,
                yields as i64,
                (breakaway / units.force / yields).round() as i64,
            ]
        };
        Self(blocks.iter().map(integers).collect())
    }

    fn step(&mut self, dx: i32) -> i64 {
        let mut force = 0;
        for [z, yields, stiffness] in &mut self.0 {
            *z = (*z + i64::from(dx)).clamp(-*yields, *yields);
            force += *stiffness * *z;
        }
        force
    }
}

fn slip_reserve_kernels_agree<const N: usize, const PAIRS: usize>() {
    let blocks = blocks::<N>();
    let units = counts(PackedSlipReserve::<PAIRS>::finest_force(
        &blocks, BREAKAWAY, COUNT,
    ));
    let plain = SlipReserve::try_new(&blocks, BREAKAWAY, units).unwrap();
    let packed = PackedSlipReserve::<PAIRS>::try_new(&blocks, BREAKAWAY, units).unwrap();
    let mut reference = Clamped::new(&blocks, units);
    let mut states = (plain.at_rest(), packed.at_rest());
    let mut random = ChaCha8Rng::seed_from_u64(N as u64);
    let limit = i64::from(plain.limit().unwrap().to_bits());
    for step in 0..STEPS {
        let dx = any_displacement(&mut random);
        let motion = Motion::quasi_static(whole(dx));
        let force = reference.step(dx);
        let found = [
            plain.step(&mut states.0, motion),
            packed.step(&mut states.1, motion),
        ];
        let found = found.map(|force| i64::from(force.to_bits()));
        assert_eq!(found, [force; 2], "N = {N}, step {step}, dx = {dx}");
        assert!(
            force.abs() <= limit,
            "N = {N}, step {step}: |{force}| > {limit}"
        );
    }
}

#[test]
fn slip_reserve_kernels_agree_bit_for_bit_with_the_clamped_form() {
    slip_reserve_kernels_agree::<1, 1>();
    slip_reserve_kernels_agree::<2, 1>();
    slip_reserve_kernels_agree::<3, 2>();
    slip_reserve_kernels_agree::<4, 2>();
    slip_reserve_kernels_agree::<5, 3>();
    slip_reserve_kernels_agree::<6, 3>();
    slip_reserve_kernels_agree::<7, 4>();
    slip_reserve_kernels_agree::<8, 4>();
    slip_reserve_kernels_agree::<9, 5>();
    slip_reserve_kernels_agree::<10, 5>();
}

fn laws_against_f64<const N: usize, const PAIRS: usize>() {
    let blocks = blocks::<N>();
    let units = counts(SlipReserve::<N>::finest_force(&blocks, BREAKAWAY, COUNT));
    let kernel = SlipReserve::try_new(&blocks, BREAKAWAY, units).unwrap();
    let found = errors(&kernel, units, quasi_static::<N>());
    check(&found, &format!("slip reserve N = {N}"), [0.4, 0.1, 0.003]);

    let units = counts(PackedSlipReserve::<PAIRS>::finest_force(
        &blocks, BREAKAWAY, COUNT,
    ));
    let kernel = PackedSlipReserve::<PAIRS>::try_new(&blocks, BREAKAWAY, units).unwrap();
    let found = errors(&kernel, units, quasi_static::<N>());
    check(&found, &format!("packed N = {N}"), [0.4, 0.1, 0.003]);

    let units = counts(CountGms::<N>::finest_force(&blocks, BREAKAWAY, COUNT));
    let kernel = CountGms::try_new(&blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, units).unwrap();
    let found = errors(&kernel, units, full(&blocks));
    check(&found, &format!("count gms N = {N}"), [0.01, 0.004, 0.0002]);
}

#[test]
fn every_law_stays_within_its_bounds_of_the_f64_reference() {
    laws_against_f64::<1, 1>();
    laws_against_f64::<2, 1>();
    laws_against_f64::<3, 2>();
    laws_against_f64::<4, 2>();
    laws_against_f64::<5, 3>();
    laws_against_f64::<6, 3>();
    laws_against_f64::<7, 4>();
    laws_against_f64::<8, 4>();
    laws_against_f64::<9, 5>();
    laws_against_f64::<10, 5>();
}

#[test]
fn no_input_takes_the_exact_kernel_beyond_its_limit() {
    let blocks = blocks::<6>();
    let units = counts(CountGms::<6>::finest_force(&blocks, BREAKAWAY, COUNT));
    let gms = CountGms::try_new(&blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, units).unwrap();
    let limit = gms.limit().unwrap();
    let mut state = gms.at_rest();
    let mut random = ChaCha8Rng::seed_from_u64(3);
    for step in 0..STEPS {
        let displacement = whole(any_displacement(&mut random));
        let velocity = match random.random_range(0..20) {
            0 => whole([i32::MIN, i32::MAX, 0, 1][random.random_range(0..4)]),
            _ => whole(random.random_range(-100_000..=100_000)),
        };
        let force = gms.step(&mut state, motion(displacement, velocity));
        assert!(force.abs() <= limit, "step {step}: {force} beyond {limit}");
    }
}

#[test]
fn a_loop_closes_and_its_inside_is_wiped_out_after_any_number_of_steps() {
    let blocks = blocks::<4>();
    let units = counts(SlipReserve::<4>::finest_force(&blocks, BREAKAWAY, COUNT));
    let gms = SlipReserve::try_new(&blocks, BREAKAWAY, units).unwrap();
    let mut state = gms.at_rest();
    let mut go = |counts: i32| gms.step(&mut state, Motion::quasi_static(whole(counts)));
    go(1_000);
    go(-700);
    let outer = go(300);
    for _ in 0..100_000 {
        go(-150);
        go(50);
        go(-30);
        assert_eq!(go(130), outer);
    }
}

#[test]
fn what_lies_outside_a_kernels_range_is_refused_with_its_name() {
    let soft = [Block {
        stiffness: 10.0,
        weight: 1.0,
    }]; // D = 90 mm
    let message = |error: preslide::ParamError| error.to_string();
    let packed = PackedSlipReserve::<1>::try_new(&soft, BREAKAWAY, counts(1e-6)).unwrap_err();
    assert!(
        message(packed).contains("yield displacement of block 1"),
        "{packed}"
    );
    assert!(SlipReserve::try_new(&soft, BREAKAWAY, counts(1e-9)).is_ok());

    let stiff = [Block {
        stiffness: 1e9,
        weight: 1.0,
    }]; // D = 0.9 nm, less than half a count
    let error = SlipReserve::try_new(&stiff, BREAKAWAY, counts(1e-9)).unwrap_err();
    assert!(message(error).contains("rounds to zero"), "{error}");

    let fine = SlipReserve::try_new(&blocks::<3>(), BREAKAWAY, counts(1e-12)).unwrap_err();
    assert!(message(fine).contains("stiffness of block 1"), "{fine}");
    let sum = SlipReserve::try_new(&blocks::<3>(), BREAKAWAY, counts(6e-10)).unwrap_err();
    assert!(message(sum).contains("breakaway force"), "{sum}");

    let exact = |blocks: &[Block; 2], units| {
        CountGms::try_new(blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, units)
    };
    let apart = [
        Block {
            stiffness: 1e7,
            weight: 0.5,
        },
        Block {
            stiffness: 10.0,
            weight: 0.5,
        },
    ];
    let error = exact(&apart, counts(1e-3)).unwrap_err();
    assert!(message(error).contains("yield displacement"), "{error}");
    let coarse = Units {
        velocity: 1e-3,
        ..counts(1e-6)
    };
    let error = exact(&blocks(), coarse).unwrap_err();
    assert!(message(error).contains("unit of velocity"), "{error}");
    let error = exact(&blocks(), counts(1e-9)).unwrap_err();
    assert!(
        message(error).contains("weight times breakaway force"),
        "{error}"
    );
}
