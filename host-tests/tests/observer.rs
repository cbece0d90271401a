//! What is promised of the observer: its estimates, that it does not wind up, and what it is for.

use fixed::types::I16F16;
use preslide::control::learning::Adaptation;
use preslide::control::{
    Axis as Settings, Learning, LearningSettings, Observed, Observer, ObserverSettings,
    ObserverState,
};
use preslide::{Friction, QuasiStaticGms, Scalar, Units};
use preslide_host::tune::observer::Belief;
use preslide_host_tests::deviation::Deviation;
use preslide_host_tests::reference::WalkingDisturbance;
use preslide_host_tests::table3::{self, BREAKAWAY};
use preslide_sim::stage::StageConfig;
use preslide_sim::tracking::{Axis, FIXED_UNITS, Step, Tracking, motions};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const COUNT: f64 = 25e-9;

/// What the observer of `ObserverSettings::PAPER_AXIS` believes, but for the walk, which makes it faster: fewer readings matter then,
/// and the reference's matrices stay small.
fn belief() -> Belief {
    Belief {
        sample_time: 50e-6,
        mass: 4.05,
        braking: 125.7,
        reading: COUNT * COUNT / 12.0,
        walk: 1.0,
    }
}

/// Observer against least squares on a mass whose disturbance walks: velocity (m/s) and disturbance (N).
fn deviations<S: Scalar>(units: Units) -> [Deviation; 2] {
    let belief = belief();
    let gains = belief.gains().expect("it settles");
    let settings = ObserverSettings {
        position: gains.position,
        velocity: gains.velocity,
        disturbance: gains.disturbance,
        mass: belief.mass,
        braking: belief.braking,
        limit: 5.0,
        top_speed: 20e-3,
    };
    let observer = Observer::<S>::try_new(&settings, belief.sample_time, units).expect("valid");
    let reference = WalkingDisturbance {
        sample_time: belief.sample_time,
        mass: belief.mass,
        braking: belief.braking,
        reading: belief.reading,
        change: belief.walk * belief.sample_time,
    };
    let to = |value: f64| S::try_from_f64(value).expect("it fits");
    let mut state = ObserverState::<S>::new();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let (mut x, mut v, mut d, mut force) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    let (mut readings, mut forces) = (Vec::new(), Vec::new());
    let mut last = 0.0;
    let mut found = [Deviation::default(); 2];
    for tick in 0..6000 {
        let count = (x / COUNT).round();
        observer.observe(&mut state, to((count - last) * COUNT / units.length));
        last = count;
        readings.push(count * COUNT);
        if tick >= 1000 && tick % 250 == 0 {
            // Readings from before these have no weight left: the filter forgets by a factor e in some 13 ticks.
            let from = readings.len() - 400;
            let (velocity, disturbance) = reference.estimate(&readings[from..], &forces[from..]);
            found[0].add(state.velocity().to_f64() * units.velocity, velocity);
            found[1].add(state.disturbance().to_f64() * units.force, disturbance);
        }
        // A drive that holds it back, so that the run stays within fixed point's range.
        if tick % 40 == 0 {
            force = rng.random_range(-1.0..1.0) + d - 200.0 * v;
        }
        let command = to(force / units.force);
        let none = S::ZERO.sub_input(state.velocity());
        observer.act(&mut state, command, none);
        forces.push(force);
        let change = (-2.0 * rng.random_range(0.0_f64..1.0).max(1e-12).ln()).sqrt()
            * (std::f64::consts::TAU * rng.random_range(0.0..1.0)).cos();
        let t = belief.sample_time;
        let pull = (force - d - belief.braking * v) / belief.mass;
        x += t * v + 0.5 * t * t * pull;
        v += t * pull;
        d += (belief.walk * t).sqrt() * change;
    }
    found
}

/// With gains from the Riccati recursion the filter is the least-squares estimate of all readings. Velocities are of some mm/s and
/// disturbances of some tenths of a newton here.
#[test]
fn the_observer_is_the_least_squares_estimate_of_everything_read() {
    // What is left is that the observer takes the braking over a tick for that at its start: b·T/2m = 8e-4 of some 0.5 N.
    let [velocity, disturbance] = deviations::<f64>(Units::SI);
    velocity.assert_within("velocity, f64 (m/s)", 1e-7, 5e-8, 5e-8);
    disturbance.assert_within("disturbance, f64 (N)", 1.5e-3, 5e-4, 3e-4);
    // Single precision: 2⁻²⁴ of the terms that a tick sums, over the 13 ticks that the filter remembers.
    let [velocity, disturbance] = deviations::<f32>(Units::SI);
    velocity.assert_within("velocity, f32 (m/s)", 2e-7, 1e-7, 5e-8);
    disturbance.assert_within("disturbance, f32 (N)", 1.6e-3, 6e-4, 3e-4);
    // Fixed point rounds the gains by up to 0.5 % and each product down by 2⁻¹⁶ units.
    let [velocity, disturbance] = deviations::<I16F16>(FIXED_UNITS);
    velocity.assert_within("velocity, I16F16 (m/s)", 3e-6, 1.5e-6, 1e-6);
    disturbance.assert_within("disturbance, I16F16 (N)", 1e-2, 5e-3, 3e-3);
}

type Blocks = QuasiStaticGms<4, f32>;

fn blocks() -> Blocks {
    QuasiStaticGms::try_new(&table3::blocks(), BREAKAWAY, Units::SI).expect("Table 3 is valid")
}

