//! The recordings of real machines.

use preslide_host_tests::{recordings, shared};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;

#[test]
fn every_real_csv_loads_or_says_why() {
    let Some(root) = recordings() else { return };
    let mut seen = 0;
    for folder in std::fs::read_dir(&root)
        .expect("folder")
        .flatten()
        .filter(|f| f.path().is_dir())
    {
        for file in std::fs::read_dir(folder.path()).expect("folder").flatten() {
            let path = file.path();
            if path.extension().is_none_or(|e| e != "csv") {
                continue;
            }
            seen += 1;
            let name = path
                .strip_prefix(&root)
                .expect("inside")
                .display()
                .to_string();
            let plain = load(&path, &LoadOptions::default());
            let map: &[(&str, &str)] = if name.contains("stribeck_map") {
                refuses(plain, &["no time (`t_s`", "--map torque_Nm=torque_mean_Nm"]);
                continue;
            } else if name.contains("steady_state") {
                let parts = ["time runs backwards", "line 502", "--map segment=run"];
                refuses(plain, &parts);
                &[("segment", "run")]
            } else {
                &[]
            };
            let r = load(&path, &options(map)).unwrap_or_else(|e| panic!("{e}"));
            check_invariants(&r);
            assert!(r.sample_time_s() > 0.0);
            let codes: Vec<_> = r.warnings.iter().map(|w| w.code).collect();
            let strokes = r.segment.iter().max().map_or(0, |m| m + 1);
            let repeats = r.repeat.iter().max().map_or(0, |m| m + 1);
            println!(
                "{name}: {} samples, {} pieces, {strokes} segments, {repeats} repeats, {codes:?}",
                r.len(),
                r.pieces.len()
            );
            let has = |code: &str| codes.contains(&code);
            for (code, files) in [
                ("position-integrated", &["screw_drives"][..]),
                ("one-way-motion", &["rolling", "speed_control"]),
                ("effort-sign-flipped", &["tribometer"]),
                ("time-restarts", &["steady_state"]),
            ] {
                let is_one = files.iter().any(|file| name.contains(file));
                assert_eq!(has(code), is_one, "{name}: {code}");
            }
            if name.contains("pneumatic_seal") {
                assert!(has("time-jitter"), "{name}");
                assert_eq!(has("gap"), !name.contains("X-ring257_7bar"), "{name}");
            }
        }
    }
    assert_eq!(seen, 33, "files of the folder");
}

#[test]
fn emps_has_four_cycles_of_two_strokes() {
    let Some(root) = recordings() else { return };
    let r = real_file(&root, "emps/emps_tracking.csv", &[]);
    assert_eq!(
        (r.len(), r.kind, r.role),
        (24_841, MotionKind::Linear, EffortRole::Force)
    );
    assert!((r.sample_time_s() - 1e-3).abs() < 1e-9);
    assert_eq!((r.segment.last(), r.repeat.last()), (Some(&7), Some(&3)));
    assert!(r.repeats_found && r.segments_found && r.reference.is_some());
    let codes: Vec<_> = r.warnings.iter().map(|w| w.code).collect();
    assert_eq!(codes, ["extra-columns"], "voltage_cmd_V alone");
}

#[test]
fn the_emps_originals_agree_with_their_csv() {
    let Some(root) = recordings() else { return };
    refuses(
        load(&root.join("emps/DATA_EMPS.mat"), &LoadOptions::default()),
        &["gtau 1×1", "qm 24841×1", "vir 24841×1", "--map x_m=COLUMN"],
    );
    let csv = real_file(&root, "emps/emps_tracking.csv", &[]);
    let map = [("t_s", "t"), ("x_m", "qm"), ("x_ref_m", "qg")];
    let original = |name: &str, effort| real_file(&root, name, &[&map[..], &[effort]].concat());
    for force in ["gtau*vir", "35.1507*vir"] {
        let r = original("emps/DATA_EMPS.mat", ("force_N", force));
        assert_eq!(r.repeat, csv.repeat);
        assert!(apart(&r.effort, &csv.effort) < 1e-3);
        assert!(apart(&r.position, &csv.position) < 1e-7);
        assert!(apart(&r.t_s, &csv.t_s) < 1e-7);
    }
    let r = original("emps/DATA_EMPS_PULSES.mat", ("voltage_V", "vir"));
    assert_eq!((r.role, r.effort_unit()), (EffortRole::Voltage, "V"));
}

#[test]
fn a_damaged_emps_original_never_panics_and_never_loses_a_variable_unnoticed() {
    let Some(root) = recordings() else { return };
    let bytes = std::fs::read(root.join("emps/DATA_EMPS.mat")).expect("readable");
    let options = options(&[("t_s", "t"), ("x_m", "qm"), ("voltage_V", "vir")]);
    for k in 0..200 {
        let length = if k < 150 {
            k * 2
        } else {
            bytes.len() * (k - 149) / 51
        };
        assert!(
            load_mat(&bytes[..length], "cut.mat", &options).is_err(),
            "cut at {length}"
        );
    }
    assert!(load_mat(&bytes[..bytes.len() - 1], "cut.mat", &options).is_err());
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut refused = 0;
    for _ in 0..300 {
        let mut damaged = bytes.clone();
        let at = rng.random_range(0..damaged.len());
        damaged[at] ^= rng.random_range(1..=255u8);
        refused += usize::from(load_mat(damaged.as_slice(), "bad.mat", &options).is_err());
    }
    assert!(
        refused > 290,
        "zlib's checksum guards all but the headers, {refused} refused"
    );
}

