//! Whole-number kernels over all of a small range, and over all displacements and velocities there are: nothing overflows (the tests run with
//! overflow checks), no force is beyond the limit.

use super::reference::*;
use preslide::kernels::{CountGms, PackedSlipReserve, SlipReserve, Whole};
use preslide::{Friction, Motion};

fn motion(displacement: i32, velocity: i32) -> Motion<Whole> {
    Motion {
        displacement: whole(displacement),
        velocity: whole(velocity),
    }
}

/// Every way of so many steps from here on; how many there are.
fn walk<F: Friction<Scalar = Whole>>(
    kernel: &F,
    state: &F::State,
    limit: Whole,
    steps: &[Motion<Whole>],
    left: u32,
) -> u64 {
    if left == 0 {
        return 1;
    }
    let mut ways = 0;
    for step in steps {
        let mut state = state.clone();
        let force = kernel.step(&mut state, *step);
        assert!(
            force.abs() <= limit,
            "{force} beyond {limit} after {step:?} with {left} left"
        );
        ways += walk(kernel, &state, limit, steps, left - 1);
    }
    ways
}

/// Every one of 2³² values, or of each `apart` one and those about 0 and the ends.
fn all(apart: u32) -> impl Iterator<Item = i32> {
    let about = |at: i32| (-5000..5000).map(move |by| at.wrapping_add(by));
    let each = (i32::MIN..=i32::MAX).step_by(apart as usize);
    about(0).chain(about(i32::MIN)).chain(each)
}

/// Three states of `kernel`: at rest, slipping, and stuck half-way back.
fn states<F: Friction<Scalar = Whole>>(kernel: &F) -> [F::State; 3] {
    let mut states = [(); 3].map(|()| kernel.at_rest());
    for state in &mut states[1..] {
        kernel.step(state, motion(10_000, 50_000));
    }
    kernel.step(&mut states[2], motion(-200, -1000));
    states
}

/// From each state every displacement: the force is within the limit, and never falls as the displacement grows.
fn every_displacement<F: Friction<Scalar = Whole>>(kernel: &F, apart: u32) {
    let limit = kernel.limit().expect("bounded by construction");
    for state in states(kernel) {
        let mut last = (i32::MIN, -limit);
        for displacement in all(apart) {
            let force = kernel.step(&mut state.clone(), motion(displacement, 0));
            assert!(force.abs() <= limit, "{displacement}: {force}");
            // A unit of force a block is what rounding may take.
            if displacement >= last.0 {
                assert!(
                    force >= last.1 - whole(2),
                    "{displacement}: {force} after {}",
                    last.1
                );
            }
            last = (displacement, force);
        }
    }
}

fn every_value(apart: u32) {
    let blocks = blocks::<2>();
    let finest = PackedSlipReserve::<1>::finest_force(&blocks, BREAKAWAY, COUNT);
    let units = counts(finest);
    every_displacement(
        &SlipReserve::try_new(&blocks, BREAKAWAY, units).expect("fits"),
        apart,
    );
    every_displacement(
        &PackedSlipReserve::<1>::try_new(&blocks, BREAKAWAY, units).expect("fits"),
        apart,
    );
    let units = counts(CountGms::<2>::finest_force(&blocks, BREAKAWAY, COUNT));
    let gms = CountGms::try_new(&blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, units).expect("fits");
    every_displacement(&gms, apart);
    let limit = gms.limit().expect("bounded by construction");
    for state in states(&gms) {
        for velocity in all(apart) {
            for displacement in [-3, 0, 3, 10_000] {
                let force = gms.step(&mut state.clone(), motion(displacement, velocity));
                assert!(
                    force.abs() <= limit,
                    "{displacement} at {velocity}: {force}"
                );
            }
        }
    }
}

#[test]
fn every_way_of_a_few_steps_stays_within_the_limit() {
    let blocks = blocks::<2>();
    let all = |displacements: &[i32], velocities: &[i32]| -> Vec<_> {
        let each = displacements
            .iter()
            .flat_map(|d| velocities.iter().map(|v| motion(*d, *v)));
        each.collect()
    };
    let ends = [i32::MIN, -401, -20, -1, 0, 1, 7, 300, i32::MAX];
    let units = counts(CountGms::<2>::finest_force(&blocks, BREAKAWAY, COUNT));
    let gms = CountGms::try_new(&blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, units).expect("fits");
    let steps = all(&ends, &[i32::MIN, 0, 3000, i32::MAX]);
    let limit = gms.limit().expect("bounded by construction");
    assert_eq!(walk(&gms, &gms.at_rest(), limit, &steps, 4), 36_u64.pow(4));
    let units = counts(PackedSlipReserve::<1>::finest_force(
        &blocks, BREAKAWAY, COUNT,
    ));
    let plain = SlipReserve::try_new(&blocks, BREAKAWAY, units).expect("fits");
    let packed = PackedSlipReserve::<1>::try_new(&blocks, BREAKAWAY, units).expect("fits");
    let steps = all(&ends, &[0]);
    let limit = plain.limit().expect("bounded by construction");
    assert_eq!(
        walk(&plain, &plain.at_rest(), limit, &steps, 7),
        9_u64.pow(7)
    );
    assert_eq!(
        walk(&packed, &packed.at_rest(), limit, &steps, 7),
        9_u64.pow(7)
    );
}

#[test]
fn displacements_and_velocities_of_the_whole_range_overflow_nothing() {
    every_value(65_537);
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn every_displacement_and_velocity_overflows_nothing() {
    every_value(1);
}
