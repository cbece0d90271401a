//! Columns of one value a sample.

use super::Scene;
use crate::diagnose::weak::Column;

impl Scene<'_> {
    /// `of` at every sample.
    pub(super) fn sampled(&self, of: impl Fn(usize) -> f64) -> Vec<f64> {
        (0..self.s.x.len()).map(of).collect()
    }

    /// A force.
    pub(super) fn force(&self, of: impl Fn(usize) -> f64) -> Column {
        Column::of(self.sampled(of))
    }

    /// A change of the friction level.
    pub(super) fn friction(&self, level: impl Fn(usize) -> f64) -> Column {
        self.force(|i| self.core.friction[i] * level(i))
    }
}
