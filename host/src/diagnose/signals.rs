//! The coordinates that can organise a mismatch, at every sample.

use super::column::{Kind, Own};
use preslide_fit::recording::{MotionKind, Recording};
use preslide_fit::signal::Kinematics;
use preslide_fit::signal::ZeroPhase;
use preslide_fit::statistics::{bounds, quantile_between_ranks};
use std::ops::Range;

/// A reversal counts once the motion came back by this share of the travel, or by six times the encoder's noise.
const HYSTERESIS: f64 = 0.003;
/// The same in deviations of the position's noise, and not less.
const TURN: f64 = 6.0;
/// Strokes end at the same places where the ends scatter by less than this share of the travel.
const SAME_ENDS: f64 = 0.03;
/// Speeds below this share of the highest are rest.
const REST: f64 = 0.01;

/// Where, when and how the axis moved.
pub struct Signals {
    /// Sample time (s).
    pub dt: f64,
    /// Time (s), from the first sample, running on over pieces.
    pub t: Vec<f64>,
    /// Measured position (m or rad).
    pub x: Vec<f64>,
    /// The same within the band of the kinematics (m or rad), zero-phase.
    pub smooth: Vec<f64>,
    /// RMS of what that leaves: counts and noise of the encoder (m or rad).
    pub position_noise: f64,
    /// Velocity (m/s or rad/s), zero-phase.
    pub v: Vec<f64>,
    /// Acceleration (m/s² or rad/s²), zero-phase.
    pub a: Vec<f64>,
    /// Direction of the stroke, ±1.
    pub direction: Vec<f64>,
    /// Displacement since the last reversal (m or rad), not negative.
    pub since_reversal: Vec<f64>,
    /// Length of the stroke before the last reversal (m or rad).
    pub last_stroke: Vec<f64>,
    /// Travelled path (m or rad).
    pub path: Vec<f64>,
    /// Duration of the last rest (s); 0 before the first one.
    pub dwell: Vec<f64>,
    /// Commanded position (m or rad), where recorded.
    pub reference: Option<Vec<f64>>,
    /// Temperature (°C), where recorded.
    pub temperature: Option<Vec<f64>>,
    /// Load (N), where recorded.
    pub load: Option<Vec<f64>>,
    /// Further columns of the recording, such as another axis's position: name and values as written.
    pub extra: Vec<(String, Vec<f64>)>,
    /// Further columns that are this axis's motion or effort once more, with what they are.
    pub left_out: Vec<(String, Kind)>,
    /// Whether the axis turns.
    pub rotary: bool,
    /// Contiguous samples.
    pub pieces: Vec<Range<usize>>,
    /// Number of the repeat of the motion that every sample is in.
    pub repeat: Vec<u32>,
    /// Samples between which the clock tells the time: one range, or one a file.
    pub sessions: Vec<Range<usize>>,
    /// Fold of every sample.
    pub fold: Vec<usize>,
    /// Number of folds.
    pub folds: usize,
    /// Reversals found.
    pub reversals: usize,
    /// Band of the kinematics (Hz).
    pub band_hz: f64,
    filter: ZeroPhase,
}

