//! What the effort of a simulation shows of its own laws: friction that reverses with the velocity, as most simulators have it, and the spring of
//! its drive.

use super::core::Core;
use super::effect::Scene;
use super::effect::behind::{swinging, swings};
use super::noise::Noise;
use super::normal::{Bound, Normal};
use super::rows::Rows;
use super::weak::Column;
use preslide_fit::statistics::spread;
use rayon::prelude::*;

/// Share of the squares that a law of the simulation's own may leave of what blocks do.
const LEAVES: f64 = 0.5;
/// Rounds in which the distance to the neighbours is cut to a quarter: a thousandth of a parameter in the end.
const ROUNDS: i32 = 4;

/// The effort of a simulation at the rows (N or N·m), beside inertia, viscous friction and weight.
pub struct Simulated<'a> {
    rows: &'a Rows,
    core: &'a Core,
    noise: &'a Noise,
    effort: &'a [f64],
    plain: [Vec<f64>; 2],
}

impl<'a> Simulated<'a> {
    /// That of a recording's rows.
    pub fn new(rows: &'a Rows, core: &'a Core, noise: &'a Noise, effort: &'a [f64]) -> Self {
        let s = &rows.s;
        let plain = [s.v.clone(), vec![1.0; s.v.len()]];
        Self {
            plain: plain.map(|column| rows.weak.rows(&Column::of(column))),
            rows,
            core,
            noise,
            effort,
        }
    }

    /// The speed (m/s or rad/s) over which its friction reverses, where it is `level·tanh(v/v₀)`.
    pub fn smooth_friction(&self) -> Option<f64> {
        /// Speeds that are tried, from a part of the usual top speed that nobody sees to where it is all but viscous.
        const TRIED: usize = 40;
        const SPAN: [f64; 2] = [3e-4, 0.5];
        let s = &self.rows.s;
        let top = s.moving_speed(0.95).max(1e-300);
        let speeds = spread(SPAN[0] * top, SPAN[1] * top, TRIED);
        let smooth = |slow: f64| Column::of(s.v.iter().map(|v| (v / slow).tanh()).collect());
        self.best(&speeds, &[], smooth)
    }

    /// The frequency (Hz) at which the load of its elastic drive swings behind a motor that stands.
    pub fn swing(&self, scene: &Scene) -> Option<f64> {
        self.best(&swings(scene), &self.blocks(), |hz| swinging(hz, scene))
    }

    fn blocks(&self) -> Vec<&[f64]> {
        let first = self.core.first_of_friction();
        self.core.rows[first..].iter().map(Vec::as_slice).collect()
    }

    /// The parameter, of a grid by its logarithm and then between, with which a law leaves least beside some columns, and less than half of what
    /// blocks leave.
    fn best(
        &self,
        grid: &[f64],
        beside: &[&[f64]],
        law: impl Fn(f64) -> Column + Sync,
    ) -> Option<f64> {
        let left = |value: f64| {
            let own = self.rows.weak.rows(&law(value));
            self.left(&[beside, &[&own]].concat())
        };
        let best = |among: &[f64]| {
            let tried = among.par_iter().filter_map(|x| Some((*x, left(*x)?)));
            tried.min_by(|a, b| a.1.total_cmp(&b.1))
        };
        let mut found = best(grid)?;
        let ratio = grid.get(1)? / grid[0];
        for round in 0..ROUNDS {
            let step = ratio.powf(0.25_f64.powi(round + 1));
            let nearer: Vec<f64> = (-3..=3).map(|i| found.0 * step.powi(i)).collect();
            found = best(&nearer)?;
        }
        (found.1 < LEAVES * self.left(&self.blocks())?).then_some(found.0)
    }

    /// Squares of what such columns leave of it.
    fn left(&self, own: &[&[f64]]) -> Option<f64> {
        let first = self.core.first_of_friction();
        let plain = self.core.rows[..first].iter().chain(&self.plain);
        let columns: Vec<&[f64]> = plain
            .map(Vec::as_slice)
            .chain(own.iter().copied())
            .collect();
        let bounds = vec![Bound::Free; columns.len()];
        let folds = &self.rows.weak.folds;
        let fit = Normal::new(self.noise, folds, &columns, &bounds, self.effort)?;
        let left = fit.held_out_residual(&columns, self.effort);
        Some(left.iter().map(|r| r * r).sum())
    }
}
