//! Velocity and acceleration from a measured position: a zero-phase low-pass whose band is chosen from the data.

use crate::recording::Recording;
use preslide_fft::{Complex64, ComplexToReal, Planner, RealToComplex};
use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::Arc;

/// Share of the acceleration's power that may be noise in the chosen band. Noise in a regressor of power share
/// `q` biases its coefficient by `−q`, so this bounds the bias of the inertia at 0.1 % of where
/// velocity and direction explain none of the acceleration; [`Kinematics::reliable`](super::Kinematics::reliable) takes it off.
pub(super) const NOISE_SHARE: f64 = 1e-3;

/// Bins over which the noise is averaged, more than a recording has repeats.
const BINS: usize = 64;

/// Samples that the band is chosen from.
const MOST_SAMPLES: usize = 1 << 20;

/// Half the order of the Butterworth magnitude `1/(1 + (f/f_c)⁸)`: the response of a fourth-order filter run
/// forward and backward.
const STEEPNESS: i32 = 8;

/// Time constants of the filter by which every piece is continued at both ends.
const MARGIN: f64 = 5.0;

/// A zero-phase low-pass and its derivatives, for the pieces of one recording.
///
/// Works in the frequency domain on samples spaced evenly at the piece's mean sample time, each piece continued at its
/// ends by point reflection, which keeps value and slope. Pieces with uneven time stamps are interpolated
/// linearly to that spacing and back.
#[derive(Clone)]
pub struct ZeroPhase {
    cutoff_hz: f64,
    pieces: Vec<Piece>,
    samples: usize,
}

#[derive(Clone)]
struct Piece {
    rows: Range<usize>,
    /// Time stamps in sample times from the piece's first one; `None` where they are even.
    uneven: Option<Vec<f64>>,
    length: usize,
    margin: usize,
    sample_time: f64,
    /// What the low-pass keeps of each bin.
    kept: Vec<f64>,
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
}

impl Piece {
    /// `usual` is the recording's sample time, for a piece that has none of its own. The others keep to theirs,
    /// so that runs of very different rates stay as long as they are.
    fn new(
        planner: &mut Planner,
        t_s: &[f64],
        rows: Range<usize>,
        usual: f64,
        cutoff_hz: f64,
    ) -> Self {
        let t = &t_s[rows.clone()];
        // The loader brings uneven samples to even times: their mean step is the step.
        let sample_time = match t {
            [first, .., last] if last > first => (last - first) / (t.len() - 1) as f64,
            _ => usual,
        };
        let places: Vec<f64> = t.iter().map(|t_i| (t_i - t[0]) / sample_time).collect();
        let even = places
            .iter()
            .enumerate()
            .all(|(i, place)| (place - i as f64).abs() < 0.05);
        let length = places.last().map_or(0, |last| last.round() as usize) + 1;
        let margin = (MARGIN / (cutoff_hz * sample_time)).ceil() as usize;
        let margin = margin.min(length.saturating_sub(1));
        let size = smooth_size(length + 2 * margin + 2);
        let bin = 1.0 / (size as f64 * sample_time);
        let kept = (0..=size / 2).map(|i| magnitude(i as f64 * bin / cutoff_hz));
        Self {
            kept: kept.collect(),
            rows,
            uneven: (!even).then_some(places),
            length,
            margin,
            sample_time,
            forward: planner.forward(size),
            inverse: planner.inverse(size),
        }
    }

    /// The piece on an even grid, continued at both ends and closed smoothly to a circle.
    fn continued(&self, values: &[f64]) -> Vec<f64> {
        let even = match &self.uneven {
            None => values.to_vec(),
            Some(places) => interpolate(places, values, self.length),
        };
        let (first, last) = (even[0], even[even.len() - 1]);
        let before = even[1..=self.margin].iter().rev().map(|v| 2.0 * first - v);
        let inner = even.len() - 1 - self.margin..even.len() - 1;
        let after = even[inner].iter().rev().map(|v| 2.0 * last - v);
        let mut circle: Vec<f64> = before.chain(even.iter().copied()).chain(after).collect();
        let (from, to) = (circle[circle.len() - 1], circle[0]);
        let open = self.forward.len() - circle.len();
        circle.extend((0..open).map(|i| {
            let part = (i + 1) as f64 / (open + 1) as f64;
            from + (to - from) * (0.5 - 0.5 * (0.5 * TAU * part).cos())
        }));
        circle
    }