/// The axis whose observer takes the integral's place.
fn settings() -> Settings {
    let mut settings = Settings::PAPER_AXIS;
    settings.gains.integral = 0.0;
    settings
}

fn observed<F: Friction>(friction: F, units: Units) -> Observed<F> {
    let observer = ObserverSettings::PAPER_AXIS;
    Observed::try_new(friction, &observer, 50e-6, units).expect("valid")
}

/// Pushed by 3 N against a drive that is cut at 1.8 N, the axis gives way for 40 ms. What is observed stays what pushes, within the
/// friction that is not modelled; an observer fed with the uncut command would be off by all that was cut, several newtons.
#[test]
fn a_cut_command_does_not_wind_it_up() {
    let mut settings = settings();
    settings.duty_limit = 0.05;
    settings.watch.following_error = 0.8e-3;
    settings.watch.frozen_duty = 0.04;
    let model = observed(blocks(), Units::SI);
    let mut axis =
        Axis::try_new(&settings, model, Units::SI, StageConfig::default()).expect("a valid axis");
    let mut cut = 0;
    let mut off = Deviation::default();
    axis.stage_mut().set_external_force_n(3.0).expect("finite");
    for tick in 0..800 {
        let (command, ..) = axis.tick();
        assert_eq!(command.fault, None, "tick {tick}");
        cut += u32::from(command.code.abs() == (0.05 * f64::from(settings.hardware.steps)) as i32);
        if tick >= 400 {
            let truth = axis.stage().truth();
            // The model follows the reference, which rests.
            let pushes = f64::from(axis.friction_state().observer().disturbance());
            off.add(pushes, truth.friction_n - truth.external_n);
        }
    }
    assert!(cut > 500, "it was cut in {cut} ticks only");
    // The observer's lag, of some ms, behind friction that grows with the speed, and the drive's mode, which it does not know.
    off.assert_within("disturbance (N)", 0.5, 0.25, 0.2);
}

/// Disabled in motion it forgets the disturbance, and not the velocity.
#[test]
fn a_released_observer_keeps_the_motion() {
    let observer = observed(blocks(), Units::SI);
    let mut state = observer.at_rest();
    for _ in 0..2000 {
        observer.velocity(&mut state, 100e-9, || 0.0);
        observer.acted(&mut state, 0.0, || 0.0);
    }
    observer.release(&mut state);
    assert_eq!(state.observer().disturbance(), 0.0);
    let velocity = f64::from(state.observer().velocity());
    // 100 nm in 50 µs.
    assert!((velocity / 2e-3 - 1.0).abs() < 1e-3, "{velocity}");
    observer.acted(&mut state, 0.0, || f32::NAN);
    observer.velocity(&mut state, 0.0, || 0.0);
    observer.release(&mut state);
    assert_eq!(state.observer().velocity(), 0.0);
}

/// RMS error of the nested reversals (m) on one stage, whose friction is `level` of what it is.
fn nested<F: Friction>(settings: &Settings, model: F, units: Units, level: f64, kg: f64) -> f64 {
    let mut stage = StageConfig {
        seed: 101,
        ..StageConfig::default()
    };
    stage.mass_kg += kg;
    let mut axis = Axis::try_new(settings, model, units, stage).expect("a valid axis");
    (axis.stage_mut().set_friction_level(level)).expect("above zero");
    let moves = Step::plan_all(&motions::nested_triangles(), settings).expect("valid moves");
    let mut tracking = Tracking::default();
    axis.follow(&moves, |now| tracking.add(&now, settings.encoder.count));
    tracking.rms_m().expect("no fault")
}

/// With Table 3's blocks, which are not those of this stage: at most half the error of the feed-forward alone, where friction and
/// mass are as told and where they are not, in both arithmetics, and with the adaptation within.
#[test]
fn the_observer_halves_the_error_of_nested_reversals() {
    the_observer_halves_the_error(&[(1.0, 0.0)]);
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn the_observer_halves_the_error_on_other_stages() {
    the_observer_halves_the_error(&[(1.15, 0.0), (0.85, 0.0), (1.0, 1.0)]);
}

fn the_observer_halves_the_error(stages: &[(f64, f64)]) {
    let si = Units::SI;
    for &(level, kg) in stages {
        let without = nested(&Settings::PAPER_AXIS, blocks(), si, level, kg);
        let with = nested(&settings(), observed(blocks(), si), si, level, kg);
        let [a, b] = [without, with].map(|error| error * 1e9);
        println!("friction {level}, +{kg} kg: {a:.1} nm, observed {b:.1} nm");
        assert!(with < 0.5 * without, "{level} {kg}: {with} {without}");
        if (level, kg) == (1.0, 0.0) {
            let fixed =
                QuasiStaticGms::<4, I16F16>::try_new(&table3::blocks(), BREAKAWAY, FIXED_UNITS);
            let fixed = observed(fixed.expect("valid"), FIXED_UNITS);
            let fixed = nested(&settings(), fixed, FIXED_UNITS, level, kg);
            assert!((fixed / with - 1.0).abs() < 0.05, "{fixed} {with}");
            let learning = LearningSettings::PAPER_AXIS;
            let adaptive: Learning<_, Adaptation<f32>> =
                Learning::try_new(blocks(), &learning, si).expect("valid");
            let adaptive = nested(&settings(), observed(adaptive, si), si, level, kg);
            assert!(adaptive < 1.1 * with, "{adaptive} {with}");
        }
    }
}
