//! How late a simulation's effort was logged: a shift of the signal, found beside the numbers that a simulation may have wrong, and taken off.

use super::signals::Signals;
use rayon::prelude::*;

/// Longest shift that is looked for (s).
const LATEST_S: f64 = 0.5;
/// Squares that the shift leaves beside wrong numbers, over those that wrong numbers alone leave, up to which it is one.
const SHIFTED: f64 = 0.5;
/// Samples from which a shift is one.
const LEAST: f64 = 2.0;
/// Steps of the search within two samples: each leaves two thirds, all of them a thousandth.
const THIRDS: usize = 18;
/// Share of the usual top speed over which friction reverses in the numbers that may be wrong.
const SLOW: f64 = 0.02;

/// By how much (s) a simulated effort is later than the measured one.
pub(super) fn lateness(s: &Signals, measured: &[f64], simulated: &[f64]) -> Option<f64> {
    let n = measured.len();
    let most = ((LATEST_S / s.dt) as usize).min(n / 4);
    let inside = most..n - most;
    let wrong = orthonormal(plain(s), inside.clone());
    let left = |late: isize| -> f64 {
        let apart: Vec<f64> = (inside.clone())
            .map(|i| measured[i] - simulated[i.wrapping_add_signed(late)])
            .collect();
        left_of(&wrong, &apart)
    };
    let reach = most as isize;
    let all: Vec<f64> = (-reach..=reach).into_par_iter().map(left).collect();
    let best = (0..all.len()).min_by(|a, b| all[*a].total_cmp(&all[*b]))?;
    if best == 0 || best + 1 == all.len() {
        return None;
    }
    // Where friction jumps the least is a kink, which no parabola tells.
    let left_at = |late: f64| {
        let shifted = earlier(s, simulated, late * s.dt);
        let apart: Vec<f64> = inside.clone().map(|i| measured[i] - shifted[i]).collect();
        left_of(&wrong, &apart)
    };
    let middle = best as f64 - most as f64;
    let (mut low, mut high) = (middle - 1.0, middle + 1.0);
    for _ in 0..THIRDS {
        let third = (high - low) / 3.0;
        match left_at(low + third) < left_at(high - third) {
            true => high -= third,
            false => low += third,
        }
    }
    let late = 0.5 * (low + high);
    (late.abs() >= LEAST && left_at(late) < SHIFTED * all[most]).then_some(late * s.dt)
}

/// Squares of a mismatch that wrong numbers do not take.
fn left_of(wrong: &[Vec<f64>], apart: &[f64]) -> f64 {
    let taken = wrong.iter().map(|column| dot(column, apart).powi(2));
    (dot(apart, apart) - taken.sum::<f64>()).max(0.0)
}

/// Values of evenly spaced samples as they were so much later (s), held beyond the ends.
pub(super) fn earlier(s: &Signals, values: &[f64], late: f64) -> Vec<f64> {
    let last = values.len() - 1;
    let at = |i: usize| {
        let place = (i as f64 + late / s.dt).clamp(0.0, last as f64);
        let before = place as usize;
        let part = place - before as f64;
        values[before] + part * (values[(before + 1).min(last)] - values[before])
    };
    (0..values.len()).map(at).collect()
}

/// What a simulation's numbers multiply: offset, spring, viscous friction, inertia, Coulomb friction, gravity.
fn plain(s: &Signals) -> Vec<Vec<f64>> {
    let slow = SLOW * s.moving_speed(0.95).max(1e-300);
    let friction = s.v.iter().map(|v| (v / slow).tanh()).collect();
    let mut columns = vec![
        vec![1.0; s.x.len()],
        s.smooth.clone(),
        s.v.clone(),
        s.a.clone(),
        friction,
    ];
    if s.rotary {
        columns
            .extend([f64::sin, f64::cos].map(|wave| s.smooth.iter().map(|q| wave(*q)).collect()));
    }
    columns
}

/// The columns within a range of samples, each less what those before it have of it, of length 1; those of nothing new are left out.
fn orthonormal(columns: Vec<Vec<f64>>, inside: std::ops::Range<usize>) -> Vec<Vec<f64>> {
    let mut found: Vec<Vec<f64>> = Vec::new();
    for column in columns {
        let mut own = column[inside.clone()].to_vec();
        let whole = dot(&own, &own);
        // Twice, since once leaves rounding.
        for other in found.iter().chain(&found.clone()) {
            let part = dot(other, &own);
            own.iter_mut().zip(other).for_each(|(o, f)| *o -= part * f);
        }
        let left = dot(&own, &own);
        if left > 1e-10 * whole {
            own.iter_mut().for_each(|o| *o /= left.sqrt());
            found.push(own);
        }
    }
    found
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
