//! A diagnosis without a model says what the fit of `identify` has and what it lacks: the files of `../shared/cases` with their right values.

use std::sync::Arc;

use preslide_fit::identify::{Identification, Options, identify};
use preslide_fit::model::Model;
use preslide_fit::progress::Progress;
use preslide_fit::recording::{self, LoadOptions, Recording};
use preslide_host::diagnose::fit::Fit;
use preslide_host::diagnose::named::Named;
use preslide_host::diagnose::verdict::Verdict;
use preslide_host::diagnose::{Diagnosis, diagnose};
use preslide_host_tests::shared;

fn case(name: &str) -> Option<Recording> {
    let file = shared("cases")?.join(name);
    Some(recording::load(&file, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}")))
}

fn told(recording: &Recording) -> Diagnosis {
    told_of(recording, None)
}

fn told_of(recording: &Recording, model: Option<&Model>) -> Diagnosis {
    let fit = Some(Arc::new(Fit::of(recording)));
    let found = diagnose(recording, model, fit, &Progress::new("test", 0));
    let found = found.unwrap_or_else(|e| panic!("{e}"));
    println!("{}: {}", recording.name, found.verdict_words(recording));
    found
}

fn fitted(recording: &Recording) -> Identification {
    let found = identify(recording, &Options::default(), &Progress::new("test", 100));
    found.unwrap_or_else(|e| panic!("{e}"))
}

/// The first parameters of a name, each right within a share of the truth and inside its interval.
fn holds(named: &Named, truths: &[(f64, f64)]) {
    for ((key, estimate), (truth, share)) in named.parameters.iter().zip(truths) {
        let [low, high] = estimate.ci95.expect("an interval");
        println!("  {key} {} ({low} … {high}), true {truth}", estimate.value);
        assert!((estimate.value / truth - 1.0).abs() < *share, "{key}");
        assert!((low..=high).contains(truth), "{key}");
    }
}

fn the_only_missing<'a>(found: &'a Diagnosis, id: &str) -> &'a Named {
    let missing: Vec<&Named> = found.missing().collect();
    let ids: Vec<&str> = missing.iter().map(|e| e.id()).collect();
    assert_eq!(ids, [id]);
    missing[0]
}

fn of_the_fit<'a>(found: &'a Diagnosis, id: &str) -> &'a Named {
    found.in_fit().find(|e| e.id() == id).expect(id)
}

#[test]
fn a_circle_lacks_nothing() {
    circles_lack_nothing(&[30]);
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn a_circle_of_any_radius_lacks_nothing() {
    circles_lack_nothing(&[50, 100]);
}

fn circles_lack_nothing(radii: &[u32]) {
    for radius in radii {
        if let Some(recording) = case(&format!("circle_R{radius}.csv")) {
            let found = told(&recording);
            assert_eq!(found.verdict, Verdict::Consistent);
            // Noise of the effort leaves 0.00015 %.
            assert!(found.baseline.test < 5e-4, "{}", found.baseline.test);
            holds(of_the_fit(&found, "viscous"), &[(300.0, 0.01)]);
            // The same holds for the fit's own model.
            let own = fitted(&recording).best().model.clone();
            let of_own = told_of(&recording, Some(&own));
            assert_eq!(of_own.verdict, Verdict::Consistent);
            let [own, none] = [&of_own, &found].map(|found| found.baseline.test);
            assert!(
                (own / none - 1.0).abs() < 0.05,
                "{own} with it, {none} without"
            );
        }
    }
}

#[test]
fn a_fast_spin_hides_no_cogging() {
    spins_hide_no_cogging(15);
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn a_faster_spin_hides_no_cogging() {
    spins_hide_no_cogging(20);
}

fn spins_hide_no_cogging(speed: u32) {
    if let Some(recording) = case(&format!("cogging_spin_{speed}.csv")) {
        let found = told(&recording);
        let cogging = the_only_missing(&found, "periodic_force");
        holds(cogging, &[(0.667, 0.01)]);
        assert!(found.extended.test < 0.01, "{}", found.extended.test);
    }
}

#[test]
fn friction_follows_a_load_that_pushes_both_ways() {
    if let Some(recording) = case("strainwave_load.csv") {
        let found = told(&recording);
        holds(
            the_only_missing(&found, "load_dependent_friction"),
            &[(0.15, 0.01)],
        );
        holds(of_the_fit(&found, "gravity"), &[(12.0, 0.01)]);
    }
}

#[test]
fn friction_that_falls_is_told_without_a_temperature() {
    if let Some(recording) = case("warming_no_temperature.csv") {
        let found = told(&recording);
        assert_eq!(found.verdict, Verdict::UnknownPhysics);
        let falls = found.unknown().and_then(|u| u.rises_by).expect("a drift");
        // By a third from the first moment to the last, and less between the means of the first and the last fifth.
        assert!((-0.35..-0.22).contains(&falls), "{falls}");
        let words = found.verdict_words(&recording);
        assert!(words.contains("friction falls by") && words.contains("cannot say which"));
    }
}

/// The benchmark's position as a slower bus would have read it.
#[test]
fn a_position_that_is_held_is_taken_where_it_was_read() {
    let Some(file) = shared("recordings").map(|s| s.join("emps/emps_tracking.csv")) else {
        return;
    };
    let text = std::fs::read_to_string(&file).expect("the recording");
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let head = lines.next().expect("a head");
    let at = head.split(',').position(|key| key == "x_m").expect("x_m");
    let (mut held, mut last) = (format!("{head}\n"), String::new());
    for (row, line) in lines.enumerate() {
        let mut cells: Vec<&str> = line.split(',').collect();
        if row % 10 == 3 || last.is_empty() {
            last = cells[at].to_owned();
        }
        cells[at] = &last;
        held += &format!("{}\n", cells.join(","));
    }
    let recording = recording::load_csv(held.as_bytes(), "held.csv", &LoadOptions::default());
    let recording = recording.unwrap_or_else(|e| panic!("{e}"));
    let said = recording.warnings.iter().find(|w| w.code == "held");
    println!("{}", said.expect("a warning"));
    let found = fitted(&recording);
    for (name, truth, share) in [("mass", 95.15, 0.01), ("viscous", 203.9, 0.02)] {
        let own = found.best().rigid_body.iter().find(|p| p.0 == name);
        let value = own.expect(name).1.value;
        println!("  {name} {value}, {truth} of the rows as they are");
        assert!((value / truth - 1.0).abs() < share, "{name}: {value}");
    }
}

#[test]
fn names_the_level_at_which_a_reading_saturates() {
    if let Some(recording) = case("saturation_of_the_reading/rec.csv") {
        let found = told(&recording);
        holds(
            the_only_missing(&found, "actuator_saturation"),
            &[(0.906, 0.02)],
        );
        assert!(found.extended.test < 0.02, "{}", found.extended.test);
    }
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn an_end_of_the_command_is_named_with_its_place() {
    let parts = [1, 2, 3].map(|k| case(&format!("saturation_typical/rec{k}.csv")));
    if let [Some(a), Some(b), Some(c)] = parts {
        let found = told(&Recording::join(vec![a, b, c]).expect("one machine"));
        holds(
            the_only_missing(&found, "actuator_saturation"),
            &[(1.183, 0.01)],
        );
    }
}