    fn spectrum(&self, values: &[f64]) -> Vec<Complex64> {
        let mut circle = self.continued(values);
        let mut spectrum = self.forward.make_output_vec();
        // The lengths come from the plan itself, the only thing that can be wrong.
        let planned = self.forward.process(&mut circle, &mut spectrum);
        debug_assert!(planned.is_ok());
        spectrum
    }

    fn frequency(&self, bin: usize) -> f64 {
        bin as f64 / (self.forward.len() as f64 * self.sample_time)
    }

    fn back(&self, mut spectrum: Vec<Complex64>, out: &mut [f64]) {
        if let Some(first) = spectrum.first_mut() {
            first.im = 0.0;
        }
        if let Some(last) = spectrum.last_mut() {
            last.im = 0.0;
        }
        let mut circle = self.inverse.make_output_vec();
        let planned = self.inverse.process(&mut spectrum, &mut circle);
        debug_assert!(planned.is_ok());
        let scale = 1.0 / circle.len() as f64;
        let even = &circle[self.margin..self.margin + self.length];
        match &self.uneven {
            None => out.copy_from_slice(even),
            Some(places) => {
                for (out, place) in out.iter_mut().zip(places) {
                    let low = (place.floor() as usize).min(self.length.saturating_sub(2));
                    let part = place - low as f64;
                    let high = even.get(low + 1).copied().unwrap_or(even[low]);
                    *out = even[low] + part * (high - even[low]);
                }
            }
        }
        out.iter_mut().for_each(|v| *v *= scale);
    }
}

/// The next size whose only prime factors are 2, 3 and 5, which the transform does fastest.
fn smooth_size(at_least: usize) -> usize {
    (at_least..)
        .find(|&size| {
            let mut rest = size;
            for prime in [2, 3, 5] {
                while rest % prime == 0 {
                    rest /= prime;
                }
            }
            rest == 1 && size % 2 == 0
        })
        .unwrap_or(at_least)
}

/// Linear interpolation of `values` at ascending `places` to `0, 1, … length − 1`.
fn interpolate(places: &[f64], values: &[f64], length: usize) -> Vec<f64> {
    let mut low = 0;
    (0..length)
        .map(|i| {
            let place = i as f64;
            while low + 2 < places.len() && places[low + 1] < place {
                low += 1;
            }
            let high = (low + 1).min(places.len() - 1);
            let width = places[high] - places[low];
            if width <= 0.0 {
                return values[low];
            }
            let part = ((place - places[low]) / width).clamp(0.0, 1.0);
            values[low] + part * (values[high] - values[low])
        })
        .collect()
}

/// Periods of the cut-off over which the filter spreads a sample, and in which it knows the motion beside a gap from one side only:
/// accelerations there are half made up, and eight lost stretches of half a second took 1.2 % off a mass.
const REACH: f64 = 0.5;

impl ZeroPhase {
    /// A filter with the cut-off (−6 dB) `cutoff_hz` for the samples of `recording`.
    pub fn new(recording: &Recording, cutoff_hz: f64) -> Self {
        let usual = recording.sample_time_s();
        let mut planner = Planner::new();
        Self {
            cutoff_hz,
            pieces: recording
                .pieces
                .iter()
                .filter(|rows| !rows.is_empty())
                .map(|rows| {
                    Piece::new(&mut planner, &recording.t_s, rows.clone(), usual, cutoff_hz)
                })
                .collect(),
            samples: recording.t_s.len(),
        }
    }

    /// The widest band in which at most 0.1 % of the acceleration's power is noise.
    ///
    /// The noise of the position is taken as white at the level of the spectrum's top octave: the median of the
    /// means of 64 bins each. The median, so that a resonance does not count; the means, because a motion that
    /// repeats exactly repeats its quantisation error too, and leaves most bins between the harmonics empty. Never above a fifth of the sample rate, nor below ten periods of the longest
    /// piece.
    pub fn choose(recording: &Recording) -> Self {
        Self::new(recording, Self::choose_cutoff(recording))
    }

    /// The cut-off (Hz) of [`choose`](Self::choose): that of the longest piece.
    pub fn choose_cutoff(recording: &Recording) -> f64 {
        let longest = recording.pieces.iter().max_by_key(|rows| rows.len());
        let cutoff = longest.map(|piece| Self::cutoff_of(recording, piece));
        cutoff.unwrap_or(0.2 / recording.sample_time_s())
    }

