//! The same fault has the same exit code in every command that can meet it.

use super::binary::{Folder, HEADER, MODEL, preslide, recording};

/// Commands that read a recording `REC`, those that fit it first; `MODEL` is a model file.
const FITTING: [&str; 5] = [
    "identify REC",
    "compare REC",
    "diagnose REC",
    "diagnose REC --model MODEL",
    "tune MODEL --count 25e-9 --recording REC",
];
const RUNNING: [&str; 2] = [
    "simulate MODEL --motion REC",
    "export MODEL --recording REC",
];

/// Commands that read a model.
const WITH_MODEL: [&str; 4] = [
    "simulate MODEL --motion REC",
    "export MODEL --recording REC",
    "tune MODEL --count 25e-9 --recording REC",
    "diagnose REC --model MODEL",
];

/// Runs a command of the tables.
#[track_caller]
fn code(command: &str, model: &str, rec: &str, more: &[&str], expected: i32, parts: &[&str]) {
    let words = command.split(' ').map(|word| match word {
        "MODEL" => model,
        "REC" => rec,
        other => other,
    });
    let arguments: Vec<&str> = words.chain(more.iter().copied()).collect();
    let run = preslide(&arguments);
    assert_eq!(
        run.code,
        Some(expected),
        "{arguments:?}\n{}\n{}",
        run.out,
        run.err
    );
    run.fails(expected, parts);
}

fn table(x: impl Fn(u32) -> f64, force: impl Fn(u32) -> f64, rows: u32) -> String {
    let row = |i| format!("{:.3},{:.9},{:.6}\n", f64::from(i) * 0.01, x(i), force(i));
    format!("{HEADER}\n{}", (0..rows).map(row).collect::<String>())
}

#[test]
fn what_is_wrong_with_a_file_or_an_option_is_2_everywhere() {
    let folder = Folder::new();
    let model = folder.file("model.toml", MODEL);
    let good = recording(HEADER);
    let line = |number: usize, text: &str| {
        let mut lines: Vec<&str> = good.lines().collect();
        lines[number - 1] = text;
        lines.join("\n")
    };
    // One in five rows from line 100 on: more than a recording can lose.
    let broken = |cells: &str| {
        let mut text = String::new();
        for (number, line) in (1..).zip(good.lines()) {
            let time = line.split(',').next().unwrap_or_default();
            text += &match number {
                100.. if number % 5 == 0 => format!("{time}{cells}\n"),
                _ => format!("{line}\n"),
            };
        }
        text
    };
    let of_file = [
        ("empty.csv", String::new(), "empty"),
        ("names.csv", recording("t_s,pos,out"), "--map"),
        ("nan.csv", broken(",NaN,0"), "line 100"),
        ("back.csv", line(100, "0.001,0,0"), "line 100"),
        ("ragged.csv", broken(",0"), "line 100"),
        ("absurd.csv", broken(",0,1e200"), "line 100"),
        ("broken.mat", "MATLAB 5.0 MAT-file".to_owned(), "at byte"),
        ("a.tdms", "TDSm and more".to_owned(), "TDMS"),
    ];
    for (name, text, part) in of_file {
        let path = folder.file(name, text);
        for command in FITTING.iter().chain(&RUNNING) {
            code(command, &model, &path, &[], 2, &[name, part]);
        }
    }
    let path = folder.file("good.csv", &good);
    let of_options: [(&[&str], &str); 4] = [
        (&["--map", "x_m=nowhere"], "nowhere"),
        (&["--map", "nonsense"], "NAME=COLUMN"),
        (&["--sign", "2"], "--sign 2 is neither 1 nor -1"),
        (&["--ignore", "nowhere"], "nowhere"),
    ];
    for command in FITTING.iter().chain(&RUNNING) {
        let absent = folder.path("absent.csv");
        code(command, &model, &absent, &[], 2, &["absent.csv"]);
        for (more, part) in of_options {
            code(command, &model, &path, more, 2, &[part]);
        }
    }
    for (name, part) in [("absent.csv", "check the path"), ("", "cannot be read")] {
        preslide(&["identify", &folder.path(name)]).fails(2, &[name, part]);
    }
}

