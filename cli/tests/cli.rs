//! The `preslide` binary from outside: outputs, models, help.

use super::binary::{Folder, HEADER, MODEL, preslide, recording};
use preslide_fit::model::Model;
use preslide_host_tests::made::Blocks;
use std::fmt::Write as _;
use std::path::Path;
use std::time::{Duration, Instant};

#[test]
fn model_json_and_report_are_written_and_read_back() {
    let folder = Folder::new();
    let path = folder.file("good.csv", recording(HEADER));
    let (model, json, page) = (
        folder.path("m.toml"),
        folder.path("r.json"),
        folder.path("r.html"),
    );
    let run = preslide(&[
        "identify", &path, "-o", &model, "--json", &json, "--report", &page,
    ]);
    run.succeeds();
    assert!(run.out.contains("Use GMS with 1 block"), "{}", run.out);

    let read = Model::load(Path::new(&model)).expect("a model file");
    assert_eq!(read.friction.kind(), "gms");
    let text = std::fs::read_to_string(&json).expect("json");
    let value: serde_json::Value = serde_json::from_str(&text).expect("valid JSON");
    assert_eq!(value["schema"], "preslide.identification/1");
    assert_eq!(value["recommended"]["blocks"], 1);
    let coulomb = value["parameters"]["coulomb_N"]["value"]
        .as_f64()
        .expect("a number");
    assert!((coulomb - 1.0).abs() < 0.01, "{coulomb}");
    let html = std::fs::read_to_string(&page).expect("page");
    assert!(html.contains("Use GMS with 1 block") && html.contains("</html>"));
    assert!(html.contains("good.csv"));

    // Asked for: other sizes.
    preslide(&["identify", &path, "--blocks", "0", "-o", &model]).succeeds();
    // What `diagnose` would not fit by itself is written first.
    let run = preslide(&["identify", &path, "--blocks", "0"]);
    assert!(
        run.succeeds().out.contains("--blocks 0 -o model.toml"),
        "{}",
        run.out
    );
    assert_eq!(
        Model::load(Path::new(&model))
            .expect("a model file")
            .friction
            .kind(),
        "coulomb"
    );
    // Another model of the family, with its parameters in a table.
    let run = preslide(&["identify", &path, "--friction", "dahl_linear", "-o", &model]);
    assert!(run.succeeds().out.contains("Dahl, n = 1 *"), "{}", run.out);
    assert!(run.out.contains("stiffness "), "{}", run.out);
    let kind = Model::load(Path::new(&model)).expect("a model file");
    assert_eq!(kind.friction.kind(), "dahl");
    let both = ["--friction", "lugre", "--blocks", "2"];
    preslide(&[&["identify", path.as_str()][..], &both].concat()).fails(2, &["--blocks"]);
    preslide(&["identify", &path, "--friction", "wet"]).fails(2, &["wet", "two_state"]);
}

#[test]
fn outputs_that_cannot_be_written_say_so() {
    let folder = Folder::new();
    let path = folder.file("good.csv", recording(HEADER));
    for option in ["-o", "--json", "--report"] {
        let target = folder.path("absent/file.html");
        let run = preslide(&["identify", &path, option, &target]);
        run.fails(1, &["cannot write", "file.html", "folder that exists"]);
    }
    let (page, model) = (folder.path("r.png"), folder.path("m.toml"));
    let run = preslide(&["identify", &path, "--report", &page, "-o", &model]);
    run.fails(2, &["r.png", ".html"]);
    assert!(!Path::new(&model).exists(), "refused, and left a model");
    let blocker = folder.file("blocker", "");
    preslide(&["demo", "--out", &format!("{blocker}/inside")]).fails(2, &["--out", "blocker"]);
}

#[test]
fn what_explains_nothing_is_no_model() {
    let folder = Folder::new();
    let (mut text, mut seed) = ("t_s,x_m,force_N\n".to_owned(), 7_u32);
    for i in 0..8000 {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let t = f64::from(i) * 1e-3;
        let noise = f64::from(seed >> 8) / f64::from(1 << 24) - 0.5;
        text += &format!("{t:.3},{:.6},{noise:.5}\n", 0.01 * (5.0 * t).sin());
    }
    let path = folder.file("noise.csv", text);
    let (model, json) = (folder.path("model.toml"), folder.path("noise.json"));
    preslide(&["identify", &path, "-o", &model, "--json", &json])
        .fails(3, &["noise.csv", "explains nothing", "no model is written"]);
    assert!(!std::path::Path::new(&model).exists() && std::path::Path::new(&json).exists());
}

