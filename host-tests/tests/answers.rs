//! Answers of `preslide diagnose` that must not flip, on a stage that repeats perfectly: the few that a test can afford. All of
//! them, on real machines too: `cargo xtask properties`.

use preslide_host_tests::judge::properties::{PROPERTIES, Property, compare};
use preslide_host_tests::judge::tool::Tool;
use preslide_host_tests::trials::effect::{Id, Strength};
use preslide_host_tests::trials::{Kind, repeatable, trial};

fn tool() -> Tool {
    Tool::of_workspace().unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn a_clean_stage_that_repeats_is_consistent() {
    let (answer, _) = tool().diagnose(&repeatable(70_000_500).given("stage"));
    let answer = answer.unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(answer.verdict, "consistent", "{:?}", answer.effects);
}

/// Units, sign, direction and the clock's zero are the reader's, not the machine's: exactly the same is said after the changes.
fn the_same_is_said_after(changes: &[&[Property]]) {
    let tool = tool();
    let made = trial(
        70_000_004,
        Kind::Single(Id::PeriodicForce, Strength::Typical),
    );
    let mut recording = made.given("cogging");
    // Its first third names the cogging as the whole does, in less of the gate's time.
    let whole = &recording.parts[0];
    let third = whole.len() / 3;
    recording.parts = vec![whole.kept(|row| row < third)];
    let before = tool.diagnose(&recording).0;
    let said = before.as_ref().unwrap_or_else(|e| panic!("{e}"));
    assert!(
        !said.effects.is_empty(),
        "nothing is named, and nothing can flip"
    );
    for properties in changes {
        let changed = properties
            .iter()
            .fold(recording.clone(), |changed, property| {
                property.apply(&changed).expect("asked")
            });
        let after = tool.diagnose(&changed).0;
        for &property in *properties {
            let outcome = compare(property, &before, &after);
            assert!(outcome.agrees(property), "{properties:?}: {outcome:?}");
        }
    }
}

#[test]
fn units_signs_and_the_clock_change_nothing_at_once() {
    the_same_is_said_after(&[&[Property::Later, Property::SignFlipped, Property::Units]]);
}

#[test]
#[ignore = "long study: cargo xtask test --all"]
fn units_signs_and_the_clock_change_nothing_each() {
    the_same_is_said_after(&[
        &[Property::Later],
        &[Property::SignFlipped],
        &[Property::Units],
    ]);
}

/// The judge itself: every property changes the files, and keeps what it promises to keep.
#[test]
fn a_change_keeps_the_machine() {
    let made = trial(70_000_000, Kind::Clean).given("clean");
    let [before] = &made.parts[..] else {
        panic!("one file")
    };
    let rms =
        |column: &[f64]| (column.iter().map(|v| v * v).sum::<f64>() / column.len() as f64).sqrt();
    for property in PROPERTIES {
        let changed = property.apply(&made).expect("a recording long enough");
        let files = match property {
            Property::TwiceFiles | Property::Split => 2,
            _ => 1,
        };
        assert_eq!(changed.parts.len(), files, "{}", property.name());
        let after = &changed.parts[0];
        let rows = after.len() as f64 / before.len() as f64;
        let kept = match property {
            Property::TwiceJoined => 2.0..=2.0,
            Property::Split => 0.499..=0.501,
            Property::EverySecondRow => 0.499..=0.501,
            Property::LostRows => 0.998..=0.9998,
            Property::RestAppended => 1.01..=1.2,
            Property::Cut1s | Property::Cut3s | Property::CutAtRandom => 0.85..=0.995,
            _ => 1.0..=1.0,
        };
        assert!(kept.contains(&rows), "{}: {rows}", property.name());
        let clock = &after.columns[after.time()];
        assert!(clock.windows(2).all(|t| t[1] > t[0]), "{}", property.name());
        if property == Property::Units {
            assert!(after.find("x_m").is_none() && changed.arguments.len() == 4);
            continue;
        }
        let ratio = rms(&after.columns[after.effort()]) / rms(&before.columns[before.effort()]);
        assert!((0.9..1.1).contains(&ratio), "{}: {ratio}", property.name());
    }
}
