//! Maps over the travel: cosines of multiples of one angle.

use super::Fitted;
use super::readout::{Values, known};
use crate::diagnose::signals::Signals;
use preslide_fit::statistics::bounds;
use std::f64::consts::PI;

/// Numbers of cosines that are tried.
pub(super) const COUNTS: [f64; 4] = [2.0, 3.0, 5.0, 8.0];

/// `cos(jπu)` for `j = 1 … count`, `u` from 0 to 1 over the travel, by their recurrence.
pub(super) fn cosines(s: &Signals, count: f64) -> Vec<Vec<f64>> {
    let (from, to) = bounds(&s.x);
    let base: Vec<f64> =
        s.x.iter()
            .map(|x| (PI * (x - from) / (to - from)).cos())
            .collect();
    let (mut before, mut now) = (vec![1.0; base.len()], base.clone());
    let mut columns = Vec::new();
    for _ in 0..count as usize {
        let next = base.iter().zip(&now).zip(&before);
        let next = next
            .map(|((c, now), before)| 2.0 * c * now - before)
            .collect();
        before = std::mem::replace(&mut now, next);
        columns.push(before.clone());
    }
    columns
}

/// The first `count` coefficients as `cosine1`, `cosine2`, … with the unit, and where the map begins and ends.
pub(super) fn map(fitted: &Fitted, count: usize, unit: &str) -> Values {
    let key = |j: usize| format!("cosine{}{unit}", j + 1);
    let (from, to) = bounds(&fitted.scene.s.x);
    (0..count)
        .map(|j| fitted.entry(&key(j), j))
        .chain([known("from_m", from), known("to_m", to)])
        .collect()
}
