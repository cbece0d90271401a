//! Whole files: the real recordings, bad ones, and random ones.

use std::fmt::Write as _;
use std::path::Path;

use preslide_host_tests::{recordings, shared};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;

fn options(map: &[(&str, &str)]) -> LoadOptions {
    LoadOptions {
        map: map
            .iter()
            .map(|(a, b)| (a.to_string(), b.to_string()))
            .collect(),
        ..LoadOptions::default()
    }
}

fn text(csv: &str, map: &[(&str, &str)]) -> Result<Recording, RecordingError> {
    load_csv(csv.as_bytes(), "test.csv", &options(map))
}

fn warns(r: &Recording, code: &str) -> bool {
    r.warnings.iter().any(|w| w.code == code)
}

/// Loads `folder/name`, which must succeed.
fn real_file(folder: &Path, name: &str, map: &[(&str, &str)]) -> Recording {
    load(&folder.join(name), &options(map)).unwrap_or_else(|e| panic!("{e}"))
}

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
                let e = plain.expect_err(&name).to_string();
                assert!(
                    e.contains("no time (`t_s`)") && e.contains("torque_mean_Nm"),
                    "{e}"
                );
                continue;
            } else if name.contains("steady_state") {
                let e = plain.expect_err(&name);
                assert!(
                    matches!(
                        e.problem,
                        Problem::Time {
                            how: "runs backwards",
                            ..
                        }
                    ),
                    "{e}"
                );
                assert!(
                    e.to_string().contains("line 502")
                        && e.to_string().contains("--map segment=run"),
                    "{e}"
                );
                &[("segment", "run")]
            } else if name.contains("laas_cogging") {
                let e = plain.expect_err(&name).to_string();
                assert!(e.contains("no effort") && e.contains("current_iq_A"), "{e}");
                &[("current_A", "current_iq_A")]
            } else {
                &[]
            };
            let r = load(&path, &options(map)).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(r.position.len(), r.len());
            assert_eq!(
                (r.effort.len(), r.segment.len(), r.repeat.len()),
                (r.len(), r.len(), r.len())
            );
            assert_eq!(r.pieces.iter().map(|p| p.len()).sum::<usize>(), r.len());
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
            assert_eq!(
                has("position-integrated"),
                name.contains("screw_drives"),
                "{name}"
            );
            assert_eq!(
                has("one-way-motion"),
                name.contains("rolling") || name.contains("speed_control"),
                "{name}"
            );
            assert_eq!(
                has("effort-sign-flipped"),
                name.contains("tribometer"),
                "{name}"
            );
            assert_eq!(
                has("time-restarts"),
                name.contains("steady_state"),
                "{name}"
            );
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
    let e = load(&root.join("emps/DATA_EMPS.mat"), &LoadOptions::default())
        .expect_err("other names")
        .to_string();
    for part in ["gtau 1×1", "qm 24841×1", "vir 24841×1", "--map t_s=t"] {
        assert!(e.contains(part), "{e} lacks {part}");
    }
    let csv = real_file(&root, "emps/emps_tracking.csv", &[]);
    let map = [("t_s", "t"), ("x_m", "qm"), ("x_ref_m", "qg")];
    let product = real_file(
        &root,
        "emps/DATA_EMPS.mat",
        &[&map[..], &[("force_N", "gtau*vir")]].concat(),
    );
    let factor = real_file(
        &root,
        "emps/DATA_EMPS.mat",
        &[&map[..], &[("force_N", "35.1507*vir")]].concat(),
    );
    for r in [product, factor] {
        assert_eq!(r.len(), csv.len());
        assert_eq!(r.repeat, csv.repeat);
        for (a, b) in r.effort.iter().zip(&csv.effort) {
            assert!((a - b).abs() < 1e-3, "{a} {b}");
        }
        for (a, b) in r
            .position
            .iter()
            .zip(&csv.position)
            .chain(r.t_s.iter().zip(&csv.t_s))
        {
            assert!((a - b).abs() < 1e-7, "{a} {b}");
        }
    }
    let r = real_file(
        &root,
        "emps/DATA_EMPS_PULSES.mat",
        &[&map[..], &[("voltage_V", "vir")]].concat(),
    );
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
        load(
            &path,
            &LoadOptions {
                sign: Some(sign),
                ..LoadOptions::default()
            },
        )
        .expect("loads")
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
    let gap = r.warnings.iter().find(|w| w.code == "gap").expect("a gap");
    assert!(
        gap.message.contains("2.6600 s at line 14") && gap.message.contains("line 3743"),
        "{}",
        gap.message
    );
    let inner = r.pieces[1].clone();
    assert_eq!((r.pieces.len(), r.pieces[2].end), (3, r.len()));
    assert!((12..3741).contains(&inner.start) || inner.start == 12);
    assert!(r.segment[inner.start - 1] < r.segment[inner.start]);
}

