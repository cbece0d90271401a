//! What is reported of the user's model, the recording's columns and its clock, before any name.

use super::*;
use column::Kind;
use fit::Fit;
use given::Refitted;
use preslide_fit::effects::Effect;
use preslide_fit::recording::Extra;
use preslide_fit::simulate::force_of_motion;
use std::sync::Arc;

/// The made machine's own model, its friction level and inertia times factors, with viscous friction (N·s/m).
fn model(level: f64, inertia: f64, viscous: f64) -> Model {
    let stiffness = BLOCKS.map(|b| level * b.0);
    Model {
        inertia: inertia * MASS_KG,
        viscous,
        ..Model::of_friction(
            MotionKind::Linear,
            FrictionModel::maxwell_slip(&stiffness, &BLOCKS.map(|b| b.1)),
        )
    }
}

fn told(recording: &Recording, model: Option<&Model>) -> Diagnosis {
    let found = diagnose(recording, model, None, &Progress::new("", 0)).expect("a diagnosis");
    println!("{}", found.verdict_words(recording));
    found
}

fn ids(found: &Diagnosis) -> Vec<&'static str> {
    found.confident().map(|e| e.id()).collect()
}

#[test]
fn reports_wrong_parameters_and_no_right_ones() {
    let recording = made(|_, _, v| 8.0 * v);
    let right = told(&recording, Some(&model(1.0, 1.0, 8.0)));
    assert_eq!(right.verdict, Verdict::Consistent);
    let own = right.given_model.as_ref().expect("a model");
    println!("{} {}", own.stands, own.refitted.test);
    assert!(own.stands < 1.2 * own.refitted.test && own.wrong().next().is_none());
    // Nothing takes more than what the model leaves as it stands.
    assert!(right.baseline.test <= own.stands);
    assert!(right.extended.test <= own.stands);

    for (given, key, name, value) in [
        (
            model(0.7, 1.0, 8.0),
            "breakaway_N",
            "breakaway 2.10 N →",
            3.0,
        ),
        (model(1.0, 0.6, 8.0), "mass_kg", "mass ", MASS_KG),
    ] {
        let found = told(&recording, Some(&given));
        assert_eq!(found.verdict, Verdict::ParametersDiffer, "{key}");
        assert_eq!(found.verdict.name(), "parameters-differ");
        let own = found.given_model.as_ref().expect("a model");
        assert!(
            own.stands > 3.0 * own.refitted.test,
            "{} {}",
            own.stands,
            own.refitted.test
        );
        let wrong: Vec<_> = own.wrong().collect();
        assert_eq!(
            wrong.iter().map(|p| p.key.as_str()).collect::<Vec<_>>(),
            [key]
        );
        let refitted = &wrong[0].found;
        println!("{key} {refitted:?}");
        assert!((refitted.value / value - 1.0).abs() < 0.02, "{refitted:?}");
        assert!(found.recommendation(&recording).contains(name));
        // What is written is never worse than what was given, and says what it replaces.
        let extended = found.extended_model(&recording);
        let written = [
            extended.model.inertia,
            extended.model.friction.breakaway().unwrap(),
        ];
        let written = written[usize::from(key == "breakaway_N")];
        let recommended = found.recommendation(&recording);
        assert!(
            recommended.contains(&wrong[0].change(recording.effort_unit(), written)),
            "{recommended}"
        );
        let left = |m: &Model| {
            force_of_motion(m, &recording)
                .unwrap()
                .agreement
                .unwrap()
                .nmse
        };
        assert!(left(&extended.model) < left(&given));
        let again = told(&recording, Some(&extended.model));
        let stands = |d: &Diagnosis| d.given_model.as_ref().map(|g| g.stands);
        assert!(stands(&again) < stands(&found).map(|s| s / 3.0));
        assert!(!extended.replaces.is_empty());
        assert_eq!(again.verdict, Verdict::Consistent);
    }
}

