//! Deviations and lengths of the noise by maximum likelihood.

use super::{Course, Noise, PROCESSES, Parameters, dot, rms, run};
use rayon::prelude::*;
use std::ops::Range;

/// Most that the level of friction wanders about itself: 5 to 20 % is common on guideways and screws. What is more is a model
/// that is wrong, and noise that took it would leave the fit without a hold.
const VARIABLE: f64 = 0.3;

/// Every so many rows for a first look.
const THIN: usize = 4;

/// A part of the rows.
struct Part {
    folds: Vec<Range<usize>>,
    columns: [Vec<f64>; 4],
    residual: Vec<f64>,
    stroke: f64,
}

impl Part {
    fn of(course: &Course, residual: &[f64]) -> Self {
        let mut folds = Vec::new();
        let mut rows = Vec::new();
        for fold in course.folds {
            let first = rows.len();
            rows.extend(fold.clone().step_by(THIN));
            folds.push(first..rows.len());
        }
        let pick = |column: &[f64]| rows.iter().map(|&i| column[i]).collect::<Vec<f64>>();
        Self {
            columns: [course.time, course.path, course.friction, course.stiffness].map(pick),
            residual: pick(residual),
            stroke: course.stroke,
            folds,
        }
    }

    fn course(&self) -> Course<'_> {
        let [time, path, friction, stiffness] = &self.columns;
        Course {
            folds: &self.folds,
            time,
            path,
            friction,
            stiffness,
            stroke: self.stroke,
        }
    }
}

/// Bounds of the search, as logarithms.
struct Bounds {
    low: Parameters,
    high: Parameters,
}

impl Noise {
    /// Finds the parameters that make `residual` most likely.
    pub fn estimate(residual: &[f64], course: &Course) -> Self {
        let rms = rms(residual).max(1e-300);
        // A course without friction or stiffness has no process that acts through it, whatever its deviation.
        let or_one = |size: f64| if size > 0.0 { size } else { 1.0 };
        let friction = or_one(self::rms(course.friction));
        let stiffness = or_one(self::rms(course.stiffness));
        let row_s = course
            .time
            .windows(2)
            .map(|t| t[1] - t[0])
            .fold(f64::INFINITY, f64::min)
            .max(1e-9);
        let duration = course
            .folds
            .iter()
            .map(|f| course.time[f.end - 1] - course.time[f.start])
            .fold(f64::INFINITY, f64::min)
            .max(20.0 * row_s);
        let relative = rms / friction;
        let displaced = rms / stiffness;
        let set = |scale: f64| Parameters {
            deviation: [relative, relative, relative, displaced, rms, rms]
                .map(|d| (d * scale).ln()),
            length: [course.stroke; PROCESSES].map(f64::ln),
            white: (rms * scale).ln(),
            position: (displaced * scale).ln(),
        };
        let lengths = [
            course.stroke / 100.0,
            course.stroke / 5.0,
            1.0,
            course.stroke / 100.0,
            4.0 * row_s,
            40.0 * row_s,
        ]
        .map(f64::ln);
        let (mut low, mut high) = (set(1e-3), set(3.0));
        for deviation in &mut high.deviation[..3] {
            *deviation = deviation.min(VARIABLE.ln());
        }
        low.length = [
            course.stroke / 3000.0,
            course.stroke / 30.0,
            1.0,
            course.stroke / 3000.0,
            row_s,
            10.0 * row_s,
        ]
        .map(f64::ln);
        // A disturbance slower than a few of its periods in a fold is physics or a gain, not noise.
        high.length = [
            course.stroke / 10.0,
            course.stroke,
            1.0,
            course.stroke / 10.0,
            20.0 * row_s,
            (duration / 20.0).max(20.0 * row_s),
        ]
        .map(f64::ln);
        let bounds = Bounds { low, high };
        // The likelihood has several hills: friction that wanders, a disturbance, or both. A part of the rows tells which is
        // the highest; the processes are the same on it.
        let part = Part::of(course, residual);
        let hills = [(0.3, 0.3), (0.5, 0.05), (0.05, 0.5)].map(|(level, force)| {
            let mut start = set(level);
            start.length = lengths;
            start.white = (force * rms).ln();
            start.deviation[4..].fill(start.white);
            start
        });
        let climbed = hills.into_par_iter().map(|start| {
            let of = |p: &Parameters| likelihood(p, &part.residual, &part.course());
            let top = climb(start, &bounds, &[1.5, 0.7, 0.35], of);
            (of(&top), top)
        });
        let start = climbed
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(set(0.3), |best| best.1);
        let best = climb(start, &bounds, &[0.5, 0.25], |p| {
            likelihood(p, residual, course)
        });
        Self::of(best, course)
    }
}

fn likelihood(p: &Parameters, residual: &[f64], course: &Course) -> f64 {
    // Added up in one order: the threads' would differ from run to run, and a fit without a hold shows it.
    let parts: Vec<f64> = course
        .folds
        .par_iter()
        .map(|rows| {
            let mut state = [0.0; PROCESSES];
            let mut sum = 0.0;
            run(p, course, rows.clone(), |i, s, variance| {
                let innovation = residual[i] - dot(&s.load, &state);
                sum -= 0.5 * (innovation * innovation / variance + variance.ln());
                s.advance(&mut state, innovation);
            });
            sum
        })
        .collect();
    parts.iter().sum()
}

/// Climbs along one parameter at a time (Hooke and Jeeves 1961), with smaller and smaller steps.
fn climb(
    start: Parameters,
    bounds: &Bounds,
    steps: &[f64],
    of: impl Fn(&Parameters) -> f64,
) -> Parameters {
    let mut best = start;
    let (mut low, mut high) = (bounds.low, bounds.high);
    for k in 0..Parameters::COUNT {
        let (l, h) = (*low.slot(k), *high.slot(k));
        let slot = best.slot(k);
        *slot = slot.clamp(l, h.max(l));
    }
    let mut value = of(&best);
    for &step in steps {
        for _ in 0..3 {
            let before = value;
            for k in 0..Parameters::COUNT {
                let (l, h) = (*low.slot(k), *high.slot(k));
                if h - l < 1e-9 {
                    continue;
                }
                for sign in [1.0, -1.0] {
                    let mut moved = best;
                    let slot = moved.slot(k);
                    *slot = (*slot + sign * step).clamp(l, h);
                    let reached = of(&moved);
                    if reached > value {
                        (best, value) = (moved, reached);
                        break;
                    }
                }
            }
            if value - before < 1.0 {
                break;
            }
        }
    }
    best
}
