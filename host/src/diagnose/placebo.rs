//! How much of a line or a narrow place chance would take as well: waves of the state that the machine does not have. Ripples at other periods are no such
//! measure: harmonics of the motion stand out as well as a true line does; nor are its own columns at other times, which show no more than these.

use super::null_model::{Hypothesis, NullModel};
use super::term::Term;
use preslide_fit::statistics::quantile_between_ranks;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Waves of the state.
const WAVES: usize = 48;
/// Least and most cycles of a wave over what a coordinate covers.
const CYCLES: [f64; 2] = [0.5, 30.0];
/// The quantile that stands for what chance takes.
const CHANCE: f64 = 0.9;
/// The least and the most that is stated of it, as a logarithm: beyond e⁴ more says nothing more.
const TOLD: f64 = 4.0;

/// How a term that is a line or a narrow place stands out of chance, on top of the others: the logarithm of what it takes, a column, over what waves
/// of position, velocity and displacement since reversal do; `None` where nothing of it is new.
pub fn over_state(null: &NullModel, rest: &Hypothesis, term: &Term) -> Option<f64> {
    let taken = |columns: &[Vec<f64>]| rest.normal.reduction(columns).map_or(0.0, |r| r.0);
    let own = null.columns(term);
    if own.is_empty() {
        return None;
    }
    let waves: Vec<f64> = state_waves(null)
        .into_par_iter()
        .map(|wave| taken(&[wave]))
        .collect();
    let chance = quantile_between_ranks(&waves, CHANCE).max(f64::MIN_POSITIVE);
    let taken = (taken(&own) / own.len() as f64).max(f64::MIN_POSITIVE);
    Some((taken / chance).ln().clamp(-TOLD, TOLD))
}

/// Value `k` of a sequence that fills the unit interval evenly, another for each dimension (Roberts's, of the roots of x⁵ = x + 1): nothing is
/// drawn, so that what is said of a recording is always the same.
fn spread(k: usize, dimension: i32) -> f64 {
    const ROOT: f64 = 1.167_303_978_261_418_7;
    (0.5 + (k + 1) as f64 * ROOT.powi(-(dimension + 1))).fract()
}

/// Waves over a third each of position, of velocity and displacement since reversal, and of all three, every second one of the friction level.
fn state_waves(null: &NullModel) -> Vec<Vec<f64>> {
    let (s, weak) = (&null.rows.s, &null.rows.weak);
    let friction = weak.at_centres(&null.baseline.friction);
    let state: Vec<Vec<f64>> = [&s.x, &s.v, &s.since_reversal]
        .map(|c| unit(weak.at_centres(c)))
        .to_vec();
    (0..WAVES)
        .map(|k| {
            let cycles = |axis: usize| {
                let used = [axis == 0, axis > 0, true][k % 3];
                let share = spread(k, axis as i32);
                f64::from(used) * CYCLES[0] * (CYCLES[1] / CYCLES[0]).powf(share)
            };
            let turns: Vec<f64> = (0..state.len()).map(cycles).collect();
            let phase = spread(k, state.len() as i32);
            (0..friction.len())
                .map(|i| {
                    let along = turns.iter().zip(&state).map(|(t, c)| t * c[i]);
                    let wave = (TAU * (phase + along.sum::<f64>())).cos();
                    if k / 3 % 2 == 0 {
                        wave
                    } else {
                        wave * friction[i]
                    }
                })
                .collect()
        })
        .collect()
}

/// A coordinate over what most of it covers.
fn unit(values: Vec<f64>) -> Vec<f64> {
    let [low, high] = [0.05, 0.95].map(|q| quantile_between_ranks(&values, q));
    let covered = (high - low).max(f64::MIN_POSITIVE);
    values.into_iter().map(|v| (v - low) / covered).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_fills_the_interval() {
        for dimension in 0..4 {
            let mut values: Vec<f64> = (0..WAVES).map(|k| spread(k, dimension)).collect();
            values.sort_by(f64::total_cmp);
            let gap = values.windows(2).map(|p| p[1] - p[0]).fold(0.0, f64::max);
            assert!(gap < 7.0 / WAVES as f64, "{dimension}: {gap}");
        }
    }
}