#[test]
fn no_output_overwrites_an_input_or_another_output() {
    let folder = Folder::new();
    let path = folder.file("good.csv", recording(HEADER));
    let before = std::fs::read(&path).expect("there");
    let link = folder.path("link.csv");
    std::fs::hard_link(&path, &link).expect("linked");
    let model = folder.path("model.toml");
    let start = Instant::now();
    preslide(&["identify", &path, "-o", &path]).fails(2, &["-o", "this would overwrite the input"]);
    preslide(&["identify", &path, "-o", &link])
        .fails(2, &["link.csv", "this would overwrite the input"]);
    preslide(&["identify", &path, "-o", &model, "--json", &model])
        .fails(2, &["--json", "already goes there"]);
    preslide(&["diagnose", &path, "--experiment", &path])
        .fails(2, &["--experiment", "this would overwrite the input"]);
    preslide(&["diagnose", &path, "-o", &model, "--experiment", &model])
        .fails(2, &["--experiment", "-o already goes there"]);
    let nowhere = folder.path("no/where.json");
    preslide(&["identify", &path, "-o", &link, "--json", &nowhere]).fails(
        2,
        &[
            "this would overwrite the input",
            "no/where.json",
            "folder that exists",
        ],
    );
    assert!(
        start.elapsed() < Duration::from_secs(5),
        "refused before any work"
    );
    assert!(std::fs::read(&path).expect("there") == before);
    let piped = preslide(&["identify", &path, "-o", "-"]);
    assert!(
        piped
            .succeeds()
            .out
            .contains("schema = \"preslide.model/1\""),
        "{}",
        piped.out
    );
    assert!(
        !piped.out.contains("Use ") && piped.err.contains("Use "),
        "{}",
        piped.out
    );
    let left: Vec<_> = std::fs::read_dir(folder.path(""))
        .expect("folder")
        .flatten()
        .map(|f| f.file_name())
        .collect();
    assert_eq!(left.len(), 2, "{left:?}");
}

#[cfg(unix)]
#[test]
fn a_model_without_end_and_absurd_ones_are_refused() {
    let folder = Folder::new();
    let path = folder.file("good.csv", recording(HEADER));
    preslide(&["simulate", "/dev/zero", "--motion", &path])
        .fails(2, &["/dev/zero", "1048576 bytes"]);
    let model = "schema = \"preslide.model/1\"\nmotion = \"linear\"\n[friction]\nkind = \"coulomb\"\ncoulomb_N = 1e308\n";
    let huge = folder.file("huge.toml", model);
    preslide(&["simulate", &huge, "--motion", &path])
        .fails(2, &["huge.toml", "friction.coulomb_N", "1e308"]);
}

#[test]
fn help_names_units_and_an_example() {
    let top = preslide(&["--help"]);
    for part in ["Exit codes", "identify", "demo"] {
        assert!(top.succeeds().out.contains(part), "{}", top.out);
    }
    let commands: Vec<&str> = top
        .out
        .lines()
        .skip_while(|line| !line.starts_with("Commands:"))
        .skip(1)
        .take_while(|line| line.starts_with("  "))
        .filter(|line| !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|&name| name != "help")
        .collect();
    assert!(commands.len() >= 2, "{commands:?}");
    for command in commands {
        let help = preslide(&[command, "--help"]);
        let text = &help.succeeds().out;
        assert!(text.contains(&format!("preslide {command}")), "{text}");
        assert!(text.contains("Example: preslide"), "{command}: {text}");
        // A link of the code's documentation leads nowhere here.
        assert!(!text.contains("[`"), "{command}: {text}");
        let units = ["_s", "_N", "_m", "in N", "[N", "[s", "Hz", "seconds"];
        assert!(
            units.iter().any(|unit| text.contains(unit)),
            "{command}: {text}"
        );
    }
    preslide(&[]).fails(2, &["Usage"]);
    preslide(&["identfy"]).fails(2, &["identify"]);
    preslide(&["identify"]).fails(2, &["<REC>"]);
}

#[test]
fn capture_leaves_nothing_behind_where_nothing_comes() {
    let folder = Folder::new();
    let (old, new) = (folder.file("old.csv", "t_s\n"), folder.path("new.csv"));
    let noise = folder.file("noise", [0x55; 500]);
    preslide(&["capture", &noise, "-o", &old]).fails(2, &["old.csv exists", "--overwrite"]);
    preslide(&["capture", "tcp:127.0.0.1:1", "-o", &new]).fails(2, &["127.0.0.1:1", "--wait"]);
    preslide(&["capture", &noise, "-o", &new]).fails(3, &["no telemetry", "speed"]);
    assert!(!std::path::Path::new(&new).exists());
    let nowhere = folder.path("none/new.csv");
    preslide(&["capture", &noise, "-o", &nowhere]).fails(1, &["none", "folder"]);
    preslide(&["capture", &noise, "-o", &new, "--every", "0"]).fails(2, &["--every"]);
}

