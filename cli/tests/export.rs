//! Exported source: it is what is compiled here, and its model gives the force that the host computes.
//!
//! `exported/*.rs` are written by `preslide export`; run with `BLESS=1` to write them anew after a change.

use super::binary::{Folder, MODEL, preslide};
use preslide::{Friction, Motion, Scalar, Units};
use preslide_fit::effects::{Effect, form};
use preslide_fit::friction::Path as MotionPath;
use preslide_fit::model::{Measured, Model};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

pub mod linear {
    include!("exported/linear.rs");
}
pub mod rotary {
    include!("exported/rotary.rs");
}
pub mod plain {
    include!("exported/plain.rs");
}
mod bouc_wen {
    include!("exported/bouc_wen.rs");
}
mod elasto_plastic {
    include!("exported/elasto_plastic.rs");
}
mod leuven {
    include!("exported/leuven.rs");
}
mod two_state {
    include!("exported/two_state.rs");
}
pub mod packed_f32 {
    include!("exported/packed_f32.rs");
}
pub mod packed_i16f16 {
    include!("exported/packed_i16f16.rs");
}
pub mod full {
    include!("exported/full.rs");
}

pub fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/exported")
        .join(name)
}

pub fn export(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_preslide"))
        .arg("export")
        .args(arguments)
        .output()
        .expect("the binary runs")
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A committed file is what export writes; with `BLESS=1` it is made so.
pub fn assert_kept(golden: &Path, source: &str) {
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(golden, source).expect("blessed");
    }
    let kept = std::fs::read_to_string(golden).unwrap_or_default();
    assert!(
        kept == source,
        "{} is not what export writes; look at the difference, then BLESS=1",
        golden.display()
    );
}

/// The model whose source is compiled here has every effect that a controller can use; with `BLESS=1` it is given what it lacks.
fn keep_every_effect() {
    let path = file("linear.toml");
    let mut model = Model::load(&path).expect("valid");
    // Gravity is a rotary axis's.
    let elsewhere = [&form::CONSTANT_FORCE, &form::GRAVITY];
    let of_controllers = form::ALL.into_iter().filter(|f| f.controller.is_ok());
    for form in of_controllers.filter(|form| !elsewhere.contains(form)) {
        if !model.effects.iter().any(|effect| effect.is(form)) {
            model.effects.push(Effect::of(form, form.example));
        }
    }
    assert_kept(
        &path,
        &model.to_toml(&["identified from a test".to_owned()]),
    );
}

#[test]
fn the_source_that_is_compiled_here_is_what_export_writes() {
    keep_every_effect();
    let folder = tempfile::tempdir().expect("temporary folder");
    for (model, name, more) in [
        ("linear", "linear", &[][..]),
        ("rotary", "rotary", &[]),
        ("plain", "plain", &[]),
        ("bouc_wen", "bouc_wen", &[]),
        ("elasto_plastic", "elasto_plastic", &[]),
        ("leuven", "leuven", &[]),
        ("two_state", "two_state", &[]),
        ("packed", "packed_f32", &["--kernel", "packed_f32"]),
        ("packed", "packed_i16f16", &["--kernel", "packed_i16f16"]),
        ("full", "full", &["--kernel", "count_gms_i16f16"]),
        ("packed", "../../../firmware/app/src/starting", &[]),
    ] {
        let written = folder.path().join("out.rs");
        let model = file(&format!("{model}.toml")).display().to_string();
        let written_to = written.display().to_string();
        let run = export(&[&[model.as_str(), "-o", &written_to][..], more].concat());
        assert!(run.status.success(), "{}", text(&run.stderr));
        let source = std::fs::read_to_string(&written).expect("written");
        assert_kept(&file(&format!("{name}.rs")), &source);
    }
}

