//! The `preslide` binary and recordings that it cannot read, or that cannot answer: what it refuses, warns of and asks about.

use super::binary::{Folder, HEADER, Run, preslide, recording};
use preslide_fit::model::Model;
use preslide_host_tests::recordings;
use std::fmt::Write as _;
use std::process::Command;
use std::time::{Duration, Instant};

/// A folder of the real recordings, where it exists.
fn real(name: &str) -> Option<String> {
    Some(recordings()?.join(name).display().to_string())
}

/// A recording with one line (counted from 1, the header) replaced.
fn with_line(line: usize, text: &str) -> String {
    let mut lines: Vec<String> = recording(HEADER).lines().map(String::from).collect();
    lines[line - 1] = text.to_owned();
    lines.join("\n")
}

#[test]
fn bad_headers_name_the_file_and_the_remedy() {
    let folder = Folder::new();
    let headless = recording(HEADER)
        .split_once('\n')
        .expect("lines")
        .1
        .to_owned();
    for (name, text, parts) in [
        ("headless.csv", headless, &["line 1", "t_s,x_m,force_N"][..]),
        (
            "unit.csv",
            recording("t_s,x,friction_N"),
            &["`x`", "x_m", "--map"],
        ),
        (
            "furlong.csv",
            recording("t_s,x_furlong,friction_N"),
            &["`x_furlong`", "x_m", "--map"],
        ),
        (
            "two.csv",
            recording("t_s,x_m,friction_N")
                .lines()
                .enumerate()
                .fold(String::new(), |all, (i, line)| {
                    all + line + if i == 0 { ",force_N\n" } else { ",1\n" }
                }),
            &["`friction_N`", "`force_N`", "--map"],
        ),
        ("empty.csv", String::new(), &["is empty", "header"]),
        ("no_samples.csv", format!("{HEADER}\n"), &["0 samples"]),
    ] {
        let path = folder.file(name, text);
        preslide(&["identify", &path]).fails(2, &[&[name][..], parts].concat());
    }
}

#[test]
fn a_bad_cell_is_a_lost_sample_that_is_told_with_its_line() {
    let folder = Folder::new();
    for (name, row, parts) in [
        ("nan.csv", "0.480,NaN,0.1", &["`x_m`", "not finite"][..]),
        (
            "text.csv",
            "0.480,1e-6,high",
            &["`friction_N`", "`high` is not a number"],
        ),
        ("hole.csv", "0.480,,0.1", &["`x_m`", "empty"]),
        ("when.csv", "inf,1e-6,0.1", &["`t_s`", "not finite"]),
        ("short.csv", "0.480,1e-6", &["2 cells"]),
    ] {
        let path = folder.file(name, with_line(50, row));
        let run = preslide(&["identify", &path]);
        for part in [&[name, "lost-samples", "line 50"], parts].concat() {
            assert!(run.succeeds().err.contains(part), "{part}: {}", run.err);
        }
    }
}

#[test]
fn a_table_of_speed_and_effort_without_time_is_identified() {
    let folder = Folder::new();
    let row = |v: f64| format!("{v},{}\n", 0.5 * v.signum() + 0.3 * v + 0.02);
    let rows = (1..=20).map(|i| row(0.1 * f64::from(i)) + &row(-0.1 * f64::from(i)));
    let table = format!("velocity_rad_s,torque_Nm\n{}", rows.collect::<String>());
    let path = folder.file("table.csv", &table);
    let (json, model) = (folder.path("fit.json"), folder.path("model.toml"));
    let run = preslide(&["identify", &path, "--json", &json, "-o", &model]);
    assert!(
        run.succeeds().err.contains("40 rows without time"),
        "{}",
        run.err
    );
    let json = std::fs::read_to_string(json).expect("written");
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    for (key, right) in [
        ("coulomb_Nm", 0.5),
        ("viscous_Nm_s_per_rad", 0.3),
        ("offset_Nm", 0.02),
    ] {
        let value = json["fit"]["parameters"][key]["value"].as_f64();
        assert!(
            value.is_some_and(|v| (v - right).abs() < 1e-9),
            "{key}: {json}"
        );
    }
    let model = std::fs::read_to_string(model).expect("written");
    assert!(model.contains("no inertia"), "{model}");
    Model::parse(&model).expect("a model");
    preslide(&["identify", &path, "--train", "0..1"]).fails(2, &["table.csv", "--train", "t_s"]);
    preslide(&["diagnose", &path]).fails(2, &["table.csv", "no time", "preslide identify"]);
    let words = folder.file("words.csv", table.replace(",0.", ",about 0."));
    preslide(&["identify", &words]).fails(2, &["words.csv", "line 4", "torque_Nm"]);
    let steady = folder.file(
        "steady.csv",
        "qd_rad_s,torque_Nm\n".to_owned() + &"2,1\n".repeat(9),
    );
    preslide(&["identify", &steady]).fails(3, &["steady.csv", "three speeds"]);
}

