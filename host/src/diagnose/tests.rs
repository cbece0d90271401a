//! The stages, on a small made machine: 2 kg on three Maxwell-slip blocks, what is added to it, and noise.

mod as_it_is;
mod events;
mod experiments;
mod ripples;

use super::axis::Axis;
use super::candidate::{candidate_of, candidates, refined};
use super::credible::sieved;
use super::curve::Curve;
use super::effect;
use super::fit::Known;
use super::merge::merged;
use super::naming::reports;
use super::search::{Found, search, with};
use super::term::Subject;
use super::verdict::Verdict;
use super::*;
use preslide_fit::friction::FrictionModel;
use preslide_fit::recording::{LoadOptions, MotionKind, load_csv};
use preslide_host_tests::made::{Blocks, sines};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Sample time (s), samples, inertia (kg).
const STEP_S: f64 = 2e-3;
const SAMPLES: usize = 15_000;
const MASS_KG: f64 = 2.0;
/// Stiffness (N/m) and yield (m): 3 N of friction.
const BLOCKS: [(f64, f64); 3] = [(20_000.0, 5e-5), (5_000.0, 2e-4), (1_000.0, 1e-3)];
/// Deviation of the white noise (N).
const NOISE_N: f64 = 0.03;
const SEED: u64 = 20_261;

/// Frequencies (rad/s) and amplitudes (m) of the motion; no two strokes end at one place.
const MOTION: [(f64, f64); 3] = [(1.9, 0.03), (4.3, 0.008), (0.31, 0.012)];

/// Between −0.5 and 0.5.
fn uniform(rng: &mut ChaCha8Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

/// The machine's friction (N) along positions.
fn friction(position: &[f64]) -> Vec<f64> {
    let mut blocks = Blocks::new(&BLOCKS);
    position.iter().map(|x| blocks.force(*x)).collect()
}

/// A recording of the machine with `more` (N) added, from time, position and velocity.
fn made(more: impl Fn(f64, f64, f64) -> f64) -> Recording {
    made_of(&BLOCKS, more)
}

/// The same on other blocks.
fn made_of(blocks: &[(f64, f64)], more: impl Fn(f64, f64, f64) -> f64) -> Recording {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    // The sum of twelve uniform deviates has the variance one.
    let mut noise = || NOISE_N * (0..12).map(|_| uniform(&mut rng)).sum::<f64>();
    let waves = MOTION.map(|(w, a)| [a, w, 0.0]);
    let mut blocks = Blocks::new(blocks);
    let mut text = String::from("t_s,x_m,force_N\n");
    for i in 0..SAMPLES {
        let t = i as f64 * STEP_S;
        let [x, v, a] = sines(&waves, t);
        let f = MASS_KG * a + blocks.force(x) + more(t, x, v) + noise();
        writeln!(text, "{t:.6},{x:.12},{f:.9}").expect("a string");
    }
    load_csv(text.as_bytes(), "made.csv", &LoadOptions::default()).expect("a recording")
}

fn null(recording: &Recording) -> NullModel {
    NullModel::new(Rows::new(recording, &[]).expect("rows"), &[], None).expect("a fit")
}

fn found(recording: &Recording) -> Found {
    search(
        null(recording),
        &[],
        &Known::default(),
        &[],
        &Progress::new("", 0),
    )
    .expect("a hypothesis")
}

fn by_id(id: &str) -> Term {
    Term::new(
        Subject::Effect(effect::by_id(id).expect("in the catalogue")),
        &[],
    )
}

fn names(found: &Found) -> Vec<&'static str> {
    let named = found.hypothesis.terms.iter().filter_map(Term::effect);
    named.map(effect::Effect::id).collect()
}