#[test]
fn words_in_a_run_column_become_numbers_and_restarts_become_pieces() {
    let Some(root) = recordings() else { return };
    let r = real_file(
        &root,
        "screw_drives/drive3_steady_state.csv",
        &[("segment", "run")],
    );
    assert_eq!(r.pieces.len(), 46);
    assert_eq!(r.segment.last(), Some(&45));
    assert!(warns(&r, "labels-numbered") && !r.segments_found);
    for piece in &r.pieces {
        assert_eq!(r.position[piece.start], 0.0);
    }
}

/// `rows` of (t, x, F) as CSV.
fn table(rows: impl IntoIterator<Item = (f64, f64, f64)>) -> String {
    rows.into_iter()
        .fold("t_s,x_m,force_N\n".into(), |mut out, (t, x, f)| {
            writeln!(out, "{t},{x},{f}").expect("memory");
            out
        })
}

#[test]
fn time_must_advance() {
    for (t, how, place) in [
        ([0.0, 1.0, 0.5], "runs backwards", "line 4"),
        ([0.0, 1.0, 1.0], "stands still", "line 4"),
    ] {
        let e = text(&table(t.map(|t| (t, t, 1.0))), &[])
            .expect_err(how)
            .to_string();
        assert!(
            e.contains(how) && e.contains(place) && e.contains("test.csv"),
            "{e}"
        );
    }
    // Blank lines count in the message.
    let e = text("t_s,x_m,force_N\n0,0,1\n\n1,0,1\n1,0,1\n", &[])
        .expect_err("still")
        .to_string();
    assert!(e.contains("line 5"), "{e}");
}

#[test]
fn the_clock_may_start_again_with_a_new_segment_only() {
    let rows = "t_s,x_m,force_N,segment,lot\n0,0,1,0,a\n1,1,1,0,a\n2,2,1,0,a\n0,0,1,1,b\n1,1,1,1,b\n2,2,1,1,b\n";
    let r = text(rows, &[]).expect("two segments");
    assert_eq!(r.pieces, vec![0..3, 3..6]);
    assert!(warns(&r, "time-restarts") && !r.segments_found);
    let e = text(&rows.replace("segment", "other"), &[])
        .expect_err("no segment")
        .to_string();
    assert!(
        e.contains("--map segment=other") && e.contains("line 5"),
        "{e}"
    );
    let r = text(&rows.replace("segment", "other"), &[("segment", "lot")]).expect("words");
    assert_eq!(r.segment, [0, 0, 0, 1, 1, 1]);
    let e = text(&rows.replace("0,a", "0.5,a"), &[])
        .expect_err("half a segment")
        .to_string();
    assert!(e.contains("`segment`") && e.contains("whole number"), "{e}");
}

#[test]
fn position_comes_from_velocity_where_there_is_none() {
    let rows: String = (0..300).fold("t_s,qd_rad_s,torque_Nm\n".into(), |mut out, i| {
        let t = f64::from(i) * 0.01;
        writeln!(out, "{t},{},0", 2.0 * t).expect("memory");
        out
    });
    let r = text(&rows, &[]).expect("velocity");
    assert!(
        r.position_integrated && warns(&r, "position-integrated") && warns(&r, "constant-effort")
    );
    assert_eq!(r.kind, MotionKind::Rotary);
    for (t, q) in r.t_s.iter().zip(&r.position) {
        assert!((q - t * t).abs() < 1e-12);
    }
}

#[test]
fn a_file_over_a_gigabyte_is_refused_at_once() {
    let folder = tempfile::tempdir().expect("temporary folder");
    for (name, limit) in [("big.csv", 1u64 << 30), ("big.mat", 1 << 29)] {
        let path = folder.path().join(name);
        let file = File::create(&path).expect("create");
        file.set_len(limit + 1).expect("sparse");
        let e = load(&path, &LoadOptions::default()).expect_err("too large");
        assert!(matches!(e.problem, Problem::TooLarge { .. }), "{e}");
        // One that passes for its size is all zero bytes: no text, and found out in its first line.
        file.set_len(limit).expect("sparse");
        let e = load(
            &path,
            &LoadOptions {
                max_bytes: 1 << 30,
                ..LoadOptions::default()
            },
        )
        .expect_err("zeros");
        assert!(
            matches!(e.problem, Problem::NotText { .. } | Problem::Mat { .. }),
            "{e}"
        );
    }
    let e = load(&folder.path().join("absent.csv"), &LoadOptions::default())
        .expect_err("absent")
        .to_string();
    assert!(
        e.contains("absent.csv") && e.contains("check the path"),
        "{e}"
    );
    let e = load(folder.path(), &LoadOptions::default()).expect_err("a folder");
    assert!(matches!(e.problem, Problem::Io(_)), "{e}");
}