impl Signals {
    /// Derives the coordinates of a recording.
    pub fn of(recording: &Recording) -> Self {
        let kinematics = Kinematics::of(recording);
        let x = recording.position.clone();
        let smooth = kinematics.filter.smooth(&x);
        let (low, high) = bounds(&x);
        let noise = (x
            .iter()
            .zip(&smooth)
            .map(|(a, b)| (a - b).powi(2))
            .sum::<f64>()
            / x.len() as f64)
            .sqrt();
        let threshold = (HYSTERESIS * (high - low)).max(TURN * noise);
        let dt = recording.sample_time_s();
        let n = x.len();
        let mut s = Self {
            dt,
            t: running_time(recording),
            v: kinematics.velocity,
            a: kinematics.acceleration,
            direction: vec![0.0; n],
            since_reversal: vec![0.0; n],
            last_stroke: vec![high - low; n],
            path: vec![0.0; n],
            dwell: vec![0.0; n],
            reference: recording.reference.clone(),
            temperature: recording.temperature_c.clone(),
            load: recording.load_n.clone(),
            extra: Vec::new(),
            left_out: Vec::new(),
            rotary: recording.kind == MotionKind::Rotary,
            pieces: recording.pieces.clone(),
            repeat: recording.repeat.clone(),
            sessions: std::iter::once(0..n).collect(),
            fold: vec![0; n],
            folds: 0,
            reversals: 0,
            band_hz: kinematics.filter.cutoff_hz(),
            filter: kinematics.filter,
            position_noise: noise,
            x,
            smooth: Vec::new(),
        };
        let own = Own {
            motion: [&s.x, &s.v, &s.a],
            effort: &recording.effort,
            dt,
        };
        let told = recording
            .extra
            .iter()
            .map(|e| (e, Kind::of(&e.values, &own)));
        let (others, own): (Vec<_>, Vec<_>) = told.partition(|(_, kind)| *kind == Kind::Other);
        s.extra = others
            .into_iter()
            .map(|(e, _)| (e.name.clone(), e.values.clone()))
            .collect();
        s.left_out = own
            .into_iter()
            .map(|(e, kind)| (e.name.clone(), kind))
            .collect();
        s.strokes(&smooth, threshold);
        s.smooth = smooth;
        s.paths(REST * s.top_speed());
        s
    }

    /// The same with every turn that stands out of the position's noise, however short the way back.
    pub fn with_every_turn(mut self) -> Self {
        let smooth = std::mem::take(&mut self.smooth);
        self.strokes(&smooth, TURN * self.position_noise);
        self.smooth = smooth;
        self
    }

    /// Direction and displacement since reversal, with hysteresis.
    fn strokes(&mut self, x: &[f64], threshold: f64) {
        let mut turns = vec![0];
        let mut direction = 0.0;
        let (mut low, mut high) = (0, 0);
        let mut directions = Vec::new();
        for i in 0..x.len() {
            if x[i] < x[low] {
                low = i;
            }
            if x[i] > x[high] {
                high = i;
            }
            if direction <= 0.0 && x[i] - x[low] > threshold {
                if direction < 0.0 {
                    turns.push(low);
                }
                directions.push(1.0);
                (direction, high) = (1.0, i);
            } else if direction >= 0.0 && x[high] - x[i] > threshold {
                if direction > 0.0 {
                    turns.push(high);
                }
                directions.push(-1.0);
                (direction, low) = (-1.0, i);
            }
        }
        self.reversals = turns.len() - 1;
        let mut last = f64::INFINITY;
        for (k, &start) in turns.iter().enumerate() {
            let end = turns.get(k + 1).copied().unwrap_or(x.len());
            let sign = directions.get(k).copied().unwrap_or(1.0);
            for i in start..end {
                self.direction[i] = sign;
                self.since_reversal[i] = (sign * (x[i] - x[start])).max(0.0);
                if last.is_finite() {
                    self.last_stroke[i] = last;
                }
            }
            last = (x[end - 1] - x[start]).abs();
        }
    }

    /// First samples of the strokes that follow a reversal.
    pub fn turns(&self) -> impl Iterator<Item = usize> {
        let pairs = self.direction.windows(2).enumerate();
        pairs
            .filter(|(_, pair)| pair[0] != pair[1])
            .map(|(i, _)| i + 1)
    }

    /// Derivative by time of a column, with the filter of the velocity: zero-phase.
    pub fn smooth_slope(&self, values: &[f64]) -> Vec<f64> {
        self.filter.derivative(values, 1)
    }

    /// Values at the samples within the band of the kinematics.
    pub fn smoothed(&self, values: &[f64]) -> Vec<f64> {
        self.filter.smooth(values)
    }

