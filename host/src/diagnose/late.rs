//! How late a simulation's effort was logged: a shift of the signal, found beside the numbers that a simulation may have wrong, and taken off.

use super::blocks::yields;
use super::signals::Signals;
use preslide_fit::signal::Deflection;
use preslide_fit::statistics::{self, LeastSquares};

/// Longest shift that is looked for (s).
const LATEST_S: f64 = 0.5;
/// Squares that the shift leaves beside wrong numbers, over those that wrong numbers alone leave, up to which it is one.
const SHIFTED: f64 = 0.5;
/// Samples from which a shift is one.
const LEAST: f64 = 2.0;
/// Of the core's blocks, so many to each one among the numbers that may be wrong: the search is made a thousand times.
const EVERY: usize = 3;
/// Share of the usual top speed over which friction reverses in the numbers that may be wrong.
const SLOW: f64 = 0.02;

/// By how many samples a simulated effort is later than the measured one.
pub(super) fn lateness(s: &Signals, measured: &[f64], simulated: &[f64]) -> Option<f64> {
    let n = measured.len();
    let most = ((LATEST_S / s.dt) as usize).min(n / 4);
    let inside = most..n - most;
    let plain = plain(s);
    let wrong: Vec<&[f64]> = plain.iter().map(|c| &c[inside.clone()]).collect();
    let wrong = LeastSquares::of(&wrong)?;
    let left = |shifted: &[f64]| {
        let apart = inside.clone().map(|i| measured[i] - shifted[i]);
        wrong.squares_left(&apart.collect::<Vec<f64>>())
    };
    let (late, [least, unshifted]) = statistics::lateness(simulated, most, left)?;
    (late.abs() >= LEAST && least < SHIFTED * unshifted).then_some(late)
}

/// What a simulation's numbers multiply: offset, spring, viscous friction, inertia, friction, gravity.
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
    // Friction that builds up after a reversal lags the velocity's sign, as a late one does.
    let blocks = yields(s, None).into_iter().step_by(EVERY);
    columns.extend(blocks.map(|d| Deflection::along(&s.x, &s.pieces, d).z));
    if s.rotary {
        columns
            .extend([f64::sin, f64::cos].map(|wave| s.smooth.iter().map(|q| wave(*q)).collect()));
    }
    columns
}
