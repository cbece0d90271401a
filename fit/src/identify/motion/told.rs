//! The result of a search: values with intervals, what the motion cannot separate, and how much a change of the machine moves it.

use super::beside::Beside;
use super::body::Body;
use super::descent::{self, normal, slopes};
use super::search::{Point, Search, Settled};
use super::terms::Term;
use super::window::{AS_IT_IS, Drive, Window};
use super::{Apart, MotionFit, Tried};
use crate::statistics::Estimate;
use nalgebra::DMatrix;

/// Correlation of two parameters beyond which a motion determines only a combination.
const TOGETHER: f64 = 0.95;
/// By so much drive gain and friction are changed to see what that moves.
pub(super) const NUDGE: f64 = 0.01;

impl Search<'_> {
    /// Values with intervals, and what the motion cannot separate.
    pub(super) fn told(
        &self,
        first: &Point,
        settled: Settled,
        tried: Vec<Tried>,
        held_out: Option<Apart>,
        beside: Beside,
    ) -> MotionFit {
        let covariance = self.covariance(&settled);
        let agree = settled.agrees();
        let Settled {
            point,
            windows,
            losses,
            ..
        } = settled;
        let springs = point.terms.iter().any(|t| t.name() == "spring");
        let name = |term: &Term| match term.name() {
            // The force fit's is that at the position 0.
            "offset" if springs => "offset_at_mid_travel",
            name => name,
        };
        let names: Vec<&'static str> = point.terms.iter().map(name).collect();
        let estimate = |(j, term): (usize, &Term)| {
            let error = covariance.as_ref().map(|(c, _)| c[(j, j)].sqrt());
            let error = error.map(|e| e * term.scale(&self.sizes));
            let folds = covariance.as_ref().map_or(0, |c| c.1);
            (names[j], Estimate::new(term.of(&point.body), error, folds))
        };
        let mut together = Vec::new();
        if let Some((c, _)) = &covariance {
            for j in 0..names.len() {
                for k in 0..j {
                    let of = c[(j, k)] / (c[(j, j)] * c[(k, k)]).sqrt();
                    if of.abs() > TOGETHER {
                        together.push((names[k], names[j], of));
                    }
                }
            }
        }
        let whole = self.driven.windows(&self.pieces, 1);
        let simulate = |body: &Body, gain: f64| -> Vec<f64> {
            let one = |w: &Window| self.driven.simulate(body, w, self.steps, gain);
            whole.iter().flat_map(one).collect()
        };
        let simulated = [&first.body, &point.body].map(|body| simulate(body, AS_IT_IS));
        let measured: Vec<f64> = whole
            .iter()
            .flat_map(|w| &self.driven.recording.position[w.rows.clone()])
            .copied()
            .collect();
        let apart = |a: &[f64], b: &[f64]| {
            let errors: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
            Apart::of(&errors)
        };
        let mut rougher = point.body.clone();
        rougher.coulomb *= 1.0 + NUDGE;
        rougher.transmitted *= 1.0 + NUDGE;
        let nudged = [
            simulate(&point.body, 1.0 + NUDGE),
            simulate(&rougher, AS_IT_IS),
        ];
        let t_s = &self.driven.recording.t_s;
        let seconds = windows
            .iter()
            .map(|w| t_s[w.rows.end - 1] - t_s[w.rows.start]);
        MotionFit {
            model: point.body.model(&self.driven.place),
            parameters: point.terms.iter().enumerate().map(estimate).collect(),
            before: point.terms.iter().map(|t| t.of(&first.body)).collect(),
            errors: [0, 1].map(|i| apart(&simulated[i], &measured)),
            held_out,
            starts: losses,
            agree,
            window_s: seconds.fold(0.0, f64::max),
            tried,
            moves: nudged.map(|moved| apart(&moved, &simulated[1]).rms),
            together,
            closed_loop: matches!(self.driven.drive, Drive::Loop { .. }),
            simulated,
            beside,
        }
    }

    /// Covariance of the free terms, in their scales, and of how many independent errors: in the longest windows that have more of them
    /// than terms.
    fn covariance(&self, found: &Settled) -> Option<(DMatrix<f64>, usize)> {
        let mut finer = self.lengths().filter(|parts| *parts >= found.parts);
        finer.find_map(|parts| {
            let windows = self.driven.windows(&self.pieces, parts);
            self.covariance_in(&found.point, &windows)
        })
    }

    /// The same in these windows. Errors of a simulation go on for as long as their autocorrelation says.
    fn covariance_in(&self, point: &Point, windows: &[Window]) -> Option<(DMatrix<f64>, usize)> {
        let rough = self.rough(point, windows);
        let shares = point.shares(&self.sizes);
        let errors = self.errors(point, windows);
        let of = |shares: &[f64]| Some(self.errors(&point.at(shares, &self.sizes)?, windows));
        // The widest step of the descent: what it cannot see is rough.
        let slopes = slopes(&shares, descent::STEPS[0], &errors, &of);
        let (gram, _) = normal(&slopes, &errors, rough);
        let independent = (errors.len() as f64 / lasting(&errors)).max(1.0);
        let free = independent - shares.len() as f64;
        let square = descent::loss_of(&errors, rough).powi(2);
        let inverse = gram.try_inverse().filter(|_| free >= 1.0)?;
        let scale = square * errors.len() as f64 / free;
        Some((inverse * scale, free as usize + 1))
    }
}

/// For how many samples an error lasts: the integrated autocorrelation, up to where it first vanishes.
fn lasting(errors: &[f64]) -> f64 {
    let power: f64 = errors.iter().map(|e| e * e).sum();
    let mut sum = 1.0;
    for lag in 1..errors.len() / 2 {
        let products = errors.iter().zip(&errors[lag..]).map(|(a, b)| a * b);
        let of = products.sum::<f64>() / power;
        if of <= 0.0 || !of.is_finite() {
            break;
        }
        sum += 2.0 * of;
    }
    sum
}
