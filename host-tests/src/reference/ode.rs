//! Adaptive integration of one ordinary differential equation.

/// `y(length)` for `dy/dt = slope(y)`, `y(0) = start`, by the Dormand–Prince 5(4) pair with `tolerance` (absolute) on
/// each step's error estimate.
pub fn integrate(slope: impl Fn(f64) -> f64, start: f64, length: f64, tolerance: f64) -> f64 {
    let (mut y, mut t, mut h) = (start, 0.0, length);
    while t < length {
        h = h.min(length - t);
        let k1 = slope(y);
        let k2 = slope(y + h * k1 / 5.0);
        let k3 = slope(y + h * (3.0 / 40.0 * k1 + 9.0 / 40.0 * k2));
        let k4 = slope(y + h * (44.0 / 45.0 * k1 - 56.0 / 15.0 * k2 + 32.0 / 9.0 * k3));
        let k5 = slope(
            y + h
                * (19_372.0 / 6_561.0 * k1 - 25_360.0 / 2_187.0 * k2 + 64_448.0 / 6_561.0 * k3
                    - 212.0 / 729.0 * k4),
        );
        let k6 = slope(
            y + h
                * (9_017.0 / 3_168.0 * k1 - 355.0 / 33.0 * k2
                    + 46_732.0 / 5_247.0 * k3
                    + 49.0 / 176.0 * k4
                    - 5_103.0 / 18_656.0 * k5),
        );
        let next = y + h
            * (35.0 / 384.0 * k1 + 500.0 / 1_113.0 * k3 + 125.0 / 192.0 * k4
                - 2_187.0 / 6_784.0 * k5
                + 11.0 / 84.0 * k6);
        let k7 = slope(next);
        let error = h
            * (71.0 / 57_600.0 * k1 - 71.0 / 16_695.0 * k3 + 71.0 / 1_920.0 * k4
                - 17_253.0 / 339_200.0 * k5
                + 22.0 / 525.0 * k6
                - k7 / 40.0);
        let ratio = error.abs() / tolerance;
        if ratio <= 1.0 || h <= 1e-9 * length {
            t = if h >= length - t { length } else { t + h };
            y = next;
        }
        h *= (0.9 * ratio.max(1e-10).powf(-0.2)).clamp(0.2, 5.0);
    }
    y
}
