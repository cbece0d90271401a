//! Shapes to try.

use crate::diagnose::signals::Signals;

/// `count` values from `low` to `high`, evenly on a logarithmic scale; none where they are no range above zero.
pub fn spread(low: f64, high: f64, count: usize) -> Vec<f64> {
    let usable = low > 0.0 && high > low;
    (0..count)
        .filter(|_| usable)
        .map(|i| low * (high / low).powf(i as f64 / (count - 1).max(1) as f64))
        .collect()
}

/// Shapes of one parameter, by [`spread`].
pub(super) fn one(low: f64, high: f64, count: usize) -> Vec<Vec<f64>> {
    let values = spread(low, high, count);
    values.into_iter().map(|value| vec![value]).collect()
}

/// Velocities at which friction may fall (m/s or rad/s): none where the recording has one speed.
pub(super) fn falling(s: &Signals, count: usize) -> Vec<f64> {
    let (slow, fast) = s.speeds();
    if fast > 1.5 * slow {
        spread((slow / 2.0).max(fast / 1000.0), fast / 1.5, count)
    } else {
        Vec::new()
    }
}
