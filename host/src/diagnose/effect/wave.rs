//! Waves: a cosine and a sine, read as amplitude and phase.

use super::readout::Values;
use super::{Card, Fitted};
use std::f64::consts::TAU;

/// Key of the phase in model files.
pub(super) const PHASE: &str = "phase_rad";

/// `cos(2πx/p)` and `sin(2πx/p)`.
pub(super) fn wave(x: &[f64], period: f64) -> [Vec<f64>; 2] {
    let of = |wave: fn(f64) -> f64| x.iter().map(|x| wave(TAU * x / period)).collect();
    [of(f64::cos), of(f64::sin)]
}

/// `a·cos + b·sin = A·cos(… + φ)`: amplitude under `key`, and phase. Of several waves, each with a phase of its own, the mean amplitude and
/// the first one's phase.
pub(super) fn amplitude_and_phase(key: &str, phase_key: &str, fitted: &Fitted) -> Values {
    let waves: Vec<(f64, Option<f64>)> = (0..fitted.coefficients.len() / 2)
        .map(|k| amplitude(fitted, 2 * k))
        .collect();
    let n = waves.len().max(1) as f64;
    let mean = waves.iter().map(|w| w.0).sum::<f64>() / n;
    let squares: Option<f64> = waves.iter().map(|w| w.1.map(|e| e * e)).sum();
    let (a, b) = (fitted.coefficient(0), fitted.coefficient(1));
    let (first, error) = amplitude(fitted, 0);
    let reach = error.map(|e| e / first.max(f64::MIN_POSITIVE));
    vec![
        (
            key.to_owned(),
            fitted.estimate(mean, squares.map(|s| s.sqrt() / n)),
        ),
        (phase_key.to_owned(), fitted.estimate((-b).atan2(a), reach)),
    ]
}

/// The same of an effect with a phase in its model file, and its shape: the period or the frequency.
pub(super) fn amplitude_phase_and_shape(card: &Card, fitted: &Fitted) -> Values {
    let mut values = amplitude_and_phase(card.coefficient, PHASE, fitted);
    values.extend(fitted.shape_of(card));
    values
}

/// Of the wave whose cosine has the coefficient `at`, with its standard error.
fn amplitude(fitted: &Fitted, at: usize) -> (f64, Option<f64>) {
    let (a, b) = (fitted.coefficient(at), fitted.coefficient(at + 1));
    let amplitude = a.hypot(b);
    let error = fitted.error(at).zip(fitted.error(at + 1)).map(|(ea, eb)| {
        ((a * ea).powi(2) + (b * eb).powi(2)).sqrt() / amplitude.max(f64::MIN_POSITIVE)
    });
    (amplitude, error)
}
