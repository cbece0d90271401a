//! The motion of a recording, and the columns that injected effects follow: by differences and one stop, apart from the tool's own.

use std::ops::Range;

use super::table::Table;

/// Half of the time (s) over which a difference is taken.
const REACH_S: f64 = 10e-3;
/// A step of the clock longer than this many usual ones ends a piece.
const GAP: f64 = 5.0;
/// A stop that yields after this share of the travel is the sign of friction.
const YIELD: f64 = 3e-3;

/// Motion along the rows of one table.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Time (s).
    pub t: Vec<f64>,
    /// Position (m or rad), smoothed over `REACH_S`.
    pub x: Vec<f64>,
    /// Velocity.
    pub v: Vec<f64>,
    /// Acceleration.
    pub a: Vec<f64>,
    /// Rows without a gap in the clock.
    pub pieces: Vec<Range<usize>>,
}

impl Motion {
    /// From the clock and the position of a table.
    pub fn of(table: &Table) -> Self {
        Self::along(
            table.columns[table.time()].clone(),
            &table.columns[table.position()],
            table.sample_time(),
        )
    }

    /// From times (s), positions and the usual step of the clock (s).
    pub fn along(t: Vec<f64>, position: &[f64], step: f64) -> Self {
        let mut pieces = Vec::new();
        let mut start = 0;
        for i in 1..=t.len() {
            if i == t.len() || !(0.0..GAP * step).contains(&(t[i] - t[i - 1])) {
                pieces.push(start..i);
                start = i;
            }
        }
        let reach = ((REACH_S / step).round() as usize).max(1);
        let x = mean(position, reach / 2, &pieces);
        let v = slope(&x, &t, reach, &pieces);
        let a = slope(&v, &t, reach, &pieces);
        Self { t, x, v, a, pieces }
    }

    /// Force of a stop of stiffness 1/`yielding` that yields at ±1: friction's sign, with its hysteresis. Every piece starts unloaded.
    pub fn stop(&self, yielding: f64) -> Vec<f64> {
        let mut force = vec![0.0; self.x.len()];
        for piece in &self.pieces {
            let (mut z, mut before): (f64, f64) = (0.0, self.x[piece.start]);
            for (force, x) in force[piece.clone()].iter_mut().zip(&self.x[piece.clone()]) {
                z = (z + (x - before) / yielding).clamp(-1.0, 1.0);
                (*force, before) = (z, *x);
            }
        }
        force
    }
}

/// Mean over `reach` rows to either side, within the pieces.
fn mean(y: &[f64], reach: usize, pieces: &[Range<usize>]) -> Vec<f64> {
    let mut sums = vec![0.0; y.len() + 1];
    for (i, value) in y.iter().enumerate() {
        sums[i + 1] = sums[i] + value;
    }
    let mut smooth = y.to_vec();
    for piece in pieces {
        for i in piece.clone() {
            // As far to the left as to the right, or the mean would lag at the ends.
            let r = reach.min(i - piece.start).min(piece.end - 1 - i);
            smooth[i] = (sums[i + r + 1] - sums[i - r]) / (2 * r + 1) as f64;
        }
    }
    smooth
}

/// Central difference over `reach` rows to either side, within the pieces; 0 at their ends.
pub(super) fn slope(y: &[f64], t: &[f64], reach: usize, pieces: &[Range<usize>]) -> Vec<f64> {
    let mut slope = vec![0.0; y.len()];
    for piece in pieces {
        for i in piece.start + reach..piece.end.saturating_sub(reach) {
            slope[i] = (y[i + reach] - y[i - reach]) / (t[i + reach] - t[i - reach]);
        }
    }
    slope
}

/// Extent of a whole recording's motion.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Lowest position.
    pub low: f64,
    /// Highest less lowest.
    pub travel: f64,
    /// Speed that 95 % of the moving rows stay below.
    pub top: f64,
}

impl Extent {
    /// Over all parts.
    pub fn of(motions: &[Motion]) -> Self {
        let all = || motions.iter().flat_map(|m| m.x.iter().copied());
        let (low, high) = (
            all().fold(f64::INFINITY, f64::min),
            all().fold(f64::NEG_INFINITY, f64::max),
        );
        let mut speeds: Vec<f64> = motions
            .iter()
            .flat_map(|m| m.v.iter().map(|v| v.abs()))
            .collect();
        speeds.sort_by(f64::total_cmp);
        let fastest = speeds.last().copied().unwrap_or(0.0);
        speeds.retain(|v| *v > 0.01 * fastest);
        let top = speeds
            .get(speeds.len() * 95 / 100)
            .copied()
            .unwrap_or(fastest);
        Self {
            low,
            travel: high - low,
            top,
        }
    }

    /// Yield of the stop that is friction's sign.
    pub fn yielding(&self) -> f64 {
        YIELD * self.travel
    }
}
