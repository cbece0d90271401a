//! Where a model's force goes after loops, at speed and at rest, whatever its equation.

use crate::laws::{self, built};
use fixed::types::I16F16;
use preslide::{Dahl, Friction, Gms, Hsieh, LuGre, Motion, QuasiStaticGms, Sliding, Units};
use preslide_fit::friction::FrictionModel;
use preslide_host_tests::path::{COUNTS, motion};
use preslide_host_tests::table3::{BREAKAWAY, blocks, falling, hsieh};

/// More reversals than it remembers: the outermost are forgotten, the inner loops still close.
#[test]
fn deep_nests_are_closed_by_hsieh_too() {
    let model = Hsieh::<f64>::try_new(&hsieh(0.0, 0.0), 50e-6, Units::SI).expect("valid");
    let turn = |n: i32| 8e-6 * 0.9_f64.powi(n) * f64::from(1 - 2 * (n & 1));
    let force = |turns: i32, end: f64| {
        let (mut state, mut at, mut force) = (model.at_rest(), 0.0, 0.0);
        for to in (0..turns).map(turn).chain([end]) {
            for _ in 0..200 {
                force = model.step(&mut state, Motion::quasi_static((to - at) / 200.0));
            }
            at = to;
        }
        force
    };
    for turns in [8, 15, 16, 17, 18, 25, 30] {
        // Out of the six innermost loops.
        let end = 0.5 * (turn(turns - 6) + turn(turns - 8));
        let [nested, direct] = [turns, turns - 6].map(|turns| force(turns, end));
        assert!(
            (nested - direct).abs() < 1e-9 && nested.abs() > 0.01,
            "{turns}: {nested} N, {direct} N without the loops"
        );
    }
}

/// What breaks away at rest falls to the Coulomb force once it is fast, in every model that weakens.
#[test]
fn a_force_above_the_coulomb_force_falls_to_it_at_speed() {
    let sliding = |breakaway: f64| falling(0.7 * breakaway, 2_000.0);
    let models = laws::all().into_iter().flat_map(|law| law.models);
    for weak in models.filter_map(|model| model.along(sliding)) {
        let model = built::<f64>(&weak, Units::SI).expect("valid");
        // The weights of Table 3 are rounded: what is made of blocks holds no more than they do.
        let weights: f64 = weak.blocks().iter().map(|block| block.weight).sum();
        let held = |level: f64| match weak {
            FrictionModel::Gms { .. } => level * weights,
            FrictionModel::Leuven { .. } => level.min(weights),
            _ => level,
        };
        let within = match weak {
            FrictionModel::TwoState { .. } => 1e-9,
            _ => 1e-6,
        };
        for sign in [1.0, -1.0] {
            let mut state = model.at_rest();
            for (speed, level) in [(0.0, 1.0), (20e-3, 0.7)] {
                let motion = motion(sign * 1e-6, sign * speed);
                let force = (0..2000).map(|_| model.step(&mut state, motion)).last();
                let share = force.expect("ticks") * sign / BREAKAWAY;
                assert!(
                    (share - held(level)).abs() < within,
                    "{weak:?}: {share} at {speed} m/s"
                );
            }
        }
    }
}

#[test]
fn a_gms_that_slid_and_stands_keeps_its_force() {
    let sliding = falling(0.6 * BREAKAWAY, 500.0);
    let model = Gms::<4, f64>::try_new(&blocks::<4>(), BREAKAWAY, sliding, 50e-6, Units::SI);
    let model = model.expect("Table 3");
    let mut state = model.at_rest();
    let slides = motion(1e-6, 20e-3);
    let slid = (0..400).map(|_| model.step(&mut state, slides)).last();
    for _ in 0..100 {
        let stands = model.step(&mut state, Motion::quasi_static(0.0));
        assert_eq!(Some(stands), slid);
    }
}

/// Its exponent is told from 1 where the number type can, and taken for 1 where it cannot.
#[test]
fn dahl_s_exponent_is_taken_near_one_too() {
    for exponent in [0.999_95, 0.999_999, 1.0, 1.000_001, 1.000_05] {
        let model = Dahl::<I16F16>::try_new(320e3, 0.9, exponent, COUNTS);
        assert_eq!(model, Dahl::try_new(320e3, 0.9, 1.0, COUNTS), "{exponent}");
        assert!(model.is_ok());
    }
}

#[test]
fn a_quasi_static_force_at_full_slip_is_the_limit() {
    let model = QuasiStaticGms::<4, f64>::try_new(&blocks::<4>(), BREAKAWAY, Units::SI);
    let model = model.expect("Table 3");
    let force = model.step(&mut model.at_rest(), Motion::quasi_static(1.0));
    assert_eq!(Some(force), model.limit());
}

/// In fixed point a product rounds down, so that a negative force is the larger one: the limit is that.
#[test]
fn a_bristle_s_limit_holds_in_both_directions_and_is_reached() {
    for stiffness in [150e3, 171e3, 195e3, 222.2e3, 320e3] {
        let model = LuGre::<I16F16>::try_new(stiffness, 0.0, 0.9, Sliding::none(0.9), COUNTS);
        let model = model.expect("valid");
        let limit = model.limit().expect("it has no damping");
        let force = |way: i32| {
            let mut state = model.at_rest();
            let motion = Motion::quasi_static(I16F16::from_num(200 * way));
            (0..500)
                .map(|_| model.step(&mut state, motion))
                .last()
                .expect("ticks")
        };
        let most = force(1).abs().max(force(-1).abs());
        assert_eq!(most, limit, "{stiffness}");
    }
}