/// The terminal and the file list what a joint cannot hold; a recording judges what is left.
#[test]
fn a_simulators_joint_says_what_it_cannot_hold() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let written = folder.path().join("joint.xml").display().to_string();
    let recording = folder.path().join("axis.csv");
    let mut rows = "t_s,x_m,force_N\n".to_owned();
    for i in 0..4000 {
        let (t, w) = (f64::from(i) * 1e-3, 5.0_f64);
        let (x, v, a) = ((w * t).sin(), w * (w * t).cos(), -w * w * (w * t).sin());
        let force = 0.5 * 0.01 * a + 2.0 * v.signum() + 30.0 * 0.01 * v;
        rows += &format!("{t},{},{force}\n", 0.01 * x);
    }
    std::fs::write(&recording, rows).expect("written");
    let model = folder.path().join("gms.toml");
    let kept = "schema = \"preslide.model/1\"\nmotion = \"linear\"\ninertia = { mass_kg = 0.5 }\n\
        friction = { kind = \"gms\", breakaway_N = 2.0, viscous_N_s_per_m = 30.0, blocks = [{ stiffness_N_per_m = 1e5, weight = 1.0 }] }\n\
        [[effects]]\nid = \"backlash\"\ngap_m = 1e-5\n";
    std::fs::write(&model, kept).expect("written");
    let (model, recording) = (model.display().to_string(), recording.display().to_string());
    let run = export(&[&model, "--mjcf", "--recording", &recording, "-o", &written]);
    let told = text(&run.stderr);
    assert!(run.status.success(), "{told}");
    let file = std::fs::read_to_string(&written).expect("written");
    for (id, part) in [
        ("pre-sliding", "GMS, N = 1"),
        ("backlash", "nothing for it"),
    ] {
        let said = |text: &str, head: &str| {
            text.lines()
                .any(|line| line.contains(head) && line.contains(id) && line.contains(part))
        };
        assert!(said(&told, "Not in the joint: "), "{id}: {told}");
        assert!(said(&file, "<!-- Not in it: "), "{id}: {file}");
    }
    assert!(file.contains("frictionloss=\"2\"") && file.contains("damping=\"30\""));
    // Of the joint, which has no play: the recording is made of nothing but what it holds.
    let error = file.split_once("NMSE ").expect("an error").1;
    let nmse: f64 = error[..error.find(' ').expect("a number")]
        .parse()
        .expect("a number");
    assert!(nmse < 1.0, "{nmse} %: {file}");
    let both = export(&[&model, "--mjcf", "--urdf"]);
    assert!(!both.status.success() && text(&both.stderr).contains("cannot be used with"));
}

const STEP: f64 = 1e-4;

/// Position (m or rad) and velocity of `samples` samples, about 4 `scale` long, with small loops in it.
fn motion(samples: usize, scale: f64) -> (Vec<f64>, Vec<f64>) {
    (0..samples)
        .map(|i| {
            let t = i as f64 * STEP;
            let of = |w: f64, share: f64| {
                (
                    scale * share * (w * t).sin(),
                    scale * share * w * (w * t).cos(),
                )
            };
            let (slow, fast) = (of(3.0, 3.0), of(70.0, 0.02));
            (slow.0 + fast.0, slow.1 + fast.1)
        })
        .unzip()
}

/// Largest difference between an exported model, run as the control task does, and the host's force for the file.
fn difference<F: Friction>(
    name: &str,
    model: F,
    tell: impl Fn(&mut F::State, f64, f64),
    scale: f64,
) -> f64 {
    let host = Model::load(&file(&format!("{name}.toml"))).expect("valid");
    let (position, velocity) = motion(20_000, scale);
    let temperature: Vec<f64> = (0..20_000).map(|i| 20.0 + f64::from(i) * 2e-4).collect();
    let load: Vec<f64> = (0..20_000).map(|i| 32.0 - f64::from(i) * 2e-4).collect();
    let path = MotionPath {
        position: &position,
        velocity: &velocity,
        pieces: std::slice::from_ref(&(0..20_000)),
        sample_time: STEP,
    };
    let measured = Measured {
        temperature_c: Some(&temperature),
        load_n: Some(&load),
        ..Measured::default()
    };
    let wanted = host
        .force_along(path, &measured)
        .expect("all that effects need");
    let scalar = |value: f64| F::Scalar::try_from_f64(value).expect("in range");
    let mut state = model.at_rest();
    let mut last = position[0];
    let mut largest = 0.0_f64;
    for i in 0..position.len() {
        model.set_position(&mut state, scalar(position[i]));
        tell(&mut state, temperature[i], load[i]);
        let motion = Motion {
            displacement: scalar(position[i] - last),
            velocity: scalar(velocity[i]),
        };
        last = position[i];
        let force = model.step(&mut state, motion).to_f64();
        largest = largest.max((force - wanted[i]).abs());
    }
    largest
}

#[test]
fn the_models_without_a_kernel_are_exported_too() {
    macro_rules! check {
        ($($kind:ident)*) => {
            $(
                let model = $kind::model::<f64>(STEP, Units::SI).expect("valid");
                assert_eq!(difference(stringify!($kind), model, |_, _, _| (), 1e-5), 0.0);
            )*
        };
    }
    check!(bouc_wen elasto_plastic leuven two_state);
}