    /// Of joined files the highest of their own cut-offs (Hz): fewer samples would hide how the one moves that moves fastest.
    pub fn highest_cutoff(recording: &Recording) -> f64 {
        let of_file = |file: &Range<usize>| {
            let own = recording.pieces.iter();
            let own = own.filter(|piece| file.start <= piece.start && piece.end <= file.end);
            own.max_by_key(|rows| rows.len())
        };
        let longest = recording.joined.iter().filter_map(of_file);
        let cutoffs = longest.map(|piece| Self::cutoff_of(recording, piece));
        cutoffs.fold(Self::choose_cutoff(recording), f64::max)
    }

    fn cutoff_of(recording: &Recording, longest: &Range<usize>) -> f64 {
        let sample_time = recording.sample_time_s();
        let highest = 0.2 / sample_time;
        // A million samples suffice for the band; the middle of the motion, not its rest before and after.
        let spare = longest.len().saturating_sub(MOST_SAMPLES) / 2;
        let longest = &(longest.start + spare..longest.end - spare);
        let lowest = (10.0 / (longest.len() as f64 * sample_time)).min(highest);
        let piece = Piece::new(
            &mut Planner::new(),
            &recording.t_s,
            longest.clone(),
            sample_time,
            lowest,
        );
        // A piece that is cut out of a motion ends elsewhere than it begins: without the line between them, which has no acceleration,
        // the circle would close with a jump.
        let position = &recording.position[longest.clone()];
        let (first, last) = (position[0], position[position.len() - 1]);
        let slope = (last - first) / (position.len().max(2) - 1) as f64;
        let level: Vec<f64> = (0..)
            .zip(position)
            .map(|(i, x)| x - slope * f64::from(i))
            .collect();
        let power: Vec<f64> = piece
            .spectrum(&level)
            .iter()
            .map(|c| c.norm_sqr())
            .collect();
        let mut top: Vec<f64> = power[power.len() / 2..]
            .chunks(BINS)
            .map(|bins| bins.iter().sum::<f64>() / bins.len() as f64)
            .collect();
        top.sort_by(f64::total_cmp);
        let noise = top[top.len() / 2];
        let noise_share = |cutoff: f64| {
            let (mut of_noise, mut of_all) = (0.0, 0.0);
            for (bin, p) in power.iter().enumerate().skip(1) {
                let f = piece.frequency(bin);
                let weight = (f * f * magnitude(f / cutoff)).powi(2);
                of_noise += weight * noise;
                of_all += weight * p;
            }
            of_noise / of_all
        };
        let steps = 60;
        (0..=steps)
            .map(|i| highest * (lowest / highest).powf(f64::from(i) / f64::from(steps)))
            .find(|&cutoff| noise_share(cutoff) <= NOISE_SHARE)
            .unwrap_or(lowest)
    }

    /// The cut-off (−6 dB) (Hz).
    pub fn cutoff_hz(&self) -> f64 {
        self.cutoff_hz
    }

    /// What it keeps of a wave of this frequency.
    pub fn keeps(&self, hz: f64) -> f64 {
        magnitude(hz / self.cutoff_hz)
    }

    /// Samples to each side over which the filter spreads one.
    pub fn reach(&self, recording: &Recording) -> usize {
        (REACH / (self.cutoff_hz * recording.sample_time_s())).ceil() as usize
    }

    /// The low-passed `values`, one for every sample of the recording.
    pub fn smooth(&self, values: &[f64]) -> Vec<f64> {
        self.derivative(values, 0)
    }

    /// The low-passed derivative of the given order with respect to time.
    pub fn derivative(&self, values: &[f64], order: u32) -> Vec<f64> {
        let mut out = vec![0.0; self.samples];
        for piece in &self.pieces {
            let mut spectrum = piece.spectrum(&values[piece.rows.clone()]);
            spectrum
                .iter_mut()
                .zip(&piece.kept)
                .for_each(|(c, kept)| *c *= kept);
            for _ in 0..order {
                let bins = spectrum.iter_mut().enumerate();
                bins.for_each(|(bin, c)| *c *= Complex64::new(0.0, TAU * piece.frequency(bin)));
            }
            piece.back(spectrum, &mut out[piece.rows.clone()]);
        }
        out
    }
}

fn magnitude(relative: f64) -> f64 {
    1.0 / (1.0 + relative.powi(STEEPNESS))
}
