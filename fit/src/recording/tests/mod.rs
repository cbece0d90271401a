//! Whole files. Here is what their tests share.

mod damaged;
mod faults;
mod foreign;
mod loggers;
mod lost;
mod real;
mod refusals;
mod text;

use std::fmt::Write as _;
use std::path::Path;

use super::*;
use preslide_host_tests::refusal::refuses;

fn options(map: &[(&str, &str)]) -> LoadOptions {
    LoadOptions {
        map: map
            .iter()
            .map(|(a, b)| (a.to_string(), b.to_string()))
            .collect(),
        ..LoadOptions::default()
    }
}

fn text(csv: &str, map: &[(&str, &str)]) -> Result<Recording, RecordingError> {
    load_csv(csv.as_bytes(), "test.csv", &options(map))
}

fn warns(r: &Recording, code: &str) -> bool {
    r.warnings.iter().any(|w| w.code == code)
}

/// Loads `folder/name`, which must succeed.
fn real_file(folder: &Path, name: &str, map: &[(&str, &str)]) -> Recording {
    load(&folder.join(name), &options(map)).unwrap_or_else(|e| panic!("{e}"))
}

/// `rows` of (t, x, F) as CSV.
fn table(rows: impl IntoIterator<Item = (f64, f64, f64)>) -> String {
    rows.into_iter()
        .fold("t_s,x_m,force_N\n".into(), |mut out, (t, x, f)| {
            writeln!(out, "{t},{x},{f}").expect("memory");
            out
        })
}

/// A swing of 30 mm in all, 0.2 Hz, at 500 Hz, with its Coulomb force.
fn swing(change: impl Fn(i32, &mut f64, &mut f64)) -> String {
    table((0..10_000).map(|i| {
        let phase = f64::from(i) * 0.002 * 0.2 * std::f64::consts::TAU;
        let (mut x, mut f) = (
            0.015 * phase.sin(),
            phase.cos().signum() * 3.0 + 0.1 * (f64::from(i) * 0.7).sin(),
        );
        change(i, &mut x, &mut f);
        (f64::from(i) * 0.002, x, f)
    }))
}

/// What holds of anything that loads.
fn check_invariants(r: &Recording) {
    let n = r.len();
    assert!(n >= 2 && !r.is_empty());
    assert!(
        [
            r.position.len(),
            r.effort.len(),
            r.segment.len(),
            r.repeat.len()
        ]
        .iter()
        .all(|&l| l == n)
    );
    assert_eq!(r.pieces.iter().map(|p| p.len()).sum::<usize>(), n);
    assert!(r.pieces.windows(2).all(|w| w[0].end == w[1].start));
    for piece in &r.pieces {
        assert!(r.t_s[piece.clone()].windows(2).all(|w| w[0] < w[1]));
    }
    assert!(
        r.position
            .iter()
            .chain(&r.effort)
            .chain(&r.t_s)
            .all(|v| v.is_finite())
    );
}
