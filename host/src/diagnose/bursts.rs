//! A mismatch that comes and goes: bursts at times that nothing in the motion tells.
//!
//! The squares of the whitened residual are divided by their mean at the same displacement since reversal and speed, and at the same
//! place in the same direction: what the motion organises is gone. What is left must not cluster in time. Windows of a quarter of
//! a second with a variance of their own bring `−½ M Σ ln s_w` nats; the same rows in another order, within what the motion
//! organises, tell what heavy tails bring by themselves.

use super::score::{Gain, beyond};
use super::signals::quantile;
use super::signature::{Axis, Signature};
use super::study::{State, Study};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

/// Length of a window (s).
const WINDOW_S: f64 = 0.25;
/// Orders that the rows are put in.
const ORDERS: u64 = 16;
/// Nats a row from which clusters are called bursts: a variance that differs by a factor of two from window to window. Friction that
/// wanders gives a third of it on simulated stages.
const PER_ROW: f64 = 0.12;

/// The bursts in what a hypothesis leaves, if there are any.
pub fn bursts(study: &Study, state: &State) -> Option<Signature> {
    let residual = study.residual(state);
    let white = state.noise.whitened(&residual);
    let s = &study.s;
    let at = |values: &[f64]| study.weak.at_centres(values);
    let speed: Vec<f64> = at(&s.v).iter().map(|v| v.abs()).collect();
    let (since, speed) = (classes(&at(&s.since_reversal), 10), classes(&speed, 5));
    let phase: Vec<usize> = since.iter().zip(&speed).map(|(z, v)| 5 * z + v).collect();
    let place: Vec<usize> = classes(&at(&s.x), 20)
        .iter()
        .zip(at(&s.direction))
        .map(|(x, d)| 2 * x + usize::from(d > 0.0))
        .collect();
    let mut energy: Vec<f64> = white.iter().map(|w| w * w).collect();
    level(&mut energy, &phase);
    level(&mut energy, &place);

    let row_s = study.weak.spacing as f64 * s.dt;
    let length = ((WINDOW_S / row_s).round() as usize).max(4);
    let nats = |energy: &[f64]| -> Vec<f64> {
        let folds = study.weak.folds.iter();
        folds
            .map(|rows| windows(&energy[rows.clone()], length))
            .collect()
    };
    let by_fold = nats(&energy);
    let orders: Vec<Vec<f64>> = (0..ORDERS)
        .map(|seed| nats(&reordered(&energy, &phase, seed)))
        .collect();
    let usual = |fold: usize| orders.iter().map(|o| o[fold]).sum::<f64>() / orders.len() as f64;
    let null: Vec<f64> = orders.iter().map(|o| o.iter().sum()).collect();
    let mean = null.iter().sum::<f64>() / null.len() as f64;
    let gain = Gain {
        by_fold: by_fold
            .iter()
            .enumerate()
            .map(|(fold, nats)| nats - usual(fold))
            .collect(),
        null: Vec::new(),
        coefficients: Vec::new(),
    };
    (gain.total() > PER_ROW * energy.len() as f64).then(|| Signature {
        axis: Axis::Bursts,
        odd: false,
        gain,
        threshold: beyond(&null) - mean,
    })
}

/// Class of every value, `count` classes of equal size.
fn classes(values: &[f64], count: usize) -> Vec<usize> {
    let edges: Vec<f64> = (1..count)
        .map(|k| quantile(values, k as f64 / count as f64))
        .collect();
    let class = |v: &f64| edges.partition_point(|edge| edge < v);
    values.iter().map(class).collect()
}

/// Divides every value by the mean of its class.
fn level(values: &mut [f64], class: &[usize]) {
    let count = class.iter().max().map_or(0, |most| most + 1);
    let mut sums = vec![(0.0, 0.0); count];
    for (v, &c) in values.iter().zip(class) {
        sums[c].0 += v;
        sums[c].1 += 1.0;
    }
    for (v, &c) in values.iter_mut().zip(class) {
        *v *= sums[c].1 / sums[c].0.max(1e-300);
    }
}

/// The values in another order, each staying in its class.
fn reordered(values: &[f64], class: &[usize], seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let count = class.iter().max().map_or(0, |most| most + 1);
    let mut members = vec![Vec::new(); count];
    for (i, &c) in class.iter().enumerate() {
        members[c].push(i);
    }
    let mut out = vec![0.0; values.len()];
    for rows in members {
        let mut from = rows.clone();
        from.shuffle(&mut rng);
        for (to, from) in rows.into_iter().zip(from) {
            out[to] = values[from];
        }
    }
    out
}

/// Nats of a variance of its own in every window of `length` values of mean 1.
fn windows(energy: &[f64], length: usize) -> f64 {
    energy
        .chunks_exact(length)
        .map(|w| {
            let mean = (w.iter().sum::<f64>() / length as f64).max(1e-6);
            0.5 * length as f64 * (mean - 1.0 - mean.ln())
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;

    #[test]
    fn another_order_takes_the_clusters_and_leaves_the_tails() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut draw = || -2.0 * rng.random::<f64>().max(1e-12).ln();
        let steady: Vec<f64> = (0..8000).map(|_| 0.5 * draw()).collect();
        // The same mean square in bursts: every tenth window fourteen times the others.
        let burst = |i: usize| {
            if (i / 10).is_multiple_of(10) {
                6.0
            } else {
                4.0 / 9.0
            }
        };
        let clustered: Vec<f64> = (0..8000).map(|i| 0.5 * draw() * burst(i)).collect();
        let class: Vec<usize> = (0..8000).map(|i| i % 7).collect();
        let beyond_order = |values: &[f64]| {
            let own = windows(values, 10);
            let null = windows(&reordered(values, &class, 1), 10);
            (own - null) / values.len() as f64
        };
        assert!(beyond_order(&steady).abs() < 0.02);
        assert!(beyond_order(&clustered) > PER_ROW);
    }
}
