//! What is promised of friction models that learn: bounds, freezes, the estimate, the false-alarm rate, and what they are for.

use crate::measured::calm;
use fixed::types::I16F16;
use preslide::control::learning::{
    Adaptation, AdaptationSettings, BlockMeans, Condition, LOOK_EVERY, Learn, MismatchSettings,
    MismatchWatch, decision_interval,
};
use preslide::control::{
    Coefficients, Controller, Fault, Learning, LearningSettings, Measurement, Move, NormalRange,
    Settings,
};
use preslide::{Friction, Motion, QuasiStaticGms, Scalar, Units};
use preslide_host_tests::path::motion;
use preslide_host_tests::reference::Level;
use preslide_host_tests::table3::{self, BREAKAWAY};
use preslide_sim::stage::{FrictionConfig, StageConfig, VariabilityConfig};
use preslide_sim::tracking::{Axis, FIXED_UNITS, Step, Tracking, motions};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const PAPER: LearningSettings = LearningSettings::PAPER_AXIS;

type Both<S> = (MismatchWatch<S>, Adaptation<S>);
type Model<S> = QuasiStaticGms<4, S>;

/// The paper's Table 3, four blocks.
fn model<S: Scalar>(units: Units) -> Model<S> {
    QuasiStaticGms::try_new(&table3::blocks(), BREAKAWAY, units).expect("Table 3 is valid")
}

fn learning<S: Scalar, L: Learn<S>>(
    settings: &LearningSettings,
    units: Units,
) -> Learning<Model<S>, L> {
    Learning::try_new(model(units), settings, units).expect("valid settings")
}

fn level<S: Scalar>(condition: &Condition<S>) -> f64 {
    condition.level.expect("it adapts").to_f64()
}

/// Table 3's four blocks on a stage whose friction repeats.
fn repeatable(seed: u64) -> StageConfig {
    StageConfig {
        seed,
        friction: FrictionConfig {
            variability: VariabilityConfig {
                bound: 0.0,
                ..VariabilityConfig::default()
            },
            ..FrictionConfig::default()
        },
        ..StageConfig::default()
    }
}

/// Largest difference between the recursion and least squares over all that was seen.
fn deviation<S: Scalar>(units: Units) -> f64 {
    let settings = LearningSettings {
        adaptation: AdaptationSettings {
            memory: 8.0,
            range: 0.5,
            dead_zone: 0.0,
        },
        ..PAPER
    };
    let limit = BREAKAWAY;
    let adaptation: Adaptation<S> = Learn::try_new(&settings, limit, units).expect("valid");
    let mut state = adaptation.start();
    let mut reference = Level::new(8.0);
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let (mut worst, mut furthest, mut truth) = (0.0_f64, 0.0_f64, 1.0_f64);
    for block in 0..2000 {
        if block % 100 == 0 {
            truth = rng.random_range(0.75..1.25);
        }
        let model = rng.random_range(0.6..1.0);
        let spent = truth * model + rng.random_range(-0.05..0.05);
        let scalar =
            |share: f64| S::try_from_f64(share * limit / units.force).expect("a force of the axis");
        let mean = BlockMeans {
            model: scalar(model),
            spent: scalar(spent),
            path: S::ONE,
        };
        adaptation.block(&mut state, &mean);
        reference.see(model, spent);
        let found = adaptation.level(&state).to_f64();
        worst = worst.max((found - reference.estimate()).abs());
        furthest = furthest.max((found - 1.0).abs());
    }
    assert!(furthest > 0.2, "the level hardly moved: {furthest}");
    worst
}

#[test]
fn the_level_is_that_of_weighted_least_squares() {
    let (double, single) = (deviation::<f64>(Units::SI), deviation::<f32>(Units::SI));
    let fixed = deviation::<I16F16>(FIXED_UNITS);
    println!(
        "largest deviation of the level: f64 {double:.1e}, f32 {single:.1e}, I16F16 {fixed:.1e}"
    );
    // Newton's step lags behind the reciprocal; fixed point adds its resolution.
    assert!(double < 2e-3 && single < 2e-3 && fixed < 4e-3);
}

