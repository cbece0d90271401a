//! What the stage's friction was while its telemetry was captured, and whether an identified model matches it.

use crate::stage::Stage;
use crate::tracking::Step;
use preslide_fit::identify::Candidate;
use preslide_fit::statistics::Estimate;
use serde::{Deserialize, Serialize};

/// Strokes of a repeat, peak to peak (m), and their speed (m/s). The largest exceeds twice the longest yield displacement
/// of the paper's axis (39 µm), so that every block slips; the smaller ones show the memory. All speeds are far below
/// the Stribeck velocity, and differ, so that viscous friction is told from a block's force.
const STROKES: [(f64, f64); 4] = [
    (150e-6, 120e-6),
    (60e-6, 60e-6),
    (20e-6, 25e-6),
    (8e-6, 10e-6),
];
/// Repeats: one fold of the cross-validation each.
const REPEATS: usize = 4;
/// Time to reach a stroke's speed (s).
const RAMP_S: f64 = 0.02;

/// The motion for a capture: nested strokes, repeated.
pub fn presliding() -> Vec<Step> {
    let mut position = 0.0;
    let ends = (0..REPEATS)
        .flat_map(|_| STROKES)
        .flat_map(|(stroke, speed)| [(0.5 * stroke, speed), (-0.5 * stroke, speed)]);
    ends.map(|(end, speed_m_s)| {
        let distance_m = end - position;
        position = end;
        Step::Move {
            distance_m,
            speed_m_s,
            ramp_s: RAMP_S,
        }
    })
    .collect()
}

/// The virgin curve of the stage's friction, averaged over a run: gains wander along the path, and a model that is
/// identified from the whole run can know no more than their mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrueCurve {
    /// Displacements (m).
    pub x_m: Vec<f64>,
    /// Mean force there (N).
    pub force_n: Vec<f64>,
    /// Looks that were averaged.
    pub looks: u32,
}

impl Default for TrueCurve {
    /// Displacements from two counts to the largest stroke's half, evenly spaced in their logarithm.
    fn default() -> Self {
        let (first, last, points) = (50e-9_f64, 75e-6_f64, 30);
        let step = (last / first).ln() / f64::from(points - 1);
        let x_m: Vec<f64> = (0..points)
            .map(|i| first * (step * f64::from(i)).exp())
            .collect();
        Self {
            force_n: vec![0.0; x_m.len()],
            x_m,
            looks: 0,
        }
    }
}

impl TrueCurve {
    /// Adds the stage's friction of this moment, at the velocity `v_m_s`.
    pub fn look(&mut self, stage: &Stage, v_m_s: f64) {
        self.looks += 1;
        let share = 1.0 / f64::from(self.looks);
        for (mean, x) in self.force_n.iter_mut().zip(&self.x_m) {
            *mean += share * (stage.friction().virgin_now_n(*x, v_m_s) - *mean);
        }
    }

    /// This curve beside that of an identified model.
    pub fn compare(&self, model: &Candidate) -> Comparison {
        let points = self.x_m.iter().zip(&self.force_n);
        Comparison {
            points: points
                .map(|(&x, &truth)| (x, truth, model.virgin_force(x)))
                .collect(),
        }
    }
}

/// Truth and model, point by point.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Displacement (m), true force (N), identified force (N).
    pub points: Vec<(f64, f64, Estimate)>,
}

impl Comparison {
    /// Points at which the confidence interval contains the truth.
    pub fn inside(&self) -> usize {
        self.points.iter().filter(|point| contains(point)).count()
    }

    /// Whether it does at the last point, where every block slips: the breakaway force.
    pub fn breakaway_inside(&self) -> bool {
        self.points.last().is_some_and(contains)
    }

    /// RMS of the deviation over RMS of the true force [–].
    pub fn relative_rms(&self) -> f64 {
        let sum = |f: &dyn Fn(&(f64, f64, Estimate)) -> f64| self.points.iter().map(f).sum::<f64>();
        (sum(&|(_, truth, e)| (e.value - truth).powi(2)) / sum(&|(_, truth, _)| truth.powi(2)))
            .sqrt()
    }
}

fn contains((_, truth, estimate): &(f64, f64, Estimate)) -> bool {
    let interval = estimate.ci95;
    interval.is_some_and(|[low, high]| (low..=high).contains(truth))
}