#[test]
fn a_reference_is_followed_in_closed_loop() {
    let folder = Folder::new();
    let model = folder.file("model.toml", format!("{MODEL}[inertia]\nmass_kg = 2.0\n"));
    let plan = folder.file("plan.csv", recording(HEADER));
    let gains = "schema = \"preslide.controller/1\"\nrate_Hz = 8000\nproportional_N_per_m = 2e5\nintegral_N_per_m_s = 1e6\nderivative_N_s_per_m = 900\nlimit_N = 50\n";
    let good = folder.file("gains.toml", gains);
    let json = folder.path("out.json");
    let run = |gains: &str, more: &[&str]| {
        let first = [
            "simulate",
            &model,
            "--reference",
            &plan,
            "--controller",
            gains,
        ];
        preslide(&[&first[..], more].concat())
    };
    let found = run(&good, &["--json", &json]);
    assert!(
        found.succeeds().out.contains("follows its reference"),
        "{}",
        found.out
    );
    let text = std::fs::read_to_string(&json).expect("written");
    let value: serde_json::Value = serde_json::from_str(&text).expect("valid JSON");
    assert_eq!(value["input"], "reference");
    let largest = value["following_max_m"].as_f64().expect("a number");
    // Breakaway force over proportional gain, 4.5 µm, and the start: from rest to 3.5 mm/s in a loop of 316 rad/s, 5 µm.
    assert!(largest > 0.0 && largest < 1e-5, "{largest:e}");
    let bad = folder.file("bad.toml", gains.replace("rate_Hz", "rate"));
    run(&bad, &[]).fails(2, &["bad.toml", "rate_Hz"]);
    preslide(&["simulate", &model, "--reference", &plan]).fails(2, &["--controller"]);
}

/// A motion is planned for the axis that is described: its limits where nothing is said, and not beyond them.
#[test]
fn a_plan_keeps_to_the_axis_that_is_named() {
    let folder = Folder::new();
    let own = include_str!("../../axis.toml");
    let edited = own.replace("speed = 15e-3", "speed = 3e-3");
    assert_ne!(own, edited, "axis.toml has another speed");
    let (axis, motion) = (folder.file("axis.toml", edited), folder.path("motion.csv"));
    let plan = |more: &[&str]| {
        let all = [&["plan", "--axis", &axis, "-o", &motion], more].concat();
        preslide(&all)
    };
    plan(&["--travel", "30mm", "--speed", "4mm/s"]).fails(
        2,
        &[
            "--travel 3e-2 exceeds",
            "--speed 4e-3 exceeds limits.speed, 3e-3",
        ],
    );
    plan(&["--travel", "2", "--smallest", "0.01"]).fails(2, &["`2` has no unit", "2mm"]);
    preslide(&["plan", "--rotary", "--travel", "90deg", "-o", &motion])
        .fails(2, &["--speed 90deg/s --acceleration 720deg/s2", "--axis"]);
    preslide(&["plan", "-o", &motion]).fails(
        2,
        &[
            "--travel 4mm --speed 2mm/s --acceleration 0.1m/s2",
            "--axis",
        ],
    );
    assert!(!std::path::Path::new(&motion).exists());
    preslide(&["plan", "--axis", "none.toml", "-o", &motion]).fails(2, &["none.toml", "axis.toml"]);
    plan(&["--acceleration", "1"]).fails(2, &["1m/s2", "1deg/s2"]);
    let planned = plan(&["--travel", "2mm"]);
    let said = &planned.succeeds().out;
    assert!(
        said.contains("axis.toml: travel") && said.contains("speed 3.00 mm/s"),
        "{said}"
    );
}