/// Garbage of every kind, in motion and force: level and force stay within their bounds.
fn stays_bounded<S: Scalar>(units: Units, garbage: &[S], seed: u64) {
    let settings = LearningSettings {
        block: 4 * LOOK_EVERY,
        ..PAPER
    };
    let model: Learning<_, Both<S>> = learning(&settings, units);
    let bound = model.limit().expect("bounded").to_f64();
    assert!((bound * units.force / 0.9 - 1.2).abs() < 0.01, "{bound}");
    let mut state = model.at_rest();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut lowest, mut highest) = (1.0_f64, 1.0_f64);
    let mut bias = 1.0;
    for tick in 0..1_000_000 {
        if tick % 1000 == 0 {
            bias = rng.random_range(-3.0..3.0);
        }
        let mut pick = |usual: f64| {
            let wild = rng.random_range(0..500) == 0;
            let index = rng.random_range(0..garbage.len());
            let usual = S::try_from_f64(usual).expect("it fits");
            if wild { garbage[index] } else { usual }
        };
        let motion = motion(pick(2e-8 / units.length), pick(1e-3 / units.velocity));
        let force = model.step(&mut state, motion);
        assert!(force.to_f64().abs() <= bound, "{force:?}");
        let spent = pick(bias * 0.9 / units.force);
        model.spent(&mut state, || (tick % 997 > 3).then_some(spent));
        if tick % 100_003 == 0 {
            model.release(&mut state);
        }
        let level = level(&model.condition(&state));
        assert!((0.8 - 1e-4..=1.2 + 1e-4).contains(&level), "{level}");
        (lowest, highest) = (lowest.min(level), highest.max(level));
    }
    assert!(lowest < 0.81 && highest > 1.19, "{lowest} {highest}");
}

#[test]
fn whatever_comes_level_and_force_stay_within_their_bounds() {
    let floats = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30, 0.0];
    stays_bounded(Units::SI, &floats, 1);
    let fixed = [I16F16::MAX, I16F16::MIN, I16F16::ZERO, -I16F16::ONE];
    stays_bounded(FIXED_UNITS, &fixed, 2);
}

#[test]
fn without_excitation_or_knowledge_the_level_is_frozen_to_the_bit() {
    let settings = LearningSettings {
        block: 4 * LOOK_EVERY,
        ..PAPER
    };
    let model: Learning<_, Adaptation<f32>> = learning(&settings, Units::SI);
    let mut state = model.at_rest();
    let mut go = |displacement: f32, spent: Option<f32>, ticks: usize| {
        for tick in 0..ticks {
            if displacement == 0.0 && tick == 0 {
                // At rest without memory, as after a fault.
                model.release(&mut state);
            }
            model.step(&mut state, Motion::quasi_static(displacement));
            model.spent(&mut state, || spent);
        }
        model.condition(&state).level.expect("it adapts")
    };
    // Sliding at 12 % more than the model says; the first blocks, in which it still rises, say more.
    let learned = go(1e-7, Some(1.008), 5000);
    assert!((1.05..1.19).contains(&learned), "{learned}");
    assert_eq!(go(1e-7, None, 5000), learned, "the command was cut");
    assert_eq!(go(0.0, Some(9.0), 5000), learned, "at rest");
    assert_eq!(go(0.0, Some(f32::NAN), 5000), learned, "at rest");
    // Back and forth by 0.8 µm: far from the limit.
    for _ in 0..500 {
        assert_eq!(go(1e-7, Some(3.0), 4), learned, "not excited");
        assert_eq!(go(-1e-7, Some(-3.0), 8), learned, "not excited");
        assert_eq!(go(1e-7, Some(3.0), 4), learned, "not excited");
    }
    assert_ne!(
        go(1e-7, Some(3.0), 5000),
        learned,
        "it was frozen, not dead"
    );
}

