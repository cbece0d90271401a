//! The friction of a simulation that reverses with the velocity, as most simulators have it.

use super::core::Core;
use super::effect::grid::spread;
use super::noise::Noise;
use super::normal::{Bound, Normal};
use super::rows::Rows;
use super::weak::Column;
use rayon::prelude::*;

/// The speed (m/s or rad/s) over which the friction of a simulation reverses, where it is `level·tanh(v/v₀)`: of the speeds that are tried the one that
/// leaves least of the simulated effort at the rows, beside inertia and viscous friction, and less than half of what blocks leave.
pub fn smooth_friction(rows: &Rows, core: &Core, noise: &Noise, simulated: &[f64]) -> Option<f64> {
    /// Speeds that are tried, from a part of the usual top speed that nobody sees to where it is all but viscous.
    const TRIED: usize = 40;
    const SPAN: [f64; 2] = [3e-4, 0.5];
    /// Rounds in which the distance to the neighbours is cut to a quarter: a thousandth of the speed in the end.
    const ROUNDS: i32 = 4;
    let s = &rows.s;
    let at_rows = |column: Vec<f64>| rows.weak.rows(&Column::of(column));
    let first = core.first_of_friction();
    let plain = [at_rows(s.v.clone()), at_rows(vec![1.0; s.v.len()])];
    let beside: Vec<&[f64]> = core.rows[..first]
        .iter()
        .chain(&plain)
        .map(Vec::as_slice)
        .collect();
    let left = |own: &[&[f64]]| {
        let columns = [beside.as_slice(), own].concat();
        let bounds = vec![Bound::Free; columns.len()];
        let fit = Normal::new(noise, &rows.weak.folds, &columns, &bounds, simulated)?;
        Some(fit.held_out_residual(&columns, simulated))
    };
    let square = |left: &[f64]| left.iter().map(|r| r * r).sum::<f64>();
    let smooth = |slow: f64| left(&[&at_rows(s.v.iter().map(|v| (v / slow).tanh()).collect())]);
    let top = s.moving_speed(0.95).max(1e-300);
    let best = |among: &[f64]| {
        let tried = among
            .par_iter()
            .filter_map(|slow| Some((*slow, square(&smooth(*slow)?))));
        tried.min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let speeds = spread(SPAN[0] * top, SPAN[1] * top, TRIED);
    let ratio = speeds[1] / speeds[0];
    let mut found = best(&speeds)?;
    for round in 0..ROUNDS {
        let step = ratio.powf(0.25_f64.powi(round));
        let nearer: Vec<f64> = (-3..=3)
            .map(|i| found.0 * step.powf(0.25 * f64::from(i)))
            .collect();
        found = best(&nearer)?;
    }
    let blocks: Vec<&[f64]> = core.rows[first..].iter().map(Vec::as_slice).collect();
    let [of_blocks, of_smooth] = [left(&blocks)?, smooth(found.0)?];
    (square(&of_smooth) < 0.5 * square(&of_blocks)).then_some(found.0)
}
