//! What a perfect model would leave: friction that does not repeat, and noise.
//!
//! `r = F̂·(g + Σ u_j(s)) + K̂·w(s) + Σ d_j(t) + e`: a random gain `g` of each fold; relative variations `u` of the friction
//! level and a wander `w` of the hysteresis, correlated along the travelled path `s`; disturbances `d` correlated in time `t`; and
//! white noise, more of it where the friction is stiff, as a quantised position makes it. Each is an Ornstein–Uhlenbeck
//! process, so that a Kalman filter whitens a column in one pass, over gaps and at any speed (Rasmussen and Williams 2006,
//! app. B; Hartikainen and Särkkä 2010). Deviations and lengths come from the recording at hand, by maximum likelihood.

mod estimate;

use nalgebra::DMatrix;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::ops::Range;

/// Processes.
const PROCESSES: usize = 6;
/// What each acts through, and along what it is correlated.
const KINDS: [(Load, Clock); PROCESSES] = [
    (Load::Friction, Clock::Path),
    (Load::Friction, Clock::Path),
    (Load::Friction, Clock::Fold),
    (Load::Stiffness, Clock::Path),
    (Load::One, Clock::Time),
    (Load::One, Clock::Time),
];

#[derive(Clone, Copy)]
enum Load {
    Friction,
    Stiffness,
    One,
}

#[derive(Clone, Copy, PartialEq)]
enum Clock {
    Path,
    Time,
    Fold,
}

/// Parameters of the noise: logarithms of deviations and lengths.
#[derive(Clone, Copy, Debug)]
struct Parameters {
    /// Deviation of each process: relative, m (or rad), N (or N·m).
    deviation: [f64; PROCESSES],
    /// Correlation length of each process: m (or rad), or s.
    length: [f64; PROCESSES],
    /// White noise (N or N·m).
    white: f64,
    /// White noise of the position (m or rad).
    position: f64,
}

impl Parameters {
    const COUNT: usize = 2 * PROCESSES + 2;

    fn slot(&mut self, index: usize) -> &mut f64 {
        match index {
            i if i < PROCESSES => &mut self.deviation[i],
            i if i < 2 * PROCESSES => &mut self.length[i - PROCESSES],
            i if i == 2 * PROCESSES => &mut self.white,
            _ => &mut self.position,
        }
    }
}

/// Where the rows are, and what the processes act through there.
pub struct Course<'a> {
    /// Rows of each fold.
    pub folds: &'a [Range<usize>],
    /// Time (s).
    pub time: &'a [f64],
    /// Travelled path (m or rad).
    pub path: &'a [f64],
    /// Fitted friction (N or N·m).
    pub friction: &'a [f64],
    /// Its slope over position (N/m or N·m/rad).
    pub stiffness: &'a [f64],
    /// Length of a typical stroke (m or rad).
    pub stroke: f64,
}

/// The Kalman filter at one row.
#[derive(Clone, Copy)]
struct Step {
    load: [f64; PROCESSES],
    gain: [f64; PROCESSES],
    /// What is left of each process one row on.
    kept: [f64; PROCESSES],
    /// Reciprocal of the innovation's deviation.
    weight: f64,
}

impl Step {
    /// The state one row on.
    fn advance(&self, state: &mut [f64; PROCESSES], innovation: f64) {
        for (j, x) in state.iter_mut().enumerate() {
            *x = self.kept[j] * (*x + self.gain[j] * innovation);
        }
    }
}

/// The noise model, ready to whiten.
#[derive(Clone)]
pub struct Noise {
    parameters: Parameters,
    folds: Vec<Range<usize>>,
    steps: Vec<Step>,
    /// Mean variance that noise and variability leave in a row.
    pub row_variance: f64,
}

impl Noise {
    /// White noise of the residual's size, before anything is known.
    pub fn white(residual: &[f64], course: &Course) -> Self {
        let rms = rms(residual).max(1e-300);
        let tiny = (1e-6 * rms).ln();
        let parameters = Parameters {
            deviation: [tiny; PROCESSES],
            length: [0.0; PROCESSES],
            white: rms.ln(),
            position: -100.0,
        };
        Self::of(parameters, course)
    }

    /// The same with white noise of at least this deviation, under which no row loses all of its weight.
    pub fn with_floor(&self, deviation: f64, course: &Course) -> Self {
        let mut parameters = self.parameters;
        parameters.white = parameters.white.max(deviation.max(1e-300).ln());
        Self::of(parameters, course)
    }

    fn of(parameters: Parameters, course: &Course) -> Self {
        let steps = filter(&parameters, course);
        let mut total = 0.0;
        for i in 0..course.time.len() {
            let load = loads(course, i);
            total += (0..PROCESSES)
                .map(|j| (load[j] * parameters.deviation[j].exp()).powi(2))
                .sum::<f64>()
                + white(&parameters, course, i);
        }
        Self {
            parameters,
            folds: course.folds.to_vec(),
            steps,
            row_variance: total / course.time.len().max(1) as f64,
        }
    }

