//! Periods in position and in time that stand out of the mismatch.

use super::rows::Rows;
use super::signals::{bounds, quantile};
use realfft::RealFftPlanner;

/// Peaks kept of one spectrum.
const PEAKS: usize = 4;
/// Most bins.
const MOST: usize = 1 << 18;

/// Fewest periods of a vibration within the recording: slower is drift, or the motion itself.
const CYCLES: f64 = 20.0;

/// The band (Hz) in which vibrations are looked for.
pub fn in_time(rows: &Rows) -> (f64, f64) {
    (
        CYCLES / rows.s.duration().max(1e-300),
        0.45 / rows.weak.half_width_s,
    )
}

/// Frequencies at which `weights` (the mismatch, at the places or times `at`) has lines: those whose power stands highest
/// above its neighbourhood. `from..to` in periods per unit of `at`.
pub fn lines(at: &[f64], weights: &[f64], from: f64, to: f64) -> Vec<f64> {
    let (low, high) = bounds(at);
    let span = high - low;
    if span <= 0.0 || to <= from || !to.is_finite() {
        return Vec::new();
    }
    // Summed into bins of a quarter of the shortest period and padded to three times the span.
    let bin = 0.25 / to;
    let size = ((3.0 * span / bin).ceil() as usize)
        .clamp(64, MOST)
        .next_power_of_two();
    let bin = bin.max(3.0 * span / size as f64);
    let step = 1.0 / (size as f64 * bin);
    let mut binned = vec![0.0; size];
    for (x, w) in at.iter().zip(weights) {
        let place = (x - low) / bin;
        let (left, part) = (place.floor(), place.fract());
        binned[left as usize % size] += w * (1.0 - part);
        binned[(left as usize + 1) % size] += w * part;
    }
    let forward = RealFftPlanner::<f64>::new().plan_fft_forward(size);
    let mut spectrum = forward.make_output_vec();
    if forward.process(&mut binned, &mut spectrum).is_err() {
        return Vec::new();
    }
    let (first, last) = ((from / step).ceil() as usize, (to / step) as usize);
    let power: Vec<f64> = spectrum
        .get(first..=last.min(size / 2))
        .unwrap_or_default()
        .iter()
        .map(|c| c.norm_sqr())
        .collect();
    let (count, from) = (power.len(), first as f64 * step);
    if count < 8 {
        return Vec::new();
    }
    let around = 40.min(count / 4).max(2);
    let mut peaks: Vec<(f64, f64)> = (1..count - 1)
        .filter(|&i| power[i] >= power[i - 1] && power[i] >= power[i + 1])
        .map(|i| {
            let near = &power[i.saturating_sub(around)..(i + around).min(count)];
            // Parabola through the logarithms of three points.
            let l = |k: usize| power[k].max(1e-300).ln();
            let bend = l(i - 1) - 2.0 * l(i) + l(i + 1);
            let off = if bend < 0.0 {
                0.5 * (l(i - 1) - l(i + 1)) / bend
            } else {
                0.0
            };
            (
                power[i] / quantile(near, 0.5).max(1e-300),
                from + (i as f64 + off.clamp(-0.5, 0.5)) * step,
            )
        })
        .collect();
    peaks.sort_by(|a, b| b.0.total_cmp(&a.0));
    peaks.truncate(PEAKS);
    peaks.into_iter().map(|p| p.1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_period_of_a_wave_over_uneven_places() {
        let at: Vec<f64> = (0..4000)
            .map(|i| 5.0 * (f64::from(i) * 0.003).sin())
            .collect();
        let wave: Vec<f64> = at.iter().map(|x| (7.3 * x + 0.4).cos()).collect();
        let found = lines(&at, &wave, 0.3, 4.0);
        let expected = 7.3 / std::f64::consts::TAU;
        assert!(
            (found[0] / expected - 1.0).abs() < 0.01,
            "{found:?}, not {expected}"
        );
    }
}
