//! Periods in position and in time that stand out of the mismatch.

use crate::statistics::{bounds, quantile_between_ranks};
use preslide_fft::Planner;
use std::f64::consts::TAU;
use std::ops::RangeInclusive;

/// Peaks kept of one spectrum.
const PEAKS: usize = 4;
/// Share of the whole that the places' own spectrum has at the teeth of a comb: of places that lie anywhere it has next to nothing, of
/// those that a sine passes less than a tenth.
const COMB: f64 = 0.25;
/// Most bins.
const MOST: usize = 1 << 18;

/// Fewest periods of a vibration within the recording: slower is drift, or the motion itself.
const CYCLES: f64 = 20.0;

/// Fewest periods of a motion that goes to and fro at one frequency, and the share of its squares that must be there: a twentieth lost one of a blind
/// judge's vibrations.
const FEWEST: f64 = 4.0;
pub(super) const MOTION: f64 = 0.5;
/// Highest harmonic that such a motion makes: those of a friction that turns round with it are a twentieth of it there.
pub(super) const HARMONICS: u32 = 30;
/// Steps of the search for its frequency, each half of the last.
const HALVINGS: usize = 6;

/// How many times a vibration the effort's line has to be: what shakes an axis by itself is the whole of its line, or half where the loop
/// amplifies it.
const OWN: f64 = 3.0;
/// How many times its neighbourhood a line's power is.
const LINE: f64 = 30.0;
/// Where its neighbourhood is (in steps of one over the duration): beyond the window's main lobe.
const NEIGHBOURS: RangeInclusive<i32> = 4..=8;

/// The band (Hz) in which vibrations are looked for at some times, up to a frequency.
pub fn band(at: &[f64], most: f64) -> (f64, f64) {
    let (low, high) = bounds(at);
    (CYCLES / (high - low).max(1e-300), most)
}

/// Power over frequency.
struct Spectrum {
    power: Vec<f64>,
    /// Frequency of the first one, and from each to the next.
    from: f64,
    step: f64,
}

impl Spectrum {
    /// Of `weights` at the places or times `at`, between two frequencies (periods per unit of `at`); `None` where there is none.
    fn of(at: &[f64], weights: &[f64], from: f64, to: f64) -> Option<Self> {
        Self::of_parts(&[(at, weights)], from, to)
    }

    /// The sum of those of some parts, each with a phase of its own.
    fn of_parts(parts: &[(&[f64], &[f64])], from: f64, to: f64) -> Option<Self> {
        let span = |at: &[f64]| {
            let (low, high) = bounds(at);
            high - low
        };
        let longest = parts.iter().map(|(at, _)| span(at)).fold(0.0, f64::max);
        let mut all = parts
            .iter()
            .filter_map(|part| Self::within(*part, longest, from, to));
        let mut sum = all.next()?;
        for other in all {
            let both = sum.power.iter_mut().zip(other.power);
            both.for_each(|(sum, own)| *sum += own);
        }
        Some(sum)
    }