#[test]
fn an_exported_model_gives_the_hosts_force() {
    let linear = linear::model::<f64>(STEP, Units::SI).expect("valid");
    let off = difference(
        "linear",
        linear,
        |s, t, l| (s.temperature, s.load) = (Some(t), Some(l)),
        1e-3,
    );
    eprintln!("linear in f64: {off:.1e} N");
    // The host corrects the velocity for the encoder's error as well: 2πe/p = 6 %, in the viscous force and the levels.
    assert!(off < 1e-2, "{off:e}");
    let single = linear::model::<f32>(STEP, Units::SI).expect("valid");
    let off = difference(
        "linear",
        single,
        |s, t, l| (s.temperature, s.load) = (Some(t as f32), Some(l as f32)),
        1e-3,
    );
    eprintln!("linear in f32: {off:.1e} N");
    assert!(off < 1e-2, "{off:e}");
    let rotary = rotary::model::<f64>(STEP, Units::SI).expect("valid");
    let off = difference("rotary", rotary, |_, _, _| (), 0.3);
    assert!(off < 1e-12, "{off:e}");
    let plain = plain::model::<f64>(STEP, Units::SI).expect("valid");
    let off = difference("plain", plain, |_, _, _| (), 1e-3);
    assert!(off < 1e-12, "{off:e}");
    const { assert!(linear::MASS_KG == 3.9) };
    let limit = linear::model::<f32>(STEP, Units::SI)
        .expect("valid")
        .limit();
    assert!(limit.is_some_and(|l| l < 60.0), "{limit:?}");
}

/// What a kernel is asked for and cannot do is refused with what to take.
/// What is said beside the source is of the file that was named, and of a rate that was taken only where time plays a part.
#[test]
fn what_is_said_beside_the_source_is_of_it() {
    let folder = Folder::new();
    let model = folder.file("model.toml", MODEL);
    let out = folder.path("stage.c");
    let rust = ["export", &model, "-o", "-"];
    let said = preslide(&rust).succeeds().err.clone();
    assert!(
        said.contains("Declare a file of the firmware as a module"),
        "{said}"
    );
    let kernel = |name: &str| {
        let c = [
            "export", &model, "--lang", "c", "-o", &out, "--kernel", name,
        ];
        let count = ["--count", "25nm"];
        preslide(&[&c[..], &count].concat()).succeeds().err.clone()
    };
    assert!(!kernel("slip_reserve_i16f16").contains("kHz"));
    assert!(kernel("count_gms_i16f16").contains("stage_step is for 20 kHz; --rate gives another"));
}

#[test]
fn a_kernel_that_does_not_fit_is_refused_with_what_to_take() {
    let [linear, packed, dahl] = ["linear", "packed", "bouc_wen"]
        .map(|name| file(&format!("{name}.toml")).display().to_string());
    for (model, kernel, said) in [
        (&packed, "packed", "packed_i16f16"),
        (&linear, "packed_f32", "gms_f32"),
        (&dahl, "packed_f32", "leave --kernel out"),
        (&linear, "auto", "--count"),
    ] {
        let run = export(&[model.as_str(), "--kernel", kernel]);
        let error = text(&run.stderr);
        assert_eq!(run.status.code(), Some(2), "{kernel}: {error}");
        assert!(error.contains("--kernel") || kernel == "auto", "{error}");
        assert!(error.contains(said), "{kernel}: {error}");
    }
}

/// The kernel's force beside the host's, which is in `f64` and knows no counts: half a unit of length is 1/16 384 of the softest block's
/// yield displacement (39 µm), 1.2 nm, times 0.37 N/µm of all blocks; roundings of `D` and `k` add as much.
#[test]
fn an_exported_kernel_gives_the_hosts_force() {
    let packed = packed_f32::model::<f32>(STEP, Units::SI).expect("valid");
    let off = difference("packed", packed, |_, _, _| (), 1e-4);
    assert!(off < 1.5e-3, "{off:e} N");
    let counts = Units {
        length: 25e-9,
        force: 1e-3,
        velocity: 1e-3,
    };
    let fixed: packed_i16f16::Model = packed_i16f16::model(STEP, counts).expect("valid");
    assert!(
        fixed
            .limit()
            .is_some_and(|l| (899.0..900.5).contains(&l.to_f64()))
    );
    // The full law is given a whole unit ahead, with effects around it.
    let full = full::model::<f32>(STEP, Units::SI).expect("valid");
    let off = difference("full", full, |_, _, _| (), 1e-3);
    assert!(off < 5e-3, "{off:e} N");
}