/// What the figures show before and after is what the texts have the size of, whichever law leaves it.
#[test]
fn figures_show_what_the_texts_say() {
    let stiff = made_of(&[(3e5, 1e-5)], |_, _, v| 8.0 * v + 0.5);
    let plain = made(|_, _, v| 8.0 * v);
    let fit = |r: &Recording| Arc::new(Fit::of(r));
    for (recording, given, fit) in [
        (&plain, Some(model(0.7, 1.0, 8.0)), None),
        (&plain, Some(model(1.0, 1.0, 8.0)), None),
        (&plain, None, Some(fit(&plain))),
        (&stiff, None, Some(fit(&stiff))),
    ] {
        let found = diagnose(recording, given.as_ref(), fit, &Progress::new("", 0));
        let found = found.expect("a diagnosis");
        let rows = &found.null.rows;
        let before = found
            .given_model
            .as_ref()
            .map_or(found.baseline.test, |g| g.stands);
        let said = [before, found.extended.test].map(|nmse| rows.rms_of(nmse));
        let shown = found
            .mismatch
            .each_ref()
            .map(|left| rows.rms_of(rows.nmse(left)));
        let core = rows.rms_of(rows.nmse(&found.states[0].residual(rows)));
        println!("{said:?} {shown:?} {core}");
        for (said, shown) in said.iter().zip(shown) {
            // Held out a little more is left than of what is fitted.
            assert!((shown / said - 1.0).abs() < 0.05, "{said} {shown}");
        }
    }
}

/// A fit has one constant force, whatever part of it is friction that differs by direction: both are named, with what is known of them.
#[test]
fn a_constant_force_of_the_fit_may_be_friction_by_direction() {
    for (constant, told) in [(0.5, true), (0.0, false)] {
        let recording = made(|_, _, v| 8.0 * v + constant);
        let fit = Some(Arc::new(Fit::of(&recording)));
        let found = diagnose(&recording, None, fit, &Progress::new("", 0)).expect("a diagnosis");
        let words = found
            .in_fit_words(&recording)
            .expect("viscous friction at least");
        println!("{words}");
        assert_eq!(words.contains("In sliding, a constant force"), told);
        assert_eq!(
            words.contains("may be either or some of each (all of it as friction: 3.0"),
            told
        );
    }
}

/// Friction that reverses with the speed is no law of a model file: a refit on another is bent to it, and is neither said nor written. The figures
/// are those beside the machine's own law.
#[test]
fn parameters_of_another_law_are_not_refitted() {
    let recording = made_of(&[], |_, _, v| 3.0 * (v / 2e-3).tanh() + 8.0 * v);
    let coulomb = FrictionModel::Coulomb { coulomb: 2.5 };
    let given = Model {
        inertia: MASS_KG,
        viscous: 12.0,
        ..Model::of_friction(MotionKind::Linear, coulomb)
    };
    let found = told(&recording, Some(&given));
    let words = found.verdict_words(&recording);
    assert!(words.contains("the friction law is another"), "{words}");
    let extended = found.extended_model(&recording);
    assert!(extended.is_as_given, "{:?}", extended.replaces);
    assert_eq!(extended.model.viscous, given.viscous);
    assert_eq!(found.wrong().count(), 0);
    let own = found.given_model.as_ref().expect("a model");
    for (key, value) in [("coulomb_N", 3.0), ("viscous_N_s_per_m", 8.0)] {
        let own = own.parameters.iter().find(|p| p.key == key);
        let beside = own.expect("a parameter").found.value;
        println!("{key} {beside}, {value} made");
        assert!((beside / value - 1.0).abs() < 0.05, "{key} {beside}");
    }
}