#[test]
fn a_current_in_milliamperes_is_asked_about_with_the_command_that_reads_it() {
    let folder = Folder::new();
    let path = folder.file("drive.csv", recording("t_s,x_m,iq"));
    let map = "current_A=400*iq";
    let run = preslide(&["identify", &path, "--map", map]);
    let told = run
        .succeeds()
        .err
        .lines()
        .find(|l| l.starts_with("Try: preslide identify"));
    let told = told.unwrap_or_else(|| panic!("{}", run.err));
    assert!(run.err.contains("`iq` is in mA"), "{}", run.err);
    let map = "current_A=0.4*iq";
    assert_eq!(told, format!("Try: preslide identify {path} --map '{map}'"));
    let run = preslide(&["identify", &path, "--map", map]);
    assert!(!run.succeeds().err.contains("implausible"), "{}", run.err);
}

#[test]
fn bad_times_name_file_line_and_remedy() {
    let folder = Folder::new();
    for (name, row, parts) in [
        (
            "back.csv",
            "0.100,1e-6,0.1",
            &["line 50", "runs backwards", "sort the rows"][..],
        ),
        (
            "still.csv",
            "0.470,1e-6,0.1",
            &["line 50", "stands still", "more digits"],
        ),
    ] {
        let path = folder.file(name, with_line(50, row));
        preslide(&["identify", &path]).fails(2, &[&[name][..], parts].concat());
    }
}

#[test]
fn motion_that_cannot_answer_exits_with_3_and_says_what_to_record() {
    let folder = Folder::new();
    let table = |x: fn(i32) -> f64, f: fn(i32) -> f64, n: i32| {
        (0..n).fold(format!("{HEADER}\n"), |mut text, i| {
            writeln!(text, "{},{},{}", f64::from(i) * 0.01, x(i), f(i)).expect("memory");
            text
        })
    };
    let wave = |i: i32| (f64::from(i) * 0.02).sin() * 1e-3;
    let force = |i: i32| (f64::from(i) * 0.02).cos().signum();
    for (name, text, parts) in [
        (
            "one_way.csv",
            table(|i| f64::from(i) * 1e-5, |i| f64::from(i % 7), 900),
            &["one-way-motion", "explains nothing"][..],
        ),
        (
            "short.csv",
            table(wave, force, 90),
            &["too-short", "longer"],
        ),
        (
            "standstill.csv",
            table(|_| 0.5, |i| f64::from(i % 7), 900),
            &["no-motion", "record a motion"],
        ),
        (
            "no_effort.csv",
            table(wave, |_| 0.0, 3000),
            &["constant-effort", "effort"],
        ),
    ] {
        let path = folder.file(name, text);
        preslide(&["identify", &path]).fails(3, &[&[name][..], parts].concat());
    }
}