/// 4 mm are no 4 mrad, whichever option they are given for.
#[test]
fn an_angle_is_no_length_and_a_number_no_clock() {
    let folder = Folder::new();
    let (model, out) = (folder.file("model.toml", MODEL), folder.path("out"));
    let rotary = MODEL
        .replace("linear", "rotary")
        .replace("_N_per_m", "_Nm_per_rad");
    let rotary = folder.file("rotary.toml", rotary.replace("_N ", "_Nm "));
    let plan = [
        "plan", "-o", &out, "--rotary", "--travel", "4mm", "--speed", "2mm/s",
    ];
    let plan = [
        &plan[..],
        &["--acceleration", "720deg/s2", "--smallest", "1um"],
    ]
    .concat();
    let refused = |line: &[&str], parts: &[&str]| {
        preslide(line).fails(2, parts);
    };
    refused(
        &plan,
        &[
            "--travel 4mm has a unit of length",
            "--speed 2mm/s has",
            "--smallest 1um has",
            "deg",
        ],
    );
    refused(
        &[
            "plan",
            "-o",
            &out,
            "--travel",
            "90deg",
            "--speed",
            "2mm/s",
            "--acceleration",
            "1m/s2",
        ],
        &["--travel 90deg has a unit of angle", "mm"],
    );
    let tune = ["tune", &model, "--count"];
    refused(
        &[&tune[..], &["2.5urad"]].concat(),
        &[
            "--count 2.5urad has a unit of angle",
            "model.toml is the model of a linear axis",
        ],
    );
    let noise = ["25nm", "--resonance", "150Hz", "--noise", "5urad"];
    refused(
        &[&tune[..], &noise].concat(),
        &["--noise 5urad has a unit of angle"],
    );
    refused(
        &[&tune[..], &["25nm", "--clock", "170"]].concat(),
        &["--clock 170MHz"],
    );
    preslide(&[&tune[..], &["25nm", "--clock", "170MHz"]].concat()).succeeds();
    refused(
        &["tune", &rotary, "--count", "25nm"],
        &["--count 25nm has a unit of length"],
    );
    refused(
        &["export", &model, "--count", "2.5urad"],
        &["--count 2.5urad has"],
    );
    refused(
        &["capture", "nowhere", "-o", &out, "--count", "1urad"],
        &["--count 1urad has a unit of"],
    );
    refused(
        &[
            "capture", "nowhere", "-o", &out, "--count", "1um", "--rotary",
        ],
        &["--count 1um has a unit of"],
    );
    // Before a line is opened.
    let drive = |more: &[&str], part: &str| {
        let line = [&["drive", "nowhere"], more].concat();
        refused(&line, &[part, "without --rotary the axis is linear"]);
    };
    drive(&["move", "--by", "90deg"], "--by 90deg has a unit of");
    drive(
        &["move", "--to", "90deg", "--speed", "1deg/s"],
        "--speed 1deg/s has a unit of",
    );
    drive(&["jog", "5deg/s"], "5deg/s has a unit of");
    drive(
        &["home", "--back-off", "5deg"],
        "--back-off 5deg has a unit of",
    );
    drive(&["zero", "5deg"], "5deg has a unit of");
    refused(
        &["commission", "nowhere", "--rotary", "--travel", "4mm"],
        &["--travel 4mm has a unit of"],
    );
}

/// A minute and a half of a single block at 100 Hz: a table, a recommendation, JSON of the same; with an option that it cannot serve it is bad
/// usage, and a recording that is too short says how long it must be.
#[test]
fn reports_a_predictor_beside_the_friction_models() {
    let folder = Folder::new();
    let mut block = Blocks::new(&[(4000.0, 2.5e-4)]);
    let mut text = "t_s,x_m,friction_N\n".to_owned();
    for i in 0..9000 {
        let turn = std::f64::consts::TAU * f64::from(i) / 400.0;
        let x = 1e-3 * (turn.sin() + 0.4 * (3.1 * turn).sin());
        let (time, force) = (f64::from(i) * 0.01, block.force(x));
        writeln!(text, "{time:.2},{x:e},{force:e}").expect("memory");
    }
    let path = folder.file("block.csv", text);
    let json = folder.path("block.json");
    let run = preslide(&["identify", &path, "--predictor", "koopman", "--json", &json]);
    run.succeeds();
    for part in ["ARX", "Koopman, blocks", "GMS, N = 1", "LuGre", " mN"] {
        assert!(run.out.contains(part), "{part}: {}", run.out);
    }
    let told = std::fs::read_to_string(&json).expect("written");
    let told: serde_json::Value = serde_json::from_str(&told).expect("JSON");
    assert_eq!(told["schema"], "preslide.prediction/1");
    assert_eq!(
        (&told["predicted"], &told["unit"]),
        (&"friction".into(), &"N".into())
    );
    let predictors = told["predictors"].as_array().expect("a list");
    let rms = |name: &str, i: usize| {
        let named = predictors.iter().find(|p| p["name"] == name);
        named
            .and_then(|p| p["rms_N"][i].as_f64())
            .expect("a number")
    };
    // The machine is the model.
    assert!(rms("GMS, N = 1", 3) < 0.2 * rms("ARX", 3));
    let recommended = told["recommended"].as_str().expect("a name");
    assert!(
        predictors
            .iter()
            .any(|p| p["name"] == recommended && !p["delays"].is_null())
    );
    preslide(&["identify", &path, "--predictor", "koopman", "--blocks", "2"])
        .fails(2, &["--predictor", "--blocks"]);
    let short = folder.file("short.csv", recording(HEADER));
    preslide(&["identify", &short, "--predictor", "koopman"])
        .fails(3, &["short.csv", "record at least"]);
}

#[test]
fn an_experiment_is_for_effects_of_the_catalogue() {
    let folder = Folder::new();
    let path = folder.file("good.csv", recording(HEADER));
    let motion = folder.path("motion.csv");
    let ask = |ids| preslide(&["diagnose", &path, "--experiment", &motion, "--asked", ids]);
    ask("foo,run_in,none").fails(2, &["--asked foo:", "--help"]);
    ask("none").succeeds();
}
