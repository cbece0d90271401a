//! The whole comparison, and its figures on a real recording.

use super::*;
use preslide_fit::recording::{LoadOptions, load, load_csv};
use preslide_host_tests::path::recorded;
use preslide_host_tests::recordings;

fn of_kind<'a>(comparison: &'a Comparison, name: &str) -> &'a Compared {
    comparison
        .models
        .iter()
        .find(|m| m.name().starts_with(name))
        .unwrap_or_else(|| panic!("no {name}"))
}

/// The whole comparison on a recording that Dahl made: Dahl is near the lowest error at the least cost, `identify`'s own model is what to use, and
/// the parameters stand in the JSON.
#[test]
fn finds_the_model_that_made_the_recording() {
    let text = recorded(|v, f| 1e5 * v * (1.0 - f / 0.9 * v.signum()), |_, f| f);
    let recording = load_csv(text.as_bytes(), "made.csv", &LoadOptions::default()).unwrap();
    // Two strokes and more in either part; the rest would take time only.
    let options = Options {
        train: Some((0.0, 7.0)),
        test: Some((7.0, 11.0)),
    };
    let progress = Progress::new("test", steps());
    let comparison = compare(&recording, &options, &progress).unwrap();
    let dahl = of_kind(&comparison, "Dahl");
    assert!(
        dahl.candidate.nmse_test < 3e-3,
        "{}",
        dahl.candidate.nmse_test
    );
    assert!(!dahl.memory.is_nonlocal());
    let gms = of_kind(&comparison, "GMS");
    assert!(gms.memory.is_nonlocal() && gms.candidate.nmse_test > dahl.candidate.nmse_test);
    let page = comparison.page(&recording, String::new());
    let kinds: std::collections::BTreeSet<&str> = comparison
        .models
        .iter()
        .map(|m| m.candidate.model.friction.kind())
        .collect();
    // Every kind has a curve, beside the measured one.
    assert_eq!(page.sections[0].figures[0].series.len(), kinds.len() + 1);
    let json = comparison.to_json(&recording, 1.0);
    assert_eq!(json["schema"], "preslide.comparison/1");
    assert_eq!(json["models"][1]["kind"], "dahl");
    assert!(json["models"][1]["loop_closure_N"].as_f64().unwrap() > 1e-3);
    let stiffness = &json["models"][1]["model"]["friction"]["stiffness_N_per_m"];
    let stiffness = stiffness.as_f64().unwrap();
    assert!((stiffness / 1e5 - 1.0).abs() < 0.02, "{stiffness}");
    let recommendation = comparison.recommendation();
    let of_identify = identify(&recording, &options, &progress).unwrap();
    let wanted = of_identify.best();
    let used = &comparison.models[comparison.recommended].candidate;
    assert_eq!(used.size(), wanted.size());
    assert_eq!(used.nmse_test, wanted.nmse_test);
    assert!(recommendation.starts_with(&of_identify.recommendation));
    assert!(
        recommendation.contains("of their lowest error is Dahl, n = 1 ("),
        "{recommendation}"
    );
    is_the_cheapest_of_the_table(&comparison);
}

/// What is said to be the cheapest near the lowest error is, and keeps the bounds that are stated with it.
fn is_the_cheapest_of_the_table(comparison: &Comparison) {
    let chosen = comparison.cheapest.expect("one that fits");
    let cycles = |m: &Compared| m.cost.as_ref().map_or(f64::INFINITY, |c| c.cycles_mean);
    let takes_part = |m: &&Compared| cycles(m) <= 425.0 && m.candidate.at_edge.is_empty();
    let part: Vec<&Compared> = comparison.models.iter().filter(takes_part).collect();
    let errors = part.iter().map(|m| m.candidate.nmse_test);
    let near = 1.2 * errors.fold(f64::INFINITY, f64::min);
    let chosen = &comparison.models[chosen];
    assert!(takes_part(&chosen) && chosen.candidate.nmse_test <= near);
    for other in part.iter().filter(|m| m.candidate.nmse_test <= near) {
        assert!(cycles(chosen) <= cycles(other), "{}", other.name());
    }
}

