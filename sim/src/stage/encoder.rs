//! From position to counts: interpolation error, then quantisation, then a counter of 32 bits.

use std::f64::consts::TAU;

use super::config::EncoderConfig;

/// Position that the interpolation unit sees at true position `x_m` \[m\]:
/// `x + e₁·sin(2πx/p + φ₁) + e₂·sin(4πx/p + φ₂)`.
pub fn interpolated_m(config: &EncoderConfig, x_m: f64) -> f64 {
    let turn = TAU * x_m / config.period_m;
    let [first, second] = config.error_phase_rad;
    x_m + config.error_order1_m * (turn + first).sin()
        + config.error_order2_m * (2.0 * turn + second).sin()
}

/// Count at true position `x_m`: the nearest one, in two's complement of 32 bits as a quadrature timer has it.
pub fn count(config: &EncoderConfig, x_m: f64) -> i32 {
    let counts = (interpolated_m(config, x_m) / config.count_m).round() as i64;
    // Keeping the low 32 bits is the wrap.
    config.origin_count.wrapping_add(counts as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ideal() -> EncoderConfig {
        EncoderConfig {
            error_order1_m: 0.0,
            error_order2_m: 0.0,
            ..EncoderConfig::default()
        }
    }

    #[test]
    fn quantises_to_the_nearest_count() {
        let config = ideal();
        for i in -4000..4000 {
            let x = f64::from(i) * 1.7e-9;
            let back = f64::from(count(&config, x)) * config.count_m;
            assert!(
                (back - x).abs() <= 0.5 * config.count_m * (1.0 + 1e-9),
                "{x} {back}"
            );
        }
    }

    #[test]
    fn wraps_like_a_timer() {
        let mut config = ideal();
        config.origin_count = i32::MAX - 1;
        let walked: Vec<i32> = (0..5)
            .map(|i| count(&config, f64::from(i) * config.count_m))
            .collect();
        assert_eq!(
            walked,
            [i32::MAX - 1, i32::MAX, i32::MIN, i32::MIN + 1, i32::MIN + 2]
        );
        // The difference of two counts is right across the wrap.
        assert_eq!(walked[4].wrapping_sub(walked[0]), 4);
    }

    #[test]
    fn interpolation_error_has_its_orders_and_amplitudes() {
        let config = EncoderConfig::default();
        let n = 1000;
        let errors: Vec<f64> = (0..n)
            .map(|i| {
                let x = config.period_m * f64::from(i) / f64::from(n);
                interpolated_m(&config, x) - x
            })
            .collect();
        let amplitude = |order: f64| {
            let (mut re, mut im) = (0.0, 0.0);
            for (i, e) in errors.iter().enumerate() {
                let (s, c) = (TAU * order * i as f64 / f64::from(n)).sin_cos();
                re += e * c;
                im += e * s;
            }
            2.0 * re.hypot(im) / f64::from(n)
        };
        assert!((amplitude(1.0) - config.error_order1_m).abs() < 1e-12);
        assert!((amplitude(2.0) - config.error_order2_m).abs() < 1e-12);
        assert!(amplitude(3.0) < 1e-12);
        let peak = errors.iter().fold(0.0f64, |m, e| m.max(e.abs()));
        assert!(peak <= 0.01 * config.period_m, "{peak}");
        // No missing codes: the count never runs backwards.
        let counts: Vec<i32> = (0..20_000)
            .map(|i| count(&config, f64::from(i) * 1e-9))
            .collect();
        assert!(counts.windows(2).all(|w| w[1] >= w[0]));
    }
}
