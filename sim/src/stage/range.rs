//! The ranges that values of the stage may lie in.

/// Why a stage could not be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StageError {
    /// A value lies outside its range.
    #[error("stage: {key} = {value} is out of range: {reason}; set {key} {remedy}")]
    OutOfRange {
        /// The key, as in [`super::StageConfig`].
        key: &'static str,
        /// The value given.
        value: f64,
        /// Why it cannot be.
        reason: &'static str,
        /// What to set instead.
        remedy: &'static str,
    },
    /// A list that must hold something is empty.
    #[error("stage: {key} is empty; give {remedy}")]
    Empty {
        /// The key, as in [`super::StageConfig`].
        key: &'static str,
        /// What to give.
        remedy: &'static str,
    },
}

/// The ranges a key may lie in.
pub(super) fn check(
    key: &'static str,
    value: f64,
    valid: bool,
    reason: &'static str,
    remedy: &'static str,
) -> Result<(), StageError> {
    if valid && value.is_finite() {
        return Ok(());
    }
    Err(StageError::OutOfRange {
        key,
        value,
        reason,
        remedy,
    })
}

pub(super) fn positive(key: &'static str, value: f64) -> Result<(), StageError> {
    check(
        key,
        value,
        value > 0.0,
        "it must be positive and finite",
        "above zero",
    )
}

pub(super) fn not_negative(key: &'static str, value: f64) -> Result<(), StageError> {
    check(
        key,
        value,
        value >= 0.0,
        "it must be zero or more, and finite",
        "to zero or above",
    )
}

pub(super) fn share(key: &'static str, value: f64) -> Result<(), StageError> {
    check(
        key,
        value,
        (0.0..=1.0).contains(&value),
        "it is a share",
        "within 0..1",
    )
}
