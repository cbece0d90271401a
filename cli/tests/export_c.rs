//! `preslide export --lang c`: the C is compiled as a user would, with every warning an error, and run beside the library.

mod whole;

use crate::export::{export, file, linear, packed_f32, plain, rotary, text};
use preslide::{Friction, Motion, Units};
use preslide_fit::friction::Path as MotionPath;
use preslide_fit::model::Model;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const RATE_HZ: &str = "10000";
const STEP: f64 = 1e-4;
const STEPS: usize = 1_000_000;
const WARNINGS: [&str; 6] = [
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wpedantic",
    "-Werror",
];

const SANITIZED: [&str; 3] = [
    "-O1",
    "-fsanitize=address,undefined",
    "-fno-sanitize-recover=all",
];

fn compilers() -> impl Iterator<Item = &'static str> {
    let is_here = |c: &&str| Command::new(c).arg("--version").output().is_ok();
    ["gcc", "clang"].into_iter().filter(is_here)
}

/// Reads rows of displacement, velocity, position, temperature and load, or in whole numbers of the first two, and writes the forces.
const DRIVER: &str = r#"
#include "stage_model.h"
#include <stdio.h>
#ifndef PLACE
#define PLACE(s, x) ((void)(x))
#endif
#ifndef SURROUND
#define SURROUND(s, t, l) ((void)(t), (void)(l))
#endif
#ifdef WHOLE
int main(void)
{
    static stage_model_state state;
    int32_t row[2];
    stage_model_rest(&state);
    while (fread(row, sizeof row, 1, stdin) == 1) {
        const int32_t force = stage_model_step(&state, row[0], row[1]);
        if (fwrite(&force, sizeof force, 1, stdout) != 1) {
            return 1;
        }
    }
    return 0;
}
#else
int main(void)
{
    static stage_model_state state;
    float row[5];
    stage_model_rest(&state);
    while (fread(row, sizeof row, 1, stdin) == 1) {
        float force;
        PLACE(&state, row[2]);
        SURROUND(&state, row[3], row[4]);
        force = stage_model_step(&state, row[0], row[1]);
        if (fwrite(&force, sizeof force, 1, stdout) != 1) {
            return 1;
        }
    }
    return 0;
}
#endif
"#;

/// What a step is given: displacement, velocity, position, temperature and load.
type Row = [f32; 5];

/// A motion with reversals of every size, and surroundings that change.
fn rows(count: usize, scale: f64) -> Vec<Row> {
    let mut last = 0.0;
    let at = |i: usize| {
        let t = i as f64 * STEP;
        let wave = |w: f64, share: f64| {
            (
                scale * share * (w * t).sin(),
                scale * share * w * (w * t).cos(),
            )
        };
        let parts = [wave(0.7, 2.5), wave(13.0, 0.2), wave(171.0, 0.01)];
        parts
            .iter()
            .fold((0.0, 0.0), |sum, p| (sum.0 + p.0, sum.1 + p.1))
    };
    (0..count)
        .map(|i| {
            let (x, v) = at(i);
            let dx = x - last;
            last = x;
            let share = i as f64 / count as f64;
            [
                dx as f32,
                v as f32,
                x as f32,
                (20.0 + 4.0 * share) as f32,
                (32.0 - 4.0 * share) as f32,
            ]
        })
        .collect()
}

/// The exported pair in a folder, with the driver.
fn exported(folder: &Path, model: &Path) -> PathBuf {
    exported_by(folder, model, &[])
}

fn exported_by(folder: &Path, model: &Path, more: &[&str]) -> PathBuf {
    let source = folder.join("stage_model.c");
    let (from, to) = (model.display().to_string(), source.display().to_string());
    let arguments = [from.as_str(), "--lang", "c", "--rate", RATE_HZ, "-o", &to];
    let run = export(&[&arguments[..], more].concat());
    assert!(run.status.success(), "{}", text(&run.stderr));
    std::fs::write(folder.join("main.c"), DRIVER).expect("written");
    source
}

