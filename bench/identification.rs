//! Speed on the host: a model step, and whole identifications of the real recordings.
//!
//! `cargo bench -p preslide-bench`. The recordings are read from `../shared/recordings`; without them only the step
//! is measured, and a line says so.

use criterion::{Criterion, criterion_group, criterion_main};
use preslide::{Block, Friction, Gms, Motion, QuasiStaticGms, Sliding, Units};
use preslide_fit::identify::{Options, identify};
use preslide_fit::progress::Progress;
use preslide_fit::recording::{LoadOptions, load};
use preslide_host::paper::TABLE_3;
use std::hint::black_box;
use std::path::Path;

/// Table 3 of the paper, six blocks.
fn six() -> [Block; 6] {
    let column = TABLE_3[4].blocks;
    std::array::from_fn(|i| Block {
        stiffness: column[i].0,
        weight: column[i].1,
    })
}

/// Displacements of a reversing motion with random steps of up to 100 nm, long enough to defeat branch memory.
fn motions() -> Vec<Motion<f64>> {
    let mut state = 0x1727_2018_u64;
    (0..4096)
        .map(|i| {
            // xorshift64
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            let size = (state >> 40) as f64 / (1_u64 << 24) as f64 * 1e-7;
            let displacement = if (i / 512) % 2 == 0 { size } else { -size };
            Motion {
                displacement,
                velocity: displacement / 50e-6,
            }
        })
        .collect()
}

fn steps(criterion: &mut Criterion) {
    let motions = motions();
    let sliding = Sliding {
        coulomb: 0.81,
        stribeck_velocity: 1e-3,
        stribeck_exponent: 2.0,
        attraction: 20.0,
    };
    let full = Gms::<6, f64>::try_new(&six(), 0.9, sliding, 50e-6, Units::SI);
    let quasi_static = QuasiStaticGms::<6, f64>::try_new(&six(), 0.9, Units::SI);
    let (Ok(full), Ok(quasi_static)) = (full, quasi_static) else {
        panic!("Table 3 is refused")
    };
    let mut group = criterion.benchmark_group("step");
    group.throughput(criterion::Throughput::Elements(motions.len() as u64));
    group.bench_function("Gms<6, f64>, 4096 steps", |bencher| {
        let mut state = full.at_rest();
        bencher.iter(|| {
            motions
                .iter()
                .map(|&m| full.step(&mut state, black_box(m)))
                .sum::<f64>()
        });
    });
    group.bench_function("QuasiStaticGms<6, f64>, 4096 steps", |bencher| {
        let mut state = quasi_static.at_rest();
        bencher.iter(|| {
            motions
                .iter()
                .map(|&m| quasi_static.step(&mut state, black_box(m)))
                .sum::<f64>()
        });
    });
    group.finish();
}

fn identifications(criterion: &mut Criterion) {
    let recordings = Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../shared/recordings"
    ));
    if !recordings.exists() {
        eprintln!("SKIPPED: ../shared/recordings is absent, no identification is measured");
        return;
    }
    let mut group = criterion.benchmark_group("identify");
    group.sample_size(10);
    let cases = [
        (
            "EMPS, 24,841 samples",
            "emps/emps_tracking.csv",
            Options::default(),
        ),
        (
            "tribometer, N = 1…10",
            "tribometer_reciprocating/reciprocating_5N.csv",
            Options {
                train: Some((100.0, 145.0)),
                test: Some((145.0, 190.0)),
            },
        ),
    ];
    for (name, file, options) in cases {
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                let recording = load(&recordings.join(file), &LoadOptions::default());
                let Ok(recording) = recording else {
                    panic!("{file} does not load")
                };
                identify(&recording, &options, &Progress::new("bench", 1))
                    .map(|found| found.recommended)
            });
        });
    }
    group.finish();
}

criterion_group!(benches, steps, identifications);
criterion_main!(benches);
