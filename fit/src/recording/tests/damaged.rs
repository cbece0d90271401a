//! Files of every kind that is read, damaged at random: refused by name, or loaded soundly and with a word where samples are gone.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::model::Model;
use crate::recording::mat;
use crate::simulate::closed::Controller;

/// What is damaged.
enum Kind {
    Text,
    Matlab,
    Numpy,
    Model,
    Controller,
}

const MODEL: &str = r#"schema = "preslide.model/1"
motion = "linear"
inertia = { mass_kg = 3.5 }
[friction]
kind = "gms"
breakaway_N = 2.0
coulomb_N = 1.5
stribeck_velocity_m_s = 1e-3
viscous_N_s_per_m = 30.0
blocks = [{ stiffness_N_per_m = 1e5, weight = 0.6 }, { stiffness_N_per_m = 1e4, weight = 0.4 }]
[[effects]]
id = "periodic_force"
force_N = 0.1
period_m = 2e-3
phase_rad = 0.3
"#;

const CONTROLLER: &str = r#"schema = "preslide.controller/1"
rate_Hz = 2000.0
proportional_N_per_m = 1e4
integral_N_per_m_s = 1e5
derivative_N_s_per_m = 100.0
limit_N = 20.0
"#;

/// Whole files, with what else there is to be told to read them.
fn whole() -> Vec<(Kind, Vec<u8>, LoadOptions)> {
    let rows = || {
        (0..60).map(|i| {
            let t = f64::from(i) * 0.01;
            (t, (7.0 * t).sin(), (7.0 * t).cos())
        })
    };
    let lines = |head: &str, line: &dyn Fn(f64, f64, f64) -> String| {
        let lines: String = rows().map(|(t, x, f)| line(t, x, f)).collect();
        format!("{head}{lines}")
    };
    let comma = |number: f64| format!("{number:.5}").replace('.', ",");
    let german = lines(
        "Messung;Achse 3\n\nZeit [ms];Istposition [mm];Istkraft [N]\n",
        &|t, x, f| format!("{};{};{}\n", comma(1e3 * t), comma(x), comma(f)),
    );
    let stamped = lines(
        "\"time\",\"pos (mm)\",\"force_N\",\"segment\"\n",
        &|t, x, f| format!("2025-11-09T09:27:{:06.3}Z,{x:.5},{f:.5},0\n", 3.0 + t),
    );
    let labelled = lines("", &|t, x, f| {
        format!("t_s:{t:.3} x_m:{x:.5} force_N:{f:.5}\n")
    });
    let json = lines("", &|t, x, f| {
        format!("{{\"t_s\":{t},\"x_m\":{x},\"force_N\":{f}}}\n")
    });
    let scope = lines(
        "Name;Achse\nStarttime of export;133500000000000000\n\nName;x_m;force_N\nSampleTime[ms];10;10\n\n",
        &|t, x, f| format!("{};{};{}\n", comma(1e3 * t), comma(x), comma(f)),
    );
    let texts = [table(rows()), german, stamped, labelled, json, scope];
    let mut all: Vec<_> = texts
        .map(|text| (Kind::Text, text.into_bytes(), LoadOptions::default()))
        .into();
    for compressed in [false, true] {
        let bytes = mat::tests::recording(compressed, compressed);
        all.push((Kind::Matlab, bytes, options(&[("force_N", "u")])));
    }
    let numpy = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/formats/columns.npz");
    let numpy = std::fs::read(numpy).expect("columns.npz");
    all.push((Kind::Numpy, numpy, LoadOptions::default()));
    all.push((Kind::Model, MODEL.into(), LoadOptions::default()));
    all.push((Kind::Controller, CONTROLLER.into(), LoadOptions::default()));
    all
}

/// Some bytes changed, put in or left out, or the end cut off; whether it was.
fn damage(bytes: &mut Vec<u8>, rng: &mut ChaCha8Rng) -> bool {
    let alphabet = b"0123456789.,-+eE\n\r\"'#;:=[]{}\t nNaif\0\xff_tsxm";
    let mut cut = false;
    for _ in 0..rng.random_range(1..4) {
        let at = rng.random_range(0..bytes.len());
        let byte = match rng.random_range(0..3) {
            0 => rng.random(),
            _ => alphabet[rng.random_range(0..alphabet.len())],
        };
        match rng.random_range(0..8) {
            0..2 => bytes.insert(at, byte),
            2..4 => drop(bytes.remove(at)),
            4 => (cut, _) = (true, bytes.truncate(at.max(1))),
            _ => bytes[at] = byte,
        }
        if bytes.is_empty() {
            bytes.push(byte);
        }
    }
    cut
}

