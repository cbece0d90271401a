//! Plain physics in `identify`: gravity, a spring, viscous friction of each direction, what few reversals show. Made machines, whose
//! parameters are known, and the files of `../shared/cases`.

use crate::laws::{BoucWen, Dahl};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::sync::Arc;

use preslide_fit::identify::plain::Place;
use preslide_fit::identify::{Identification, Options, STEPS, identify};
use preslide_fit::model::Model;
use preslide_fit::progress::Progress;
use preslide_fit::recording::{self, LoadOptions, Recording};
use preslide_fit::simulate;
use preslide_host::compare::compare;
use preslide_host::diagnose::diagnose;
use preslide_host::diagnose::fit::Fit;
use preslide_host_tests::made::{Blocks, sines};
use preslide_host_tests::shared;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// 0.12 kg·m² with two blocks of 1.1 N·m, and a force of the position.
struct Machine {
    /// Viscous friction forwards and backwards.
    viscous: [f64; 2],
    /// Weight and the angle where it hangs.
    gravity: [f64; 2],
    /// Stiffness and centre.
    spring: [f64; 2],
    /// Amplitude and period of what the encoder shows too much.
    encoder: [f64; 2],
    /// Share of friction that it is more at rest, and the speed within which it falls.
    stribeck: [f64; 2],
    /// Torque and angular frequency of what shakes it from outside: it gives way by half, the other half is the drive's.
    shaken: [f64; 2],
}

const BARE: Machine = Machine {
    viscous: [0.3, 0.3],
    gravity: [0.0; 2],
    spring: [0.0; 2],
    encoder: [0.0, 1.0],
    stribeck: [0.0, 1.0],
    shaken: [0.0, 1.0],
};

const INERTIA: f64 = 0.12;
const COULOMB: f64 = 1.1;
const BLOCKS: [(f64, f64); 2] = [(300.0, 2e-3), (62.5, 8e-3)];

/// 60 s at 500 Hz along three sines; noise of 20 mN·m, an angle in steps of 10 µrad. `names` are the columns.
fn made(machine: &Machine, seed: u64, names: &str) -> Recording {
    made_of(30_000, machine, seed, names)
}

fn made_of(rows: u32, machine: &Machine, seed: u64, names: &str) -> Recording {
    let mut blocks = Blocks::new(&BLOCKS);
    made_by(&mut |q, _| blocks.force(q), rows, machine, seed, names)
}

/// With another friction, of an angle and a speed.
fn made_by(
    friction: &mut dyn FnMut(f64, f64) -> f64,
    rows: u32,
    machine: &Machine,
    seed: u64,
    names: &str,
) -> Recording {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let waves = [(1.1, 0.9), (0.35, 3.7), (0.1, 9.1)];
    let [torque, shaken] = machine.shaken;
    let gives_way = [0.5 * torque / (INERTIA * shaken * shaken), shaken, 0.7];
    let waves = waves.map(|(a, w)| [a, w, TAU * rng.random::<f64>()]);
    let waves: Vec<[f64; 3]> = waves.into_iter().chain([gives_way]).collect();
    let mut text = format!("t_s,{names}\n");
    for i in 0..rows {
        let t = f64::from(i) * 2e-3;
        let [q, v, acceleration] = sines(&waves, t);
        let mut effort = INERTIA * acceleration + machine.viscous[usize::from(v < 0.0)] * v;
        let level = 1.0 + machine.stribeck[0] * (-v.abs() / machine.stribeck[1]).exp();
        effort += level * friction(q, v);
        effort += machine.gravity[0] * (q - machine.gravity[1]).sin();
        effort += machine.spring[0] * (q - machine.spring[1]);
        effort -= torque * (shaken * t).cos();
        effort += rng.random_range(-0.035..0.035);
        let shown = q + machine.encoder[0] * (TAU * q / machine.encoder[1]).sin();
        writeln!(text, "{t:.3},{shown:.5},{effort:.5}").expect("memory");
    }
    let loaded = recording::load_csv(text.as_bytes(), "made.csv", &LoadOptions::default());
    loaded.unwrap_or_else(|e| panic!("{e}"))
}

fn run(recording: &Recording) -> Identification {
    let progress = Progress::new("test", STEPS);
    identify(recording, &Options::default(), &progress).unwrap_or_else(|e| panic!("{e}"))
}