    /// That of one part, as finely as a span shows it.
    fn within((at, weights): (&[f64], &[f64]), span: f64, from: f64, to: f64) -> Option<Self> {
        let low = bounds(at).0;
        if at.is_empty() || span <= 0.0 || to <= from || !to.is_finite() {
            return None;
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
        let forward = Planner::new().forward(size);
        let mut spectrum = forward.make_output_vec();
        forward.process(&mut binned, &mut spectrum).ok()?;
        let (first, last) = ((from / step).ceil() as usize, (to / step) as usize);
        let inside = spectrum.get(first..=last.min(size / 2))?;
        Some(Self {
            power: inside.iter().map(|c| c.norm_sqr()).collect(),
            from: first as f64 * step,
            step,
        })
    }

    /// Frequency of the peak at or beside a value, by a parabola through the logarithms of three points.
    fn frequency(&self, i: usize) -> f64 {
        let l = |k: usize| self.power.get(k).map_or(f64::NAN, |p| p.max(1e-300).ln());
        let [before, at, after] = [i.wrapping_sub(1), i, i + 1].map(l);
        let bend = before - 2.0 * at + after;
        let off = if bend < 0.0 {
            0.5 * (before - after) / bend
        } else {
            0.0
        };
        self.from + (i as f64 + off.clamp(-0.5, 0.5)) * self.step
    }
}

/// The frequency at which `weights` have most power, however much there is around it. Places that many passes have in common make aliases
/// of a line that stand higher above quieter neighbourhoods, and never higher themselves.
pub fn strongest(at: &[f64], weights: &[f64], from: f64, to: f64) -> Option<f64> {
    let spectrum = Spectrum::of(at, weights, from, to)?;
    let power = spectrum.power.iter().enumerate();
    let (most, _) = power.max_by(|a, b| a.1.total_cmp(b.1))?;
    Some(spectrum.frequency(most))
}

/// The comb (periods per unit) on which places stand that a scan in steps stopped at; `None` where they lie anywhere.
pub fn comb(at: &[f64], from: f64, to: f64) -> Option<f64> {
    let Spectrum { power, from, step } = Spectrum::of(at, &vec![1.0; at.len()], from, to)?;
    let whole = (at.len() as f64).powi(2);
    // The first of its harmonics.
    let first = power.iter().position(|p| *p > COMB * whole)?;
    let tooth = &power[first..];
    let fall = tooth.windows(2).position(|p| p[1] < p[0])?;
    Some(from + (first + fall) as f64 * step)
}

/// Lines, and what they are aliases of: on places of a comb a line looks like one at its distance from the nearest tooth, and at its
/// distance from the next one. All are tried, and what happens between the teeth tells them apart.
pub fn with_aliases(mut lines: Vec<f64>, comb: Option<f64>, from: f64) -> Vec<f64> {
    let Some(comb) = comb else { return lines };
    for line in lines.clone() {
        let near = (line - (line / comb).round() * comb).abs();
        lines.extend([near, comb - near].into_iter().filter(|nu| *nu >= from));
    }
    lines
}

/// Frequencies at which `weights` (the mismatch, at the places or times `at`) has lines: those whose power stands highest
/// above its neighbourhood. `from..to` in periods per unit of `at`.
pub fn lines(at: &[f64], weights: &[f64], from: f64, to: f64) -> Vec<f64> {
    lines_of(&[(at, weights)], from, to)
}

/// The same of some parts, each with a phase of its own: between files no clock runs.
pub fn lines_of(parts: &[(&[f64], &[f64])], from: f64, to: f64) -> Vec<f64> {
    let Some(spectrum) = Spectrum::of_parts(parts, from, to) else {
        return Vec::new();
    };
    let power = &spectrum.power;
    let count = power.len();
    if count < 8 {
        return Vec::new();
    }
    let around = 40.min(count / 4).max(2);
    let mut peaks: Vec<(f64, f64)> = (1..count - 1)
        .filter(|&i| power[i] >= power[i - 1] && power[i] >= power[i + 1])
        .map(|i| {
            let near = &power[i.saturating_sub(around)..(i + around).min(count)];
            (
                power[i] / quantile_between_ranks(near, 0.5).max(1e-300),
                spectrum.frequency(i),
            )
        })
        .collect();
    peaks.sort_by(|a, b| b.0.total_cmp(&a.0));
    peaks.truncate(PEAKS);
    peaks.into_iter().map(|p| p.1).collect()
}

/// Whether a frequency (Hz) is a harmonic of a motion, whose `position` at the times `at` goes to and fro at one, as near as their duration tells:
/// whatever turns round with the motion has lines at all of them.
pub fn is_harmonic(at: &[f64], position: &[f64], hz: f64) -> bool {
    let mean = position.iter().sum::<f64>() / position.len().max(1) as f64;
    let about: Vec<f64> = position.iter().map(|x| x - mean).collect();
    let (low, high) = bounds(at);
    let span = high - low;
    let Some(mut own) = strongest(at, &about, FEWEST / span, hz) else {
        return false;
    };
    let power = |hz: f64| {
        let turns = at.iter().zip(&about).map(|(t, x)| {
            let (sin, cos) = (TAU * hz * (t - low)).sin_cos();
            [x * cos, x * sin]
        });
        let [c, s] = turns.fold([0.0; 2], |[c, s], [a, b]| [c + a, s + b]);
        c * c + s * s
    };
    // Its harmonics are as many times as far off as it.
    let mut step = 0.1 / span;
    for _ in 0..HALVINGS {
        let beside = [own - step, own, own + step];
        own = *beside
            .iter()
            .max_by(|a, b| power(**a).total_cmp(&power(**b)))
            .unwrap_or(&own);
        step *= 0.5;
    }
    let squares: f64 = about.iter().map(|x| x * x).sum();
    let share = 2.0 * power(own) / (about.len() as f64 * squares).max(1e-300);
    let order = (hz / own).round();
    let apart = (hz - order * own).abs();
    order <= f64::from(HARMONICS) && share > MOTION && apart * span <= 1.0
}

/// Whether a vibration (its force at the times `at`) keeps step with the motion: at its frequency (Hz) the effort has a line that is much
/// larger.
pub fn keeps_step(at: &[f64], vibration: &[f64], effort: &[f64], hz: f64) -> bool {
    let (low, high) = bounds(at);
    let span = high - low;
    let power = |values: &[f64], hz: f64| {
        let turns = at.iter().zip(values).map(|(t, v)| {
            let along = (t - low) / span;
            let (sin, cos) = (TAU * hz * (t - low)).sin_cos();
            let weighted = v * (1.0 - (TAU * along).cos());
            [weighted * cos, weighted * sin]
        });
        let [c, s] = turns.fold([0.0; 2], |[c, s], [a, b]| [c + a, s + b]);
        c * c + s * s
    };
    let aside = |k: i32| power(effort, hz + f64::from(k) / span);
    let own = aside(0);
    let stands_out = || {
        let near: Vec<f64> = NEIGHBOURS.flat_map(|k| [aside(-k), aside(k)]).collect();
        own > LINE * near.iter().sum::<f64>() / near.len() as f64
    };
    own > OWN * OWN * power(vibration, hz) && stands_out()
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
        let expected = 7.3 / TAU;
        assert!(
            (found[0] / expected - 1.0).abs() < 0.01,
            "{found:?}, not {expected}"
        );
    }