#[test]
fn the_tribometer_has_a_hundred_strokes_and_the_opposite_sign() {
    let Some(root) = recordings() else { return };
    let r = real_file(&root, "tribometer_reciprocating/reciprocating_5N.csv", &[]);
    assert!(warns(&r, "effort-sign-flipped"));
    assert_eq!((r.segment.last(), r.repeat.last()), (Some(&99), Some(&49)));
    assert!(r.repeats_found && r.load_n.is_some());
    let path = root.join("tribometer_reciprocating/reciprocating_5N.csv");
    let signed = |sign| {
        let mut options = options(&[]);
        options.sign = Some(sign);
        load(&path, &options).expect("loads")
    };
    let (minus, plus) = (signed(-1.0), signed(1.0));
    assert_eq!(minus.effort, r.effort);
    assert!(!warns(&minus, "effort-sign-flipped") && !warns(&minus, "negative-work"));
    assert!(warns(&plus, "negative-work"));
    assert_eq!(plus.effort.iter().map(|f| -f).collect::<Vec<_>>(), r.effort);

    let (train, test) = (
        r.slice_time(100.0, 145.0).expect("train"),
        r.slice_time(145.0, 190.0).expect("test"),
    );
    assert_eq!((train.len(), test.len()), (9000, 9000));
    assert_eq!(train.pieces, vec![0..9000]);
    assert!(train.t_s.last() < test.t_s.first());
}

#[test]
fn the_gap_of_the_o_ring_is_named_and_splits_the_pieces() {
    let Some(root) = recordings() else { return };
    let r = real_file(&root, "pneumatic_seal/O-ring_3bar.csv", &[]);
    let gap = said(&r, "gap");
    for part in ["2.6600 s at line 14", "line 3743"] {
        assert!(gap.contains(part), "{gap}");
    }
    let inner = r.pieces[1].clone();
    assert_eq!((r.pieces.len(), r.pieces[2].end), (3, r.len()));
    assert!((12..3741).contains(&inner.start) || inner.start == 12);
    assert!(r.segment[inner.start - 1] < r.segment[inner.start]);
}

#[test]
fn words_in_a_run_column_become_numbers_and_restarts_become_pieces() {
    let Some(root) = recordings() else { return };
    let name = "screw_drives/drive3_steady_state.csv";
    let r = real_file(&root, name, &[("segment", "run")]);
    assert_eq!(r.pieces.len(), 46);
    assert_eq!(r.segment.last(), Some(&45));
    assert!(warns(&r, "labels-numbered") && !r.segments_found);
    for piece in &r.pieces {
        assert_eq!(r.position[piece.start], 0.0);
    }
}

/// Every bench loads with the command that its README's columns suggest.
#[test]
fn every_bench_loads() {
    let Some(root) = shared("benches") else {
        return;
    };
    let pendulum = [
        ("t_s", "time"),
        ("q_rad", "position"),
        ("qd_rad_s", "velocity"),
        ("torque_Nm", "torque"),
    ];
    let joint = [("q_rad", "joint_q_rad"), ("effort_raw", "motor_torque_raw")];
    let all = [
        ("q_rad", "qm4_motor_rad"),
        ("effort_raw", "torque_or_current4"),
    ];
    let mut seen = 0;
    for folder in [
        "staubli_tx40",
        "brfd_damper",
        "bam_xl330",
        "dfki_pendulum",
        "odrive_cogging",
    ] {
        for file in std::fs::read_dir(root.join(folder))
            .expect("folder")
            .flatten()
        {
            let name = file.file_name().to_string_lossy().into_owned();
            let map: &[(&str, &str)] = match (folder, name.as_str()) {
                (_, "static_hold_maps.csv") => continue,
                (_, name) if !name.ends_with(".csv") => continue,
                ("dfki_pendulum", _) => &pendulum,
                (_, "all_joints_2500Hz.csv") => &all,
                ("staubli_tx40", _) => &joint,
                ("odrive_cogging", _) => &[("current_A", "current_iq_A")],
                _ => &[],
            };
            if folder == "dfki_pendulum" {
                let plain = load(&file.path(), &LoadOptions::default());
                refuses(plain, &["--map q_rad=position --map torque_Nm=torque"]);
            }
            let r = real_file(&root, &format!("{folder}/{name}"), map);
            check_invariants(&r);
            println!(
                "{folder}/{name}: {} samples, {} pieces, {:?}",
                r.len(),
                r.pieces.len(),
                r.warnings
            );
            seen += 1;
        }
    }
    assert!(seen > 20, "{seen}");
}
