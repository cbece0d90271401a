//! A friction model that learns can be set like the one that it wraps.

use crate::Model;
use preslide::control::learning::Learn;
use preslide::control::{Learning, LearningSettings};
use preslide::{ParamError, Units};
use preslide_link::ModelSettings;

/// With [`LearningSettings::PAPER_AXIS`]. A new model, and new gains, begin to learn anew.
impl<F: Model, L: Learn<F::Scalar> + 'static> Model for Learning<F, L> {
    const UNITS: Units = F::UNITS;

    fn build(settings: &ModelSettings) -> Result<Self, ParamError> {
        let friction = F::build(settings)?;
        Self::try_new(friction, &LearningSettings::PAPER_AXIS, F::UNITS)
    }
}
