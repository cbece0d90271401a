//! Time and memory of `identify` by the size of the recording: `cargo run --release -p preslide-cli --example size [ROWS…]`.
//!
//! The recording is made here, at 10 kHz with an encoder of 10 nm and noise of 10 mN, read from its CSV text as a file would
//! be, thinned as the command does, and identified.

use preslide_host::identify::{Options, STEPS, identify, thinned};
use preslide_host::progress::Progress;
use preslide_host::recording::{LoadOptions, load_csv};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::fmt::Write as _;
use std::time::Instant;

const SEED: u64 = 14;

fn recording(rows: usize) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut text = String::with_capacity(30 * rows);
    text.push_str("t_s,x_m,force_N\n");
    let (mut z, mut last) = (0.0_f64, 0.0);
    for i in 0..rows {
        let t = i as f64 * 1e-4;
        let parts = [(0.02, 4.0), (0.006, 11.0), (0.002, 29.0)].map(|(a, w): (f64, f64)| {
            let (sin, cos) = (w * t).sin_cos();
            [a * sin, a * w * cos, -a * w * w * sin]
        });
        let [x, v, a] = [0, 1, 2].map(|j| parts.iter().map(|p| p[j]).sum::<f64>());
        z = (z + x - last).clamp(-1e-4, 1e-4);
        last = x;
        let noise = 0.01 * (rng.random::<f64>() + rng.random::<f64>() - 1.0);
        let force = 3.0 * a + 8.0 * v + 2e4 * z + noise;
        let _ = writeln!(text, "{t:.4},{:.8},{force:.4}", (x / 1e-8).round() * 1e-8);
    }
    text
}

/// Most memory that the process has held so far (MB), where the system says it.
fn peak_mb() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    let kb = line.and_then(|l| l.split_whitespace().next()?.parse::<f64>().ok());
    kb.unwrap_or(f64::NAN) / 1024.0
}

fn main() -> Result<(), String> {
    let asked: Result<Vec<usize>, _> = std::env::args().skip(1).map(|a| a.parse()).collect();
    let mut sizes = asked.map_err(|e| format!("rows are whole numbers: {e}"))?;
    if sizes.is_empty() {
        sizes = vec![100_000, 1_000_000, 10_000_000];
    }
    println!("seed {SEED}; the peak holds the CSV's text too");
    println!(
        "{:>9} {:>8} {:>8} {:>10} {:>8} {:>9} {:>9}",
        "rows", "read s", "thin s", "identify s", "peak MB", "kept rows", "mass kg"
    );
    for rows in sizes {
        let text = recording(rows);
        let start = Instant::now();
        let whole = load_csv(text.as_bytes(), "made.csv", &LoadOptions::default())
            .map_err(|e| e.to_string())?;
        let read = start.elapsed().as_secs_f64();
        drop(text);
        let start = Instant::now();
        let kept = thinned(&whole).unwrap_or(whole);
        let thin = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let found = identify(
            &kept,
            &Options::default(),
            &Progress::new("identify", STEPS),
        )?;
        let seconds = start.elapsed().as_secs_f64();
        let mass = found.best().rigid_body.iter().find(|p| p.0 == "mass");
        let mass = mass.map_or(f64::NAN, |m| m.1.value);
        println!(
            "{rows:>9} {read:>8.2} {thin:>8.2} {seconds:>10.2} {:>8.0} {:>9} {mass:>9.4}",
            peak_mb(),
            kept.len()
        );
    }
    Ok(())
}
