//! The friction model, chosen by type.

use fixed::types::I16F16;
use preslide::{Block, Friction, ParamError, QuasiStaticGms, Units};
use preslide_link::{MOST_BLOCKS, ModelSettings};

/// A friction model that the command link can set.
pub trait Model: Friction + Sized + 'static {
    /// The units that it computes in.
    const UNITS: Units;

    /// Validates the settings.
    ///
    /// # Errors
    /// The first parameter that is not finite, out of range, or does not fit the number type.
    fn build(settings: &ModelSettings) -> Result<Self, ParamError>;
}

fn blocks(settings: &ModelSettings) -> [Block; MOST_BLOCKS] {
    settings.blocks.map(|(stiffness, weight)| Block {
        stiffness: stiffness.into(),
        weight: weight.into(),
    })
}

impl Model for QuasiStaticGms<MOST_BLOCKS, f32> {
    const UNITS: Units = Units::SI;

    fn build(settings: &ModelSettings) -> Result<Self, ParamError> {
        Self::try_new(&blocks(settings), settings.breakaway_n.into(), Self::UNITS)
    }
}

impl Model for QuasiStaticGms<MOST_BLOCKS, I16F16> {
    /// A displacement of 1 is a count, a force of 1 a millinewton.
    const UNITS: Units = Units {
        length: 25e-9,
        force: 1e-3,
        velocity: 1e-3,
    };

    fn build(settings: &ModelSettings) -> Result<Self, ParamError> {
        Self::try_new(&blocks(settings), settings.breakaway_n.into(), Self::UNITS)
    }
}

/// What the controller starts with: the paper's Table 3, four blocks.
pub const STARTING_MODEL: ModelSettings = ModelSettings {
    breakaway_n: 0.9,
    blocks: [
        (313_728.0, 0.339),
        (43_670.0, 0.236),
        (10_545.0, 0.171),
        (5_858.0, 0.253),
    ],
};
