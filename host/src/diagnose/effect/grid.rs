//! Shapes to try.

use crate::diagnose::signals::Signals;
use preslide_fit::statistics::spread;

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
