//! A number with its confidence interval.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// A parameter's estimate.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Estimate {
    /// Its value (SI).
    pub value: f64,
    /// 95 % confidence interval; `None` where the recording has too few folds to tell.
    pub ci95: Option<[f64; 2]>,
}

impl Estimate {
    /// With a standard error estimated from `folds` independent folds (Student's t with `folds − 1` degrees
    /// of freedom).
    pub fn new(value: f64, standard_error: Option<f64>, folds: usize) -> Self {
        let reach = standard_error.and_then(|e| Some(e * quantile(folds)?));
        Self {
            value,
            ci95: reach.map(|reach| [value - reach, value + reach]),
        }
    }

    /// For a value that is positive and was estimated as its logarithm.
    pub fn logarithmic(value: f64, error_of_log: Option<f64>, folds: usize) -> Self {
        let reach = error_of_log.and_then(|e| Some(e * quantile(folds)?));
        Self {
            value,
            ci95: reach.map(|reach| [value * (-reach).exp(), value * reach.exp()]),
        }
    }
}

fn quantile(folds: usize) -> Option<f64> {
    let freedom = folds.checked_sub(1).filter(|&n| n > 0)?;
    let t = StudentsT::new(0.0, 1.0, freedom as f64).ok()?;
    Some(t.inverse_cdf(0.975))
}