#[test]
fn blocks_have_equal_shares() {
    let recording = made(|_, _, _| 0.0);
    let rows = Rows::new(&recording, &[]).expect("rows");
    let sizes: Vec<f64> = rows.blocks.iter().map(|b| b.len() as f64).collect();
    let mean = sizes.iter().sum::<f64>() / sizes.len() as f64;
    // Time and path share a block: a slow stretch has up to twice the rows of the mean.
    assert!(sizes.iter().all(|n| *n < 2.0 * mean), "{sizes:?}");
    assert!(rows.blocks.windows(2).all(|b| b[0].end == b[1].start));
}

/// A force over velocity may have friction's step at rest, and a level over speed may be alike everywhere: neither takes from the core what
/// effects and noise act through.
#[test]
fn a_free_curve_leaves_friction_to_the_core() {
    let recording = made(|_, _, v| 4.0 * v * v.abs());
    let alone = null(&recording);
    for (axis, odd) in [(Axis::Velocity, false), (Axis::Speed, true)] {
        let curve = Term::new(Subject::Curve(Curve { axis, odd }), &[]);
        let beside = alone.referred_to(&[curve]).expect("a fit");
        let level = beside.baseline.level / 3.0;
        assert!((level - 1.0).abs() < 0.03, "{axis:?}: {level} of 3 N");
    }
}

/// Nothing separates viscous friction, a free curve over velocity and a level over speed while the machine slides: effects act through the
/// friction that is found without the two curves.
#[test]
fn curves_over_speed_beside_viscous_friction_leave_its_level_to_the_core() {
    let recording = made(|_, _, v| 20.0 * v);
    let curve = |axis, odd| Term::new(Subject::Curve(Curve { axis, odd }), &[]);
    let beside = [
        by_id("viscous"),
        curve(Axis::Velocity, false),
        curve(Axis::Speed, true),
    ];
    let found = null(&recording).referred_to(&beside).expect("a fit");
    let level = found.baseline.level / 3.0;
    assert!((level - 1.0).abs() < 0.03, "{level} of 3 N");
}

/// Friction that reverses over speed is the core's where there is no hysteresis; drag or a Stribeck curve beside blocks does not bring it in.
#[test]
fn friction_without_hysteresis_is_the_cores() {
    let smooth = made_of(&[], |_, _, v| 3.0 * (v / 2e-3).tanh());
    let found = diagnose(&smooth, None, None, &Progress::new("", 0)).expect("a diagnosis");
    let words = found.verdict_words(&smooth);
    assert_eq!(found.verdict, Verdict::Consistent, "{words}");
    assert!(words.contains("tanh(v/v0)"), "{words}");
    let drag = made(|_, _, v| 100.0 * v * v.abs());
    let stribeck = made(|_, _, v| 1.5 * v.signum() * (-(v / 5e-3).powi(2)).exp());
    for other in [drag, stribeck] {
        assert!(!null(&other).core.follows_velocity());
    }
}

/// What was found needless keeps its like away, and no other ripple.
#[test]
fn another_period_is_another_ripple() {
    let ripple = |period: f64| Term::new(by_id("periodic_friction").subject, &[period]);
    assert!(ripple(0.0020).is_near(&ripple(0.00205)));
    assert!(!ripple(0.0020).is_near(&ripple(0.0040)));
    // A machine has one viscous friction, and one creep, whatever its time constant.
    assert!(by_id("viscous").is_near(&by_id("viscous")));
    let creep = |constant: f64| Term::new(by_id("creep").subject, &[constant]);
    assert!(creep(0.1).is_near(&creep(10.0)));
}

#[test]
fn a_vibration_has_a_phase_of_each_files_own() {
    let shaken =
        |phase: f64| made(move |t, _, _| 0.5 * (std::f64::consts::TAU * 9.3 * t + phase).sin());
    let files = vec![shaken(0.0), shaken(2.5)];
    let found = found(&Recording::join(files).expect("joined"));
    assert_eq!(names(&found), ["channel_delay", "external_vibration"]);
    let waves = found.hypothesis.coefficients(1);
    assert_eq!(waves.len(), 4);
    for wave in waves.chunks(2) {
        let amplitude = wave[0].hypot(wave[1]);
        assert!((amplitude / 0.5 - 1.0).abs() < 0.03, "{amplitude} N");
    }
}

