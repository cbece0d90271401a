//! What is put right, and said: wraps, spikes, dropouts, opposed signs, an effort that is given twice.

use super::*;

#[test]
fn wraps_spikes_and_dropouts_are_found_said_and_put_right() {
    let clean = read(&swing(|_, _, _| ()));
    for code in ["wrapped", "spike", "dropout", "position-jump"] {
        assert!(!warns(&clean, code), "{:?}", clean.warnings);
    }
    let count = 25e-9;
    let wrapped = read(&swing(|_, x, _| {
        *x = (*x / count).round().rem_euclid(65536.0) * count;
    }));
    assert!(warns(&wrapped, "wrapped"), "{:?}", wrapped.warnings);
    let back = clean.position[0] - wrapped.position[0];
    let unwrapped: Vec<f64> = wrapped.position.iter().map(|x| x + back).collect();
    let worst = apart(&unwrapped, &clean.position);
    assert!(worst < count, "{worst:e}");

    // Told where it stands within a recording, over two rows of a mean: by less than a tenth of the range.
    let (low, high) = clean.ends();
    let range = 2.0 * high.max(-low);
    let located = read(&swing(|i, x, _| {
        *x += 0.05 * range * [0.0, 0.4, 1.0][(i.clamp(2999, 3001) - 2999) as usize];
    }));
    assert!(warns(&located, "position-jump"), "{:?}", located.warnings);
    let across = |i: usize| located.pieces.iter().any(|p| p.start < i && i < p.end);
    assert!(!across(3000) && !across(3001), "{:?}", located.pieces);

    let spiked = read(&swing(|i, _, f| {
        if i == 4321 {
            *f = 500.0;
        }
    }));
    let spike = said(&spiked, "spike");
    assert!(spike.contains("line 4323"), "{spike}");
    assert!((spiked.effort[4321] - clean.effort[4321]).abs() < 0.3);

    let lost = read(&swing(|i, _, f| {
        if (3000..3250).contains(&i) {
            *f = 0.0;
        }
    }));
    let dropout = said(&lost, "dropout");
    assert!(dropout.contains("line 3002 to line 3251"), "{dropout}");
    assert_eq!((lost.len(), lost.pieces.len()), (9750, 2));
}

#[test]
fn an_axis_that_rests_before_a_gap_has_no_dropout() {
    // It stands still from sample 2800 on; after a second without samples it begins elsewhere.
    let row = |i: i32| {
        let t = f64::from(i) * 0.002 + if i < 3000 { 0.0 } else { 1.0 };
        let phase = f64::from(if i < 3000 { i.min(2800) } else { i - 3000 }) * 0.0025;
        (
            t,
            0.015 * phase.sin(),
            phase.cos() + 0.1 * (f64::from(i) * 0.7).sin(),
        )
    };
    let rested = read(&table((0..10_000).map(row)));
    assert!(warns(&rested, "gap"), "{:?}", rested.warnings);
    assert!(!warns(&rested, "dropout"), "{:?}", rested.warnings);
    assert_eq!((rested.len(), rested.pieces.len()), (10_000, 2));
}

#[test]
fn a_file_too_short_to_tell_its_sign_has_that_of_the_others() {
    let opposed = swing(|_, _, f| *f = -*f);
    // A quarter of the first stroke: one way only.
    let short: String = opposed.split_inclusive('\n').take(600).collect();
    assert!(!warns(&read(&short), "effort-sign-flipped"));
    let positive = |r: &Recording, at: usize| r.effort[at] > 0.0;
    for (first, second, at) in [(&opposed, &short, 10_100), (&short, &opposed, 100)] {
        let whole = Recording::join(vec![read(first), read(second)]).expect("one machine");
        assert!(warns(&whole, "effort-sign-alike"), "{:?}", whole.warnings);
        assert!(positive(&whole, at), "the stroke moves on in +x");
    }
}

#[test]
fn an_angle_that_wraps_at_a_turn_is_unwrapped() {
    let angle = |i: usize| 20.0 * (i as f64 * 0.002).sin();
    let row = |i: usize| {
        let (t, torque) = (i as f64 * 0.001, (i as f64 * 0.002).cos().signum());
        let wrapped = angle(i).rem_euclid(std::f64::consts::TAU);
        format!("{t},{wrapped:.6},{torque}\n")
    };
    let rows: String = (0..6000).map(row).collect();
    let r = read(&format!("t_s,q_rad,torque_Nm\n{rows}"));
    assert!(warns(&r, "wrapped"), "{:?}", r.warnings);
    let right: Vec<f64> = (0..6000).map(angle).collect();
    assert!(apart(&r.position, &right) < 1e-5);
}

/// A jump of any size at an end is no wrap but of a whole span, and a wrap stays one.
#[test]
fn a_spike_in_the_first_row_is_no_wrap() {
    let count = 25e-9;
    let turns = 65536.0 * count;
    let at_an_end = |row: i32, by: f64| {
        read(&swing(|i, x, _| {
            let slow = (*x / count / 100.0).round() * count;
            *x = if i == row { slow + by } else { slow };
        }))
    };
    let clean = at_an_end(0, 0.0);
    // 1.03 spans, which a few per cent would take for one; and a whole one.
    for (row, by, code) in [
        (0, 1.03 * turns, "spike"),
        (1, -0.97 * turns, "spike"),
        (0, 1.0, "spike"),
        (9999, 1.03 * turns, "spike"),
        (0, turns, "wrapped"),
    ] {
        let r = at_an_end(row, by);
        for other in ["spike", "wrapped", "position-jump"] {
            assert_eq!(
                warns(&r, other),
                other == code,
                "{row} {by}: {:?}",
                r.warnings
            );
        }
        let shift = r.position[5000] - clean.position[5000];
        let right: Vec<f64> = clean.position.iter().map(|x| x + shift).collect();
        let worst = apart(&r.position, &right);
        assert!(
            worst < 1e-6 && (shift == 0.0 || code == "wrapped"),
            "{row} {by}: {worst:e}"
        );
    }
}

/// A drive logs the force and the current that makes it: the force is the effort, wherever it stands.
#[test]
fn of_two_efforts_the_one_nearer_to_the_load_is_taken_and_the_other_left_out() {
    let clean = swing(|_, _, _| ());
    let twice = |before: bool| -> String {
        let rows = clean.lines().enumerate().map(|(i, line)| {
            let (motion, force) = line.rsplit_once(',').expect("columns");
            let current = match i {
                0 => "current_A".to_owned(),
                i => (i % 7).to_string(),
            };
            match before {
                true => format!("{motion},{current},{force}\n"),
                false => format!("{motion},{force},{current}\n"),
            }
        });
        rows.collect()
    };
    let alone = read(&clean);
    for before in [false, true] {
        let r = read(&twice(before));
        assert_eq!((r.role, &r.effort), (EffortRole::Force, &alone.effort));
        assert!(r.extra.is_empty(), "left out, not a coordinate");
        let chosen = said(&r, "effort-chosen");
        for part in ["`force_N`", "--map current_A=current_A"] {
            assert!(chosen.contains(part), "{chosen}");
        }
    }
    let mapped = text(&twice(false), &[("current_A", "current_A")]).expect("mapped");
    assert_eq!(mapped.role, EffortRole::Current);
    let alike: String = clean
        .lines()
        .enumerate()
        .map(|(i, line)| format!("{line},{}\n", if i == 0 { "friction_N" } else { "0.5" }))
        .collect();
    assert!(
        text(&alike, &[]).is_err(),
        "a force and a friction are two different things"
    );
}
