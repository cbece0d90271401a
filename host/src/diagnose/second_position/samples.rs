//! The samples of which two positions are compared, and what their difference is fitted with.

use super::super::signals::Signals;
use super::legendre::{DEGREE, legendre};
use preslide_fit::statistics::bounds;

/// Share of the stroke before after which a reversal's backlash counts as taken up.
const TAKEN_UP: f64 = 0.1;
/// Samples that are fitted.
const MOST: usize = 100_000;

/// Columns beside the curve: one, time, effort, direction, velocity, acceleration.
pub const CONSTANT: usize = 0;
pub const EFFORT: usize = 2;
pub const DIRECTION: usize = 3;
pub const BESIDE: usize = 6;
/// Those that hide what follows effort and direction: inertia and friction make of them an effort again.
pub const HIDING: [usize; 2] = [4, 5];
/// All columns: those beside the curve, and the curve's.
pub const COLUMNS: usize = BESIDE + DEGREE;

/// Samples in which a reversal's backlash is taken up.
pub struct Samples {
    /// The lowest position (m or rad).
    pub low: f64,
    /// From the lowest position to the highest (m or rad).
    pub travel: f64,
    /// What the effort's column is divided by (N or Nm).
    pub most_effort: f64,
    /// Position, 0 to 1 over the travel.
    pub place: Vec<f64>,
    /// What the difference is fitted with.
    pub columns: Vec<[f64; COLUMNS]>,
    /// The second position less the first, over the travel.
    pub difference: Vec<f64>,
    /// The number of the pass between reversals.
    pub pass: Vec<usize>,
    /// Passes of the whole recording.
    pub passes: usize,
}

impl Samples {
    /// Of a second position (m or rad) and an effort (N or Nm).
    pub fn of(second: &[f64], effort: &[f64], s: &Signals) -> Self {
        let (low, high) = bounds(&s.x);
        let travel = (high - low).max(1e-300);
        let (duration, top) = (s.duration().max(1e-300), s.top_speed().max(1e-300));
        let (most_effort, most_a) = (size(effort), size(&s.a));
        let pass = passes(s);
        let taken_up = |i: &usize| s.since_reversal[*i] >= TAKEN_UP * s.last_stroke[*i];
        let every = s.x.len().div_ceil(MOST).max(1);
        let kept: Vec<usize> = (0..s.x.len()).step_by(every).filter(taken_up).collect();
        let columns = |&i: &usize| {
            let beside = [
                1.0,
                s.t[i] / duration - 0.5,
                effort[i] / most_effort,
                s.direction[i],
                s.v[i] / top,
                s.a[i] / most_a,
            ];
            let mut columns = [0.0; COLUMNS];
            columns[..BESIDE].copy_from_slice(&beside);
            columns[BESIDE..].copy_from_slice(&legendre(2.0 * (s.x[i] - low) / travel - 1.0));
            columns
        };
        Self {
            low,
            travel,
            most_effort,
            place: kept.iter().map(|&i| (s.x[i] - low) / travel).collect(),
            columns: kept.iter().map(columns).collect(),
            difference: kept
                .iter()
                .map(|&i| (second[i] - s.x[i]) / travel)
                .collect(),
            passes: pass.last().map_or(0, |last| last + 1),
            pass: kept.iter().map(|&i| pass[i]).collect(),
        }
    }
}

fn size(v: &[f64]) -> f64 {
    v.iter().fold(1e-300, |m: f64, v| m.max(v.abs()))
}

/// The number of the pass between reversals that each sample belongs to.
fn passes(s: &Signals) -> Vec<usize> {
    let mut pass = 0;
    (0..s.x.len())
        .map(|i| {
            pass += usize::from(i > 0 && s.direction[i] != s.direction[i - 1]);
            pass
        })
        .collect()
}