#[test]
fn nothing_enters_where_nothing_is_missing() {
    let found = found(&made(|_, _, _| 0.0));
    assert_eq!(names(&found), ["channel_delay"]);
}

#[test]
fn the_true_effect_enters_first_with_its_value() {
    let found = found(&made(|_, _, v| 8.0 * v));
    assert_eq!(names(&found), ["channel_delay", "viscous"]);
    let c = found.hypothesis.coefficients(1)[0];
    assert!((c / 8.0 - 1.0).abs() < 0.03, "{c} N·s/m");
}

#[test]
fn a_period_off_the_grid_is_refined() {
    let period = 0.0031;
    let recording = made(|_, x, _| 0.4 * (std::f64::consts::TAU * x / period).sin());
    let null = null(&recording);
    let plain = null.fit(&[by_id("channel_delay")]).expect("a fit");
    let coarse = Term::new(by_id("periodic_force").subject, &[1.01 * period]);
    let sharp = refined(&null, &plain, &coarse);
    assert!(
        (sharp.shape[0] / period - 1.0).abs() < 1e-3,
        "{}",
        sharp.shape[0]
    );
    let (list, families) = candidates(&null, &plain, &[]);
    assert_eq!(
        list[0].term.effect().map(effect::Effect::id),
        Some("periodic_force")
    );
    assert!(
        list[0].chance(families) < 1e-6,
        "{}",
        list[0].chance(families)
    );
}

#[test]
fn a_gap_takes_the_place_of_the_spring_that_it_contains_and_not_of_the_users_own() {
    let null = null(&made(|_, _, _| 0.0));
    let spring = Term::new(by_id("drive_compliance").subject, &[0.5]);
    let ids_beside = |gap: &[f64], given: bool| -> Vec<&str> {
        let spring = Term {
            given,
            ..spring.clone()
        };
        let before = null.fit(&[spring]).expect("a fit");
        let gap = Term::new(by_id("backlash").subject, gap);
        let terms = with(&null, &before, &gap).expect("a fit");
        let effects = terms.iter().filter_map(Term::effect);
        effects.map(|e| e.id()).collect()
    };
    let both = ["drive_compliance", "backlash"];
    let encoder_on_load = [1e-5, 100.0, 0.5];
    assert_eq!(ids_beside(&encoder_on_load, false), both[1..]);
    assert_eq!(ids_beside(&encoder_on_load, true), both);
    // A gap behind a motor with the encoder has no spring of its own.
    assert_eq!(ids_beside(&[1e-5], false), both);
}

#[test]
fn the_effect_itself_is_no_rival_and_a_curve_that_holds_it_makes_it_needless() {
    let recording = made(|_, _, v| 8.0 * v);
    let found = found(&recording);
    let reports = reports(&found, 1, &[]);
    assert_eq!(reports.len(), 1);
    let own = &reports[0];
    assert!(own.ambiguous.is_empty(), "{}", own.ambiguous.len());
    assert!(own.gain > 0.5, "{} {:?}", own.gain, own.evidence);

    let keys = |weights: &BTreeMap<String, f64>| -> Vec<String> {
        let features = weights.keys().filter(|k| *k != "constant");
        features.cloned().collect()
    };
    let fitted = &confidence::FITTED;
    assert!(
        keys(&fitted.weights)
            .iter()
            .eq(confidence::features(own).keys())
    );
    let presence = confidence::features_of_presence(own);
    assert!(keys(&fitted.presence).iter().eq(presence.keys()));
    let hint = confidence::features_of_a_hint(Some(&own.evidence));
    assert!(keys(&fitted.hints).iter().eq(hint.keys()));
    assert!(confidence::presence(own) > 0.99, "{presence:?}");

    let curve = Curve {
        axis: axis::Axis::Velocity,
        odd: false,
    };
    let wide = found
        .null
        // The hats of a curve hold a line but for its mean.
        .fit(&[
            by_id("channel_delay"),
            by_id("constant_force"),
            Term::new(Subject::Curve(curve), &[]),
        ])
        .expect("a fit");
    let beside = candidate_of(&found.null, &wide, &[by_id("viscous")], 1.0);
    assert!(beside.is_none_or(|o| o.evidence.share < 0.05));
}