    /// A whitened column.
    pub fn whitened(&self, column: &[f64]) -> Vec<f64> {
        let [out] = self.filtered([column]);
        out
    }

    /// Whitened columns, four to a pass: each row waits for the one before it, and four such chains take the time of one.
    pub fn whitened_all(&self, columns: &[&[f64]]) -> Vec<Vec<f64>> {
        let group = |group: &[&[f64]]| match *group {
            [a, b, c, d] => Vec::from(self.filtered([a, b, c, d])),
            _ => group.iter().map(|c| self.whitened(c)).collect(),
        };
        columns.par_chunks(4).flat_map(group).collect()
    }

    fn filtered<const N: usize>(&self, columns: [&[f64]; N]) -> [Vec<f64>; N] {
        let mut out = columns.map(|column| vec![0.0; column.len()]);
        for rows in &self.folds {
            let mut states = [[0.0; PROCESSES]; N];
            for i in rows.clone() {
                let s = &self.steps[i];
                for k in 0..N {
                    let innovation = columns[k][i] - dot(&s.load, &states[k]);
                    out[k][i] = innovation * s.weight;
                    s.advance(&mut states[k], innovation);
                }
            }
        }
        out
    }

    /// Share of some blocks of rows that hold the weight: 1 where all weigh alike, their reciprocal number where one has all of it.
    pub fn spread(&self, blocks: &[Range<usize>]) -> f64 {
        let weight = |rows: &Range<usize>| {
            let steps = &self.steps[rows.clone()];
            steps.iter().map(|s| s.weight.powi(2)).sum::<f64>()
        };
        let (sum, square) = blocks
            .iter()
            .map(weight)
            .fold((0.0, 0.0), |(sum, square), w| (sum + w, square + w * w));
        sum * sum / (square * blocks.len() as f64)
    }

    /// `V⁻¹r`: what is left of a residual, weighted by how well each row is known (the filter and its adjoint).
    pub fn inverse(&self, residual: &[f64]) -> Vec<f64> {
        let mut out = self.whitened(residual);
        for rows in &self.folds {
            let mut state = [0.0; PROCESSES];
            for i in rows.clone().rev() {
                let s = &self.steps[i];
                let after: [f64; PROCESSES] = std::array::from_fn(|j| s.kept[j] * state[j]);
                let value = out[i] * s.weight + dot(&s.gain, &after);
                state = std::array::from_fn(|j| after[j] - s.load[j] * value);
                out[i] = value;
            }
        }
        out
    }

    /// `count` whitened draws of the noise alone: white by construction.
    pub fn draws(&self, count: usize, seed: u64) -> Vec<DMatrix<f64>> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        self.folds
            .iter()
            .map(|rows| DMatrix::from_fn(rows.len(), count, |_, _| normal(&mut rng)))
            .collect()
    }

    /// Relative deviation of the friction level that does not repeat (–).
    pub fn variability(&self) -> f64 {
        self.parameters.deviation[..3]
            .iter()
            .map(|d| (2.0 * d).exp())
            .sum::<f64>()
            .sqrt()
    }

    /// Deviation of the noise that is no friction (N or N·m).
    pub fn disturbance(&self) -> f64 {
        let d = &self.parameters.deviation;
        ((2.0 * d[4]).exp() + (2.0 * d[5]).exp() + (2.0 * self.parameters.white).exp()).sqrt()
    }
}

pub(super) fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