/// Viscous friction of each direction is two numbers: a model that has it is not split into three.
#[test]
fn viscous_friction_by_direction_is_told_once() {
    let recording = made(|_, _, v| 8.0 * v + 3.0 * v.abs());
    let mut given = model(1.0, 1.0, 8.0);
    given
        .effects
        .push(Effect::of(&form::VISCOUS_ASYMMETRY, &[1.0]));
    let found = told(&recording, Some(&given));
    let own = found.given_model.as_ref().expect("a model");
    let wrong: Vec<&str> = own.wrong().map(|p| p.key.as_str()).collect();
    assert_eq!(wrong, ["viscous_asymmetry.half_difference_N_s_per_m"]);
    assert!(own.parameters.iter().all(|p| !p.key.ends_with("back")));
}

/// What is written leaves no more by the simulation that users make.
#[test]
fn a_refit_that_simulates_worse_is_not_written() {
    let recording = made(|_, _, v| 8.0 * v);
    let left = |m: &Model| {
        let found = force_of_motion(m, &recording).expect("a simulation");
        found.agreement.expect("an effort").nmse
    };
    for given in [model(1.0, 1.0, 8.0), model(0.9, 1.0, 8.0)] {
        let found = told(&recording, Some(&given));
        let extended = found.extended_model(&recording);
        let (before, after) = (left(&given), left(&extended.model));
        println!("{before} {after}");
        assert!(after < before || (extended.is_as_given && after == before));
        // What is said of -o is what it writes, and the refit otherwise.
        let words = found.given_words(&recording).expect("a model");
        let says = |what: &str| words.contains(what);
        assert_eq!(says("-o writes it as it is"), extended.is_as_given);
        assert_eq!(
            says("-o writes a finer hysteresis"),
            extended.is_on_the_core
        );
        let given = found.given_model.as_ref().expect("a model");
        let is_refit = |p: &Refitted| found.written_of(p, &recording) == p.found.value;
        assert!(says("-o writes") || given.parameters.iter().all(is_refit));
    }
}

#[test]
fn missing_physics_is_no_wrong_parameter() {
    let recording = made(|_, x, v| 8.0 * v + 0.5 * (x / 8e-4).sin());
    let found = told(&recording, Some(&model(1.0, 1.0, 8.0)));
    assert_eq!(found.verdict, Verdict::MissingPhysics);
    assert_eq!(ids(&found), ["periodic_force"]);
    let own = found.given_model.as_ref().expect("a model");
    assert!(own.wrong().next().is_none());
}

#[test]
fn the_budget_begins_with_the_model_as_it_stands() {
    let recording = made(|_, x, v| 8.0 * v + 0.5 * (x / 8e-4).sin());
    let found = told(&recording, Some(&model(1.0, 0.6, 8.0)));
    assert_eq!(ids(&found), ["periodic_force"]);
    assert!(
        found
            .verdict_words(&recording)
            .contains("wrong in the model: mass")
    );
    assert!(found.recommendation(&recording).contains("correct mass "));
    let budget = found.budget_json();
    let items = budget["items"].as_array().expect("items");
    let share = |what: &str| {
        let item = items.iter().find(|item| item["what"] == what);
        item.and_then(|item| item["share"].as_f64()).expect(what)
    };
    let [parameters, ripple] = ["parameters", "periodic_force"].map(share);
    println!("{budget:#}");
    // The ripple has 0.125 N²; the mass that lacks, the rest.
    let stands = found.given_model.as_ref().expect("a model").stands;
    let of_ripple = 0.125 / found.null.rows.rms_of(stands).powi(2);
    assert!(
        (ripple - of_ripple).abs() < 0.03,
        "{ripple}, true {of_ripple}"
    );
    assert!(
        (parameters + ripple - 1.0).abs() < 0.05,
        "{parameters} {ripple}"
    );
}