/// A law at the bound of its search, or one that no tick has time for, is not the cheapest, and its error bounds no other's.
#[test]
fn a_law_at_its_bound_does_not_take_part() {
    let text = recorded(|v, f| 1e5 * v * (1.0 - f / 0.9 * v.signum()), |_, f| f);
    let recording = load_csv(text.as_bytes(), "made.csv", &LoadOptions::default()).unwrap();
    let found = identify(&recording, &Options::default(), &Progress::new("", 0)).unwrap();
    let scale = Scale {
        amplitude: found.yield_range.1,
        speed: found.top_speed(),
    };
    let model = |error: f64, cycles: f64, at_edge: &[&'static str]| {
        let mut of = judged(found.best().clone(), scale).unwrap();
        (of.candidate.nmse_test, of.candidate.at_edge) = (error, at_edge.to_vec());
        of.cost.as_mut().expect("a cost").cycles_mean = cycles;
        of
    };
    let models = [
        model(0.10, 500.0, &[]),
        model(0.11, 20.0, &["F_c/F_s"]),
        model(0.17, 18.0, &[]),
        model(0.15, 90.0, &[]),
        model(0.19, 10.0, &[]),
    ];
    assert_eq!(cheapest(&models), Some(2));
    assert_eq!(cheapest(&models[..2]), None);
}

/// A real recording, or `None` and a loud line where there is none.
fn real(name: &str) -> Option<Recording> {
    Some(load(&recordings()?.join(name), &LoadOptions::default()).unwrap())
}

/// Some steps of the optimiser lead where no LuGre force resists this motion; the fit must come back from them. A
/// model that contains another must fit no worse.
#[test]
#[ignore = "long study: cargo xtask test --all"]
fn models_fit_no_worse_than_their_special_cases() {
    let Some(recording) = real("pneumatic_seal/O-ring_3bar.csv") else {
        return;
    };
    let progress = Progress::new("test", steps());
    let comparison = compare(&recording, &Options::default(), &progress).unwrap();
    let train = |name: &str| of_kind(&comparison, name).candidate.nmse_train;
    assert!(train("LuGre") < 1.001 * train("Dahl, n = 1"));
    assert!(train("Dahl") < 1.001 * train("Dahl, n = 1"));
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn tribometer() {
    let Some(recording) = real("tribometer_reciprocating/reciprocating_5N.csv") else {
        return;
    };
    let options = Options {
        train: Some((100.0, 145.0)),
        test: Some((145.0, 190.0)),
    };
    let progress = Progress::new("test", steps());
    let comparison = compare(&recording, &options, &progress).unwrap();
    let held_out = |name: &str| of_kind(&comparison, name).candidate.nmse_test;
    assert!(held_out("Coulomb") > 50.0);
    // A free exponent goes to its lower bound, where Dahl's spring is almost one Maxwell-slip block.
    assert!(held_out("Dahl") < 0.30, "{}", held_out("Dahl"));
    assert!(
        (1.0..1.6).contains(&held_out("Dahl, n = 1")),
        "{}",
        held_out("Dahl, n = 1")
    );
    assert!(held_out("LuGre") < 1.6, "{}", held_out("LuGre"));
    assert!(held_out("Hsieh") < 0.35, "{}", held_out("Hsieh"));
    let gms: Vec<&Compared> = comparison
        .models
        .iter()
        .filter(|m| m.candidate.model.friction.kind() == "gms")
        .collect();
    assert!(
        gms.iter()
            .all(|m| m.candidate.nmse_test < 0.30 && m.memory.is_nonlocal())
    );
    assert!(
        comparison
            .recommendation()
            .starts_with("Use GMS with 1 block")
    );
    for open in ["Dahl", "LuGre"] {
        assert!(!of_kind(&comparison, open).memory.is_nonlocal());
    }
}
