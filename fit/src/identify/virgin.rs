//! The virgin curve of a recording, and the paper's procedure (7)–(9) on it.

use std::collections::BTreeMap;

/// A force–displacement curve from rest, both axes ascending from the origin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VirginCurve {
    /// Displacement (m or rad).
    pub displacement: Vec<f64>,
    /// Force (N or N·m).
    pub force: Vec<f64>,
}

/// Bins over the longest stroke when branches are averaged.
const BINS: usize = 400;

/// Share of the longest stroke that a stroke must have to count.
const LONG: f64 = 0.9;

/// Share of the highest force at which the curve counts as having reached the breakaway force.
const BREAKAWAY_REACHED: f64 = 0.98;

impl VirginCurve {
    /// The mean branch after a reversal, halved in both directions (Masing's rule: a branch from saturation is
    /// the virgin curve at twice the scale, as for every Maxwell-slip model).
    ///
    /// `friction` is the force without inertia, viscous part and offset; `strokes` are samples of one stroke
    /// each, in order. Each stroke's own first sample is taken as its reversal. Only strokes nearly as long as the
    /// longest count: a short one does not start from saturation, where Masing's rule holds.
    pub fn from_strokes(position: &[f64], friction: &[f64], strokes: &[Vec<usize>]) -> Self {
        let travel = |rows: &Vec<usize>| {
            let start = rows.first().map_or(0.0, |&i| position[i]);
            rows.iter()
                .map(|&i| (position[i] - start).abs())
                .fold(0.0, f64::max)
        };
        let longest = strokes.iter().map(travel).fold(0.0, f64::max);
        let mut bins: BTreeMap<usize, (f64, f64, f64)> = BTreeMap::new();
        for rows in strokes.iter().filter(|rows| travel(rows) >= LONG * longest) {
            let Some((&first, &last)) = rows.first().zip(rows.last()) else {
                continue;
            };
            let direction = (position[last] - position[first]).signum();
            for &i in rows {
                let travelled = direction * (position[i] - position[first]);
                if travelled > 0.0 {
                    let bin = (travelled / longest * BINS as f64) as usize;
                    let (x, f, n) = bins.entry(bin).or_default();
                    *x += travelled;
                    *f += direction * (friction[i] - friction[first]);
                    *n += 1.0;
                }
            }
        }
        let mut curve = Self {
            displacement: vec![0.0],
            force: vec![0.0],
        };
        for (x, f, n) in bins.into_values() {
            curve.displacement.push(0.5 * x / n);
            curve.force.push(0.5 * f / n);
        }
        curve
    }

    /// The force at `x` by linear interpolation; constant beyond the last point.
    pub fn at(&self, x: f64) -> f64 {
        let high = self.displacement.partition_point(|&d| d < x);
        match (high.checked_sub(1), self.displacement.get(high)) {
            (None, _) => self.force.first().copied().unwrap_or(0.0),
            (Some(low), None) => self.force[low],
            (Some(low), Some(&end)) => {
                let part = (x - self.displacement[low]) / (end - self.displacement[low]);
                self.force[low] + part * (self.force[high] - self.force[low])
            }
        }
    }

    /// `n` breakpoints at equal steps of force, the last where the curve reaches the breakaway force.
    ///
    /// The paper places them by eye ("piecewise approximation", Fig. 4b) and does not say where.
    pub fn equal_force_breakpoints(&self, n: usize) -> Vec<f64> {
        let highest = self.force.iter().copied().fold(0.0, f64::max);
        (1..=n)
            .filter_map(|i| {
                let level = BREAKAWAY_REACHED * highest * i as f64 / n as f64;
                let at = self.force.iter().position(|&f| f >= level)?;
                let low = at.checked_sub(1)?;
                let part = (level - self.force[low]) / (self.force[at] - self.force[low]);
                let (from, to) = (self.displacement[low], self.displacement[at]);
                Some(from + part * (to - from))
            })
            .collect()
    }

    /// Eqs. (7)–(8): stiffnesses `k_i` (N/m) of the blocks that yield at the ascending `breakpoints` (m).
    ///
    /// `K_i` is the chord's slope from breakpoint `i − 1` (the origin for the first) to breakpoint `i`, and
    /// `k_i = K_i − K_{i+1}`, `k_N = K_N`. (The paper's indices of `D` and `F` in (8) count from the origin.)
    /// Where a measured curve is not concave neighbouring chords are merged, which leaves out the breakpoint
    /// between them; a stiffness could not be positive there. Returns pairs of breakpoint and stiffness.
    pub fn blocks(&self, breakpoints: &[f64]) -> Vec<(f64, f64)> {
        let mut corners = vec![(0.0, 0.0)];
        for &d in breakpoints {
            let next = (d, self.at(d));
            let slope = |a: (f64, f64), b: (f64, f64)| (b.1 - a.1) / (b.0 - a.0);
            while let [.., before, last] = corners[..]
                && slope(before, last) <= slope(last, next)
            {
                corners.pop();
            }
            if corners
                .last()
                .is_some_and(|last| next.0 > last.0 && next.1 > last.1)
            {
                corners.push(next);
            }
        }
        let chords: Vec<f64> = corners
            .windows(2)
            .map(|pair| (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0))
            .collect();
        (0..chords.len())
            .map(|i| {
                let softer = chords.get(i + 1).copied().unwrap_or(0.0);
                (corners[i + 1].0, chords[i] - softer)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three blocks of known stiffness and yield: (7)–(8) at the yields give them back.
    #[test]
    fn recovers_the_blocks_of_a_piecewise_linear_curve() {
        let blocks = [(1e-6, 3e5), (5e-6, 4e4), (4e-5, 8e3)];
        let displacement: Vec<f64> = (0..=4000).map(|i| f64::from(i) * 1e-8).collect();
        let force = displacement
            .iter()
            .map(|&x| blocks.iter().map(|&(d, k)| k * x.min(d)).sum())
            .collect();
        let curve = VirginCurve {
            displacement,
            force,
        };
        for ((d, k), (d_true, k_true)) in curve.blocks(&blocks.map(|b| b.0)).iter().zip(blocks) {
            assert!((d - d_true).abs() < 1e-15);
            assert!((k / k_true - 1.0).abs() < 1e-6, "{k} instead of {k_true}");
        }
    }

    /// A dent in a measured curve must not give a negative stiffness.
    #[test]
    fn merges_chords_that_are_not_concave() {
        let curve = VirginCurve {
            displacement: vec![0.0, 1.0, 2.0, 3.0],
            force: vec![0.0, 1.0, 1.1, 1.9],
        };
        let blocks = curve.blocks(&[1.0, 2.0, 3.0]);
        assert!(blocks.iter().all(|&(_, k)| k > 0.0));
        let total: f64 = blocks.iter().map(|&(d, k)| d * k).sum();
        assert!((total - 1.9).abs() < 1e-12);
    }
}
