//! The `preslide` binary and recordings that it cannot read, or that cannot answer: what it refuses, warns of and asks about.

use super::binary::{Folder, HEADER, Run, preslide, recording};
use preslide_fit::model::Model;
use std::process::Command;
use std::time::{Duration, Instant};

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
    // The model keeps the unit: it meets no force unasked, and no simulator takes it for one.
    let model = folder.path("amperes.toml");
    preslide(&["identify", &path, "-o", &model]).succeeds();
    let force = folder.file("force.csv", recording(HEADER));
    for command in [
        &["simulate", &model, "--motion", &force][..],
        &["diagnose", &force, "--model", &model],
    ] {
        preslide(command).fails(2, &["force.csv", "in N", "in A", "--map force_N=K*COLUMN"]);
    }
    preslide(&["export", &model, "--mjcf"]).fails(2, &["amperes.toml", "in A", "--map"]);
    let column = folder.path("simulated.csv");
    let run = preslide(&["simulate", &model, "--motion", &path, "-o", &column]);
    assert!(run.succeeds().out.contains(" A"), "{}", run.out);
    let simulated = std::fs::read_to_string(column).expect("written");
    assert!(
        simulated.starts_with("t_s,x_m,v_m_s,current_A"),
        "{simulated:.80}"
    );
}

#[test]
fn a_model_of_a_motion_that_goes_one_way_says_what_its_constant_force_is() {
    let folder = Folder::new();
    let mut rows = "t_s,x_m,force_N\n".to_owned();
    for i in 0..4000 {
        let t = f64::from(i) * 2e-3;
        let (sin, cos) = (3.0 * t).sin_cos();
        let (x, v, a) = (0.1 * t - 0.02 * cos, 0.1 + 0.06 * sin, 0.18 * cos);
        rows += &format!("{t:.3},{x:.9},{:.6}\n", 30.0 + 120.0 * v + 40.0 * a);
    }
    let (path, model) = (folder.file("oneway.csv", rows), folder.path("model.toml"));
    preslide(&["identify", &path, "-o", &model]).succeeds();
    let model = std::fs::read_to_string(model).expect("written");
    assert!(
        model.contains("# the motion goes one way: constant_force"),
        "{model}"
    );
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
    // The same as if the user had kept them apart, but for the words of the command.
    let apart = run(&["--train", "0..12", "--test", "12..24"]);
    let of = |run: &Run| {
        run.out
            .lines()
            .filter(|l| !l.starts_with("Note") && !l.starts_with("Next"))
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

/// Names and cells are of strangers' files: what commands a terminal, or turns the order of letters, is spelt out.
#[test]
fn no_byte_of_a_file_commands_the_terminal() {
    let folder = Folder::new();
    let bad = "\u{1b}[2J\u{9b}\u{202e}7";
    let cell = recording(HEADER).replacen('\n', &format!("\n{bad}"), 1);
    let cell = folder.file("cell.csv", cell);
    let name = folder.file("name.csv", recording(&format!("t_s,x{bad},force_N")));
    let model = folder.file("model.toml", format!("schema = \"{bad}\"\n"));
    for line in [
        ["identify", &cell],
        ["identify", &name],
        ["identify", &format!("no{bad}.csv")],
        ["export", &model],
    ] {
        let run = preslide(&line);
        let shown = run.err.clone() + &run.out;
        let is_plain = |c: char| c == '\n' || !c.is_control() && c != '\u{202e}';
        assert!(shown.chars().all(is_plain), "{line:?}: {shown:?}");
        assert!(shown.contains("[2J"), "{line:?}: {shown}");
    }
    // The command that it offers has the name as it is found.
    let map = "x_m=x\u{fffd}[2J\u{fffd}\u{202e}7";
    preslide(&["identify", &name, "--map", map]).succeeds();
}