/// A parameter and its interval.
fn of(found: &Identification, name: &str) -> (f64, [f64; 2]) {
    let mut parameters = found.best().rigid_body.iter();
    let told = parameters.find(|p| p.0 == name);
    let (_, estimate) =
        told.unwrap_or_else(|| panic!("no {name} in {:?}", found.best().rigid_body));
    (estimate.value, estimate.ci95.expect("an interval"))
}

/// Asserts a value within `tolerance`, and that its interval is no wider than three times that.
fn holds(found: &Identification, name: &str, truth: f64, tolerance: f64) {
    let (value, [low, high]) = of(found, name);
    println!("  {name} {value:.5} ({low:.5} … {high:.5}), true {truth}");
    assert!((value - truth).abs() < tolerance, "{name}: {value}");
    assert!(high - low < 3.0 * tolerance, "{name}: {low} … {high}");
}

/// A file in `../shared/cases`.
fn case(name: &str) -> Option<Recording> {
    let file = shared("cases")?.join(name);
    if !file.exists() {
        println!("SKIPPED: no {name} in ../shared/cases");
        return None;
    }
    let loaded = recording::load(&file, &LoadOptions::default());
    Some(loaded.unwrap_or_else(|e| panic!("{e}")))
}

#[test]
fn gravity_a_spring_and_viscous_friction_by_direction_are_told_from_coulomb_friction() {
    told_from_coulomb_friction(&[3]);
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn more_seeds_are_told_from_coulomb_friction() {
    told_from_coulomb_friction(&[17, 40]);
}

fn told_from_coulomb_friction(seeds: &[u64]) {
    for &seed in seeds {
        println!("seed {seed}");
        let bare = run(&made(&BARE, seed, "q_rad,torque_Nm"));
        assert_eq!(bare.plain.place, Place::Nowhere);
        assert!(!bare.plain.by_direction);

        let gravity = [0.24, 0.4];
        let recording = made(&Machine { gravity, ..BARE }, seed, "q_rad,torque_Nm");
        let found = run(&recording);
        assert_eq!(found.plain.place, Place::Gravity);
        holds(&found, "gravity", gravity[0], 0.01);
        holds(&found, "gravity_angle", gravity[1], 0.06);
        holds(&found, "coulomb", COULOMB, 0.02);
        // Coulomb friction alone has the same.
        let alone = &found.candidates[0].rigid_body;
        assert!(alone.iter().any(|p| p.0 == "gravity"), "{alone:?}");
        the_file_says_the_same(&found, &recording);

        // One that pulls back, and one that pushes, as magnets do.
        for spring in [[1.5, -0.2], [-1.5, -0.2]] {
            let recording = made(&Machine { spring, ..BARE }, seed, "x_m,force_N");
            let found = run(&recording);
            assert_eq!(found.plain.place, Place::Spring);
            holds(&found, "spring", spring[0], 0.02);
            holds(&found, "spring_centre", spring[1], 0.02);
            holds(&found, "coulomb", COULOMB, 0.02);
            the_file_says_the_same(&found, &recording);
        }

        let viscous = [0.36, 0.28];
        let recording = made(&Machine { viscous, ..BARE }, seed, "q_rad,torque_Nm");
        let found = run(&recording);
        assert!(found.plain.by_direction);
        holds(&found, "viscous_forward", viscous[0], 0.02);
        holds(&found, "viscous_backward", viscous[1], 0.02);
        the_file_says_the_same(&found, &recording);
    }
}

/// The model file, read again, has the force of the fit.
fn the_file_says_the_same(found: &Identification, recording: &Recording) {
    let text = found.best().model.to_toml(&[]);
    let model = Model::parse(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let simulated = simulate::force_of_motion(&model, recording).expect("same axis");
    let agreement = simulated.agreement.expect("has a force");
    let pairs = agreement.measured.iter().zip(&agreement.simulated);
    let errors: Vec<f64> = pairs.map(|(m, s)| m - s).collect();
    let n = errors.len() as f64;
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt();
    let bias = errors.iter().sum::<f64>() / n;
    println!("  of the file: RMS {rms:.4}, bias {bias:.5}");
    assert!(rms < 0.03 && bias.abs() < 2e-3, "{rms} {bias}\n{text}");
}

/// Half an encoder line of 1024, which at 1 rad/s is acceleration of 500 rad/s² that no torque makes.
#[test]
fn an_encoders_periodic_error_takes_nothing_off_the_inertia() {
    an_encoders_periodic_error(11);
}

fn an_encoders_periodic_error(seed: u64) {
    const ERROR: f64 = 4e-5;
    let machine = Machine {
        encoder: [ERROR, TAU / 360.0],
        ..BARE
    };
    let recording = made(&machine, seed, "q_rad,torque_Nm");
    let found = run(&recording);
    println!("seed {seed}, below {:.1} Hz", found.band_hz);
    let notes = found.notes(&recording).concat();
    assert!(notes.contains("shows less inertia than below"), "{notes}");
    holds(&found, "mass", INERTIA, 0.02 * INERTIA);
    holds(&found, "coulomb", COULOMB, 0.02 * COULOMB);
    let progress = Progress::new("test", 100);
    let found = diagnose(&recording, None, None, &progress).unwrap_or_else(|e| panic!("{e}"));
    let named = found.confident().filter(|e| e.id() != "viscous");
    let named: Vec<_> = named.map(|e| (e.id(), &e.parameters)).collect();
    println!("  {named:?}");
    let [("encoder_error", parameters)] = named.as_slice() else {
        panic!("{named:?}");
    };
    let error = parameters[0].1.value;
    assert!((error / ERROR - 1.0).abs() < 0.05, "{error}");
}

/// What shakes the axis moves it as well: fitted without it, inertia and a delay answer for it.
#[test]
fn what_shakes_the_axis_takes_nothing_off_the_inertia() {
    what_shakes_the_axis(18);
}

fn what_shakes_the_axis(seed: u64) {
    const TORQUE: f64 = 0.4;
    const HZ: f64 = 13.37;
    let machine = Machine {
        shaken: [TORQUE, TAU * HZ],
        ..BARE
    };
    let found = run(&made(&machine, seed, "q_rad,torque_Nm"));
    let [line] = found.channel.vibrations.as_slice() else {
        panic!("{:?}", found.channel.vibrations);
    };
    println!("seed {seed}: {line:?}");
    assert!((line.frequency_hz - HZ).abs() < 1e-3, "{line:?}");
    assert!((line.force.value / TORQUE - 1.0).abs() < 0.03, "{line:?}");
    assert!(found.channel.delay.is_none(), "{:?}", found.channel.delay);
    holds(&found, "mass", INERTIA, 0.02 * INERTIA);
    holds(&found, "coulomb", COULOMB, 0.02 * COULOMB);
    let still = run(&made(&BARE, seed, "q_rad,torque_Nm"));
    assert!(still.channel.vibrations.is_empty());
}

/// Counts of the encoder let no acceleration be known above some 20 Hz: a hum there is in the effort all the same.
#[test]
fn reports_a_hum_above_the_motion_band() {
    a_hum_above_the_motion_band(20);
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn a_second_seed_hides_no_ripple_of_encoder_or_effort() {
    an_encoders_periodic_error(12);
    what_shakes_the_axis(19);
    a_hum_above_the_motion_band(21);
}

fn a_hum_above_the_motion_band(seed: u64) {
    const COUNT: f64 = 2e-3;
    const TORQUE: f64 = 0.2;
    const HZ: f64 = 71.3;
    let mut recording = made(&BARE, seed, "q_rad,torque_Nm");
    let position = recording.position.iter_mut();
    position.for_each(|q| *q = COUNT * (*q / COUNT).round());
    let still = run(&recording);
    assert!(still.channel.vibrations.is_empty());
    let times = recording.t_s.clone();
    let effort = recording.effort.iter_mut().zip(times);
    effort.for_each(|(effort, t)| *effort += TORQUE * (TAU * HZ * t + 0.5).cos());
    let found = run(&recording);
    let [line] = found.channel.vibrations.as_slice() else {
        panic!("{:?}", found.channel.vibrations);
    };
    println!("seed {seed}, up to {:.1} Hz: {line:?}", found.band_hz);
    assert!(line.is_above && found.band_hz < HZ);
    assert!((line.frequency_hz - HZ).abs() < 1e-3, "{line:?}");
    assert!((line.force.value / TORQUE - 1.0).abs() < 0.03, "{line:?}");
    let fit = Arc::new(Fit::of(&recording));
    let progress = Progress::new("test", STEPS);
    let told = diagnose(&recording, None, Some(fit), &progress).expect("a diagnosis");
    let names: Vec<&str> = told.missing().map(|e| e.id()).collect();
    assert_eq!(names, ["external_vibration"]);
    let force = told.missing().flat_map(|e| &e.force);
    let largest = force.fold(0.0, |most: f64, f| most.max(f.abs()));
    assert!((largest / TORQUE - 1.0).abs() < 0.03, "{largest}");
}

/// Then neither Coulomb nor viscous friction is what it would be by itself, and the interval reaches to that.
#[test]
fn friction_that_falls_with_the_speed_is_told() {
    for (more, told) in [(0.0, false), (0.3, true)] {
        let machine = Machine {
            stribeck: [more, 0.3],
            ..BARE
        };
        let recording = made(&machine, 17, "q_rad,torque_Nm");
        let found = run(&recording);
        let (viscous, interval) = of(&found, "viscous");
        println!("{more}: viscous {viscous:.4} {interval:.4?}, true 0.3");
        let notes = found.notes(&recording).concat();
        assert_eq!(notes.contains("at the slowest speeds"), told, "{notes}");
        let holds = (interval[0]..=interval[1]).contains(&0.3);
        assert!(holds, "{interval:?}");
    }
}

/// No number of blocks is Dahl's law or `tanh`: what they leave repeats with every stroke, and no scatter of strokes shows how it bends the rest.
#[test]
fn intervals_reach_to_what_other_laws_make_of_a_parameter() {
    intervals_reach_to_the_truth(&[20]);
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn intervals_reach_to_what_other_laws_make_of_a_parameter_on_three_seeds() {
    intervals_reach_to_the_truth(&[20, 21, 22]);
}

fn intervals_reach_to_the_truth(seeds: &[u64]) {
    type Law = fn() -> Box<dyn FnMut(f64, f64) -> f64>;
    let dahl: Law = || {
        let mut bristle = Dahl {
            stiffness: COULOMB / 4e-3,
            coulomb: COULOMB,
            exponent: 1.0,
            force: 0.0,
        };
        let mut last = None;
        Box::new(move |q, _| bristle.advance(q - last.replace(q).unwrap_or(q)))
    };
    let bouc_wen: Law = || {
        let mut spring = BoucWen::new(COULOMB / 8e-3, COULOMB, 1.2, 0.65);
        let mut last = None;
        Box::new(move |q, _| spring.advance(q - last.replace(q).unwrap_or(q)))
    };
    let smooth: Law = || Box::new(|_, v| COULOMB * (v / 0.05).tanh());
    let (mut held, mut all) = (0, 0);
    for (law, friction) in [("Dahl", dahl), ("Bouc-Wen", bouc_wen), ("tanh", smooth)] {
        for &seed in seeds {
            println!("{law}, seed {seed}");
            let recording = made_by(&mut friction(), 30_000, &BARE, seed, "q_rad,torque_Nm");
            let found = run(&recording);
            for (name, truth) in [("mass", INERTIA), ("viscous", 0.3), ("coulomb", COULOMB)] {
                let (value, interval) = of(&found, name);
                println!("  {name} {value:.5} {interval:.5?}, true {truth}");
                held += usize::from((interval[0]..=interval[1]).contains(&truth));
                all += 1;
            }
            let notes = found.notes(&recording).concat();
            assert_eq!(
                notes.contains("as tanh(v/v0) does"),
                law == "tanh",
                "{notes}"
            );
        }
    }
    println!("{held} of {all} hold the truth");
    assert!(held + 1 >= all, "{held} of {all}");
}

/// What a filter carries in from before the first sample is nobody's.
#[test]
fn what_was_cut_from_a_motion_is_not_fitted_at_its_ends() {
    const SEED: u64 = 14;
    println!("seed {SEED}");
    let mut recording = made_of(10_000, &BARE, SEED, "q_rad,torque_Nm");
    let first = recording.effort.iter_mut().take(10).enumerate();
    first.for_each(|(i, f)| *f += 12.0 * (-(i as f64) / 3.0).exp());
    let found = run(&recording);
    holds(&found, "viscous", 0.3, 5e-3);
    holds(&found, "coulomb", COULOMB, 5e-3);
    holds(&found, "mass", INERTIA, 1e-3);
}

/// The force of a spring about a place beyond the travel is nearly constant: it is of the fit all the same.
#[test]
fn the_spring_of_the_fit_has_its_centre_wherever_that_is() {
    let machine = Machine {
        spring: [3.0, 4.0],
        ..BARE
    };
    let recording = made(&machine, 13, "q_rad,torque_Nm");
    let found = run(&recording);
    holds(&found, "spring", 3.0, 0.02);
    holds(&found, "spring_centre", 4.0, 0.05);
    let fit = Some(Arc::new(Fit::of(&recording)));
    let found = diagnose(&recording, None, fit, &Progress::new("test", 0));
    let found = found.unwrap_or_else(|e| panic!("{e}"));
    let missing: Vec<&str> = found.missing().map(|e| e.id()).collect();
    assert!(missing.is_empty(), "{missing:?}");
    let spring = found.in_fit().find(|e| e.id() == "position_spring");
    let centre = spring.expect("a spring").parameters[1].1.value;
    println!("  the diagnosis' centre {centre:.3} rad");
    assert!((centre - 4.0).abs() < 0.1, "{centre}");
}

#[test]
fn every_command_reports_the_same_fit() {
    the_fit_is_the_same([made_of(2_500, &BARE, 5, "q_rad,torque_Nm")]);
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn every_command_tells_the_same_fit_of_long_recordings() {
    let long = made(&BARE, 5, "q_rad,torque_Nm");
    the_fit_is_the_same([long].into_iter().chain(case("gravity_small_0.6Nm.csv")));
}

fn the_fit_is_the_same(recordings: impl IntoIterator<Item = Recording>) {
    for recording in recordings {
        let fit = run(&recording).to_json(&recording, 0.0)["fit"].clone();
        let progress = Progress::new("test", 100);
        let compared = compare(&recording, &Options::default(), &progress);
        let compared = compared.unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(fit, compared.to_json(&recording, 0.0)["fit"]);
        assert_eq!(fit, Fit::of(&recording).to_json(&recording));
        for key in ["nmse_held_out", "parameters", "law", "rows"] {
            assert!(!fit[key].is_null(), "{key}: {fit}");
        }
    }
}

#[test]
fn the_cases_have_their_right_values() {
    for (name, gravity) in [("0.24", 0.24), ("0.6", 0.6)] {
        if let Some(recording) = case(&format!("gravity_small_{name}Nm.csv")) {
            let found = run(&recording);
            holds(&found, "coulomb", 1.1, 0.01);
            holds(&found, "gravity", gravity, 0.01);
        }
    }
    if let Some(recording) = case("spring_off_centre/rec.csv") {
        let found = run(&recording);
        holds(&found, "spring", 41.0, 4.0);
        let (value, [low, high]) = of(&found, "spring_centre");
        println!("  spring_centre {value} ({low} … {high}), true -0.0021");
        assert!((low..=high).contains(&-2.1e-3) && high - low < 0.03);
    }
}

#[test]
fn a_circle_of_any_radius_has_the_same_blocks() {
    for radius in [30, 50, 100] {
        let Some(recording) = case(&format!("circle_R{radius}.csv")) else {
            return;
        };
        let found = run(&recording);
        println!("radius {radius} mm");
        for (name, truth) in [("mass", 85.0), ("viscous", 300.0)] {
            let (value, [low, high]) = of(&found, name);
            println!("  {name} {value:.2} ({low:.2} … {high:.2}), true {truth}");
            assert!((low..=high).contains(&truth), "{name}: {low} … {high}");
        }
        let stiffest = found.best().blocks[0].1.value;
        println!(
            "  {} blocks, the stiffest yields at {stiffest:.2e} m",
            found.best().size()
        );
        assert_eq!(found.best().size(), 4);
        assert!((stiffest / 0.9e-6 - 1.0).abs() < 0.2, "{stiffest}");
    }
}

#[test]
fn few_reversals_tell_what_they_can() {
    // Forwards it speeds up and backwards it slows down: 0.21 V of friction, and 12e-3 · 2 of inertia.
    if let Some(recording) = case("one_reversal_short.csv") {
        let found = run(&recording);
        assert!(!found.best().rigid_body.iter().any(|p| p.0 == "mass"));
        holds(&found, "coulomb_and_inertia", 0.234, 2e-3);
    }
    for name in [
        "slow-forward",
        "slow-backward",
        "step_at_gap",
        "step_after_rest",
    ] {
        if let Some(recording) = case(&format!("sysid_{name}.csv")) {
            let (value, [low, high]) = of(&run(&recording), "mass");
            println!("{name}: inertia {value:.4} ({low:.4} … {high:.4}), true 0.012");
            assert!((low..=high).contains(&12e-3), "{low} … {high}");
        }
    }
    if let Some(recording) = case("sweep_one_reversal.csv") {
        let found = run(&recording);
        for (name, truth) in [("coulomb", 0.572), ("viscous", 0.522), ("offset", 0.012)] {
            holds(&found, name, truth, 3e-3);
        }
    }
}

/// The parameters of files together, the sysid recordings of those names.
fn together(names: &[&str]) -> Option<Vec<(&'static str, f64, [f64; 2])>> {
    let parts = names.iter().map(|name| case(&format!("sysid_{name}.csv")));
    let whole = Recording::join(parts.collect::<Option<Vec<_>>>()?).expect("one machine");
    let found = run(&whole);
    let notes = found.notes(&whole).concat();
    assert!(!notes.contains("changed"), "{names:?}: {notes}");
    let told = ["coulomb", "viscous", "mass"].map(|name| {
        let (value, interval) = of(&found, name);
        println!("{names:?}: {name} {value:.4} {interval:.4?}");
        (name, value, interval)
    });
    Some(told.into())
}

/// Motors do not know in which order their files are given.
#[test]
fn one_way_files_give_the_same_fit_in_any_order() {
    let orders = [
        [
            "slow-forward",
            "slow-backward",
            "fast-forward",
            "fast-backward",
        ],
        [
            "fast-backward",
            "fast-forward",
            "slow-backward",
            "slow-forward",
        ],
        [
            "fast-backward",
            "slow-forward",
            "fast-forward",
            "slow-backward",
        ],
    ];
    let told: Vec<_> = orders.iter().filter_map(|names| together(names)).collect();
    for each in &told {
        let truths = [(0.21, 0.03), (0.115, 0.03), (12e-3, 0.15)];
        for ((name, value, [low, high]), (truth, share)) in each.iter().zip(truths) {
            assert!((low..=high).contains(&&truth), "{name}: {low} … {high}");
            assert!((value / truth - 1.0).abs() < share, "{name}: {value}");
        }
        for ((name, value, _), (_, first, [low, high])) in each.iter().zip(&told[0]) {
            let apart = (value - first).abs() / (high - low);
            assert!(apart < 0.05, "{name}: {apart} of the interval");
        }
    }
    // Held out alone, the others would show none of these three.
    together(&["slow-forward", "fast-forward", "fast-backward"]);
}

#[test]
fn a_motion_that_is_not_seen_is_not_diagnosed() {
    for name in ["servo_uart_a.csv", "servo_uart_b.csv"] {
        if let Some(recording) = case(name) {
            let said = diagnose(&recording, None, None, &Progress::new("test", 0)).err();
            let said = said.expect("a refusal").to_string();
            assert!(said.contains("within 7 samples"), "{said}");
        }
    }
}

#[test]
fn recognises_stick_slip_by_its_levels() {
    if let Some(recording) = case("breakaway_ramps.csv") {
        let found = run(&recording).stick_slip.expect("slips");
        for (side, truth, spread) in [
            (found.forward, 8.03e-3, 0.30e-3),
            (found.backward, -6.62e-3, 0.24e-3),
        ] {
            let side = side.expect("slips");
            println!(
                "breakaway {:.3e} ± {:.1e}, true {truth}; kinetic {:.3e}",
                side.breakaway.value, side.spread, side.kinetic.value
            );
            assert!((side.breakaway.value - truth).abs() < spread);
            assert!((side.spread / spread - 1.0).abs() < 0.1);
            assert!((side.kinetic.value / truth / 0.6 - 1.0).abs() < 0.1);
        }
    }
    if let Some(recording) = case("hunting_at_rest.csv") {
        let progress = Progress::new("test", 0);
        let identified = identify(&recording, &Options::default(), &progress).err();
        let diagnosed = diagnose(&recording, None, None, &progress)
            .err()
            .map(|e| e.to_string());
        for said in [identified, diagnosed] {
            let said = said.expect("a refusal");
            assert!(
                said.contains("hunts") && said.contains("89.1 ± 1.9 mN·m"),
                "{said}"
            );
        }
    }
}
