//! Time and memory of `identify`, `diagnose` and `compare` by the size of the recording: `cargo run --release -p preslide-cli --example size [ROWS…]`.
//!
//! The recording is made here, at 10 kHz with an encoder of 10 nm and noise of 10 mN, read from its CSV text as a file would
//! be, and thinned as the commands do. Every tenth of its rows must give the same answer.

use preslide_host::compare::{compare, shortened};
use preslide_host::diagnose::diagnose;
use preslide_host::identify::{MANY, Options, identify, thinned};
use preslide_host::progress::Progress;
use preslide_host::recording::{LoadOptions, Recording, load_csv};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::time::Instant;

const SEED: u64 = 14;

/// Every `every`-th row of a recording: three sines, a block of friction, viscous friction and cogging.
fn recording(rows: usize, every: usize) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut text = String::with_capacity(30 * rows / every);
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
        let cogging = 0.15 * (TAU * x / 8e-3).cos();
        let force = 3.0 * a + 8.0 * v + 2e4 * z + cogging + noise;
        if i % every != 0 {
            continue;
        }
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

/// Time that all cores have spent on the process so far (s), where the system says it: on a busy machine the clock tells little.
fn cpu_s() -> f64 {
    /// Linux counts in these, on every architecture.
    const TICKS_HZ: f64 = 100.0;
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = stat.rsplit(')').next().map(str::split_whitespace);
    let ticks: Option<f64> = fields.map(|f| f.skip(11).take(2).flat_map(str::parse::<f64>).sum());
    ticks.unwrap_or(f64::NAN) / TICKS_HZ
}

/// Reads a recording as the commands do, with as many samples as its band needs.
fn read(text: &str) -> Result<Recording, String> {
    let whole = load_csv(text.as_bytes(), "made.csv", &LoadOptions::default())
        .map_err(|e| e.to_string())?;
    Ok(thinned(&whole, MANY).unwrap_or(whole))
}

/// What is done with a recording, with the duration and CPU time of each step (s).
struct Answer {
    kept: usize,
    seconds: [[f64; 2]; 4],
    mass: f64,
    names: Vec<&'static str>,
    best: String,
}

fn answer(text: String) -> Result<Answer, String> {
    let mut last = (Instant::now(), cpu_s());
    let mut lap = || {
        let now = (Instant::now(), cpu_s());
        let (clock, cpu) = std::mem::replace(&mut last, now);
        [(now.0 - clock).as_secs_f64(), now.1 - cpu]
    };
    let recording = read(&text)?;
    drop(text);
    let reading = lap();
    let quiet = |name: &'static str| Progress::new(name, 0);
    let found = identify(&recording, &Options::default(), &quiet("identify"))?;
    let identifying = lap();
    let mass = found.best().rigid_body.iter().find(|p| p.0 == "mass");
    let mass = mass.map_or(f64::NAN, |m| m.1.value);
    let found = diagnose(&recording, None, None, &quiet("diagnose")).map_err(|e| e.to_string())?;
    let diagnosing = lap();
    let names = found.confident().map(|e| e.id()).collect();
    let few = shortened(&recording, &Options::default());
    let few = few.as_ref().unwrap_or(&recording);
    let compared = compare(few, &Options::default(), &quiet("compare"))?;
    let best = compared.models[compared.recommended].name();
    Ok(Answer {
        kept: recording.len(),
        seconds: [reading, identifying, diagnosing, lap()],
        mass,
        names,
        best,
    })
}

fn main() -> Result<(), String> {
    let asked: Result<Vec<usize>, _> = std::env::args().skip(1).map(|a| a.parse()).collect();
    let mut sizes = asked.map_err(|e| format!("rows are whole numbers: {e}"))?;
    if sizes.is_empty() {
        sizes = vec![100_000, 1_000_000, 10_000_000];
    }
    println!(
        "seed {SEED}; seconds by the clock and (of all cores); every command reads first; the peak holds the CSV's text too"
    );
    let [a, b, c, d] = ["read", "identify", "diagnose", "compare"];
    println!(
        "{:>9} {a:>15} {b:>15} {c:>15} {d:>15} {:>8} {:>7}  mass kg, names, best model (of every tenth row)",
        "rows", "peak MB", "kept"
    );
    for rows in sizes {
        let whole = answer(recording(rows, 1))?;
        let peak = peak_mb();
        let tenth = answer(recording(rows, 10))?;
        let [a, b, c, d] = whole.seconds.map(|[s, cpu]| format!("{s:.2} ({cpu:.2})"));
        println!(
            "{rows:>9} {a:>15} {b:>15} {c:>15} {d:>15} {peak:>8.0} {:>7}  {:.4} {}, {} ({:.4} {}, {})",
            whole.kept,
            whole.mass,
            whole.names.join(" "),
            whole.best,
            tenth.mass,
            tenth.names.join(" "),
            tenth.best
        );
    }
    Ok(())
}