#[test]
fn an_implausible_name_does_not_block_others() {
    let recording = made(|_, _, v| 8.0 * v);
    let mut found = found(&recording);
    let mut terms = found.hypothesis.terms.clone();
    terms.push(Term::new(by_id("periodic_force").subject, &[0.0123]));
    found.hypothesis = found.null.fit(&terms).expect("a fit");
    let (kept, gone) = sieved(&mut found, 1, &[]).expect("a fit");
    let ids = |list: &[naming::TermReport]| -> Vec<&str> {
        let effects = list.iter().filter_map(|s| s.term.effect());
        effects.map(effect::Effect::id).collect()
    };
    assert_eq!(ids(&kept), ["viscous"]);
    assert_eq!(ids(&gone), ["periodic_force"]);
    assert_eq!(names(&found), ["channel_delay", "viscous"]);
}

#[test]
fn a_simpler_effect_that_explains_as_much_replaces_the_other() {
    let period = 0.04;
    let recording = made(|_, x, _| 0.4 * (std::f64::consts::TAU * x / period).sin());
    let mut found = found(&recording);
    let delay = by_id("channel_delay");
    let alone = found.null.fit(std::slice::from_ref(&delay)).expect("a fit");
    let (list, _) = candidates(&found.null, &alone, &[]);
    let is_map = |o: &&candidate::Candidate| o.term.is_like(&by_id("position_force"));
    let map = list.iter().find(is_map).expect("a candidate");
    found.hypothesis = found.null.fit(&[delay, map.term.clone()]).expect("a fit");
    sieved(&mut found, 1, &[]).expect("a fit");
    assert_eq!(names(&found), ["channel_delay", "periodic_force"]);
    let own = found.hypothesis.terms[1].shape[0];
    assert!((own / period - 1.0).abs() < 0.01, "{own} m");
}

#[test]
fn no_viscous_force_drives_the_axis_but_a_users_own_model_keeps_its_sign() {
    // Friction that falls with speed looks like it.
    let recording = made(|_, _, v| 1.5 * v.signum() * (-v.abs() / 0.03).exp());
    let null = null(&recording);
    let forces = effect::ALL.iter().filter(|e| {
        let is_bound = e.card().bound == normal::Bound::NonNegative;
        is_bound && e.axis() == Axis::Velocity
    });
    for term in forces.map(|e| by_id(e.id())) {
        let bound = null.fit(std::slice::from_ref(&term)).expect("a fit");
        assert_eq!(bound.coefficients(0), [0.0]);
        let own = Term {
            given: true,
            ..term
        };
        let free = null.fit_as_given(&[own]).expect("a fit");
        assert!(free.coefficients(0)[0] < -1.0, "{:?}", free.coefficients(0));
        assert!(free.normal.loss() < bound.normal.loss());
    }
}

#[test]
fn a_level_refers_to_the_friction_that_it_is_stated_with() {
    let (level, at, width) = (0.5, 0.01, 0.004);
    let recording = made(|_, x, v| {
        let spot = (-((x - at) / width).powi(2)).exp();
        60.0 * v + 3.0 * level * v.signum() * spot
    });
    let found = diagnose(&recording, None, None, &Progress::new("", 0)).expect("a diagnosis");
    let ids: Vec<&str> = found.confident().map(|e| e.id()).collect();
    assert!(ids.contains(&"local_friction_spot"), "{ids:?}");
    let spot = found.confident().find(|e| e.id() == "local_friction_spot");
    let own = spot.expect("confident").parameters[0].1.value;
    println!("level {own}");
    assert!((own / level - 1.0).abs() < 0.05, "{own}");
}