#[test]
fn what_no_controller_can_use_is_refused_by_name() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let with = |id: &str, values: &str| {
        let path = folder.path().join("model.toml");
        let plain = std::fs::read_to_string(file("plain.toml")).expect("there");
        std::fs::write(
            &path,
            format!("{plain}\n[[effects]]\nid = \"{id}\"\n{values}\n"),
        )
        .expect("written");
        path.display().to_string()
    };
    for (id, values) in [
        ("channel_delay", "delay_s = 1e-3"),
        ("drive_compliance", "frequency_Hz = 60.0"),
        ("backlash", "gap_m = 1e-6"),
        ("creep", "rate_m_s = 1e-8\nshare_of_breakaway = 0.15"),
        (
            "torque_ripple",
            "share = 0.05\nperiod_m = 1e-3\nphase_rad = 0.0",
        ),
        ("actuator_dead_zone", "width_N = 0.1"),
        ("actuator_saturation", "limit_N = 2.0"),
        (
            "external_vibration",
            "force_N = 0.1\nfrequency_Hz = 20.0\nphase_rad = 0.0",
        ),
        ("run_in", "level = 0.1\npath_m = 10.0"),
    ] {
        let path = with(id, values);
        let refused = export(&[&path]);
        assert_eq!(refused.status.code(), Some(2), "{id}");
        let error = text(&refused.stderr);
        assert!(
            error.contains("model.toml") && error.contains(&format!("--without {id}")),
            "{error}"
        );
        let rest = export(&[&path, "--without", id]);
        assert!(rest.status.success(), "{}", text(&rest.stderr));
        assert!(text(&rest.stdout).contains(&format!("Left out by request: {id}")));
    }
    let path = with("run_in", "level = 0.1\npath_m = 10.0");
    let wrong = text(&export(&[&path, "--without", "stribeck"]).stderr);
    assert!(
        wrong.contains("--without stribeck") && wrong.contains("it has run_in"),
        "{wrong}"
    );
}

/// The recording is named by its hash, and the error is that of the exported model.
#[test]
fn a_recording_is_named_by_its_hash_and_error() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let host = Model::load(&file("plain.toml")).expect("valid");
    let (position, velocity) = motion(20_000, 1e-3);
    let path = MotionPath {
        position: &position,
        velocity: &velocity,
        pieces: std::slice::from_ref(&(0..20_000)),
        sample_time: STEP,
    };
    let force = host.resistance(path).expect("valid");
    let mut csv = "t_s,x_m,friction_N\n".to_owned();
    for (i, (x, f)) in position.iter().zip(&force).enumerate() {
        csv += &format!("{:.4},{x:e},{f:e}\n", i as f64 * STEP);
    }
    let recording = folder.path().join("axis.csv");
    std::fs::write(&recording, &csv).expect("written");
    let run = export(&[
        &file("plain.toml").display().to_string(),
        "--recording",
        &recording.display().to_string(),
    ]);
    assert!(run.status.success(), "{}", text(&run.stderr));
    let hash = preslide_host::export::sha256(csv.as_bytes());
    let source = text(&run.stdout);
    assert!(
        source.contains(&format!(
            "Recording axis.csv, SHA-256 {hash}: NMSE 0.0000 %"
        )),
        "{source}"
    );
}

