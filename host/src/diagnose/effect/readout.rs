//! Parameters of a fit, and their entry in a model file.

use super::{Card, Fitted, Scale};
use preslide_fit::effects::Effect as Entry;
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;

/// Parameters by key.
pub(super) type Values = Vec<(String, Estimate)>;

impl Fitted<'_> {
    /// A coefficient; 0 where the recording has no column for it.
    pub(super) fn coefficient(&self, index: usize) -> f64 {
        self.coefficients.get(index).copied().unwrap_or(0.0)
    }

    /// Its standard error.
    pub(super) fn error(&self, index: usize) -> Option<f64> {
        self.errors.get(index).copied().flatten()
    }

    /// A value of a standard error.
    pub(super) fn estimate(&self, value: f64, error: Option<f64>) -> Estimate {
        Estimate::new(value, error, self.folds)
    }

    /// A coefficient with its interval, under a key.
    pub(super) fn entry(&self, key: &str, index: usize) -> (String, Estimate) {
        let value = self.coefficient(index);
        (key.to_owned(), self.estimate(value, self.error(index)))
    }

    /// The shape parameters that the fit has, with their intervals.
    pub(super) fn shape_of(&self, card: &Card) -> Values {
        let keys = card.shape.iter().zip(self.shape).enumerate();
        keys.map(|(k, ((key, scale), &value))| {
            let error = self.shape_errors.get(k).copied().flatten();
            let estimate = match scale {
                Scale::Logarithmic => {
                    Estimate::logarithmic(value, error.map(|e| e / value), self.folds)
                }
                _ => self.estimate(value, error),
            };
            ((*key).to_owned(), estimate)
        })
        .collect()
    }

    /// One coefficient, then the shape.
    pub(super) fn one(&self, card: &Card) -> Values {
        let mut values = vec![self.entry(card.coefficient, 0)];
        values.extend(self.shape_of(card));
        values
    }
}

/// A value that the recording gives, not the fit.
pub(super) fn known(key: &str, value: f64) -> (String, Estimate) {
    (key.to_owned(), Estimate { value, ci95: None })
}

/// The value of a key, 0 where it has none.
pub(super) fn value_of(values: &[(String, Estimate)], key: &str) -> f64 {
    let own = values.iter().find(|(own, _)| own == key);
    own.map_or(0.0, |(_, estimate)| estimate.value)
}

/// Enters the parameters of `id` in a model file, less those of the keys `left_out`, for which it has no use.
pub(super) fn enter(
    id: &str,
    values: &[(String, Estimate)],
    left_out: &[&str],
    model: &mut Model,
) -> Result<(), String> {
    let kept: Vec<(&str, f64)> = values
        .iter()
        .filter(|(key, _)| !left_out.contains(&key.as_str()))
        .map(|(key, estimate)| (key.as_str(), estimate.value))
        .collect();
    model.effects.push(Entry::new(id, &kept)?);
    Ok(())
}