/// Compiles the pair and its driver.
fn compiled(folder: &Path, compiler: &str, flags: &[&str]) -> PathBuf {
    let header = std::fs::read_to_string(folder.join("stage_model.h")).expect("written");
    let program = folder.join(format!("{compiler}_{}", flags.len()));
    let mut command = Command::new(compiler);
    command.args(WARNINGS).args(flags);
    if header.contains("_set_position") {
        command.arg("-DPLACE(s,x)=stage_model_set_position(s,x)");
    }
    if header.contains("_set_load") {
        command
            .arg("-DSURROUND(s,t,l)=(stage_model_set_temperature(s,t),stage_model_set_load(s,l))");
    }
    let files = ["stage_model.c", "main.c"].map(|name| folder.join(name));
    let run = command
        .args(files)
        .arg("-o")
        .arg(&program)
        .arg("-lm")
        .output();
    let run = run.expect("a C compiler, which Rust's linker needs, too");
    assert!(run.status.success(), "{}", text(&run.stderr));
    program
}

fn forces(program: &Path, rows: &[Row]) -> Vec<f32> {
    let forces = run(program, rows.iter().flatten().flat_map(|v| v.to_le_bytes()));
    forces.into_iter().map(f32::from_le_bytes).collect()
}

/// The words that it answers.
fn run(program: &Path, bytes: impl Iterator<Item = u8>) -> Vec<[u8; 4]> {
    let mut child = Command::new(program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it runs");
    let bytes: Vec<u8> = bytes.collect();
    let mut input = child.stdin.take().expect("piped");
    let writer = std::thread::spawn(move || input.write_all(&bytes));
    let run = child.wait_with_output().expect("it ends");
    let written = writer.join().expect("no panic");
    assert!(run.status.success(), "{}", text(&run.stderr));
    written.expect("all is read");
    let words = run.stdout.chunks_exact(4);
    words.map(|b| [b[0], b[1], b[2], b[3]]).collect()
}

/// What the library gives for the same rows.
fn library<F: Friction<Scalar = f32>>(
    model: &F,
    tell: impl Fn(&mut F::State, f32, f32),
    rows: &[Row],
) -> Vec<f64> {
    let mut state = model.at_rest();
    let step = |[dx, v, x, temperature, load]: &Row| {
        model.set_position(&mut state, *x);
        tell(&mut state, *temperature, *load);
        f64::from(model.step(
            &mut state,
            Motion {
                displacement: *dx,
                velocity: *v,
            },
        ))
    };
    rows.iter().map(step).collect()
}

/// Largest difference, RMS and bias.
fn apart(c: &[f32], wanted: &[f64]) -> [f64; 3] {
    assert_eq!(c.len(), wanted.len());
    let n = c.len() as f64;
    let differences = || c.iter().zip(wanted).map(|(c, w)| f64::from(*c) - w);
    let largest = differences().fold(0.0, |most: f64, d| most.max(d.abs()));
    let square: f64 = differences().map(|d| d * d).sum();
    [largest, (square / n).sqrt(), differences().sum::<f64>() / n]
}

fn assert_near(name: &str, c: &[f32], wanted: &[f64], bounds: [f64; 3]) {
    let found = apart(c, wanted);
    eprintln!(
        "{name}: max {:.1e}, RMS {:.1e}, bias {:.1e}",
        found[0], found[1], found[2]
    );
    for (found, bound) in found.iter().zip(bounds) {
        assert!(found.abs() <= bound, "{name}: {found:e} > {bound:e}");
    }
}

#[test]
fn blocks_in_c_have_the_librarys_bits() {
    let folder = tempfile::tempdir().expect("temporary folder");
    exported(folder.path(), &file("plain.toml"));
    let rows = rows(STEPS, 1e-3);
    let model = plain::model::<f32>(STEP, Units::SI).expect("valid");
    let wanted = library(&model, |_, _, _| (), &rows);
    let c = forces(&compiled(folder.path(), "cc", &["-O2"]), &rows);
    assert_eq!(apart(&c, &wanted), [0.0; 3]);
}

/// Marsaglia's generator of 32 bits, from a fixed seed.
fn xorshift() -> impl FnMut() -> u32 {
    let mut random = 0x1727_2018_u32;
    move || {
        random ^= random << 13;
        random ^= random >> 17;
        random ^= random << 5;
        random
    }
}

/// Rows that are taken through the ends of what the kernel holds, too: displacements of every size, of both signs.
fn any_rows() -> Vec<Row> {
    let mut next = xorshift();
    let row = |_| {
        let size = 10_f32.powi((next() % 9) as i32 - 12);
        let dx = size * (next() as i32 as f32 / 2_147_483_648.0);
        let dx = if next().is_multiple_of(5) { 0.0 } else { dx };
        let dx = if next().is_multiple_of(1000) {
            1e9 * dx
        } else {
            dx
        };
        [dx, 0.0, 0.0, 0.0, 0.0]
    };
    (0..STEPS).map(row).collect()
}

#[test]
fn the_packed_kernel_in_c_has_the_librarys_bits() {
    let folder = tempfile::tempdir().expect("temporary folder");
    exported_by(
        folder.path(),
        &file("packed.toml"),
        &["--kernel", "packed_f32"],
    );
    let model = packed_f32::model::<f32>(STEP, Units::SI).expect("valid");
    for rows in [any_rows(), rows(STEPS, 1e-4)] {
        let wanted = library(&model, |_, _, _| (), &rows);
        assert!(wanted.iter().any(|f| f.abs() > 0.8) && wanted.iter().any(|f| f.abs() < 0.1));
        let c = forces(&compiled(folder.path(), "cc", &["-O2"]), &rows);
        assert_eq!(apart(&c, &wanted), [0.0; 3]);
    }
}

/// `firmware/cycles` counts what is exported; run with `BLESS=1` to write it anew after a change.
#[test]
fn the_c_whose_cycles_are_counted_is_what_export_writes() {
    let counted = Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware/cycles/peers/exported");
    for (model, name, more) in [
        ("full", "gms_f32", &[][..]),
        ("blocks", "quasi_static_f32", &[]),
        ("blocks", "packed_f32", &["--kernel", "packed_f32"]),
        (
            "full",
            "count_gms_i16f16",
            &["--kernel", "count_gms_i16f16", "--count", "25e-9"],
        ),
        (
            "blocks",
            "packed_i16f16",
            &["--kernel", "packed_i16f16", "--count", "25e-9"],
        ),
        (
            "blocks",
            "slip_reserve_i16f16",
            &["--kernel", "slip_reserve_i16f16", "--count", "25e-9"],
        ),
    ] {
        let folder = tempfile::tempdir().expect("temporary folder");
        let written = folder
            .path()
            .join(format!("{name}.c"))
            .display()
            .to_string();
        let model = counted.join(format!("{model}.toml")).display().to_string();
        let arguments = [&model, "--lang", "c", "--rate", "20000", "-o", &written];
        let run = export(&[&arguments[..], more].concat());
        assert!(run.status.success(), "{}", text(&run.stderr));
        for file in [format!("{name}.c"), format!("{name}.h")] {
            let source = std::fs::read_to_string(folder.path().join(&file)).expect("written");
            crate::export::assert_kept(&counted.join(file), &source);
        }
    }
}

/// The library has Stribeck curves and spots as tables, and waves as polynomials; C has them from `math.h`.
#[test]
fn every_effect_in_c_gives_the_librarys_force() {
    let folder = tempfile::tempdir().expect("temporary folder");
    exported(folder.path(), &file("linear.toml"));
    let rows = rows(STEPS, 1e-3);
    let model = linear::model::<f32>(STEP, Units::SI).expect("valid");
    let told = |s: &mut <linear::Model as Friction>::State, t: f32, l: f32| {
        (s.temperature, s.load) = (Some(t), Some(l));
    };
    let wanted = library(&model, told, &rows);
    let c = forces(&compiled(folder.path(), "cc", &["-O2"]), &rows);
    // Forces reach 1.6 N.
    assert_near("linear", &c, &wanted, [2e-3, 3e-4, 1e-4]);
    let folder = tempfile::tempdir().expect("temporary folder");
    exported(folder.path(), &file("rotary.toml"));
    let rows = self::rows(STEPS, 0.3);
    let model = rotary::model::<f32>(STEP, Units::SI).expect("valid");
    let wanted = library(&model, |_, _, _| (), &rows);
    let c = forces(&compiled(folder.path(), "cc", &["-O2"]), &rows);
    assert_near("rotary", &c, &wanted, [1e-6, 1e-7, 1e-8]);
}

/// Against the host, in double precision.
#[test]
fn laws_in_c_give_the_hosts_force() {
    let sliding = "coulomb_N = 0.7\nstribeck_velocity_m_s = 0.002\nstribeck_exponent = 1.5";
    let block = "blocks = [{ stiffness_N_per_m = 1e5, weight = 0.6 }, { stiffness_N_per_m = 2e4, weight = 0.4 }]";
    for (name, friction) in [
        ("coulomb", "kind = \"coulomb\"\ncoulomb_N = 0.9".to_owned()),
        (
            "dahl",
            "kind = \"dahl\"\nstiffness_N_per_m = 1e5\ncoulomb_N = 0.9\nexponent = 1.0".to_owned(),
        ),
        (
            "dahl_1_5",
            "kind = \"dahl\"\nstiffness_N_per_m = 1e5\ncoulomb_N = 0.9\nexponent = 1.5".to_owned(),
        ),
        (
            "lugre",
            format!(
                "kind = \"lugre\"\nstiffness_N_per_m = 1e5\ndamping_N_s_per_m = 3.0\nbreakaway_N = 0.9\nattraction_N_per_s = inf\n{sliding}"
            ),
        ),
        (
            "gms",
            format!(
                "kind = \"gms\"\nbreakaway_N = 0.9\nattraction_N_per_s = 20.0\n{sliding}\n{block}"
            ),
        ),
        (
            "gms_at_once",
            format!(
                "kind = \"gms\"\nbreakaway_N = 0.9\nattraction_N_per_s = inf\n{sliding}\n{block}"
            ),
        ),
    ] {
        let folder = tempfile::tempdir().expect("temporary folder");
        let toml = folder.path().join("model.toml");
        let head = "schema = \"preslide.model/1\"\nmotion = \"linear\"\n[friction]\nviscous_N_s_per_m = 0.0\n";
        std::fs::write(&toml, format!("{head}{friction}\n")).expect("written");
        exported(folder.path(), &toml);
        let rows = rows(STEPS / 5, 1e-3);
        let mut x = 0.0;
        let position: Vec<f64> = rows
            .iter()
            .map(|row| {
                x += f64::from(row[0]);
                x
            })
            .collect();
        let velocity: Vec<f64> = rows.iter().map(|row| f64::from(row[1])).collect();
        let whole = 0..rows.len();
        let path = MotionPath {
            position: &position,
            velocity: &velocity,
            pieces: std::slice::from_ref(&whole),
            sample_time: STEP,
        };
        let wanted = Model::load(&toml)
            .expect("valid")
            .resistance(path)
            .expect("a force");
        let c = forces(&compiled(folder.path(), "cc", &["-O2"]), &rows);
        assert_near(name, &c, &wanted, [2e-3, 2e-4, 1e-4]);
    }
}

/// NaN and infinity at every input in turn, under the sanitizers, by every compiler that is here: nothing is undefined, nothing leaves the
/// bounds, and the model recovers.
#[test]
fn bad_input_is_bounded_and_nothing_is_undefined() {
    let mut rows = rows(STEPS / 20, 1e-3);
    let calm = rows.clone();
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX];
    for (i, row) in rows.iter_mut().enumerate().take(40_000).skip(1000) {
        if i % 7 == 0 {
            row[i % 5] = bad[i % 4];
        }
    }
    for compiler in compilers() {
        for name in ["plain", "linear", "rotary", "packed"] {
            let folder = tempfile::tempdir().expect("temporary folder");
            let kernel = ["--kernel", "packed_f32"];
            let more: &[&str] = if name == "packed" { &kernel } else { &[] };
            exported_by(folder.path(), &file(&format!("{name}.toml")), more);
            let program = compiled(folder.path(), compiler, &SANITIZED);
            let c = forces(&program, &rows);
            assert!(c.iter().all(|f| f.abs() < 60.0), "{compiler} {name}");
            let after = forces(&program, &calm);
            let off = c
                .iter()
                .zip(&after)
                .skip(45_000)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f32::max);
            eprintln!("{compiler}, {name}: {off:.1e} apart after bad input");
            assert!(off < 2e-2, "{compiler} {name}: {off}");
        }
    }
}

