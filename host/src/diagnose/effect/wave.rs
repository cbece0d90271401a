//! Waves: a cosine and a sine, read as amplitude and phase.

use super::Fitted;
use super::readout::Values;
use std::f64::consts::TAU;

/// Key of the phase in model files.
pub(super) const PHASE: &str = "phase_rad";

/// `cos(2πx/p)` and `sin(2πx/p)`.
pub(super) fn wave(x: &[f64], period: f64) -> [Vec<f64>; 2] {
    let of = |wave: fn(f64) -> f64| x.iter().map(|x| wave(TAU * x / period)).collect();
    [of(f64::cos), of(f64::sin)]
}

/// `a·cos + b·sin = A·cos(… + φ)`: amplitude under `key`, and phase.
pub(super) fn amplitude_and_phase(key: &str, phase_key: &str, fitted: &Fitted) -> Values {
    let (a, b) = (fitted.coefficient(0), fitted.coefficient(1));
    let amplitude = a.hypot(b);
    let error = fitted.error(0).zip(fitted.error(1)).map(|(ea, eb)| {
        ((a * ea).powi(2) + (b * eb).powi(2)).sqrt() / amplitude.max(f64::MIN_POSITIVE)
    });
    let reach = error.map(|e| e / amplitude.max(f64::MIN_POSITIVE));
    vec![
        (key.to_owned(), fitted.estimate(amplitude, error)),
        (phase_key.to_owned(), fitted.estimate((-b).atan2(a), reach)),
    ]
}