#[test]
fn a_long_delay_is_a_shift() {
    for delay in [0.016, -0.024] {
        let mut recording = made(|_, _, v| 8.0 * v);
        let samples = (delay / STEP_S) as i64;
        let prompt = recording.effort.clone();
        let last = prompt.len() as i64 - 1;
        for (i, f) in recording.effort.iter_mut().enumerate() {
            *f = prompt[(i as i64 - samples).clamp(0, last) as usize];
        }
        let found = told(&recording, Some(&model(1.0, 1.0, 8.0)));
        assert_eq!(ids(&found), ["channel_delay"]);
        let stated = &found.confident().next().expect("a delay").parameters[0];
        println!("{stated:?}");
        assert_eq!(stated.0, "delay_s");
        assert!((stated.1.value / delay - 1.0).abs() < 0.03, "{stated:?}");
        assert!(found.extended.test < 0.3 * found.baseline.test);
        let extended = found.extended_model(&recording);
        assert!(
            extended
                .model
                .effects
                .iter()
                .any(|e| e.id() == "channel_delay")
        );
    }
    let prompt = told(&made(|_, _, v| 8.0 * v), Some(&model(1.0, 1.0, 8.0)));
    assert!(
        !prompt
            .effects
            .iter()
            .any(|e| e.id() == "channel_delay" && e.confident)
    );
}

/// A model that has the delay is told so, and one that has another is told which.
#[test]
fn a_delay_that_the_model_has_is_said_and_a_wrong_one_corrected() {
    let late = |delay: f64| {
        let mut late = model(1.0, 1.0, 8.0);
        let effect = Effect::new("channel_delay", &[("delay_s", delay)]).expect("valid");
        late.effects.push(effect);
        late
    };
    let mut recording = made(|_, _, v| 8.0 * v);
    let prompt = recording.effort.clone();
    let effort = recording.effort.iter_mut().enumerate();
    effort.for_each(|(i, f)| *f = prompt[i.saturating_sub(8)]);
    let said = "the effort is recorded 16.";
    let right = told(&recording, Some(&late(0.016)));
    assert_eq!(right.verdict, Verdict::Consistent);
    let words = right.verdict_words(&recording);
    assert!(words.contains(said) && words.contains("the model allows for it"));

    let wrong = told(&recording, Some(&late(0.005)));
    assert_eq!(wrong.verdict, Verdict::ParametersDiffer);
    let words = wrong.verdict_words(&recording);
    assert!(words.contains(said) && words.contains("the model allows for 5"));
    let keys: Vec<&str> = wrong.wrong().map(|p| p.key.as_str()).collect();
    assert_eq!(keys, ["channel_delay.delay_s"]);
    let written = &wrong.extended_model(&recording).model;
    let delays: Vec<f64> = (written.effects.iter())
        .filter(|e| e.id() == "channel_delay")
        .map(|e| e.get("delay_s"))
        .collect();
    assert!(
        matches!(delays.as_slice(), [one] if (one / 0.016 - 1.0).abs() < 0.03),
        "{delays:?}"
    );
}

#[test]
fn a_spring_has_its_own_centre() {
    let recording = made(|_, x, _| 60.0 * (x - 0.04));
    let found = told(&recording, None);
    assert_eq!(ids(&found), ["position_spring"]);
    let [stiffness, centre] = [0, 1].map(|k| found.effects[0].parameters[k].1);
    println!("{stiffness:?} {centre:?}");
    assert!((stiffness.value / 60.0 - 1.0).abs() < 0.05);
    assert!((centre.value - 0.04).abs() < 0.003);
    let [low, high] = centre.ci95.expect("an interval");
    assert!(low < 0.04 && 0.04 < high && high - low < 0.02);
}