/// As the help has it: what was assumed of the controller is said.
#[test]
fn a_kernel_that_needs_a_rate_is_for_20_khz() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let run = Command::new(env!("CARGO_BIN_EXE_preslide"))
        .current_dir(folder.path())
        .args(["export", &file("full.toml").display().to_string()])
        .args([
            "--lang",
            "c",
            "--kernel",
            "count_gms_i16f16",
            "-o",
            "stage_model.c",
        ])
        .args(["--count", "25e-9", "--without", "periodic_force"])
        .output()
        .expect("the binary runs");
    assert!(run.status.success() && text(&run.stderr).contains("20 kHz"));
    let header = std::fs::read_to_string(folder.path().join("stage_model.h")).expect("written");
    assert!(header.contains("RATE_HZ 20000"), "{header}");
}

#[test]
fn what_c_needs_and_lacks_is_said() {
    let model = |name: &str| file(&format!("{name}.toml")).display().to_string();
    // What is written by mistake is not written beside the sources.
    let folder = tempfile::tempdir().expect("temporary folder");
    let refused = |arguments: &[&str]| {
        let run = Command::new(env!("CARGO_BIN_EXE_preslide"))
            .current_dir(folder.path())
            .arg("export")
            .args(arguments)
            .output()
            .expect("the binary runs");
        assert_eq!(run.status.code(), Some(2), "{arguments:?}");
        text(&run.stderr)
    };
    let error = refused(&[&model("linear"), "--lang", "c", "-o", "stage_model.c"]);
    assert!(
        error.contains("--rate") && error.contains("frictional_lag"),
        "{error}"
    );
    let error = refused(&[&model("plain"), "--lang", "c"]);
    assert!(error.contains("-o stage_model.c"), "{error}");
    let error = refused(&[&model("plain"), "--lang", "c", "-o", "Stage Model.c"]);
    assert!(error.contains("small letters"), "{error}");
    let error = refused(&[&model("leuven"), "--lang", "c", "-o", "stage_model.c"]);
    assert!(
        error.contains("leuven") && error.contains("without --lang"),
        "{error}"
    );
    let whole = |name: &str, kernel: &str, more: &[&str]| {
        let model = model(name);
        let own = [
            &model,
            "--lang",
            "c",
            "-o",
            "stage_model.c",
            "--kernel",
            kernel,
        ];
        refused(&[&own[..], more].concat())
    };
    let error = whole("linear", "count_gms_i16f16", &["--count", "1e-7"]);
    assert!(
        error.contains("--without frictional_lag") && error.contains("gms_f32"),
        "{error}"
    );
    let error = whole("plain", "slip_reserve_i16f16", &[]);
    assert!(error.contains("--count"), "{error}");
    let error = whole("plain", "slip_reserve_i16f16", &["--count", "1e4"]);
    assert!(error.contains("give its unit"), "{error}");
    let plain = std::fs::read_to_string(model("plain")).expect("readable");
    let soft = plain
        .replace("113948.0", "113.948")
        .replace("8870.0", "8.87");
    std::fs::write(folder.path().join("soft.toml"), soft).expect("written");
    let mut own = vec!["soft.toml", "--lang", "c", "-o", "stage_model.c"];
    own.extend(["--kernel", "packed_i16f16", "--count", "25e-9"]);
    let error = refused(&own);
    assert!(error.contains("yield displacement of block 1"), "{error}");
    let error = refused(&[&model("plain"), "--rate", "1000"]);
    assert!(error.contains("--lang c"), "{error}");
}

