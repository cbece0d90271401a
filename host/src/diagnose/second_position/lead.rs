//! The part of a difference that is smooth over the travel.

use super::held_out::HeldOut;
use super::legendre::{DEGREE, legendre};
use super::samples::{BESIDE, Samples};
use preslide_fit::statistics::Estimate;

/// Points of the reported curve.
const POINTS: usize = 41;

/// A difference that is smooth over the travel.
pub struct Lead {
    /// Its slope (m/m), where there is one.
    pub slope: Option<Estimate>,
    /// What is left of it without the slope, from its lowest to its highest (m or rad) …
    pub bow: f64,
    /// … and where those are (m or rad).
    pub lowest_at: f64,
    /// See [`lowest_at`](Self::lowest_at).
    pub highest_at: f64,
    /// Position and difference (m or rad), the mean taken off.
    pub curve: Vec<[f64; 2]>,
    /// Share of the squared difference that it takes on passes held out …
    pub share: f64,
    /// … in standard errors between them.
    pub z: f64,
}

impl Lead {
    /// The curve of a fit to these samples; it has a slope where that is known.
    pub fn of(fit: &HeldOut, samples: &Samples, sloped: bool) -> Self {
        let scale = samples.travel;
        let of_degree = |d: usize| fit.coefficients[BESIDE + d - 1];
        let point = |k: usize| 2.0 * k as f64 / (POINTS - 1) as f64 - 1.0;
        let place = |k: usize| samples.low + 0.5 * scale * (point(k) + 1.0);
        let from = |first: usize| -> Vec<f64> {
            let at = |k| {
                let p = legendre(point(k));
                let terms = (first..=DEGREE).map(|d| scale * of_degree(d) * p[d - 1]);
                terms.sum()
            };
            (0..POINTS).map(at).collect()
        };
        let bow = from(2);
        let at = |sign: f64| {
            let best = (0..POINTS).max_by(|a, b| (sign * bow[*a]).total_cmp(&(sign * bow[*b])));
            best.unwrap_or(0)
        };
        let (lowest, highest) = (at(-1.0), at(1.0));
        Self {
            // The first polynomial goes from −1 to 1 over the travel.
            slope: sloped.then(|| fit.estimate(BESIDE, 2.0)),
            bow: bow[highest] - bow[lowest],
            lowest_at: place(lowest),
            highest_at: place(highest),
            curve: (0..).zip(from(1)).map(|(k, d)| [place(k), d]).collect(),
            share: 0.0,
            z: 0.0,
        }
    }
}