/// The recording with further columns: what a force was computed from, its own command, and another axis.
#[test]
fn a_column_of_the_effort_couples_to_nothing() {
    let drag = |v: f64| 8.0 * v;
    let other = |t: f64| 0.02 * (2.7 * t).sin();
    let mut recording = made(|t, _, v| drag(v) + 30.0 * other(t));
    let (effort, position) = (recording.effort.clone(), recording.position.clone());
    let at = |i: usize| i as f64 * STEP_S;
    let mut add = |name: &str, values: Vec<f64>| {
        let name = name.to_owned();
        recording.extra.push(Extra { name, values });
    };
    let late = |i: usize| effort[i.saturating_sub(3)];
    let noise = |i: usize| 0.3 * (at(i) * at(i) * 977.0).sin();
    add(
        "i_q",
        (0..SAMPLES)
            .map(|i| 0.25 * late(i) + 0.25 * noise(i))
            .collect(),
    );
    add(
        "x_ref",
        (0..SAMPLES)
            .map(|i| position[(i + 4).min(SAMPLES - 1)])
            .collect(),
    );
    add("other_m", (0..SAMPLES).map(|i| other(at(i))).collect());
    let found = told(&recording, None);
    let left_out: Vec<(&str, Kind)> = found
        .null
        .rows
        .s
        .left_out
        .iter()
        .map(|(n, k)| (n.as_str(), *k))
        .collect();
    assert_eq!(
        left_out,
        [("i_q", Kind::Effort), ("x_ref", Kind::OwnMotion)]
    );
    let mut named = ids(&found);
    named.sort_unstable();
    assert_eq!(named, ["axis_coupling", "viscous"]);
}

#[test]
fn expected_noise_is_never_more_than_what_is_left() {
    let shaken = |t: f64| 9.0 * (3.0 * (2.3 * t).sin() + 5.0 * (0.7 * t).cos()).sin();
    for found in [
        told(&made(|t, _, _| shaken(t)), None),
        told(&made(|_, _, v| 8.0 * v), None),
        told(&made(|_, _, _| 0.0), None),
    ] {
        assert!(found.noise_floor <= found.extended.test);
    }
    // Where noise is all that is left, it is measured as that; where a force is, it is not.
    let clean = told(&made(|_, _, _| 0.0), None);
    assert!(
        clean.noise_floor > 0.7 * clean.extended.test,
        "{} {}",
        clean.noise_floor,
        clean.extended.test
    );
    let recording = made(|t, _, _| shaken(t));
    let slow = told(&recording, None);
    assert!(slow.noise_floor < 0.1 * slow.extended.test);
    assert!(
        !slow
            .recommendation(&recording)
            .contains("what is left is noise")
    );
}

/// Cogging stands out of waves of the state; a line where there is none does not.
#[test]
fn a_line_is_held_against_placebos() {
    let period = 5e-3;
    let recording = made(|_, x, _| 0.15 * (std::f64::consts::TAU * x / period).cos());
    let null = null(&recording);
    let rest = null.fit(&[by_id("channel_delay")]).expect("a fit");
    let of = |period: f64| {
        let effect = effect::by_id("periodic_force").expect("in the catalogue");
        let term = Term::new(Subject::Effect(effect), &[period]);
        placebo::over_state(&null, &rest, &term).expect("columns")
    };
    let (there, absent) = (of(period), of(0.7 * period));
    println!("{there:?} {absent:?}");
    assert!(there > 2.0 && absent < 1.0);
}

#[test]
fn friction_does_not_push() {
    let asymmetry = by_id("coulomb_asymmetry");
    assert!(asymmetry.admits(&[0.4]) && asymmetry.admits(&[-0.9]));
    assert!(!asymmetry.admits(&[1.74]) && !asymmetry.admits(&[-1.1]));
}

/// Friction that falls with time is reported without a temperature column, with run-in as likely.
#[test]
fn warming_shows_without_a_thermometer() {
    let recording = made(|t, _, v| 1.5 * v.signum() * ((-t / 12.0).exp() - 0.5));
    let found = told(&recording, None);
    let drift = found
        .confident()
        .find(|e| matches!(e.id(), "thermal_drift" | "run_in"));
    let drift = drift.expect("a drift");
    let rivals: Vec<&str> = drift.ambiguous.iter().map(|e| e.id()).collect();
    println!("{} {rivals:?}", drift.id());
    assert!(rivals.contains(&"thermal_drift") || rivals.contains(&"run_in"));
    assert!(
        !found
            .lacks
            .iter()
            .any(|l| l.hides.iter().any(|e| e.id() == drift.id()))
    );
}