#[test]
fn a_fault_and_new_gains_keep_what_was_learned_and_another_model_does_not() {
    let settings = Settings::PAPER_AXIS;
    let friction: Learning<_, Both<f32>> = learning(&PAPER, Units::SI);
    let coefficients =
        Coefficients::try_new(&settings, friction, Units::SI).expect("valid settings");
    let mut controller = Controller::new(coefficients, 0_u32);
    assert_eq!(controller.enable(), Ok(()));
    let slide = || Move::plan(4e-4, 1e-3, 0.1, settings.grid()).expect("a valid move");
    let healthy = |count| calm(count);
    // The axis lags by ten counts: the feedback adds force to the model's.
    assert_eq!(controller.start(slide()), Ok(()));
    let mut count = 0;
    while !controller.is_idle() {
        let command = controller.tick(healthy(count));
        count = ((command.reference >> 16) - 10).max(0) as u32;
    }
    let learned = controller.condition();
    assert!(level(&learned) > 1.01, "{learned:?}");
    assert_eq!(controller.start(slide()), Ok(()));
    let jump = controller.tick(healthy(count + 5000));
    assert_eq!(jump.fault, Some(Fault::EncoderJump));
    for _ in 0..1000 {
        controller.tick(healthy(count));
        assert_eq!(controller.condition(), learned);
    }
    controller.acknowledge();
    assert_eq!(controller.enable(), Ok(()));
    controller.tick(healthy(count));
    assert_eq!(controller.condition(), learned);
    // Every tick late is a fault; every second one is none, but tells nothing.
    assert_eq!(controller.start(slide()), Ok(()));
    let mut late = false;
    while !controller.is_idle() {
        late = !late;
        let measurement = Measurement {
            late,
            ..healthy(count)
        };
        count = ((controller.tick(measurement).reference >> 16) + 10).max(0) as u32;
    }
    assert_eq!(controller.condition(), learned);
    let mut stiffer = settings;
    stiffer.gains.proportional *= 1.5;
    let with = |settings, learning_settings| {
        let friction: Learning<_, Both<f32>> = learning(learning_settings, Units::SI);
        Coefficients::try_new(settings, friction, Units::SI).expect("valid settings")
    };
    controller.swap(&with(&stiffer, &PAPER));
    assert_eq!(controller.condition(), learned);
    let slower = LearningSettings {
        block: 504,
        ..PAPER
    };
    controller.swap(&with(&stiffer, &slower));
    assert_eq!(level(&controller.condition()), 1.0);
}

#[test]
fn without_learning_nothing_changes() {
    let plain = model::<f32>(Units::SI);
    let wrapped: Learning<_, ()> = learning(&PAPER, Units::SI);
    let (mut a, mut b) = (plain.at_rest(), wrapped.at_rest());
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for _ in 0..100_000 {
        let motion = Motion::quasi_static(rng.random_range(-1e-6_f32..1e-6));
        assert_eq!(plain.step(&mut a, motion), wrapped.step(&mut b, motion));
        wrapped.spent(&mut b, || Some(1.0));
    }
    assert_eq!(wrapped.condition(&b), Condition::NONE);
    assert_eq!(wrapped.limit(), plain.limit());
}

/// What a tick costs in the mean: in all others the controller is not asked, and nothing is done.
#[test]
fn looks_at_the_work_in_one_tick_of_seven() {
    let model: Learning<_, Both<f32>> = learning(&PAPER, Units::SI);
    let mut state = model.at_rest();
    let mut asked = Vec::new();
    for tick in 0..700 * LOOK_EVERY {
        model.step(&mut state, Motion::quasi_static(2e-8));
        model.spent(&mut state, || {
            asked.push(tick);
            Some(1.0)
        });
    }
    let expected: Vec<u32> = (0..700).map(|look| look * LOOK_EVERY).collect();
    assert_eq!(asked, expected);
    // It was learned from all the same.
    assert!(level(&model.condition(&state)) > 1.01);
}

