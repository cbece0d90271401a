//! What a command takes on long recordings, on one core, beside the least that anyone would do: forty yields by non-negative least squares.
//!
//! `cargo bench -p preslide-bench --bench whole` prints seconds of this machine and ratios of one run; nothing is asserted.

use nalgebra::{DMatrix, DVector};
use preslide_fit::identify::{MANY, Options, identify, thinned};
use preslide_fit::progress::Progress;
use preslide_fit::recording::{LoadOptions, Recording, load_csv};
use preslide_fit::signal::Deflection;
use preslide_host::compare::compare;
use preslide_host::diagnose::diagnose;
use preslide_host::diagnose::fit::Fit;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

const SEED: u64 = 20_261_128;
const STEP_S: f64 = 1e-3;
/// Yields of the least squares, from a typical step to the pre-sliding's end (m).
const YIELDS: usize = 40;
const BETWEEN: (f64, f64) = (1e-7, 1e-3);

fn main() {
    println!(
        "seed {SEED}; seconds on one thread, and times the non-negative least squares of as many rows"
    );
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.expect("a thread").install(|| {
        for rows in [100_000, 1_000_000] {
            let recording = made(rows);
            let least = seconds(|| nnls(&recording));
            println!("{rows} rows: NNLS of {YIELDS} yields {least:.2} s");
            let quiet = || Progress::new("bench", 0);
            let told = |what: &str, took: f64| {
                println!("  {what:<10} {took:>7.2} s  {:>6.2} x", took / least)
            };
            told(
                "identify",
                seconds(|| {
                    let thin = thinned(&recording, MANY);
                    identify(
                        thin.as_ref().unwrap_or(&recording),
                        &Options::default(),
                        &quiet(),
                    )
                }),
            );
            told(
                "diagnose",
                seconds(|| {
                    let fit = Arc::new(Fit::of(&recording));
                    let thin = thinned(&recording, 0);
                    diagnose(
                        thin.as_ref().unwrap_or(&recording),
                        None,
                        Some(fit),
                        &quiet(),
                    )
                    .map(|_| ())
                }),
            );
            told(
                "compare",
                seconds(|| {
                    let thin = thinned(&recording, MANY);
                    compare(
                        thin.as_ref().unwrap_or(&recording),
                        &Options::default(),
                        &quiet(),
                    )
                    .map(|_| ())
                }),
            );
        }
    });
}

fn seconds<T>(work: impl FnOnce() -> T) -> f64 {
    let begun = Instant::now();
    black_box(work());
    begun.elapsed().as_secs_f64()
}

/// Four blocks, 3 kg, viscous friction and a cogging, along three sines, its force with noise of 10 mN.
fn made(rows: usize) -> Recording {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let blocks = [(1e5, 3e-6), (4e4, 1e-5), (1e4, 4e-5), (2e3, 2e-4)];
    let mut z = [0.0_f64; 4];
    let (mut text, mut last) = ("t_s,x_m,force_N\n".to_owned(), 0.0);
    for i in 0..rows {
        let t = i as f64 * STEP_S;
        let (mut x, mut v, mut a) = (0.0, 0.0, 0.0);
        for (size, hertz, phase) in [(0.02, 0.13, 0.0), (0.004, 0.71, 1.0), (4e-4, 3.1, 2.0)] {
            let w = TAU * hertz;
            let (sin, cos) = (w * t + phase).sin_cos();
            x += size * sin;
            v += size * w * cos;
            a -= size * w * w * sin;
        }
        let dx = if i == 0 { 0.0 } else { x - last };
        last = x;
        let mut force = 3.0 * a + 12.0 * v + 0.15 * (TAU * x / 3e-3).sin();
        for (z, (stiffness, yields)) in z.iter_mut().zip(blocks) {
            *z = (*z + dx).clamp(-yields, yields);
            force += stiffness * *z;
        }
        force += 0.01 * random.random_range(-1.7..1.7);
        let _ = writeln!(text, "{t:.3},{x:.8e},{force:.6}");
    }
    load_csv(text.as_bytes(), "made.csv", &LoadOptions::default()).expect("a recording")
}

/// Lawson and Hanson's algorithm (1974, chapter 23) on the normal equations: acceleration, velocity, a constant and forty blocks.
fn nnls(recording: &Recording) -> DVector<f64> {
    let x = &recording.position;
    let n = x.len();
    let slope = |x: &[f64]| -> Vec<f64> {
        let at = |i: usize| x[i.min(n - 1)];
        (0..n)
            .map(|i| (at(i + 1) - at(i.saturating_sub(1))) / (2.0 * STEP_S))
            .collect()
    };
    let v = slope(x);
    let mut columns = vec![slope(&v), v, vec![1.0; n]];
    let (short, long) = BETWEEN;
    columns.extend((0..YIELDS).map(|j| {
        let d = short * (long / short).powf(j as f64 / (YIELDS - 1) as f64);
        let z = Deflection::along(x, &recording.pieces, d).z;
        z.iter().map(|z| z / d).collect()
    }));
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let p = columns.len();
    let gram = DMatrix::from_fn(p, p, |i, j| dot(&columns[i], &columns[j]));
    let right = DVector::from_fn(p, |i, _| dot(&columns[i], &recording.effort));
    let scaled = |r: &DVector<f64>, i: usize| r[i] / gram[(i, i)].sqrt();
    let enough = 1e-9 * (0..p).map(|i| scaled(&right, i).abs()).fold(0.0, f64::max);
    let mut passive: Vec<usize> = vec![0, 1, 2];
    let mut solution = DVector::zeros(p);
    // It ends by itself after about as many rounds as there are columns.
    for _ in 0..3 * p {
        let size = passive.len();
        let part = DMatrix::from_fn(size, size, |i, j| gram[(passive[i], passive[j])]);
        let Some(solved) = part
            .lu()
            .solve(&DVector::from_fn(size, |i, _| right[passive[i]]))
        else {
            break;
        };
        let negative = (3..size).filter(|i| solved[*i] < 0.0);
        if let Some(worst) = negative.min_by(|a, b| solved[*a].total_cmp(&solved[*b])) {
            passive.remove(worst);
            continue;
        }
        solution = DVector::zeros(p);
        passive
            .iter()
            .zip(solved.iter())
            .for_each(|(i, s)| solution[*i] = *s);
        let gradient = &right - &gram * &solution;
        let next = (3..p).filter(|i| !passive.contains(i));
        let next = next.max_by(|a, b| scaled(&gradient, *a).total_cmp(&scaled(&gradient, *b)));
        match next.filter(|i| scaled(&gradient, *i) > enough) {
            Some(next) => passive.push(next),
            None => break,
        }
    }
    solution
}
