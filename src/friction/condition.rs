//! What a friction model that learns has to say.

/// What a model that learns has to say.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Condition<S> {
    /// The watch's verdict; `None` without a watch.
    pub range: Option<NormalRange>,
    /// The friction level (-); `None` without adaptation.
    pub level: Option<S>,
}

impl<S> Condition<S> {
    /// Of a model that learns nothing.
    pub const NONE: Self = Self {
        range: None,
        level: None,
    };
}

/// The watch's verdict. Above and below stay until [`MismatchState::acknowledge`](crate::control::learning::MismatchState::acknowledge), or a swap of the controller's coefficients.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NormalRange {
    /// Commissioning: the range is being learned.
    Learning,
    /// Within it.
    Inside,
    /// More is spent than was: wear, a new spot.
    Above,
    /// Less is spent than was.
    Below,
}