#[test]
fn a_model_that_is_wrong_or_of_another_axis_is_2_everywhere() {
    let folder = Folder::new();
    let path = folder.file("good.csv", recording(HEADER));
    let rotary = folder.file("rotary.csv", recording("t_s,q_rad,torque_Nm"));
    let good = folder.file("good.toml", MODEL);
    let edited = |name, from, to, part| (name, MODEL.replace(from, to), part);
    let models = [
        edited(
            "key.toml",
            "breakaway_N",
            "colour = 3\nbreakaway_N",
            "colour",
        ),
        edited(
            "line.toml",
            "breakaway_N",
            "colour = 3\nbreakaway_N",
            "line 5",
        ),
        edited("value.toml", "= 20000.0", "= -20000.0", "stiffness"),
        edited("number.toml", "= 20000.0", "= -20000.0", "-20000"),
        edited("weights.toml", "0.75", "0.5", "weight"),
        edited("nan.toml", "0.75", "nan", "weight"),
        edited("schema.toml", "model/1", "model/9", "preslide.model/1"),
        edited("broken.toml", "]\n", "", "line"),
        ("empty.toml", String::new(), "motion"),
    ];
    for command in WITH_MODEL {
        for (name, text, part) in &models {
            let model = folder.file(name, text);
            code(command, &model, &path, &[], 2, &[name, part]);
        }
        code(
            command,
            &folder.path("absent.toml"),
            &path,
            &[],
            2,
            &["absent.toml"],
        );
        code(command, &good, &rotary, &[], 2, &["rotary", "linear"]);
    }
}

#[test]
fn a_recording_that_cannot_answer_is_3_where_something_is_fitted() {
    let folder = Folder::new();
    let model = folder.file("model.toml", MODEL);
    let wave = |i: u32| 1e-3 * (f64::from(i) * 0.02).sin();
    let force = |i: u32| (f64::from(i) * 0.02).cos().signum();
    let saw = |i: u32| f64::from(i % 7);
    for (name, text, warning, remedy) in [
        (
            "standstill.csv",
            table(|_| 0.5, saw, 900),
            "no-motion",
            "record a motion",
        ),
        (
            "no_effort.csv",
            table(wave, |_| 0.0, 3000),
            "constant-effort",
            "effort",
        ),
        (
            "short.csv",
            table(wave, force, 90),
            "too-short",
            "record for longer",
        ),
    ] {
        let path = folder.file(name, text);
        for command in FITTING {
            code(command, &model, &path, &[], 3, &[name, warning, remedy]);
        }
        // What is only run along a motion has nothing to tell apart.
        preslide(&["simulate", &model, "--motion", &path]).succeeds();
    }
    let one_way = folder.file("one_way.csv", table(|i| 1e-5 * f64::from(i), saw, 900));
    let parts = ["one_way.csv", "one-way-motion", "explains nothing"];
    preslide(&["identify", &one_way]).fails(3, &parts);
}

#[test]
fn outputs_are_refused_alike_before_any_work() {
    let folder = Folder::new();
    let model = folder.file("model.toml", MODEL);
    let path = folder.file("good.csv", recording(HEADER));
    let nowhere = folder.path("absent/out.json");
    let to_file = ["simulate MODEL --motion REC"].iter().chain(&FITTING);
    for command in to_file {
        code(
            command,
            &model,
            &path,
            &["--json", &path],
            2,
            &["this would overwrite the input"],
        );
        code(
            command,
            &model,
            &path,
            &["--json", &nowhere],
            1,
            &["folder that exists"],
        );
    }
    for command in WITH_MODEL.iter().filter(|c| !c.starts_with("export")) {
        code(
            command,
            &model,
            &path,
            &["--json", &model],
            2,
            &["this would overwrite the input"],
        );
    }
    code(
        "export MODEL",
        &model,
        "",
        &["-o", &model],
        2,
        &["this would overwrite the input"],
    );
    assert_eq!(std::fs::read_to_string(&model).expect("there"), MODEL);
}

