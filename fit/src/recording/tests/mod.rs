//! Whole files. Here is what their tests share.

mod damaged;
mod faults;
mod foreign;
mod loggers;
mod lost;
mod plausible;
mod real;
mod refusals;
mod text;

use std::path::Path;

use super::*;
use preslide_host_tests::deviation::Deviation;
use preslide_host_tests::refusal::refuses;

pub(super) fn options(map: &[(&str, &str)]) -> LoadOptions {
    LoadOptions {
        map: map
            .iter()
            .map(|(a, b)| (a.to_string(), b.to_string()))
            .collect(),
        ..LoadOptions::default()
    }
}

pub(super) fn text(csv: &str, map: &[(&str, &str)]) -> Result<Recording, RecordingError> {
    load_csv(csv.as_bytes(), "test.csv", &options(map))
}

/// A text that must be readable.
pub(super) fn read(csv: &str) -> Recording {
    text(csv, &[]).unwrap_or_else(|e| panic!("{e}"))
}

/// A MATLAB file from memory.
pub(super) fn load_mat(
    bytes: &[u8],
    name: &str,
    options: &LoadOptions,
) -> Result<Recording, RecordingError> {
    recording(super::read::mat(bytes, options), name, options)
}

pub(super) fn warns(r: &Recording, code: &str) -> bool {
    r.warnings.iter().any(|w| w.code == code)
}

/// What the warning of that code says, which must be there.
#[track_caller]
pub(super) fn said<'a>(r: &'a Recording, code: &str) -> &'a str {
    let found = r.warnings.iter().find(|w| w.code == code);
    &found
        .unwrap_or_else(|| panic!("no {code}: {:?}", r.warnings))
        .message
}

/// The largest difference of two columns.
pub(super) fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let mut apart = Deviation::default();
    a.iter().zip(b).for_each(|(a, b)| apart.add(*a, *b));
    apart.max
}

/// Loads `folder/name`, which must succeed.
fn real_file(folder: &Path, name: &str, map: &[(&str, &str)]) -> Recording {
    load(&folder.join(name), &options(map)).unwrap_or_else(|e| panic!("{e}"))
}

/// `rows` of (t, x, F) as CSV.
fn table(rows: impl IntoIterator<Item = (f64, f64, f64)>) -> String {
    let rows = rows.into_iter().map(|(t, x, f)| format!("{t},{x},{f}\n"));
    format!("t_s,x_m,force_N\n{}", rows.collect::<String>())
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
    let lengths = [
        r.position.len(),
        r.effort.len(),
        r.segment.len(),
        r.repeat.len(),
    ];
    assert_eq!(lengths, [n; 4]);
    assert_eq!(r.pieces.iter().map(|p| p.len()).sum::<usize>(), n);
    assert!(r.pieces.windows(2).all(|w| w[0].end == w[1].start));
    for piece in &r.pieces {
        assert!(r.t_s[piece.clone()].windows(2).all(|w| w[0] < w[1]));
    }
    let mut all = r.position.iter().chain(&r.effort).chain(&r.t_s);
    assert!(all.all(|v| v.is_finite()));
}