#[test]
fn signs_maps_and_windows_that_make_no_sense() {
    let csv = table((0..9).map(|i| (f64::from(i), f64::from(i), 1.0)));
    let bad = LoadOptions {
        sign: Some(2.0),
        ..LoadOptions::default()
    };
    assert!(matches!(
        load_csv(csv.as_bytes(), "s", &bad).map_err(|e| e.problem),
        Err(Problem::Sign(_))
    ));
    for bad in ["force_N", "=x", "force_N=", ""] {
        assert!(parse_map(bad).is_err_and(|e| e.contains("NAME=COLUMN")));
    }
    assert_eq!(
        parse_map("force_N= 2*a")
            .as_ref()
            .map(|(a, b)| (a.as_str(), b.as_str())),
        Ok(("force_N", "2*a"))
    );
    let r = text(&csv, &[]).expect("loads");
    assert_eq!(r.slice_time(2.0, 5.0).expect("inside").t_s, [2.0, 3.0, 4.0]);
    for (from, to) in [(5.0, 2.0), (20.0, 30.0), (2.0, 2.5), (f64::NAN, 3.0)] {
        let e = r
            .slice_time(from, to)
            .expect_err("nothing inside")
            .to_string();
        assert!(e.contains("covers 0 s to 8 s"), "{e}");
    }
}

/// What holds of anything that loads.
fn check_invariants(r: &Recording) {
    let n = r.len();
    assert!(n >= 2 && !r.is_empty());
    assert!(
        [
            r.position.len(),
            r.effort.len(),
            r.segment.len(),
            r.repeat.len()
        ]
        .iter()
        .all(|&l| l == n)
    );
    assert_eq!(r.pieces.iter().map(|p| p.len()).sum::<usize>(), n);
    assert!(r.pieces.windows(2).all(|w| w[0].end == w[1].start));
    for piece in &r.pieces {
        assert!(r.t_s[piece.clone()].windows(2).all(|w| w[0] < w[1]));
    }
    assert!(
        r.position
            .iter()
            .chain(&r.effort)
            .chain(&r.t_s)
            .all(|v| v.is_finite())
    );
}

#[test]
fn random_bytes_and_random_damage_never_panic() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let good =
        table((0..60).map(|i| (f64::from(i) * 0.01, f64::from(i).sin(), f64::from(i).cos())))
            .into_bytes();
    let alphabet = b"0123456789.,-+eE\n\r\"#;\t nNaif\0\xff_tsxm";
    let mut loaded = 0;
    for round in 0..6000 {
        let mut bytes = good.clone();
        if round % 10 == 0 {
            bytes.resize(rng.random_range(0..400), 0);
            rng.fill_bytes(&mut bytes);
        } else {
            for _ in 0..rng.random_range(1..4) {
                let at = rng.random_range(0..bytes.len());
                let byte = alphabet[rng.random_range(0..alphabet.len())];
                match rng.random_range(0..4) {
                    0 => bytes.insert(at, byte),
                    1 => drop(bytes.remove(at)),
                    2 => bytes.truncate(at.max(1)),
                    _ => bytes[at] = byte,
                }
            }
        }
        for result in [
            load_csv(bytes.as_slice(), "random.csv", &LoadOptions::default()),
            load_mat(bytes.as_slice(), "random.mat", &LoadOptions::default()),
        ] {
            match result {
                Ok(r) => {
                    check_invariants(&r);
                    loaded += 1;
                }
                Err(e) => assert!(e.to_string().starts_with("random."), "{e}"),
            }
        }
    }
    assert!(
        loaded > 500,
        "the damage must leave some readable: {loaded}"
    );
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

/// A swing of 30 mm in all, 0.2 Hz, at 500 Hz, with its Coulomb force.
fn swing(change: impl Fn(i32, &mut f64, &mut f64)) -> String {
    table((0..10_000).map(|i| {
        let phase = f64::from(i) * 0.002 * 0.2 * std::f64::consts::TAU;
        let (mut x, mut f) = (
            0.015 * phase.sin(),
            phase.cos().signum() * 3.0 + 0.1 * (f64::from(i) * 0.7).sin(),
        );
        change(i, &mut x, &mut f);
        (f64::from(i) * 0.002, x, f)
    }))
}

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
                ("dfki_pendulum", _) => &pendulum,
                (_, "all_joints_2500Hz.csv") => &all,
                ("staubli_tx40", _) => &joint,
                ("odrive_cogging", _) => &[("current_A", "current_iq_A")],
                _ => &[],
            };
            if map.is_empty() || !name.ends_with(".csv") {
                if !name.ends_with(".csv") {
                    continue;
                }
            } else if folder == "dfki_pendulum" {
                let e = load(&file.path(), &LoadOptions::default())
                    .expect_err(&name)
                    .to_string();
                assert!(
                    e.contains("--map t_s=time --map q_rad=position --map torque_Nm=torque"),
                    "{e}"
                );
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
