//! Blocks and bristles of the over-resolved core: their lengths, and their deflections along the path between the samples.
//!
//! Parallel blocks remember every reversal, and their stiffness after one is that of the first loading. Dahl's law forgets, and is twice as
//! stiff after a reversal; LuGre's does too, and Bouc and Wen's, and elasto-plastic ones in part. `F = Σ k_i·z_i` is linear with either.

use super::signals::Signals;
use preslide_fit::signal::{Deflection, LATE, RELAXED, bristle, step_at_reversals};
use preslide_fit::statistics::{quantile_between_ranks, spread};
use std::ops::{Range, RangeInclusive};

/// Blocks of the over-resolved core: error of the hysteresis core is the main impostor of other physics, and an earlier engine named
/// 45 % of simulated effects with the paper's six blocks, 71 % with 24. More where displacements of more decades are resolved.
const CORE: RangeInclusive<f64> = 24.0..=36.0;
/// Ratio of neighbours that is wanted.
const RATIO: f64 = 1.3;
/// Bristles beside them.
const BRISTLES: usize = 12;
/// Blocks that stand for one bristle in a model of blocks.
const FOR_A_BRISTLE: usize = 4;
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

/// Deflection of a bristle of relaxation length `d` at the samples, followed between them.
pub fn bend(fine: &[f64], pieces: &[Range<usize>], d: f64) -> Vec<f64> {
    let z = bristle(fine, pieces, d, false);
    z.into_iter().step_by(FINER).collect()
}

/// The blocks, each of stiffness and yield displacement, whose force is that of a bristle of stiffness `k` and length `d` after a reversal
/// in sliding, `2kd·(1 − e^(−u/d)) − kd`: parts of its curve with equal changes of slope, each by the mean of its yields `u/2`.
pub fn as_blocks((k, d): (f64, f64)) -> impl Iterator<Item = (f64, f64)> {
    let n = FOR_A_BRISTLE as f64;
    // Mean of `−ln p` over `from < p < to`, times the part's width `1/n`.
    let integral = |p: f64| if p > 0.0 { p * (1.0 - p.ln()) } else { 0.0 };
    (0..FOR_A_BRISTLE).map(move |i| {
        let (from, to) = (i as f64 / n, (i + 1) as f64 / n);
        (2.0 * k / n, 0.5 * d * n * (integral(to) - integral(from)))
    })
}

/// Log-spaced relaxation lengths beside blocks of such yields.
pub fn lengths(yields: &[f64]) -> Vec<f64> {
    let ends = yields.first().zip(yields.last());
    ends.map_or(Vec::new(), |(short, long)| {
        spread(2.0 * short, long / RELAXED, BRISTLES)
    })
}

/// Log-spaced yields from what a typical slow sample moves, or one near a reversal, to the share [`LATE`] of the travel, with those of a fit
/// in the places of their neighbours: a block that lies between two of the grid leaves an error that looks like creep or delay. Without a fit
/// the grid begins with the slow sample: blocks that are known from reversals alone are held by nothing.
pub fn yields(s: &Signals, fitted: Option<&[f64]>) -> Vec<f64> {
    let steps: Vec<f64> =
        s.x.windows(2)
            .map(|p| (p[1] - p[0]).abs())
            .filter(|d| *d > 0.0)
            .collect();
    let long = LATE * s.travel();
    let typical = quantile_between_ranks(&steps, 0.1);
    let local = fitted.and_then(|_| step_at_reversals(&s.x, &s.pieces, s.turns()));
    let short = (0.5 * local.unwrap_or(typical).min(typical))
        .max(quantile_between_ranks(&steps, 0.0))
        .min(long / 10.0)
        .max(long / 3e4);
    let Some(fitted) = fitted else {
        return spread(short, long, *CORE.start() as usize);
    };
    let wanted = ((long / short).ln() / RATIO.ln()).ceil();
    let count = wanted.clamp(*CORE.start(), *CORE.end()) as usize;
    with(spread(short, long, count), fitted)
}

/// The yields of a grid, each of those `fitted` within it in place of what lies closer to it than half a step.
fn with(mut grid: Vec<f64>, fitted: &[f64]) -> Vec<f64> {
    let [.., before, long] = grid[..] else {
        return grid;
    };
    let (short, half_a_step) = (grid[0], 0.5 * (long / before).ln());
    for &d in fitted.iter().filter(|d| (short..=long).contains(*d)) {
        grid.retain(|g| (g / d).ln().abs() > half_a_step);
        grid.push(d);
    }
    grid.sort_by(f64::total_cmp);
    grid
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bristle and the blocks that stand for it agree after reversals in sliding as far as four straight lines follow a curve that swings by
    /// `2kd`, and in sliding exactly.
    #[test]
    fn blocks_stand_for_a_bristle() {
        let (k, d) = (3.0, 2e-3);
        let fine: Vec<f64> = (0..4000)
            .map(|i| 0.02 * (f64::from(i) * std::f64::consts::TAU / 4000.0).sin())
            .collect();
        let whole = 0..fine.len();
        let pieces = std::slice::from_ref(&whole);
        let bristle: Vec<f64> = bend(&fine, pieces, d).iter().map(|z| k * z).collect();
        let mut blocks = vec![0.0; bristle.len()];
        for (k, d) in as_blocks((k, d)) {
            let own = deflection(&fine, pieces, d);
            blocks.iter_mut().zip(own).for_each(|(b, z)| *b += k * z);
        }
        // From the first reversal on, over a quarter of the sine.
        let settled = bristle.len() / 4..bristle.len();
        let apart = |i: usize| (bristle[i] - blocks[i]) / (k * d);
        let largest = settled.clone().map(|i| apart(i).abs()).fold(0.0, f64::max);
        let square: f64 = settled.clone().map(|i| apart(i).powi(2)).sum();
        let rms = (square / settled.len() as f64).sqrt();
        let bias = settled.clone().map(apart).sum::<f64>() / settled.len() as f64;
        assert!(
            largest < 0.19 && rms < 0.045 && bias.abs() < 1e-3,
            "largest {largest}, RMS {rms}, bias {bias}"
        );
        let before_reversal = 3 * bristle.len() / 4 - 1;
        assert!(apart(before_reversal).abs() < 1e-3);
    }

    /// After a reversal in sliding a bristle is twice as stiff as from rest.
    #[test]
    fn a_bristle_is_twice_as_stiff_after_a_reversal() {
        let d = 1e-3;
        let step = 1e-6;
        let up = (0..20_000).map(|i| f64::from(i) * step);
        let down = (1..=8).map(|i| (19_999.0 - f64::from(i)) * step);
        let fine: Vec<f64> = up.chain(down).collect();
        let z = bend(&fine, std::slice::from_ref(&(0..fine.len())), d);
        let way = FINER as f64 * step;
        assert!((z[1] / way - 1.0).abs() < 0.01, "{}", z[1] / way);
        let last = z.len() - 1;
        let slope = (z[last - 1] - z[last]) / way;
        assert!((slope - 2.0).abs() < 0.02, "{slope}");
    }
}