/// The places to call it from, against the names that they take of their frameworks.
#[test]
fn the_examples_compile_against_their_frameworks_names() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let whole = ["--kernel", "slip_reserve_i16f16", "--count", "1e-7"];
    for (model, name, more) in [
        ("plain", "stage_model", &[][..]),
        ("plain", "counts_model", &whole),
        ("rotary", "joint_model", &[]),
    ] {
        let source = folder
            .path()
            .join(format!("{name}.c"))
            .display()
            .to_string();
        let model = file(&format!("{model}.toml")).display().to_string();
        let own = [&model, "--lang", "c", "--rate", RATE_HZ, "-o", &source];
        let run = export(&[&own[..], more].concat());
        assert!(run.status.success(), "{}", text(&run.stderr));
    }
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/c");
    for name in [
        "linuxcnc.c",
        "stm32.c",
        "stm32_counts.c",
        "simplefoc.cpp",
        "ros2_control.cpp",
    ] {
        let is_cpp = name.ends_with("cpp");
        let (compiler, standard) = if is_cpp {
            ("c++", "-std=c++17")
        } else {
            ("cc", "-std=c99")
        };
        let run = Command::new(compiler)
            .args(&WARNINGS[1..])
            .args([standard, "-c", "-o", "/dev/null", "-I"])
            .arg(folder.path())
            .arg("-I")
            .arg(examples.join("interfaces"))
            .arg(examples.join(name))
            .output();
        let run = run.unwrap_or_else(|e| panic!("{compiler}: {e}; on Debian: apt install g++"));
        assert!(run.status.success(), "{name}: {}", text(&run.stderr));
    }
}
