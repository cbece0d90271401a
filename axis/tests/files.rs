//! What the project's axis.toml says, and what is refused.

use preslide::control::Axis;
use preslide_axis::{AxisFile, rust};

const PAPER: &str = preslide_axis::OWN;

fn refusal(text: &str) -> String {
    AxisFile::parse("mine.toml", text)
        .expect_err("it is wrong")
        .to_string()
}

/// The library's constant is this file's result, to the bit.
#[test]
fn the_paper_axis_is_what_the_file_says() {
    let file = AxisFile::parse("axis.toml", PAPER).expect("the project's own");
    assert_eq!(file.axis(), Axis::PAPER_AXIS);
    assert!(file.board("stm32g474").is_ok());
}

#[test]
fn a_value_is_found_by_its_parameter_s_name() {
    let file = AxisFile::parse("axis.toml", PAPER).expect("the project's own");
    assert_eq!(file.value("gains.proportional"), Some(1e5));
    assert_eq!(file.value("watch.overruns"), Some(2.0));
    assert_eq!(file.value("duty_limit"), Some(0.38));
    for unknown in ["gains", "gains.", "gains.nothing", "nothing.at_all", ""] {
        assert_eq!(file.value(unknown), None, "{unknown}");
    }
}

#[test]
fn what_is_written_for_the_build_reads_back() {
    let text = rust(&Axis::PAPER_AXIS);
    for part in [
        "count: 2.5e-8",
        "drive: Reference",
        "travel: Some((-0.0125, 0.0125))",
        "rate_hz: 20000",
    ] {
        assert!(text.contains(part), "{part} is not in {text}");
    }
}

#[test]
fn what_is_wrong_is_told_with_its_key() {
    let misspelt = refusal(&PAPER.replace("torque_constant", "torque_konstant"));
    assert!(
        misspelt.contains("torque_konstant") && misspelt.contains("mine.toml"),
        "{misspelt}"
    );
    let missing = refusal(&PAPER.replace("mass = 4.05", ""));
    assert!(missing.contains("missing field `mass`"), "{missing}");
    let one_end = refusal(&PAPER.replace("travel_low = -12.5e-3", ""));
    assert!(one_end.contains("go together"), "{one_end}");
    let schema = refusal(&PAPER.replace("preslide.axis/1", "preslide.model/1"));
    assert!(schema.contains("preslide.axis/1"), "{schema}");
    let values = refusal(
        &PAPER
            .replace("resistance = 3.41", "resistance = -1.0")
            .replace("current_span = 6.4", "current_span = 0.0"),
    );
    assert!(
        values.contains("resistance") && values.contains("boards.stm32g474.current_span"),
        "{values}"
    );
    let board = AxisFile::parse("mine.toml", PAPER).expect("the project's own");
    let board = board.board("esc").expect_err("not there").to_string();
    assert!(board.contains("[boards.esc]"), "{board}");
}

/// Whoever has no notch and no brake says nothing of them.
#[test]
fn a_notch_and_a_brake_may_be_left_out() {
    let (before, rest) = PAPER.split_once("[notch]").expect("it has one");
    let (_, after) = rest.split_once("[feed_forward]").expect("behind it");
    let without = format!("{before}[feed_forward]{after}");
    let file = AxisFile::parse("mine.toml", &without).expect("it may be left out");
    assert_eq!(file.axis(), Axis::PAPER_AXIS);
    assert_eq!(file.board("pico2").expect("there").brake_set, 0.0);
    let in_ms = PAPER.replace("[boards.pico2]", "[boards.pico2]\nbrake_set = 60");
    let error = refusal(&in_ms);
    assert!(
        error.contains("boards.pico2.brake_set is 60; it must be within 0..5 s"),
        "{error}"
    );
    let beyond = PAPER.replace("frequency = 0.0", "frequency = 12e3");
    let error = refusal(&beyond);
    assert!(
        error.contains("frequency of the notch is 12000: it must be below 10000"),
        "{error}"
    );
}