/// Terms that reach ten breakaway forces on a recording are not cut there, and the command that is proposed knows that recording.
#[test]
fn the_bound_is_that_of_the_recording_and_what_it_cuts_is_said() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let mut csv = "time,x_m,f\n".to_owned();
    for i in 0..4000 {
        let (t, w) = (f64::from(i) * 1e-3, 5.0_f64);
        let x = 0.01 * (w * t).sin();
        let force = 2000.0 * x + 0.9 * (w * t).cos().signum();
        csv += &format!("{t},{x:e},{force}\n");
    }
    let plain = std::fs::read_to_string(file("plain.toml")).expect("readable");
    let spring =
        "[[effects]]\nid = \"position_spring\"\nstiffness_N_per_m = 2000.0\ncentre_m = 0.0\n";
    let (model, recording, json) = (path("model.toml"), path("an axis.csv"), path("out.json"));
    std::fs::write(&model, plain + "\n" + spring).expect("written");
    std::fs::write(&recording, csv).expect("written");
    let read = [
        "--recording",
        &recording,
        "--map",
        "t_s=time",
        "--map",
        "force_N=f",
    ];
    let of = |more: &[&str], code: i32| {
        let run = export(&[&[model.as_str(), "--json", &json], more].concat());
        assert_eq!(run.status.code(), Some(code), "{}", text(&run.stderr));
        (text(&run.stdout), text(&run.stderr))
    };
    let answer = || {
        let answer = std::fs::read_to_string(&json).expect("written");
        serde_json::from_str::<serde_json::Value>(&answer).expect("JSON")["bounds"][0].clone()
    };
    let (source, said) = of(&[], 0);
    let cut = "position_spring beyond ±4.50 mm of its centre; --limit";
    assert!(
        source.contains(cut) && said.contains(cut),
        "{said}\n{source}"
    );
    assert_eq!(answer()["from"], "default");
    assert!((answer()["cuts"][0]["beyond_m"].as_f64().expect("a number") - 4.5e-3).abs() < 1e-9);
    let (source, _) = of(&read, 0);
    assert_eq!(answer()["from"], "recording");
    assert!((answer()["limit_N"].as_f64().expect("a number") - 40.0).abs() < 0.1);
    assert!(
        source.contains("Force bound 40.0 N (twice the largest on the recordings)"),
        "{source}"
    );
    let (_, refused) = of(&[&read[..], &["--limit", "5"]].concat(), 2);
    assert!(
        refused.contains("position_spring reaches 20.0 N") && refused.contains("--limit 20 "),
        "{refused}"
    );
    // As `diagnose` and `identify` read it.
    let next = Command::new(env!("CARGO_BIN_EXE_preslide"))
        .args([
            "simulate", &model, "--motion", &recording, "--map", "t_s=time", "--ignore", "f",
        ])
        .output()
        .expect("the binary runs");
    let next = text(&next.stdout);
    assert!(
        next.contains(&format!(
            "--recording '{recording}' --map t_s=time --ignore f -o stage_model.rs"
        )),
        "{next}"
    );
}

/// The names and comments of a model of currents are in A, on either kind of axis and in either language.
#[test]
fn a_model_in_amperes_has_no_newtons() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let plain = std::fs::read_to_string(file("plain.toml")).expect("readable");
    let plain = plain.replacen(
        "[friction]",
        "effort_unit = \"A\"\n[inertia]\nmass_kg = 2.0\n[friction]",
        1,
    );
    let linear = plain.replace("viscous_N_s_per_m = 0.0", "viscous_N_s_per_m = 3.0");
    let rotary = linear
        .replace("linear", "rotary")
        .replace("mass_kg", "inertia_kg_m2");
    let rotary = rotary
        .replace("_N_per_m", "_Nm_per_rad")
        .replace("_N_s_per_m", "_Nm_s_per_rad");
    let rotary = rotary.replace("breakaway_N ", "breakaway_Nm ");
    let units = ["_N_", "_NM_", "_KG", "(N)", "(N or", "(N,", "N m"];
    for (name, model, inertia) in [
        ("linear", linear, "MASS_A_S2_PER_M"),
        ("rotary", rotary, "INERTIA_A_S2_PER_RAD"),
    ] {
        let file = path(&format!("{name}.toml"));
        std::fs::write(&file, model).expect("written");
        let c = path(&format!("{name}.c"));
        let whole = ["--kernel", "slip_reserve_i16f16", "--count", "1e-7"];
        for more in [
            &[][..],
            &["--lang", "c", "-o", &c],
            &[&["--lang", "c", "-o", &c][..], &whole].concat(),
        ] {
            let run = export(&[&[file.as_str()][..], more].concat());
            assert!(run.status.success(), "{}", text(&run.stderr));
            let source = match more.is_empty() {
                true => text(&run.stdout),
                false => [&c, &path(&format!("{name}.h"))]
                    .map(|file| std::fs::read_to_string(file).expect("written"))
                    .concat(),
            };
            assert!(source.contains(inertia), "{source}");
            for line in source.lines() {
                // Keys of the model file are in backticks.
                let own: String = line.split('`').step_by(2).collect();
                assert!(!units.iter().any(|unit| own.contains(unit)), "{line}");
            }
        }
    }
}