#[test]
fn a_current_is_taken_as_it_is_and_what_a_constant_would_add_is_said() {
    let folder = Folder::new();
    let path = folder.file("current.csv", recording("t_s,x_m,current_A"));
    let run = preslide(&["identify", &path]);
    let said = &run.succeeds().out;
    for part in [
        "the effort is in A",
        "K in N/A",
        "--map force_N=K*COLUMN",
        "A·s²/m",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    preslide(&["identify", &path, "--map", "friction_N=2*current_A"]).succeeds();
}

#[test]
fn the_gap_of_the_o_ring_is_a_warning_that_names_the_line() {
    let Some(path) = real("pneumatic_seal/O-ring_3bar.csv") else {
        return;
    };
    let run = preslide(&["identify", &path]);
    run.succeeds();
    for part in ["O-ring_3bar.csv", "gap", "2.6600 s at line 14"] {
        assert!(run.err.contains(part), "{}", run.err);
    }
}

#[test]
fn a_truncated_mat_file_names_the_byte() {
    let Some(path) = real("emps/DATA_EMPS.mat") else {
        return;
    };
    let bytes = std::fs::read(path).expect("readable");
    let folder = Folder::new();
    let cut = folder.file("cut.mat", &bytes[..bytes.len() / 2]);
    let map = [
        "--map",
        "t_s=t",
        "--map",
        "x_m=qm",
        "--map",
        "force_N=gtau*vir",
    ];
    preslide(&[&["identify", &cut][..], &map].concat()).fails(2, &["cut.mat", "at byte"]);
    let head = folder.file("head.mat", &bytes[..60]);
    preslide(&[&["identify", &head][..], &map].concat()).fails(2, &["head.mat"]);
}

/// Under a limit of address space, so that reading it would fail loudly.
#[cfg(unix)]
#[test]
fn a_gigabyte_is_refused_at_once_and_in_little_memory() {
    let folder = Folder::new();
    for (name, bytes, reason) in [
        ("over.csv", (1u64 << 30) + 1, "exceed the limit"),
        ("zeros.csv", 1 << 30, "64 KiB"),
        ("over.mat", 1 << 30, "exceed the limit"),
    ] {
        let path = folder.file(name, "");
        let file = std::fs::File::options()
            .write(true)
            .open(&path)
            .expect("open");
        file.set_len(bytes).expect("sparse");
        let start = Instant::now();
        let run = Run::from(
            Command::new("sh")
                .args(["-c", "ulimit -v 400000; exec \"$0\" identify \"$1\""])
                .args([env!("CARGO_BIN_EXE_preslide"), &path])
                .output()
                .expect("sh runs"),
        );
        run.fails(2, &[name, reason]);
        assert!(start.elapsed() < Duration::from_secs(10), "{name}");
    }
}

#[test]
fn files_that_are_not_there_and_maps_that_lead_nowhere() {
    let folder = Folder::new();
    let path = folder.file("good.csv", recording(HEADER));
    preslide(&["identify", &folder.path("absent.csv")]).fails(2, &["absent.csv", "check the path"]);
    preslide(&["identify", &folder.path("")]).fails(2, &["cannot be read"]);
    preslide(&["identify", &path, "--map", "friction_N=load_cell"]).fails(
        2,
        &["good.csv", "no column `load_cell`", "t_s, x_m, friction_N"],
    );
    preslide(&["identify", &path, "--map", "force=friction_N"])
        .fails(2, &["`force` is no column", "force_N"]);
    preslide(&["identify", &path, "--map", "nonsense"]).fails(2, &["NAME=COLUMN"]);
    preslide(&["identify", &path, "--sign", "2"]).fails(2, &["--sign 2", "1 nor -1"]);
}

#[test]
fn windows_and_sizes_that_make_no_sense() {
    let folder = Folder::new();
    let path = folder.file("good.csv", recording(HEADER));
    let run = |more: &[&str]| preslide(&[&["identify", path.as_str()][..], more].concat());
    run(&["--train", "12..4"]).fails(2, &["12..4", "end after it starts"]);
    run(&["--train", "4"]).fails(2, &["FROM..TO"]);
    run(&["--test", "a..b"]).fails(2, &["FROM..TO"]);
    run(&["--train", "50..60"]).fails(2, &["--train 50..60", "good.csv", "0 to 23.99 s"]);
    run(&["--test", "50..60"]).fails(2, &["--test 50..60", "0 to 23.99 s"]);
    preslide(&["compare", &path, "--train", "50..60"]).fails(2, &["--train 50..60", "good.csv"]);
    run(&["--train", "2..8", "--test", "0..20"]).fails(2, &["do not overlap"]);
    run(&["--train", "0..0.2"]).fails(3, &["good.csv", "explains nothing"]);
    run(&["--blocks", "99"]).fails(2, &["--blocks 99", "models of 0, 1"]);

    let overlap = run(&["--train", "0..16", "--test", "12..24"]);
    let note = "--train and --test overlap from 12 to 16 s: these samples are judged, not fitted";
    assert!(overlap.succeeds().out.contains(note), "{}", overlap.out);
    // The same as if the user had kept them apart.
    let apart = run(&["--train", "0..12", "--test", "12..24"]);
    let of = |run: &Run| {
        run.out
            .lines()
            .filter(|l| !l.starts_with("Note"))
            .collect::<Vec<_>>()
            .join("\n")
    };
    assert_eq!(of(&overlap), of(apart.succeeds()));
}

#[test]
fn recordings_of_different_machines_are_not_joined() {
    let folder = Folder::new();
    let one = folder.file("one.csv", recording(HEADER));
    let other = folder.file("other.csv", recording("t_s,q_rad,torque_Nm"));
    preslide(&["identify", &one, &other]).fails(2, &["one.csv", "other.csv", "not of one machine"]);
    preslide(&["identify", &one, &one]).succeeds();
}