fn dot(a: &[f64; PROCESSES], b: &[f64; PROCESSES]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let mut uniform = || ((rng.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
    (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos()
}

fn loads(course: &Course, i: usize) -> [f64; PROCESSES] {
    KINDS.map(|(load, _)| match load {
        Load::Friction => course.friction[i],
        Load::Stiffness => course.stiffness[i],
        Load::One => 1.0,
    })
}

fn white(p: &Parameters, course: &Course, i: usize) -> f64 {
    (2.0 * p.white).exp() + (2.0 * p.position).exp() * course.stiffness[i].powi(2)
}

/// The filter over one fold, each row handed to `of` with the innovation's variance.
fn run(p: &Parameters, course: &Course, rows: Range<usize>, mut of: impl FnMut(usize, Step, f64)) {
    let variance = p.deviation.map(|d| (2.0 * d).exp());
    let length = p.length.map(f64::exp);
    let mut covariance = [[0.0; PROCESSES]; PROCESSES];
    for j in 0..PROCESSES {
        covariance[j][j] = variance[j];
    }
    for i in rows.clone() {
        let load = loads(course, i);
        let mut shared = [0.0; PROCESSES];
        for j in 0..PROCESSES {
            shared[j] = dot(&covariance[j], &load);
        }
        let innovation = dot(&shared, &load) + white(p, course, i);
        let gain = shared.map(|s| s / innovation);
        let (mut by_path, mut by_time) = (0.0, 0.0);
        if i + 1 < rows.end {
            by_path = (course.path[i + 1] - course.path[i]).max(0.0);
            by_time = (course.time[i + 1] - course.time[i]).max(0.0);
        }
        let mut kept = [1.0; PROCESSES];
        for j in 0..PROCESSES {
            kept[j] = match KINDS[j].1 {
                Clock::Path => (-by_path / length[j]).exp(),
                Clock::Time => (-by_time / length[j]).exp(),
                Clock::Fold => 1.0,
            };
        }
        for j in 0..PROCESSES {
            for k in 0..=j {
                let value = (covariance[j][k] - gain[j] * shared[k]) * kept[j] * kept[k];
                covariance[j][k] = value;
                covariance[k][j] = value;
            }
            covariance[j][j] += variance[j] * (1.0 - kept[j] * kept[j]);
        }
        let weight = innovation.sqrt().recip();
        of(
            i,
            Step {
                load,
                gain,
                kept,
                weight,
            },
            innovation,
        );
    }
}

fn filter(p: &Parameters, course: &Course) -> Vec<Step> {
    let mut steps = Vec::with_capacity(course.time.len());
    for rows in course.folds {
        run(p, course, rows.clone(), |_, step, _| steps.push(step));
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A course that slides back and forth.
    type Columns = [Vec<f64>; 4];

    fn course(folds: usize, rows: usize) -> (Vec<Range<usize>>, Columns) {
        let n = folds * rows;
        let columns = [
            (0..n).map(|i| i as f64 * 0.01).collect(),
            (0..n).map(|i| i as f64 * 1e-5).collect(),
            (0..n)
                .map(|i| if (i / 100) % 2 == 0 { 1.0 } else { -1.0 })
                .collect(),
            vec![0.0; n],
        ];
        (
            (0..folds).map(|k| k * rows..(k + 1) * rows).collect(),
            columns,
        )
    }

    fn over<'a>(folds: &'a [Range<usize>], columns: [&'a [f64]; 4]) -> Course<'a> {
        let [time, path, friction, stiffness] = columns;
        Course {
            folds,
            time,
            path,
            friction,
            stiffness,
            stroke: 1e-3,
        }
    }

    #[test]
    fn finds_the_deviations_that_made_the_data() {
        let (folds, [time, path, friction, stiffness]) = course(20, 800);
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut r = vec![0.0; time.len()];
        for rows in &folds {
            let gain = 0.1 * normal(&mut rng);
            for i in rows.clone() {
                r[i] = 0.01 * normal(&mut rng) + gain * friction[i];
            }
        }
        let course = over(&folds, [&time, &path, &friction, &stiffness]);
        let noise = Noise::estimate(&r, &course);
        assert!(
            (noise.variability() / 0.1 - 1.0).abs() < 0.5,
            "{}",
            noise.variability()
        );
        // The gain and what wanders share what the disturbance leaves: its size is known to a factor, the whitening exactly.
        assert!(
            (noise.disturbance() / 0.01 - 1.0).abs() < 0.4,
            "{}",
            noise.disturbance()
        );
        let white = noise.whitened(&r);
        let mean_square = white.iter().map(|w| w * w).sum::<f64>() / white.len() as f64;
        assert!((mean_square - 1.0).abs() < 0.1, "{mean_square}");
    }

    #[test]
    fn rows_at_frictions_zero_outweigh_the_rest_until_white_noise_has_a_floor() {
        let (folds, [time, path, mut friction, stiffness]) = course(2, 1000);
        // Two stretches of a hundred rows without friction, in all of whose noise friction has no part.
        for rows in [300..400, 1300..1400] {
            friction[rows].fill(0.0);
        }
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let r: Vec<f64> = friction
            .iter()
            .map(|f| (0.1 * f + 1e-4) * normal(&mut rng))
            .collect();
        let course = over(&folds, [&time, &path, &friction, &stiffness]);
        let blocks: Vec<Range<usize>> = (0..20).map(|b| b * 100..(b + 1) * 100).collect();
        assert!((Noise::white(&r, &course).spread(&blocks) - 1.0).abs() < 1e-9);
        let noise = Noise::estimate(&r, &course);
        // Two of twenty.
        let own = noise.spread(&blocks);
        assert!((own - 0.1).abs() < 0.02, "{own}");
        let held = noise.with_floor(0.1, &course).spread(&blocks);
        assert!(held > 0.8, "{held}");
    }

    #[test]
    fn the_inverse_is_the_filter_and_its_adjoint() {
        let (folds, [time, path, friction, stiffness]) = course(2, 30);
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut draw = || {
            (0..time.len())
                .map(|_| normal(&mut rng))
                .collect::<Vec<f64>>()
        };
        let (a, b) = (draw(), draw());
        let course = over(&folds, [&time, &path, &friction, &stiffness]);
        let noise = Noise::estimate(&a, &course);
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (left, right) = (
            product(&b, &noise.inverse(&a)),
            product(&noise.whitened(&b), &noise.whitened(&a)),
        );
        assert!(
            (left - right).abs() < 1e-9 * right.abs().max(1.0),
            "{left} {right}"
        );
    }
}