#[test]
fn verdicts_say_what_the_recording_says() {
    let of = |more: &dyn Fn(f64, f64, f64) -> f64| {
        let recording = made(more);
        diagnose(&recording, None, None, &Progress::new("", 0)).expect("a diagnosis")
    };
    assert_eq!(of(&|_, _, _| 0.0).verdict, Verdict::Consistent);
    let viscous = of(&|_, _, v| 8.0 * v);
    assert_eq!(viscous.verdict, Verdict::MissingPhysics);
    assert!(viscous.extended.test < 0.2 * viscous.baseline.test);
    // A force of nobody's making, three times the friction: no name, and nothing to say.
    let shaken = of(&|t, _, _| 9.0 * (3.0 * (2.3 * t).sin() + 5.0 * (0.7 * t).cos()).sin());
    assert!(
        shaken.confident().next().is_none(),
        "{:?}",
        shaken.confident().map(|e| e.id()).collect::<Vec<_>>()
    );
    assert_ne!(shaken.verdict, Verdict::Consistent);
}

/// The machine's blocks with their displacements times a factor, the friction the same.
fn stretched(factor: f64) -> [(f64, f64); 3] {
    BLOCKS.map(|(k, d)| (k / factor, d * factor))
}

#[test]
fn a_hysteresis_that_is_too_soft_is_a_parameter_and_one_that_is_too_stiff_may_be_a_gap() {
    // Pre-sliding over a good part of the strokes: displacements would hardly matter otherwise.
    let recording = made_of(&stretched(10.0), |_, _, _| 0.0);
    let friction = |factor: f64| {
        let blocks = stretched(10.0 * factor);
        FrictionModel::maxwell_slip(&blocks.map(|b| b.0), &blocks.map(|b| b.1))
    };
    let told = |factor: f64| {
        let model = Model::of_friction(MotionKind::Linear, friction(factor));
        let found =
            diagnose(&recording, Some(&model), None, &Progress::new("", 0)).expect("a diagnosis");
        println!("{factor}: {}", found.verdict_words(&recording));
        let id = found.confident().next().map(named::Named::id);
        (found.verdict, id, found.displacement_factor())
    };
    assert_eq!(told(1.0), (Verdict::Consistent, None, None));
    assert_eq!(told(4.0), (Verdict::Consistent, None, Some(0.25)));

    // Nothing beside it: late blocks would stand in for what it lacks.
    let null = null(&recording);
    let alone = null.fit(&[]).expect("a fit");
    let shape = |factor: f64| {
        let shape = hysteresis::Shape::of(&null, &alone, &friction(factor)).expect("a shape");
        println!("{factor}: {:?} % {:?}", shape.nmse, shape.shorter);
        (shape.is_wrong(), shape.displacement_factor())
    };
    assert_eq!(shape(1.0), (false, None));
    assert_eq!(shape(0.01), (true, None));
}

