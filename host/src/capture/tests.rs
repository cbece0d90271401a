use super::{CaptureError, End, Scale, capture, open};
use preslide::control::Settings;
use preslide_fit::recording::MotionKind;
use preslide_link::{FaultCode, LARGEST_FRAME, RangeCode, Report, Sample, encode};
use std::time::Duration;

fn frame(sequence: u32, tick: u32) -> Vec<u8> {
    let sample = Sample {
        sequence,
        dropped: 0,
        tick,
        position: 3 * tick.cast_signed(),
        reference: i64::from(tick) << 16,
        code: 0,
        current: 1000,
        supply: 6000,
        fault: (tick == 8).then_some(FaultCode::Overrun),
        range: Some(if tick < 6 {
            RangeCode::Inside
        } else {
            RangeCode::Above
        }),
        level: 0,
    };
    let mut frame = [0; LARGEST_FRAME];
    let length = encode(&Report::Sample(sample), &mut frame).expect("it fits");
    frame[..length].to_vec()
}

fn telemetry(ticks: impl Iterator<Item = u32>) -> Vec<u8> {
    ticks.flat_map(|tick| frame(tick, tick)).collect()
}

fn scale(every: u32) -> Scale {
    Scale::of(&Settings::PAPER_AXIS, every)
}

#[test]
fn telemetry_becomes_a_recording_in_si() {
    let mut csv = Vec::new();
    let summary =
        capture(&telemetry(0..11)[..], &mut csv, &scale(2), None, || {}).expect("telemetry");
    let text = String::from_utf8(csv).expect("text");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "t_s,x_m,x_ref_m,force_N");
    // Ticks 1 and 2: counts 3 and 6 of 25 nm, references 1 and 2, 0.1 A of 20.7 N/A.
    assert_eq!(
        lines[1],
        "0.0000750,1.125000000e-7,3.750000000e-8,2.070310e0"
    );
    assert_eq!((summary.samples, summary.rows, lines.len()), (11, 5, 6));
    assert_eq!((summary.gaps, summary.damaged), (0, 0));
    assert_eq!(summary.fault, Some((FaultCode::Overrun, 8.0 * 50e-6)));
    assert_eq!(summary.left_range, Some((RangeCode::Above, 6.0 * 50e-6)));
    assert_eq!(summary.end, End::Closed);
}

#[test]
fn what_comes_before_is_left_out_and_is_no_gap() {
    let mut csv = Vec::new();
    let later = Scale {
        after_s: 5.0 * 50e-6,
        ..scale(1)
    };
    let line = telemetry(0..11);
    let summary = capture(&line[..], &mut csv, &later, None, || {}).expect("telemetry");
    let text = String::from_utf8(csv).expect("text");
    // Rows are counted from behind tick 5.
    assert!(
        text.lines()
            .nth(1)
            .is_some_and(|row| row.starts_with("0.0003000,")),
        "{text}"
    );
    assert_eq!((summary.samples, summary.rows, summary.gaps), (6, 5, 0));
}

#[test]
fn a_rotary_axis_has_its_own_columns_and_rows_can_be_limited() {
    let mut csv = Vec::new();
    let rotary = Scale {
        motion: MotionKind::Rotary,
        ..scale(1)
    };
    let summary =
        capture(&telemetry(1..11)[..], &mut csv, &rotary, Some(3), || {}).expect("telemetry");
    assert!(csv.starts_with(b"t_s,q_rad,q_ref_rad,torque_Nm\n"));
    assert_eq!((summary.rows, summary.end), (3, End::Complete));
}

#[test]
fn what_is_missing_or_damaged_is_counted_and_no_row_reaches_across() {
    let mut line = telemetry((1..11).filter(|i| ![5, 6].contains(i)));
    // Cut into the first frame, as a listener that comes late does.
    line.drain(..5);
    let mut csv = Vec::new();
    let summary = capture(&line[..], &mut csv, &scale(2), None, || {}).expect("telemetry");
    assert_eq!((summary.samples, summary.damaged), (7, 1));
    assert_eq!((summary.gaps, summary.missing), (1, 2));
    // Ticks 3, 4 behind 2, which is the first whole one; then 8, 9 behind 7; 10 is left over.
    let text = String::from_utf8(csv).expect("text");
    let times: Vec<&str> = text
        .lines()
        .skip(1)
        .filter_map(|l| l.split(',').next())
        .collect();
    assert_eq!(times, ["0.0001750", "0.0004250"]);
}

#[test]
fn every_fourth_tick_of_a_slow_line_is_no_gap() {
    let mut line = Vec::new();
    for sequence in 0..12_u32 {
        line.extend(frame(sequence, 4 * (sequence + 1)));
    }
    let mut csv = Vec::new();
    let summary = capture(&line[..], &mut csv, &scale(12), None, || {}).expect("telemetry");
    assert_eq!((summary.samples, summary.rows, summary.gaps), (12, 3, 0));
    let text = String::from_utf8(csv).expect("text");
    // Ticks 8, 12, 16 behind 4; then 20, 24, 28.
    assert!(
        text.contains("\n0.0006000,") && text.contains("\n0.0012000,"),
        "{text}"
    );
}

#[test]
fn a_restart_ends_the_recording() {
    let line = [telemetry(0..9), telemetry(0..5)].concat();
    let summary = capture(&line[..], Vec::new(), &scale(2), None, || {}).expect("telemetry");
    assert_eq!((summary.rows, summary.end), (4, End::Restarted));
}

#[test]
fn silence_and_noise_are_errors() {
    for line in [&[][..], &[0x55; 500], &[1, 2, 3, 0, 9, 9, 0]] {
        let error = capture(line, Vec::new(), &scale(1), None, || {}).expect_err("no telemetry");
        assert!(error.to_string().contains("no telemetry"), "{error}");
    }
    let (short, mut csv) = (telemetry(1..5), Vec::new());
    let error = capture(&short[..], &mut csv, &scale(20), None, || {}).expect_err("short");
    assert!(csv.is_empty(), "no row, no header");
    assert!(
        matches!(error, CaptureError::NoTelemetry { samples: 4, .. }),
        "{error}"
    );
}

#[test]
fn a_source_that_is_not_there_is_named_with_a_remedy() {
    // A port that was free a moment ago.
    let free = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = free.local_addr().expect("its address");
    drop(free);
    let fail = |source: &str| match open(source, Duration::ZERO) {
        Ok(_) => panic!("{source} opened"),
        Err(error) => error.to_string(),
    };
    let refused = fail(&format!("tcp:{address}"));
    assert!(
        refused.contains(&address.to_string()) && refused.contains("--wait"),
        "{refused}"
    );
    assert!(fail("tcp:nowhere").contains("tcp:HOST:PORT"));
    assert!(fail("/no/such/device").contains("tcp:HOST:PORT or the path"));
}