/// Loads one of them; `None` where it is no recording.
fn read(
    kind: &Kind,
    bytes: &[u8],
    options: &LoadOptions,
    folder: &Path,
) -> Option<Result<Recording, String>> {
    let told = |read: Result<Recording, RecordingError>| {
        Some(read.map_err(|e| {
            let told = e.to_string();
            assert!(told.contains("random."), "{told}");
            told
        }))
    };
    match kind {
        Kind::Text => told(load_csv(bytes, "random.csv", options)),
        Kind::Matlab => told(load_mat(bytes, "random.mat", options)),
        Kind::Numpy => {
            let path = folder.join("random.npz");
            std::fs::write(&path, bytes).expect("written");
            told(load(&path, options))
        }
        Kind::Model => {
            if let Ok(model) = Model::parse(&String::from_utf8_lossy(bytes)) {
                let again = model.to_toml(&[]);
                let again = Model::parse(&again).unwrap_or_else(|e| panic!("{e}: {again}"));
                assert_eq!(again.to_toml(&[]), model.to_toml(&[]));
            }
            None
        }
        Kind::Controller => {
            let _ = Controller::parse(&String::from_utf8_lossy(bytes));
            None
        }
    }
}

/// No panic; what is loaded is sound, and as many samples as before but for a word about those that are gone.
fn do_no_harm(rounds: u64, seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let folder = tempfile::tempdir().expect("folder");
    let whole = whole();
    let sound: Vec<Option<Recording>> = whole
        .iter()
        .map(|(kind, bytes, options)| {
            read(kind, bytes, options, folder.path()).map(|r| r.unwrap_or_else(|e| panic!("{e}")))
        })
        .collect();
    let mut loaded = vec![0_u64; whole.len()];
    for round in 0..rounds {
        let which = round as usize % whole.len();
        let (kind, good, options) = &whole[which];
        let mut bytes = good.clone();
        let random = round % 10 == 0;
        let mut cut = random;
        if random {
            bytes.resize(rng.random_range(0..400), 0);
            rng.fill_bytes(&mut bytes);
        } else {
            cut |= damage(&mut bytes, &mut rng);
        }
        let harm = std::panic::catch_unwind(|| {
            let read = read(kind, &bytes, options, folder.path());
            let (Some(Ok(r)), Some(sound)) = (read, &sound[which]) else {
                return false;
            };
            check_invariants(&r);
            let few = r.len() + 8 < sound.len() && r.warnings.len() <= sound.warnings.len();
            assert!(cut || !few, "{} of {} samples", r.len(), sound.len());
            true
        });
        match harm {
            Ok(read) => loaded[which] += u64::from(read),
            Err(_) => panic!(
                "seed {seed}, round {round}, file {which}:\n{}\n{bytes:?}",
                String::from_utf8_lossy(&bytes)
            ),
        }
    }
    println!("{rounds} files of seed {seed}; loaded, by kind: {loaded:?}");
    // A sum of checks guards what is packed.
    for ((kind, ..), loaded) in whole.iter().zip(&loaded) {
        let least = match kind {
            Kind::Text => rounds / whole.len() as u64 / 20,
            Kind::Matlab | Kind::Numpy => 1,
            Kind::Model | Kind::Controller => 0,
        };
        assert!(*loaded >= least, "{loaded} readable, not {least}");
    }
}

#[test]
fn random_damage_does_no_harm() {
    do_no_harm(6_000, 2);
}

/// As many of another seed with `INPUTS=100000000 SEED=7`.
#[test]
#[ignore = "long study: cargo xtask test --all"]
fn a_million_times_random_damage_does_no_harm() {
    let told = |name, usual| std::env::var(name).map_or(usual, |n| n.parse().expect("a number"));
    do_no_harm(told("INPUTS", 1_000_000), told("SEED", 3));
}
