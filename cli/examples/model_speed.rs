//! How long a model file takes for a sample, in Rust: what `python/examples/speed.py` compares the Python package with.
//!
//! `cargo run --release --example model_speed -- MODEL.toml SAMPLES` prints nanoseconds a sample, of a whole path and one tick after the other, the
//! best of five runs.

use preslide_fit::friction::Path;
use preslide_fit::model::{Measured, Model, Now, Stepper};
use std::time::Instant;

/// Time between samples (s).
const STEP: f64 = 1e-4;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(file), Some(samples)) = (arguments.next(), arguments.next()) else {
        return Err("give MODEL.toml and the number of samples".into());
    };
    let (model, samples) = (Model::load(file.as_ref())?, samples.parse::<usize>()?);
    let of = |wave: fn(f64) -> f64| -> Vec<f64> {
        (0..samples)
            .map(|i| wave(i as f64 * STEP))
            .collect::<Vec<f64>>()
    };
    let (t_s, position) = (of(|t| t), of(|t| 0.02 * (2.1 * t).sin()));
    let (velocity, acceleration) = (
        of(|t| 0.042 * (2.1 * t).cos()),
        of(|t| -0.0882 * (2.1 * t).sin()),
    );
    let whole = 0..samples;
    let path = Path {
        position: &position,
        velocity: &velocity,
        pieces: std::slice::from_ref(&whole),
        sample_time: STEP,
    };
    let measured = Measured {
        t_s: Some(&t_s),
        acceleration: Some(&acceleration),
        ..Measured::default()
    };
    let [mut whole, mut ticks] = [f64::INFINITY; 2];
    for _ in 0..5 {
        let start = Instant::now();
        let force = model.force_along(path, &measured)?;
        whole = whole.min(start.elapsed().as_secs_f64() / std::hint::black_box(force).len() as f64);
        let mut stepper = Stepper::of(&model, STEP)?;
        let start = Instant::now();
        for i in 0..samples {
            let now = Now {
                position: position[i],
                velocity: Some(velocity[i]),
                acceleration: Some(acceleration[i]),
                ..Now::default()
            };
            std::hint::black_box(stepper.step(&now)?);
        }
        ticks = ticks.min(start.elapsed().as_secs_f64() / samples as f64);
    }
    println!("{:.2} {:.2}", whole * 1e9, ticks * 1e9);
    Ok(())
}
