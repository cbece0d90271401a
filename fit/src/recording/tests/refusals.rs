//! Bad files, and random ones: refused by name, or loaded soundly.

use super::*;
use std::fs::File;

#[test]
fn time_must_advance() {
    for (t, how, remedy) in [
        ([0.0, 1.0, 0.5], "runs backwards", "sort the rows"),
        ([0.0, 1.0, 1.0], "stands still", "more digits"),
    ] {
        refuses(
            text(&table(t.map(|t| (t, t, 1.0))), &[]),
            &["test.csv", "line 4", how, remedy],
        );
    }
    // Blank lines count in the message.
    let blank = "t_s,x_m,force_N\n0,0,1\n\n1,0,1\n1,0,1\n";
    refuses(text(blank, &[]), &["line 5"]);
    // 0.41 s, and 0.41 s but for the last digit of a double.
    let near = (0..60).map(|i| {
        let t = if i == 40 { 0.41 } else { f64::from(i) * 0.01 };
        (t, f64::from(i), 1.0)
    });
    refuses(text(&table(near), &[]), &["line 43", "stands still"]);
}

#[test]
fn the_clock_may_start_again_with_a_new_segment_only() {
    let rows = "t_s,x_m,force_N,segment,lot\n0,0,1,0,a\n1,1,1,0,a\n2,2,1,0,a\n0,0,1,1,b\n1,1,1,1,b\n2,2,1,1,b\n";
    let r = read(rows);
    assert_eq!(r.pieces, vec![0..3, 3..6]);
    assert!(warns(&r, "time-restarts") && !r.segments_found);
    let other = rows.replace("segment", "other");
    refuses(text(&other, &[]), &["--map segment=other", "line 5"]);
    let r = text(&other, &[("segment", "lot")]).expect("words");
    assert_eq!(r.segment, [0, 0, 0, 1, 1, 1]);
    let half = rows.replace("0,a", "0.5,a");
    refuses(text(&half, &[]), &["`segment`", "whole number"]);
}

#[test]
fn position_comes_from_velocity_where_there_is_none() {
    let row = |i: i32| format!("{},{},0\n", f64::from(i) * 0.01, f64::from(i) * 0.02);
    let rows: String = (0..300).map(row).collect();
    let r = read(&format!("t_s,qd_rad_s,torque_Nm\n{rows}"));
    assert!(r.position_integrated && warns(&r, "position-integrated"));
    assert!(warns(&r, "constant-effort") && r.kind == MotionKind::Rotary);
    let right: Vec<f64> = r.t_s.iter().map(|t| t * t).collect();
    assert!(apart(&r.position, &right) < 1e-12);
}

#[test]
fn a_file_over_a_gigabyte_is_refused_at_once() {
    let folder = tempfile::tempdir().expect("temporary folder");
    for (name, limit) in [("big.csv", 1u64 << 30), ("big.mat", 1 << 29)] {
        let path = folder.path().join(name);
        let file = File::create(&path).expect("create");
        file.set_len(limit + 1).expect("sparse");
        refuses(load(&path, &LoadOptions::default()), &["exceed the limit"]);
        // One that passes for its size is all zero bytes: no text, and found out in its first line.
        file.set_len(limit).expect("sparse");
        let options = LoadOptions {
            max_bytes: 1 << 30,
            ..LoadOptions::default()
        };
        let what = if name == "big.csv" {
            "64 KiB"
        } else {
            "MATLAB"
        };
        refuses(load(&path, &options), &[what]);
    }
    refuses(
        load(&folder.path().join("absent.csv"), &LoadOptions::default()),
        &["absent.csv", "check the path"],
    );
    let e = load(folder.path(), &LoadOptions::default()).expect_err("a folder");
    assert!(e.problem.is_of_the_system(), "{e}");
}

#[test]
fn signs_maps_and_windows_that_make_no_sense() {
    let csv = table((0..9).map(|i| (f64::from(i), f64::from(i), 1.0)));
    let mut bad = options(&[]);
    bad.sign = Some(2.0);
    refuses(
        load_csv(csv.as_bytes(), "s", &bad),
        &["--sign 2 is neither"],
    );
    for bad in ["force_N", "=x", "force_N=", ""] {
        assert!(parse_map(bad).is_err_and(|e| e.contains("NAME=COLUMN")));
    }
    assert_eq!(
        parse_map("force_N= 2*a")
            .as_ref()
            .map(|(a, b)| (a.as_str(), b.as_str())),
        Ok(("force_N", "2*a"))
    );
    let r = read(&csv);
    assert_eq!(r.slice_time(2.0, 5.0).expect("inside").t_s, [2.0, 3.0, 4.0]);
    for (from, to) in [(5.0, 2.0), (20.0, 30.0), (2.0, 2.5), (f64::NAN, 3.0)] {
        refuses(r.slice_time(from, to), &["covers 0 s to 8 s"]);
    }
}

#[test]
fn extreme_numbers_are_refused_by_name_or_loaded() {
    for (huge, loads) in [(1e308, false), (1e288, false), (9e14, true), (5e-324, true)] {
        let values = [0.0, huge, -huge, 0.5 * huge, -0.1 * huge];
        let csv = table((0..400).map(|i| {
            let at = |i: i32| values[i as usize % 5];
            (f64::from(i), at(i), at(i / 6))
        }));
        match text(&csv, &[]) {
            Ok(r) => check_invariants(&r),
            Err(e) => assert!(
                !loads && e.to_string().contains("no sensor"),
                "{huge:e}: {e}"
            ),
        }
    }
}
