//! How high a CUSUM's threshold must be for the false-alarm rate that is wanted.

/// Nodes and weights of the seven-point Gauss–Hermite rule, for the mean over a standard normal variable.
const NORMAL: [(f64, f64); 7] = [
    (-3.750_439_717_725_742, 5.482_688_559_722_184e-4),
    (-2.366_759_410_734_541, 3.075_712_396_758_65e-2),
    (-1.154_405_394_739_968, 2.401_231_786_050_127e-1),
    (0.0, 4.571_428_571_428_571e-1),
    (1.154_405_394_739_968, 2.401_231_786_050_127e-1),
    (2.366_759_410_734_541, 3.075_712_396_758_65e-2),
    (3.750_439_717_725_742, 5.482_688_559_722_184e-4),
];

/// Mean number of windows to an alarm of a one-sided CUSUM `S ← max(0, S + z − k)`, `S > h`, of independent normal `z` of spread
/// 1: `(exp(2Δb) − 2Δb − 1)/(2Δ²)`, `b = h + 1.166`, where `Δ` is `k` less the mean of `z` (D. Siegmund, *Sequential
/// Analysis*, 1985, chapter X, by a Brownian motion with corrected threshold).
fn run_length(drift: f64, threshold: f64) -> f64 {
    let b = threshold + 1.166;
    let y = 2.0 * drift * b;
    if y.abs() < 1e-3 {
        return b * b;
    }
    (libm::exp(y) - y - 1.0) / (2.0 * drift * drift)
}

/// Expected false alarms per window of the two-sided CUSUM with slack `k` and threshold `h`, in spreads, whose mean was estimated
/// from `2n` windows and whose spread from the mean absolute deviation of `n`.
///
/// The mean over what the estimates may be: the mean's error is `1/√(2n)` spreads, the spread's `√((π/2 − 1)/n)` of it. Errors of
/// estimation multiply the rate (W. A. Jensen et al., *Effects of parameter estimation on control chart properties*, J. Quality
/// Technology 38, 2006), here by some 2 to 5: what is asked for would not be met without.
fn false_alarms(slack: f64, threshold: f64, windows: f64) -> f64 {
    let mean_error = 1.0 / libm::sqrt(2.0 * windows);
    let spread_error = libm::sqrt((core::f64::consts::FRAC_PI_2 - 1.0) / windows);
    let mut rate = 0.0;
    for (m, m_weight) in NORMAL {
        for (s, s_weight) in NORMAL {
            let spread = 1.0 + spread_error * s;
            let spread = if spread > 0.1 { spread } else { 0.1 };
            let length = run_length(slack * spread - mean_error * m, threshold * spread);
            rate += m_weight * s_weight / length;
        }
    }
    // Both sides alike.
    2.0 * rate
}

/// Threshold `h` in spreads of the two-sided CUSUM of slack `k` (in spreads) that gives `rate` false alarms per window,
/// expected of an axis commissioned with twice `windows` windows; at most 64.
pub fn decision_interval(slack: f64, rate: f64, windows: u32) -> f64 {
    let (mut low, mut high) = (0.0, 64.0);
    // To 1e-8.
    for _ in 0..32 {
        let middle = 0.5 * (low + high);
        if false_alarms(slack, middle, windows.into()) > rate {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}
