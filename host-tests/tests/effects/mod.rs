//! The effects of the library against formulas that share no code with it, and what must hold whatever comes in.

mod composition;
mod formulas;
mod place;
mod refusals;

use preslide::{Gms, Scalar, Units};
use preslide_host_tests::path::{COUNT, COUNTS, SAMPLE_TIME, random_reversals};
use preslide_host_tests::table3;
use preslide_host_tests::table3::falling;

const TICKS: usize = 200_000;

/// A tick in SI.
#[derive(Clone, Copy)]
struct Tick {
    t: f64,
    x: f64,
    v: f64,
    friction: f64,
    temperature: f64,
    load: f64,
}

/// ±0.4 mm about 0.1 mm, up to 30 mm/s, slow and fast, with rests; friction, temperature and load of no particular law.
fn ticks() -> impl Iterator<Item = Tick> {
    random_reversals(7, TICKS, 2000.0, 60.0)
        .into_iter()
        .enumerate()
        .scan(4000_i64, |count, (i, step)| {
            *count += i64::from(step);
            if (*count - 4000).abs() > 16_000 {
                *count = 4000;
            }
            let t = i as f64 * SAMPLE_TIME;
            Some(Tick {
                t,
                x: *count as f64 * COUNT,
                v: f64::from(step) * COUNT / SAMPLE_TIME,
                friction: 0.9 * (31.0 * t).sin(),
                temperature: 20.0 + 8.0 * (0.7 * t).sin(),
                load: 30.0 + 5.0 * (1.3 * t).sin(),
            })
        })
}

fn scalar<S: Scalar>(value: f64) -> S {
    S::try_from_f64(value).expect("in range")
}

fn gms<S: Scalar>(units: Units) -> Gms<3, S> {
    let sliding = falling(0.81, 20.0);
    Gms::try_new(&table3::blocks::<3>(), 0.9, sliding, SAMPLE_TIME, units).expect("valid")
}
