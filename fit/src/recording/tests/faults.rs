//! What is put right, and said: wraps, spikes, dropouts, opposed signs, an effort that is given twice.

use std::fmt::Write as _;

use super::*;

#[test]
fn wraps_spikes_and_dropouts_are_found_said_and_put_right() {
    let clean = text(&swing(|_, _, _| ()), &[]).expect("clean");
    assert!(
        clean
            .warnings
            .iter()
            .all(|w| ["wrapped", "spike", "dropout", "position-jump"]
                .iter()
                .all(|c| w.code != *c)),
        "{:?}",
        clean.warnings
    );
    let worst = |r: &Recording| {
        let off = r
            .position
            .iter()
            .zip(&clean.position)
            .map(|(a, b)| (a - b - r.position[0] + clean.position[0]).abs());
        off.fold(0.0, f64::max)
    };
    let count = 25e-9;
    let wrapped = text(
        &swing(|_, x, _| *x = (*x / count).round().rem_euclid(65536.0) * count),
        &[],
    );
    let wrapped = wrapped.expect("wrapped");
    assert!(warns(&wrapped, "wrapped"), "{:?}", wrapped.warnings);
    assert!(worst(&wrapped) < count, "{:e}", worst(&wrapped));

    // Told where it stands within a recording, over two rows of a mean: by less than a tenth of the range.
    let range = clean
        .position
        .iter()
        .fold(0.0, |r: f64, x| r.max(2.0 * x.abs()));
    let located = text(
        &swing(|i, x, _| {
            *x += 0.05 * range * [0.0, 0.4, 1.0][(i.clamp(2999, 3001) - 2999) as usize]
        }),
        &[],
    );
    let located = located.expect("located");
    assert!(warns(&located, "position-jump"), "{:?}", located.warnings);
    let across = |i: usize| located.pieces.iter().any(|p| p.start < i && i < p.end);
    assert!(!across(3000) && !across(3001), "{:?}", located.pieces);

    let spiked = text(
        &swing(|i, _, f| {
            if i == 4321 {
                *f = 500.0
            }
        }),
        &[],
    )
    .expect("spiked");
    let said = spiked
        .warnings
        .iter()
        .find(|w| w.code == "spike")
        .expect("a spike");
    assert!(said.message.contains("line 4323"), "{}", said.message);
    assert!((spiked.effort[4321] - clean.effort[4321]).abs() < 0.3);

    let lost = text(
        &swing(|i, _, f| {
            if (3000..3250).contains(&i) {
                *f = 0.0
            }
        }),
        &[],
    )
    .expect("dropout");
    let said = lost
        .warnings
        .iter()
        .find(|w| w.code == "dropout")
        .expect("a dropout");
    assert!(
        said.message.contains("line 3002 to line 3251"),
        "{}",
        said.message
    );
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
    let rested = text(&table((0..10_000).map(row)), &[]).expect("rested");
    assert!(warns(&rested, "gap"), "{:?}", rested.warnings);
    assert!(!warns(&rested, "dropout"), "{:?}", rested.warnings);
    assert_eq!((rested.len(), rested.pieces.len()), (10_000, 2));
}

#[test]
fn a_file_too_short_to_tell_its_sign_has_that_of_the_others() {
    let opposed = swing(|_, _, f| *f = -*f);
    // A quarter of the first stroke: one way only.
    let short: String = opposed
        .lines()
        .take(600)
        .map(|l| format!("{l}\n"))
        .collect();
    let load = |csv: &str| text(csv, &[]).expect("a recording");
    assert!(!warns(&load(&short), "effort-sign-flipped"));
    let positive = |r: &Recording, at: usize| r.effort[at] > 0.0;
    for (first, second, at) in [(&opposed, &short, 10_100), (&short, &opposed, 100)] {
        let whole = Recording::join(vec![load(first), load(second)]).expect("one machine");
        assert!(warns(&whole, "effort-sign-alike"), "{:?}", whole.warnings);
        assert!(positive(&whole, at), "the stroke moves on in +x");
    }
}

#[test]
fn an_angle_that_wraps_at_a_turn_is_unwrapped() {
    let mut csv = "t_s,q_rad,torque_Nm\n".to_owned();
    for i in 0..6000 {
        let q = 20.0 * (f64::from(i) * 0.002).sin();
        let wrapped = q.rem_euclid(std::f64::consts::TAU);
        writeln!(
            csv,
            "{},{wrapped:.6},{}",
            f64::from(i) * 0.001,
            (f64::from(i) * 0.002).cos().signum()
        )
        .expect("memory");
    }
    let r = text(&csv, &[]).expect("wrapped");
    assert!(warns(&r, "wrapped"), "{:?}", r.warnings);
    for (i, q) in r.position.iter().enumerate() {
        assert!(
            (q - 20.0 * (i as f64 * 0.002).sin()).abs() < 1e-5,
            "{i}: {q}"
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
            let current = if i == 0 {
                "current_A".into()
            } else {
                format!("{}", (i % 7) as f64)
            };
            if before {
                format!("{motion},{current},{force}\n")
            } else {
                format!("{motion},{force},{current}\n")
            }
        });
        rows.collect()
    };
    let alone = text(&clean, &[]).expect("clean");
    for before in [false, true] {
        let r = text(&twice(before), &[]).expect("two efforts");
        assert_eq!((r.role, &r.effort), (EffortRole::Force, &alone.effort));
        assert!(r.extra.is_empty(), "left out, not a coordinate");
        let said = r
            .warnings
            .iter()
            .find(|w| w.code == "effort-chosen")
            .expect("said");
        assert!(
            said.message.contains("`force_N`")
                && said.message.contains("--map current_A=current_A"),
            "{}",
            said.message
        );
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