/// Into a pipe, too, sentences are folded; commands and tables stay whole.
#[test]
fn sentences_are_folded_wherever_they_go() {
    let folder = Folder::new();
    let rec = folder.file("rec.csv", recording(HEADER));
    let said = preslide(&["diagnose", &rec]);
    let said = &said.succeeds().out;
    let is_whole = |line: &&str| {
        let words = line.trim_start();
        words.contains("  ") || words.contains('─') || words.starts_with("Next: ")
    };
    // The first line sums up the file, as a row of a table.
    let long = said.lines().skip(1).filter(|line| !is_whole(line));
    let long: Vec<&str> = long.filter(|line| line.chars().count() > 100).collect();
    assert!(long.is_empty(), "{long:#?}");
    assert!(said.lines().count() > 8, "{said}");
}

/// `preslide … 2>&1 | head`: a reader that has seen enough loses no file.
#[test]
fn a_closed_pipe_ends_nothing() {
    let folder = Folder::new();
    let rec = folder.file("rec.csv", recording(HEADER));
    let [json, page] = ["answer.json", "page.html"].map(|name| folder.path(name));
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_preslide"))
        .args(["identify", &rec, "--json", &json, "--report", &page])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the binary runs");
    drop((child.stdout.take(), child.stderr.take()));
    assert_eq!(child.wait().expect("an end").code(), Some(0));
    for file in [json, page] {
        assert!(std::path::Path::new(&file).exists(), "{file}");
    }
}

/// An observer without the user's axis, or whose forces are none; a file in place of a port or of a model; units that are no speed's.
#[test]
fn what_was_taken_for_something_else_is_said_to_be_it() {
    let folder = Folder::new();
    let (model, table) = (
        folder.file("model.toml", MODEL),
        folder.file("axis.csv", recording(HEADER)),
    );
    let current = MODEL.replacen("[friction]", "effort_unit = \"A\"\n[friction]", 1);
    let (current, own) = (folder.file("current.toml", current), own_axis());
    let out = folder.path("motion.csv");
    let plan = [
        "plan",
        "--travel",
        "4mm",
        "--acceleration",
        "0.1m/s2",
        "-o",
        &out,
        "--speed",
    ];
    let tune = ["--count", "25nm", "--resonance", "300Hz"];
    for (line, code, parts) in [
        (
            [&["tune", &model][..], &tune].concat(),
            2,
            &["--axis", "PRESLIDE_AXIS", "axis.toml"][..],
        ),
        (
            [&["tune", &current][..], &tune, &["--axis", &own]].concat(),
            2,
            &["forces are in A"],
        ),
        (
            vec!["commission", &table],
            2,
            &["it is a file, not a serial port"],
        ),
        (
            vec!["export", &table],
            2,
            &["this is a table", "preslide identify"],
        ),
        (
            vec!["diagnose", &table, "--model", &table],
            2,
            &["this is a table", "preslide identify"],
        ),
        (
            [&plan[..], &["2mm"]].concat(),
            2,
            &["`2mm` is not a speed", "60rpm"],
        ),
        ([&plan[..], &["60rpm"]].concat(), 2, &["--speed 60rpm"]),
    ] {
        preslide(&line).fails(code, parts);
    }
    let coarse = ["tune", &model, "--count", "1mm", "--cpu"];
    for cores in ["cortex-m4", "all"] {
        let run = preslide(&[&coarse[..], &[cores]].concat());
        run.fails(3, &["--count 1.00 mm: so coarse"]);
    }
    // The blocks have their answer where the observer has none.
    let run = preslide(
        &[
            &["tune", &model][..],
            &tune[..2],
            &["--resonance", "60Hz", "--axis", &own],
        ]
        .concat(),
    );
    run.fails(3, &["gains.proportional of 100 kN/m", "axis.toml"]);
    assert!(run.out.contains("slip_reserve_i16f16"), "{}", run.out);
    preslide(&[&plan[..], &["2mm/s"]].concat()).succeeds();
}

/// The project's own axis, named as a user's would be.
fn own_axis() -> String {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../axis.toml");
    path.display().to_string()
}