    /// Distance between the outermost positions (m or rad).
    pub fn travel(&self) -> f64 {
        let (low, high) = bounds(&self.x);
        high - low
    }

    /// Time from the first sample to the last (s).
    pub fn duration(&self) -> f64 {
        self.t.last().copied().unwrap_or(0.0)
    }

    /// Highest speed (m/s or rad/s).
    pub fn top_speed(&self) -> f64 {
        self.v.iter().fold(0.0, |top, v| top.max(v.abs()))
    }

    /// The speed that the share `q` of the moving samples stays below (m/s or rad/s).
    pub fn moving_speed(&self, q: f64) -> f64 {
        let still = REST * self.top_speed();
        let speeds = self.v.iter().map(|v| v.abs());
        let moving: Vec<f64> = speeds.filter(|v| *v > still).collect();
        quantile_between_ranks(&moving, q)
    }

    /// Low and high speed of the moving samples: the 5 % and 95 % quantiles (m/s or rad/s).
    pub fn speeds(&self) -> (f64, f64) {
        (self.moving_speed(0.05), self.moving_speed(0.95))
    }

    /// Whether every stroke runs between the same ends, so that position and displacement since reversal are one coordinate.
    pub fn same_ends(&self) -> bool {
        let (low, high) = bounds(&self.x);
        let samples = self.x.iter().zip(&self.since_reversal).zip(&self.direction);
        // Where the recording begins within a stroke nobody knows.
        let first = self.turns().next().unwrap_or_default();
        let off = samples.skip(first).map(|((x, since), direction)| {
            let expected = if *direction > 0.0 {
                low + since
            } else {
                high - since
            };
            (x - expected).powi(2)
        });
        let rms = (off.sum::<f64>() / (self.x.len() - first).max(1) as f64).sqrt();
        self.reversals > 2 && rms < SAME_ENDS * (high - low)
    }

    /// The kind of the stroke that each sample belongs to: strokes in the order of their highest speeds, cut into `count` kinds of
    /// as many samples each.
    pub fn kinds_of_strokes(&self, count: usize) -> Vec<usize> {
        let mut strokes: Vec<(f64, std::ops::Range<usize>)> = Vec::new();
        for i in 0..self.x.len() {
            match strokes.last_mut() {
                Some((top, stroke)) if self.direction[i] == self.direction[stroke.start] => {
                    *top = self.v[i].abs().max(*top);
                    stroke.end = i + 1;
                }
                _ => strokes.push((self.v[i].abs(), i..i + 1)),
            }
        }
        strokes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut kinds = vec![0; self.x.len()];
        let mut before = 0;
        for (_, stroke) in strokes {
            let middle = before + stroke.len() / 2;
            before += stroke.len();
            kinds[stroke].fill(middle * count / self.x.len().max(1));
        }
        kinds
    }

    fn paths(&mut self, still: f64) {
        let (mut path, mut rest, mut dwell) = (0.0, 0.0, 0.0);
        for i in 0..self.x.len() {
            let speed = self.v[i].abs();
            if speed > still {
                path += speed * self.dt;
                if rest > 0.05 {
                    dwell = rest;
                }
                rest = 0.0;
            } else {
                rest += self.dt;
            }
            self.path[i] = path;
            self.dwell[i] = dwell;
        }
    }
}

/// Time from 0 that runs on where a joined recording starts its clock again.
fn running_time(recording: &Recording) -> Vec<f64> {
    let mut t = Vec::with_capacity(recording.len());
    let mut now = 0.0;
    for (i, &stamp) in recording.t_s.iter().enumerate() {
        if i > 0 {
            let step = stamp - recording.t_s[i - 1];
            now += if step > 0.0 {
                step
            } else {
                recording.sample_time_s()
            };
        }
        t.push(now);
    }
    t
}

/// Mean of some values.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}
