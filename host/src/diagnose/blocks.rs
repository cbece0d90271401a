//! The blocks of the over-resolved core: their yields, and their deflections along the path between the samples.

use super::effect::grid::spread;
use super::rows::LATE;
use super::signals::{Signals, quantile};
use crate::signal::Deflection;
use std::ops::Range;

/// Blocks of the over-resolved core: error of the hysteresis core is the main impostor of other physics, and an earlier engine named
/// 45 % of simulated effects with the paper's six blocks, 71 % with 24.
const CORE: usize = 24;
/// Points of the path for each sample.
pub const FINER: usize = 4;

/// The path with points between the samples, by cubic interpolation (Catmull and Rom 1974), as many for each sample: a
/// reversal lies between two samples, and a block that does not see its peak is off by as much from there on.
pub fn between_samples(s: &Signals) -> (Vec<f64>, Vec<Range<usize>>) {
    let mut fine = Vec::with_capacity(FINER * s.x.len());
    for piece in &s.pieces {
        let x = &s.x[piece.clone()];
        let at = |i: usize| x[i.min(x.len() - 1)];
        for i in 0..x.len() {
            let (a, b, c, d) = (at(i.saturating_sub(1)), at(i), at(i + 1), at(i + 2));
            for k in 0..FINER {
                let u = k as f64 / FINER as f64;
                let bend = (3.0 * (b - c) + d - a) * u + 2.0 * a - 5.0 * b + 4.0 * c - d;
                fine.push(b + 0.5 * u * (c - a + u * bend));
            }
        }
    }
    let finer = |p: &Range<usize>| FINER * p.start..FINER * p.end;
    (fine, s.pieces.iter().map(finer).collect())
}

/// Deflection of a block of yield displacement `d` at the samples, followed between them.
pub fn deflection(fine: &[f64], pieces: &[Range<usize>], d: f64) -> Vec<f64> {
    let z = Deflection::along(fine, pieces, d).z;
    z.into_iter().step_by(FINER).collect()
}

/// Log-spaced yields from what a typical sample moves to the share [`LATE`] of the travel.
pub fn yields(s: &Signals) -> Vec<f64> {
    let steps: Vec<f64> =
        s.x.windows(2)
            .map(|p| (p[1] - p[0]).abs())
            .filter(|d| *d > 0.0)
            .collect();
    let long = LATE * s.travel();
    let short = (0.5 * quantile(&steps, 0.1))
        .max(quantile(&steps, 0.0))
        .min(long / 10.0)
        .max(long / 3e4);
    spread(short, long, CORE)
}