/// Mean run lengths of the two-sided CUSUM with known parameters, from D. C. Montgomery, *Introduction to Statistical Quality
/// Control*: slack 1/2, thresholds 4 and 5, 168 and 465 samples.
#[test]
fn the_threshold_is_the_published_one_where_nothing_is_estimated() {
    let many = u32::MAX;
    for (length, threshold) in [(168.0, 4.0), (465.0, 5.0)] {
        let found = decision_interval(0.5, 1.0 / length, many);
        println!("one in {length}: threshold {found:.3}, published {threshold}");
        assert!((found - threshold).abs() < 0.03, "{found}");
    }
    // Fewer windows know less, and a rarer alarm takes more.
    assert!(decision_interval(1.0, 1e-3, 16) > decision_interval(1.0, 1e-3, 64));
    assert!(decision_interval(1.0, 1e-4, 64) > decision_interval(1.0, 1e-3, 64));
}

/// Independent normal windows: the rate is the one that was asked for, estimation of the normal range included.
#[test]
fn false_alarms_come_at_the_rate_that_was_asked_for() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let mut normal = || {
        // Box and Muller.
        let radius = (-2.0 * (1.0 - rng.random_range(0.0..1.0_f64)).ln()).sqrt();
        radius * (std::f64::consts::TAU * rng.random_range(0.0..1.0_f64)).cos()
    };
    for (slack, commissioning, asked, axes, windows) in [
        (1.0, 32, 1e-2, 2000, 200),
        (1.0, 32, 1e-3, 4000, 500),
        (1.0, 16, 1e-3, 4000, 500),
        (0.5, 64, 1e-3, 4000, 500),
        (1.0, 32, 1e-4, 8000, 1500),
    ] {
        let settings = LearningSettings {
            watch: MismatchSettings {
                slack,
                commissioning,
                false_alarms: asked,
                ..PAPER.watch
            },
            ..PAPER
        };
        let watch: MismatchWatch<f32> = Learn::try_new(&settings, 0.9, Units::SI).expect("valid");
        let per_axis: Vec<f64> = (0..axes)
            .map(|_| {
                let mut state = watch.start();
                let mut alarms = 0;
                for _ in 0..2 * commissioning + windows {
                    watch.window(&mut state, (0.03 + 0.012 * normal()) as f32);
                    if matches!(state.range(), NormalRange::Above | NormalRange::Below) {
                        alarms += 1;
                        state.acknowledge();
                    }
                }
                f64::from(alarms) / f64::from(windows)
            })
            .collect();
        let n = f64::from(axes);
        let mean = per_axis.iter().sum::<f64>() / n;
        let variance = per_axis.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let half = 1.96 * (variance / n).sqrt();
        println!(
            "slack {slack}, {commissioning} windows a half: asked {asked:.0e}, measured {mean:.3e} (±{half:.1e})"
        );
        // Siegmund's approximation is good to some 10 %.
        assert!((mean - asked).abs() < 0.15 * asked + 2.0 * half);
    }
}

/// RMS error of the nested triangles, the level in the end.
fn nested<F: Friction>(friction: F, stage_level: f64) -> (f64, Option<f64>) {
    let settings = Settings::PAPER_AXIS;
    let mut axis =
        Axis::try_new(&settings, friction, Units::SI, repeatable(101)).expect("a valid axis");
    let set = axis.stage_mut().set_friction_level(stage_level);
    set.expect("a level above zero");
    let moves = Step::plan_all(&motions::nested_triangles(), &settings).expect("valid moves");
    let mut tracking = Tracking::default();
    axis.follow(&moves, |now| tracking.add(&now, settings.encoder.count));
    let level = axis.condition().level.map(Scalar::to_f64);
    (tracking.rms_m().expect("no fault"), level)
}

