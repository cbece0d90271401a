//! Fewer samples of a recording that is sampled far beyond the band that matters.

use crate::report::figures::quantity;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::ops::Range;

use super::Recording;
use super::samples::ranges;

/// Half of the filter's length, in samples that are kept.
const HALF: usize = 6;

/// Its cut-off, relative to the new sample rate. With a Blackman window of this length it is flat to 0.12 and closed from
/// 0.58 on, so that nothing folds below 0.42 of the new rate.
const CUTOFF: f64 = 0.35;

impl Recording {
    /// Every `factor`-th sample of each piece, low-passed before so that nothing folds into the band up to an eighth of the
    /// new rate. Numbers of segments and repeats are those of the samples that are kept.
    pub fn decimated(&self, factor: usize) -> Recording {
        if factor < 2 {
            return self.clone();
        }
        let weights = blackman_sinc(factor);
        let numbers = |values: &[f64]| -> Vec<f64> {
            let of = |piece: &Range<usize>| low_passed(&values[piece.clone()], factor, &weights);
            self.pieces.iter().flat_map(of).collect()
        };
        fn kept<T: Copy>(values: &[T], pieces: &[Range<usize>], factor: usize) -> Vec<T> {
            let of = |p: &Range<usize>| values[p.clone()].iter().copied().step_by(factor);
            pieces.iter().flat_map(of).collect()
        }
        let t_s = kept(&self.t_s, &self.pieces, factor);
        let labels = |values: &[u32]| kept(values, &self.pieces, factor);
        let pieces = ranges(&self.pieces, |piece| piece.len().div_ceil(factor));
        let joined = ranges(&self.joined, |run| {
            let of_run = self.pieces.iter().filter(|p| run.contains(&p.start));
            of_run.map(|p| p.len().div_ceil(factor)).sum()
        });
        let mut fewer = self.with_samples(t_s, pieces, joined, numbers, labels);
        fewer.sample_time_s *= factor as f64;
        fewer.warnings.push(warning!(
            "decimated",
            "one sample in {factor} of {} is kept, low-passed: {} apart",
            self.len(),
            quantity(fewer.sample_time_s, "s")
        ));
        fewer
    }
}

/// The filter's weights from the middle to its end; all of them together sum to 1.
pub(super) fn blackman_sinc(factor: usize) -> Vec<f64> {
    let half = HALF * factor;
    let weight = |i: usize| {
        let place = i as f64 / (half + 1) as f64;
        let window = 0.42 + 0.5 * (PI * place).cos() + 0.08 * (2.0 * PI * place).cos();
        let phase = 2.0 * PI * CUTOFF * i as f64 / factor as f64;
        window * if i == 0 { 1.0 } else { phase.sin() / phase }
    };
    let mut weights: Vec<f64> = (0..=half).map(weight).collect();
    let sum = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
    weights.iter_mut().for_each(|w| *w /= sum);
    weights
}

/// The low-passed values at every `factor`-th sample, continued at the ends by point reflection.
pub(super) fn low_passed(values: &[f64], factor: usize, weights: &[f64]) -> Vec<f64> {
    let Some(last) = values.len().checked_sub(1) else {
        return Vec::new();
    };
    let at = |i: isize| {
        let end = last as isize;
        let inside = |i: isize| values[i.clamp(0, end) as usize];
        if i < 0 {
            2.0 * values[0] - inside(-i)
        } else if i > end {
            2.0 * values[last] - inside(2 * end - i)
        } else {
            inside(i)
        }
    };
    let half = weights.len() - 1;
    let one = |i: usize| {
        if i >= half && i + half <= last {
            let (before, after) = (values[i - half..i].iter().rev(), &values[i + 1..]);
            let pairs = before.zip(after).zip(&weights[1..]);
            return weights[0] * values[i] + pairs.map(|((a, b), w)| w * (a + b)).sum::<f64>();
        }
        let i = i as isize;
        let pairs = weights.iter().enumerate().skip(1);
        weights[0] * at(i)
            + pairs
                .map(|(k, w)| w * (at(i - k as isize) + at(i + k as isize)))
                .sum::<f64>()
    };
    (0..=last / factor)
        .into_par_iter()
        .map(|k| one(k * factor))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_in_the_band_stays_and_what_would_fold_is_gone() {
        let factor = 8;
        let weights = blackman_sinc(factor);
        for (frequency, least, most) in [
            (0.0, 0.99999, 1.00001),
            (0.05, 0.999, 1.001),
            (0.12, 0.98, 1.001),
            (0.6, 0.0, 1e-3),
            (0.95, 0.0, 1e-3),
        ] {
            let wave: Vec<f64> = (0..4000)
                .map(|i| (2.0 * PI * frequency * f64::from(i) / factor as f64 + 0.3).sin())
                .collect();
            let kept = low_passed(&wave, factor, &weights);
            let inner = &kept[20..kept.len() - 20];
            let rms = (inner.iter().map(|v| v * v).sum::<f64>() / inner.len() as f64).sqrt();
            let whole = (wave.iter().map(|v| v * v).sum::<f64>() / wave.len() as f64).sqrt();
            let gain = rms / whole;
            assert!(
                (least - 0.01 * least..=most + 0.01 * most).contains(&gain),
                "{frequency}: {gain}"
            );
        }
        let line: Vec<f64> = (0..1001).map(f64::from).collect();
        let kept = low_passed(&line, factor, &weights);
        assert!(
            kept.iter()
                .zip(line.iter().step_by(factor))
                .all(|(a, b)| (a - b).abs() < 1e-9),
            "the ends too"
        );
    }
}