/// The machine beside a measured temperature, from time.
fn beside_temperature(temperature: impl Fn(f64) -> f64) -> Recording {
    let mut recording = made(|_, _, _| 0.0);
    let times = (0..SAMPLES).map(|i| i as f64 * STEP_S);
    recording.temperature_c = Some(times.map(temperature).collect());
    recording
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn friction_that_follows_a_measured_temperature_is_named_though_friction_wanders() {
    const PER_KELVIN: f64 = -0.03;
    let temperature = |t: f64| 25.0 - 3.0 * (0.4 * t).cos();
    let told = |seed: u64, per_kelvin: f64| {
        let mut recording = beside_temperature(temperature);
        let level = wandering(&recording.position, seed);
        let friction = friction(&recording.position);
        for i in 0..SAMPLES {
            let drift = per_kelvin * (temperature(i as f64 * STEP_S) - 25.0);
            recording.effort[i] += (drift + 0.04 * level[i]) * friction[i];
        }
        let found = diagnose(&recording, None, None, &Progress::new("", 0)).expect("a diagnosis");
        println!(
            "seed {seed}, {per_kelvin} 1/K: {}",
            found.verdict_words(&recording)
        );
        let drift = found.confident().find(|e| e.id() == "thermal_drift");
        let words = drift.map(|e| found.sentence(e, &recording));
        drift.map(|e| e.parameters[0].1).zip(words)
    };
    let (mut named, mut held) = (0, 0);
    for seed in 1..=6 {
        assert!(told(seed, 0.0).is_none());
        let Some((drift, words)) = told(seed, PER_KELVIN) else {
            continue;
        };
        let [low, high] = drift.ci95.expect("an interval");
        println!("{} ({low} … {high}) 1/K: {words}", drift.value);
        assert!(high < -0.015 && low > -0.06);
        assert!(words.contains("higher or lower"), "{words}");
        named += 1;
        held += usize::from((low..=high).contains(&PER_KELVIN));
    }
    println!("named in {named} of 6, held by {held}");
    assert!(named >= 5 && held + 1 >= named);
}

#[test]
fn only_warming_cannot_separate_run_in_from_temperature() {
    let declared = |temperature: &dyn Fn(f64) -> f64| {
        let rows = Rows::new(&beside_temperature(temperature), &[]).expect("rows");
        let of = |id: &str| {
            let effect = effect::by_id(id).expect("in the catalogue");
            effect.equivalents(&rows.s).first().copied()
        };
        [of("run_in"), of("thermal_drift")]
    };
    let both = [Some("thermal_drift"), Some("run_in")];
    assert_eq!(declared(&|t| 29.0 - 7.0 * (-t / 10.0).exp()), both);
    assert_eq!(declared(&|t| 22.0 + 7.0 * (-t / 10.0).exp()), both);
    // Up, down and up again; its ends lie as far apart as it goes.
    assert_eq!(declared(&|t| 25.0 - 3.0 * (0.314 * t).cos()), [None, None]);
}

/// A level of deviation one that wanders along the path, correlated over 20 mm.
fn wandering(position: &[f64], seed: u64) -> Vec<f64> {
    const REACH_M: f64 = 0.02;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut now, mut before) = (0.0, position[0]);
    let next = |&x: &f64| {
        let kept = (-(x - before).abs() / REACH_M).exp();
        // A uniform deviate of variance one.
        let fresh = 12.0_f64.sqrt() * uniform(&mut rng);
        now = kept * now + (1.0 - kept * kept).sqrt() * fresh;
        before = x;
        now
    };
    position.iter().map(next).collect()
}

/// Two and a half periods within the travel are found as spots: one ripple says the same with less. Two spots stay two.
#[test]
fn a_ripple_takes_the_place_of_two_spots_and_nothing_that_of_two_true_ones() {
    let spot = |at: f64| {
        let effect = effect::by_id("local_friction_spot").expect("in the catalogue");
        Term::new(Subject::Effect(effect), &[at, 0.01])
    };
    let one_for_two = |level: &dyn Fn(f64) -> f64, places: [f64; 2]| {
        let recording = made(|_, x, v| 3.0 * level(x) * v.signum());
        let null = null(&recording);
        let two = null.fit(&places.map(spot)).expect("a fit");
        let (one, _) = merged(&null, &two, 0, &[])?;
        one.terms.last().cloned()
    };
    let ripple = |x: f64| 0.2 * (std::f64::consts::TAU * x / 0.036).cos();
    let one = one_for_two(&ripple, [0.0, 0.036]).expect("one for two");
    assert_eq!(one.effect().expect("an effect").id(), "periodic_friction");
    assert!((one.shape[0] / 0.036 - 1.0).abs() < 0.02, "{:?}", one.shape);
    let bump = |x: f64, at: f64| 0.3 * (-((x - at) / 0.01).powi(2)).exp();
    let spots = |x: f64| bump(x, -0.02) + bump(x, 0.011);
    assert!(one_for_two(&spots, [-0.02, 0.011]).is_none());
}