#[test]
fn the_level_follows_the_stage_and_does_no_harm_where_it_is_right() {
    the_level_follows(&[(1.15, 0.8), (1.0, 1.05)]);
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn the_level_follows_a_stage_that_rubs_less() {
    the_level_follows(&[(0.85, 0.8)]);
}

fn the_level_follows(stages: &[(f64, f64)]) {
    for &(stage_level, most) in stages {
        let (without, _) = nested(model::<f32>(Units::SI), stage_level);
        let adaptive: Learning<_, Adaptation<f32>> = learning(&PAPER, Units::SI);
        let (with, level) = nested(adaptive, stage_level);
        println!("stage {stage_level}: {without:.3e} m → {with:.3e} m, level {level:?}");
        assert!(with < most * without, "{stage_level}: {with} {without}");
    }
}

/// Flag and the window in which it was raised, on a stage that wears by 1 % a stroke after `healthy` strokes.
fn wear<F: Friction>(friction: F) -> (Option<usize>, Option<f64>) {
    let settings = Settings::PAPER_AXIS;
    let stage = StageConfig {
        seed: 9,
        substeps: 2,
        ..StageConfig::default()
    };
    let mut axis = Axis::try_new(&settings, friction, Units::SI, stage).expect("a valid axis");
    for stroke in 0..60 {
        if stroke >= HEALTHY {
            let level = 1.0 + 0.01 * (stroke - HEALTHY) as f64;
            axis.stage_mut().set_friction_level(level).expect("a level");
        }
        let step = Step::Move {
            distance_m: if stroke % 2 == 0 { 1e-3 } else { -1e-3 },
            speed_m_s: 4e-3,
            ramp_s: 0.02,
        };
        let mut faults = 0;
        axis.follow(&[step.plan(&settings).expect("a valid move")], |now| {
            faults += usize::from(now.command.fault.is_some())
        });
        assert_eq!(faults, 0, "a status must not stop the axis");
        let condition = axis.condition();
        match condition.range {
            Some(NormalRange::Above) => {
                return (Some(stroke), condition.level.map(Scalar::to_f64));
            }
            Some(NormalRange::Inside | NormalRange::Learning) => {}
            other => panic!("{other:?} in stroke {stroke}"),
        }
    }
    (None, None)
}

/// Strokes before the wear; commissioning takes 28.
const HEALTHY: usize = 40;

#[test]
fn wear_is_noticed_soon_not_before_and_not_hidden_by_the_adaptation() {
    let (watched, _) = wear(learning::<f32, MismatchWatch<f32>>(&PAPER, Units::SI));
    let (adapted, level) = wear(learning::<f32, Both<f32>>(&PAPER, Units::SI));
    println!(
        "wear from stroke {HEALTHY}: noticed in {watched:?}, with adaptation in {adapted:?}, level {level:?}"
    );
    for stroke in [watched, adapted] {
        let stroke = stroke.expect("a flag");
        assert!((HEALTHY + 1..HEALTHY + 12).contains(&stroke), "{stroke}");
    }
}

#[test]
fn settings_that_cannot_be_are_refused_by_name() {
    let refused = |change: fn(&mut LearningSettings)| {
        let mut settings = PAPER;
        change(&mut settings);
        Learning::<_, Both<I16F16>>::try_new(model(FIXED_UNITS), &settings, FIXED_UNITS)
            .expect_err("must be refused")
            .parameter
    };
    assert_eq!(refused(|s| s.block = 0), "ticks of a block");
    assert_eq!(
        refused(|s| s.limit = f64::NAN),
        "limit of the learned force"
    );
    assert_eq!(refused(|s| s.excitation = 0.05), "excitation");
    let memory = "memory of the adaptation in blocks";
    assert_eq!(refused(|s| s.adaptation.memory = 1.0), memory);
    assert_eq!(refused(|s| s.adaptation.memory = f64::NAN), memory);
    let range = "range of the friction level";
    assert_eq!(refused(|s| s.adaptation.range = 0.6), range);
    let dead_zone = "dead zone of the adaptation";
    assert_eq!(refused(|s| s.adaptation.dead_zone = -0.1), dead_zone);
    assert_eq!(refused(|s| s.watch.window = 0.0), "window of the watch");
    let commissioning = "windows of half the commissioning";
    assert_eq!(refused(|s| s.watch.commissioning = 4), commissioning);
    assert_eq!(refused(|s| s.watch.slack = 9.0), "slack of the watch");
    let alarms = "false alarms per window";
    assert_eq!(refused(|s| s.watch.false_alarms = 0.0), alarms);
    assert_eq!(refused(|s| s.watch.false_alarms = f64::NAN), alarms);
}