    #[test]
    fn finds_the_frequency_of_parts_whose_phases_cancel() {
        let at: Vec<f64> = (0..600).map(|i| f64::from(i) * 0.01).collect();
        let wave = |phase: f64| at.iter().map(|t| (TAU * 11.3 * t + phase).cos()).collect();
        let parts: Vec<Vec<f64>> = (0..6).map(|i| wave(f64::from(i) * TAU / 6.0)).collect();
        let parts: Vec<(&[f64], &[f64])> = parts.iter().map(|p| (&at[..], &p[..])).collect();
        let found = lines_of(&parts, 2.0, 40.0);
        assert!((found[0] - 11.3).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn a_line_of_the_motion_keeps_step_with_it_and_a_vibration_does_not() {
        let at: Vec<f64> = (0..4000).map(|i| f64::from(i) * 0.01).collect();
        let wave = |hz: f64| move |t: &f64| (TAU * hz * t).sin();
        let effort: Vec<f64> = at
            .iter()
            .map(|t| 3.0 * wave(2.35)(t) + wave(7.7)(t))
            .collect();
        let left: Vec<f64> = at.iter().map(wave(7.7)).map(|v| 0.2 * v).collect();
        assert!(keeps_step(&at, &left, &effort, 7.7));
        // What shakes it by itself is all that the effort has at its frequency, or stands beside the motion's lines.
        let shaken: Vec<f64> = at.iter().map(wave(7.7)).map(|v| 0.8 * v).collect();
        assert!(!keeps_step(&at, &shaken, &effort, 7.7));
        let beside: Vec<f64> = at.iter().map(wave(7.9)).map(|v| 0.2 * v).collect();
        assert!(!keeps_step(&at, &beside, &effort, 7.9));
    }

    #[test]
    fn a_force_that_reverses_with_the_motion_has_its_harmonics() {
        let at: Vec<f64> = (0..9000).map(|i| f64::from(i) * 0.01).collect();
        let triangle: Vec<f64> = at.iter().map(|t| (TAU * 0.25 * t).sin().asin()).collect();
        for (hz, told) in [(3.25, true), (2.0, true), (3.37, false), (11.3, false)] {
            assert_eq!(is_harmonic(&at, &triangle, hz), told, "{hz}");
        }
    }

    #[test]
    fn positions_on_a_comb_have_aliases_and_others_have_none() {
        // Steps of 0.05, a hundredth of that off; a wave of period 0.08.
        let at: Vec<f64> = (0..600)
            .map(|i| f64::from(i / 10) * 0.05 + 5e-4 * (f64::from(i) * 0.7).sin())
            .collect();
        let found = comb(&at, 0.5, 500.0).expect("a comb");
        assert!((found / 20.0 - 1.0).abs() < 0.01, "{found}");
        let lines = with_aliases(vec![367.5], Some(20.0), 0.5);
        assert_eq!(lines, [367.5, 7.5, 12.5]);
        let swing: Vec<f64> = (0..4000)
            .map(|i| 5.0 * (f64::from(i) * 0.003).sin())
            .collect();
        assert_eq!(comb(&swing, 0.15, 40.0), None);
    }
}
